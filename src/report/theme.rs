//! Colours by what they mean, for paper and for dark screens.
//!
//! Figures have classes; `figure.css` says what these look like, with colours by name. The page
//! resolves the names itself, for light and dark; a PNG file gets the light ones put in.

/// Name, colour on a light and on a dark background. Data, model and truth are told apart by people
/// with any kind of colour vision.
///
/// # Source
/// Okabe & Ito 2008, "Color universal design", for data, model and truth.
const COLOURS: [(&str, &str, &str); 9] = [
    ("paper", "#ffffff", "#15191d"),
    ("raised", "#f4f6f8", "#1e242a"),
    ("ink", "#1b2127", "#e4e9ee"),
    ("muted", "#5a6570", "#9ba7b3"),
    ("frame", "#8d98a3", "#66727e"),
    ("grid", "#e4e8ec", "#2a3139"),
    ("data", "#0067a5", "#62b5ee"),
    ("model", "#c04a00", "#ff9a5c"),
    ("truth", "#00805e", "#3fd0a4"),
];

/// What figures look like.
const FIGURE_CSS: &str = include_str!("figure.css");

/// The stylesheet of figures within the page, and the colours that it names.
pub(super) fn page_css() -> String {
    let colours = |pick: fn(&(&str, &'static str, &'static str)) -> &'static str| {
        let one = |colour: &(&str, &'static str, &'static str)| {
            format!("--{}:{};", colour.0, pick(colour))
        };
        COLOURS.iter().map(one).collect::<String>()
    };
    format!(
        ":root{{color-scheme:light dark;{}}}\n\
         @media screen and (prefers-color-scheme:dark){{:root{{{}}}}}\n{FIGURE_CSS}",
        colours(|c| c.1),
        colours(|c| c.2)
    )
}

/// The stylesheet of a figure by itself, on white.
pub(super) fn file_css() -> String {
    COLOURS
        .iter()
        .fold(FIGURE_CSS.to_owned(), |css, (name, light, _)| {
            css.replace(&format!("var(--{name})"), light)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_of_a_figure_is_known() {
        assert!(!file_css().contains("var("), "{}", file_css());
    }
}
