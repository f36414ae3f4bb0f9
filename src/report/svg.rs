//! The letters of a drawing: elements of SVG with classes, never with colours of their own.

use std::fmt::Write as _;

/// Text as it may stand in HTML and XML, between tags or in an attribute. What XML has no letter for
/// becomes a question mark.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('?'),
            c => out.push(c),
        }
    }
    out
}

/// A coordinate to a tenth of a pixel, as short as it goes.
pub(super) fn px(value: f64) -> String {
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Where a text stands relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Elements, one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Svg(String);

impl Svg {
    pub(super) fn into_body(self) -> String {
        self.0
    }

    /// A path of class `class`; nothing of nothing.
    pub(super) fn path(&mut self, class: &str, d: &str) {
        if !d.is_empty() {
            let _ = write!(self.0, "<path class=\"{class}\" d=\"{d}\"/>");
        }
    }

    /// A path from point to point.
    pub(super) fn line(&mut self, class: &str, points: &[[f64; 2]]) {
        self.path(class, &polyline(points));
    }

    pub(super) fn rect(&mut self, class: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let [x, y, width, height] = [x, y, width, height].map(px);
        let _ = write!(
            self.0,
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>"
        );
    }

    pub(super) fn circle(&mut self, class: &str, [x, y]: [f64; 2], radius: f64) {
        let [x, y, radius] = [x, y, radius].map(px);
        let _ = write!(
            self.0,
            "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>"
        );
    }

    pub(super) fn text(&mut self, class: &str, anchor: Anchor, [x, y]: [f64; 2], text: &str) {
        let end = Self::anchored(anchor);
        let (x, y, text) = (px(x), px(y), escaped(text));
        let _ = write!(
            self.0,
            "<text class=\"{class}\" x=\"{x}\" y=\"{y}\"{end}>{text}</text>"
        );
    }

    /// A text turned by a quarter against the clock.
    pub(super) fn text_up(&mut self, class: &str, [x, y]: [f64; 2], text: &str) {
        let end = Self::anchored(Anchor::Middle);
        let (x, y, text) = (px(x), px(y), escaped(text));
        let _ = write!(
            self.0,
            "<text class=\"{class}\" transform=\"translate({x} {y}) rotate(-90)\"{end}>{text}</text>"
        );
    }

    /// What `draw` draws, with a title that a pointer shows.
    pub(super) fn titled(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        let _ = write!(self.0, "<g><title>{}</title>", escaped(title));
        draw(self);
        self.0.push_str("</g>");
    }

    /// The same as a link to a place in the page. It is no stop for the Tab key: the table of sources
    /// has the same links.
    pub(super) fn linked(&mut self, id: &str, title: &str, draw: impl FnOnce(&mut Self)) {
        let _ = write!(self.0, "<a href=\"#{}\" tabindex=\"-1\">", escaped(id));
        self.titled(title, draw);
        self.0.push_str("</a>");
    }

    fn anchored(anchor: Anchor) -> &'static str {
        match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        }
    }
}

/// The data of a path from point to point.
pub(super) fn polyline(points: &[[f64; 2]]) -> String {
    let mut d = String::new();
    for (i, [x, y]) in points.iter().enumerate() {
        d.push(if i == 0 { 'M' } else { 'L' });
        let _ = write!(d, "{} {}", px(*x), px(*y));
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_from_a_file_is_markup() {
        assert_eq!(
            escaped("<b a=\"1\" c='2'>&\u{1}\n"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;? "
        );
    }

    #[test]
    fn coordinates_are_short() {
        assert_eq!(
            [0.0, -0.01, 12.0, 3.1234].map(px),
            ["0", "0", "12", "3.1"].map(String::from)
        );
        assert_eq!(polyline(&[[0.0, 1.0], [2.5, 3.0]]), "M0 1L2.5 3");
    }
}
