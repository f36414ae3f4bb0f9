//! A catalogue as a page to look at: one HTML file that needs nothing else, and its figures as files.
//!
//! | file | answers |
//! |---|---|
//! | `contents.rs`, `details.rs` | what is shown: the catalogue, the truth, the visibilities |
//! | `visibilities.rs` | do the visibilities look as the catalogue says that they should |
//! | `figures` | one drawing a file |
//! | `axis.rs`, `panel.rs`, `density.rs` | what drawings have in common |
//! | `svg.rs`, `figure.rs`, `theme.rs`, `png.rs` | drawings as SVG, in a page or a file |
//! | `page.rs`, `page` | the page, section by section |
//!
//! Figures are drawn once, as SVG with classes instead of colours: the page colours them for light, dark
//! and print, and a PNG file is the same drawing on white. The page is well-formed XML, has its styles and
//! its few lines of script in itself, and forbids itself any other resource. Equal inputs give equal
//! bytes.

mod axis;
mod contents;
mod density;
mod details;
mod figure;
mod figures;
mod format;
mod page;
mod panel;
mod png;
mod svg;
mod theme;
mod visibilities;

use std::path::Path;

use vis2cat_formats::{PendingFile, WriteError};

pub use contents::{Contents, Truth};
pub use figure::Figure;
pub use png::write as write_pngs;
pub use visibilities::{Check, CheckOptions, UvBin, check};

use figures::Figures;

/// What is drawn and written of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    contents: Contents,
    figures: Figures,
}

impl Report {
    /// Draws all figures; corner plots of the `n_corner` sources with the highest signal-to-noise ratio.
    pub fn new(contents: Contents, n_corner: usize) -> Self {
        let figures = Figures::draw(&contents, n_corner);
        Self { contents, figures }
    }

    /// All figures, in the order of the page.
    pub fn figures(&self) -> Vec<&Figure> {
        self.figures.all()
    }

    /// The page.
    pub fn html(&self) -> String {
        page::html(&self.contents, &self.figures)
    }

    /// Writes the page, which has its name only when it is whole.
    ///
    /// # Errors
    /// The file exists and `overwrite` is false, or it cannot be written.
    pub fn write_html(&self, path: &Path, overwrite: bool) -> Result<(), WriteError> {
        let mut file = PendingFile::create(path, overwrite)?;
        file.append(self.html().as_bytes())?;
        file.commit()
    }
}
