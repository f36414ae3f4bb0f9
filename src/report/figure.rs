//! One figure: a drawing with a name, a title, and words for those who cannot see it.

use std::fmt::Write as _;

use super::svg::{Svg, escaped, px};
use super::theme::file_css;

/// A figure, drawn once: for the page and for a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file, and of its place in the page.
    pub name: String,
    /// What it is.
    pub title: String,
    /// What is to be seen in it, in a sentence or two.
    pub about: String,
    /// Width and height [pixel].
    pub size: [f64; 2],
    body: String,
}

impl Figure {
    pub(super) fn new(name: &str, title: &str, about: &str, size: [f64; 2], svg: Svg) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            about: about.to_owned(),
            size,
            body: svg.into_body(),
        }
    }

    /// The figure with its caption, for the page. `extra` is HTML below the caption.
    pub(super) fn inline(&self, extra: &str) -> String {
        let [width, height] = self.size.map(px);
        let (name, title, about) = (&self.name, escaped(&self.title), escaped(&self.about));
        let role = if self.body.contains("<a ") {
            "group"
        } else {
            "img"
        };
        let mut html = String::new();
        let _ = write!(
            html,
            "<figure id=\"fig-{name}\" style=\"max-width:{width}px\">\n\
             <svg viewBox=\"0 0 {width} {height}\" role=\"{role}\" \
             aria-labelledby=\"fig-{name}-title\" aria-describedby=\"fig-{name}-about\">\
             <title id=\"fig-{name}-title\">{title}</title>{}</svg>\n\
             <figcaption><b>{title}.</b> <span id=\"fig-{name}-about\">{about}</span>{extra}\
             </figcaption>\n</figure>\n",
            self.body
        );
        html
    }

    /// A whole SVG file on white.
    pub fn svg_file(&self) -> String {
        let [width, height] = self.size.map(px);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\"><title>{}</title><style>{}</style>\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{}</svg>",
            escaped(&self.title),
            file_css(),
            self.body
        )
    }
}
