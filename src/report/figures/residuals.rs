//! Estimates less the truth, against the truth: Figures 7 to 9 of Malyali et al. (2018).

use super::super::Contents;
use super::super::axis::Axis;
use super::super::contents::Truth;
use super::super::figure::Figure;
use super::super::panel::{Bar, Panel};
use super::super::svg::Svg;
use crate::catalogue::{CatalogueSource, FoundRow};
use crate::evaluate::{MatchedRow, PARAMETERS};
use crate::units::{ARCSEC, MICROJY};

const SIZE: [f64; 2] = [560.0, 300.0];
const CORNER: [f64; 2] = [70.0, 14.0];
const PANEL: [f64; 2] = [474.0, 236.0];

/// What is compared: the parameter, its axis, and what it is drawn against.
struct Residual {
    name: &'static str,
    title: &'static str,
    label: &'static str,
    against: Against,
    err: fn(&FoundRow) -> f64,
}

/// A true quantity: its label, whether it is spread logarithmically, its value.
type Against = (&'static str, bool, fn(&CatalogueSource) -> f64);

const TRUE_FLUX: Against = ("True flux density [µJy]", true, |s| s.flux_jy / MICROJY);

/// In the order of [`PARAMETERS`].
const RESIDUALS: [Residual; PARAMETERS.len()] = [
    Residual {
        name: "truth_ra",
        title: "Right ascension against the truth",
        label: "Offset to the east [arcsec]",
        against: TRUE_FLUX,
        err: |row| row.e_ra_rad / ARCSEC,
    },
    Residual {
        name: "truth_dec",
        title: "Declination against the truth",
        label: "Offset to the north [arcsec]",
        against: TRUE_FLUX,
        err: |row| row.e_dec_rad / ARCSEC,
    },
    Residual {
        name: "truth_flux",
        title: "Flux density against the truth",
        label: "Estimate − truth [µJy]",
        against: TRUE_FLUX,
        err: |row| row.flux_jy.err / MICROJY,
    },
    Residual {
        name: "truth_scale",
        title: "Scale-length against the truth",
        label: "Estimate − truth [arcsec]",
        against: ("True scale-length [arcsec]", true, |s| s.scale_rad / ARCSEC),
        err: |row| row.scale_rad.err / ARCSEC,
    },
    Residual {
        name: "truth_e1",
        title: "Ellipticity e₁ against the truth",
        label: "Estimate − truth",
        against: ("True e₁", false, |s| s.e.e1),
        err: |row| row.e1.err,
    },
    Residual {
        name: "truth_e2",
        title: "Ellipticity e₂ against the truth",
        label: "Estimate − truth",
        against: ("True e₂", false, |s| s.e.e2),
        err: |row| row.e2.err,
    },
    Residual {
        name: "truth_index",
        title: "Spectral index against the truth",
        label: "Estimate − truth",
        against: ("True spectral index", false, |s| s.spectral_index),
        err: |row| row.spectral_index.err,
    },
];
/// How they stand in the page: flux, size, shape, position, spectrum.
const ORDER: [usize; PARAMETERS.len()] = [2, 3, 4, 5, 0, 1, 6];

pub(super) fn draw(contents: &Contents, truth: &Truth) -> Vec<Figure> {
    ORDER
        .into_iter()
        .filter_map(|which| one(contents, truth, which))
        .collect()
}

fn one(contents: &Contents, truth: &Truth, which: usize) -> Option<Figure> {
    let residual = &RESIDUALS[which];
    let (label, is_log, value) = residual.against;
    let point = |matched: &MatchedRow| {
        let row = &contents.catalogue.rows[matched.row - 1];
        let x = value(&truth.list.sources[matched.truth_row - 1]);
        let y = Bar::symmetric(matched.differences[which], (residual.err)(row));
        let is_shown = y.value.is_finite() && x.is_finite() && (x > 0.0 || !is_log);
        is_shown.then(|| (contents.title(matched.row - 1), x, y))
    };
    let points: Vec<_> = truth.evaluation.matched.iter().filter_map(point).collect();
    if points.is_empty() {
        return None;
    }
    let xs = points.iter().map(|(_, x, _)| *x);
    let panel = Panel {
        x: if is_log {
            Axis::log(label, xs)
        } else {
            Axis::around(label, xs)
        },
        y: Axis::about_zero(residual.label, points.iter().flat_map(|(.., y)| y.ends())),
        corner: CORNER,
        size: PANEL,
    };
    let mut svg = Svg::default();
    panel.frame(&mut svg);
    panel.across(&mut svg, "rule", 0.0);
    for (title, x, y) in &points {
        svg.titled(title, |svg| {
            panel.bars(svg, "bar", Bar::exact(*x), *y);
            svg.circle("dot", panel.at(*x, y.value), 3.2);
        });
    }
    let about = about(truth, which, points.len());
    Some(Figure::new(
        residual.name,
        residual.title,
        &about,
        SIZE,
        svg,
    ))
}

/// Bias, pulls and coverage in words.
fn about(truth: &Truth, which: usize, n: usize) -> String {
    let (name, unit) = PARAMETERS[which];
    let unit = match unit {
        "" => "",
        "uJy" => " µJy",
        _ => " arcsec",
    };
    let report = truth.evaluation.parameters.iter().find(|p| p.name == name);
    let Some(report) = report else {
        return format!("{n} sources.");
    };
    let [in_68, in_95] = report.coverage.map(|c| c.covered);
    let pulls = if report.pull_rms.is_finite() {
        format!(
            "; pulls: mean {:.2}, rms {:.2}, largest {:.1}",
            report.pull_mean, report.pull_rms, report.pull_largest
        )
    } else {
        String::new()
    };
    format!(
        "{n} sources; mean {:.3} ± {:.3}{unit}{pulls}; the truth is within {} of {} intervals of 68% \
         and {} of {} of 95%.",
        report.bias.value, report.bias.err, in_68.n, in_68.of, in_95.n, in_95.of
    )
    .replace('-', "\u{2212}")
}
