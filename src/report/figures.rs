//! The figures of a report, one a file.

mod corner;
mod field;
mod flux;
mod rates;
mod reliability;
mod residuals;
mod roc;
mod visibilities;

use super::Contents;
use super::figure::Figure;

/// Width and height of a figure of one panel, and where its panel is [px].
const SIZE: [f64; 2] = [560.0, 420.0];
const CORNER: [f64; 2] = [64.0, 34.0];
const PANEL: [f64; 2] = [480.0, 336.0];
/// Where its legend begins.
const LEGEND: [f64; 2] = [66.0, 16.0];

/// All figures, by where they stand.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Figures {
    pub(super) field: Option<Figure>,
    pub(super) measurements: Vec<Figure>,
    pub(super) truth: Vec<Figure>,
    pub(super) visibilities: Option<Figure>,
    /// Corner plots with the rows that they are of.
    pub(super) corners: Vec<(usize, Figure)>,
}

impl Figures {
    pub(super) fn draw(contents: &Contents, n_corner: usize) -> Self {
        let truth = contents.truth.as_ref().map_or_else(Vec::new, |truth| {
            let mut figures = residuals::draw(contents, truth);
            figures.extend(rates::draw(truth));
            figures.extend(roc::draw(truth));
            figures.extend(reliability::draw(truth));
            figures
        });
        let chosen = contents.by_snr().into_iter().take(n_corner);
        let mut corners: Vec<(usize, Figure)> = chosen
            .filter_map(|row| Some((row, corner::draw(contents, row)?)))
            .collect();
        corners.sort_by_key(|(row, _)| *row);
        Self {
            field: field::draw(contents),
            measurements: flux::draw(contents),
            truth,
            visibilities: contents.check.as_ref().and_then(visibilities::draw),
            corners,
        }
    }

    pub(super) fn all(&self) -> Vec<&Figure> {
        let corners = self.corners.iter().map(|(_, figure)| figure);
        (self.field.iter())
            .chain(&self.measurements)
            .chain(&self.truth)
            .chain(&self.visibilities)
            .chain(corners)
            .collect()
    }
}
