//! What was measured, against flux density: signal-to-noise ratios with the cut, and sizes.

use super::super::Contents;
use super::super::axis::Axis;
use super::super::figure::Figure;
use super::super::panel::{Bar, Panel, Sample, cross, legend};
use super::super::svg::Svg;
use super::{CORNER, LEGEND, PANEL, SIZE};
use crate::catalogue::{FoundMode, FoundRow};
use crate::detect::Status;
use crate::units::{ARCSEC, MICROJY};

const FLUX_LABEL: &str = "Flux density [µJy]";

pub(super) fn draw(contents: &Contents) -> Vec<Figure> {
    [snr(contents), scale(contents)]
        .into_iter()
        .flatten()
        .collect()
}

/// A mode, kept or not, as the figure has it.
struct Point {
    flux_ujy: Bar,
    snr: f64,
    /// Why it is no source.
    dropped: Option<Status>,
}

fn flux_ujy(row: &FoundRow) -> Bar {
    Bar::symmetric(row.flux_jy.mean / MICROJY, row.flux_jy.err / MICROJY)
}

/// Sources, then modes that are none.
fn points(contents: &Contents) -> Vec<Point> {
    let of_row = |row: &FoundRow| Point {
        flux_ujy: flux_ujy(row),
        snr: if row.snr_peak.is_nan() {
            row.snr
        } else {
            row.snr_peak
        },
        dropped: None,
    };
    let of_mode = |mode: &FoundMode| Point {
        flux_ujy: Bar::exact(mode.flux_jy / MICROJY),
        snr: mode.snr_peak,
        dropped: Some(mode.status),
    };
    let modes = contents.catalogue.modes.iter().flatten();
    let dropped = modes.filter(|mode| mode.status != Status::Kept);
    let rows = contents.catalogue.rows.iter().map(of_row);
    let points = rows.chain(dropped.map(of_mode));
    points
        .filter(|p| p.flux_ujy.value > 0.0 && p.snr > 0.0)
        .collect()
}

/// Figure 6 of Malyali et al. (2018).
fn snr(contents: &Contents) -> Option<Figure> {
    let points = points(contents);
    if points.is_empty() {
        return None;
    }
    let flux_cut_ujy = contents.details.number("search.flux_cut");
    let snr_cut = contents.details.number("search.snr_cut");
    let fluxes = points.iter().flat_map(|p| p.flux_ujy.ends());
    let panel = Panel {
        x: Axis::log(FLUX_LABEL, fluxes.chain(flux_cut_ujy)),
        y: Axis::log(
            "Matched-filter signal-to-noise ratio",
            points.iter().map(|p| p.snr).chain(snr_cut),
        ),
        corner: CORNER,
        size: PANEL,
    };
    let mut svg = Svg::default();
    panel.frame(&mut svg);
    let mut entries = vec![(Sample::Dot, "dot", "source")];
    if let Some(cut) = snr_cut {
        panel.across(&mut svg, "rule", cut);
        entries.push((Sample::Line, "rule", "cut"));
    }
    if let Some(cut) = flux_cut_ujy {
        panel.up(&mut svg, "rule", cut);
        entries.push((Sample::Line, "rule", "cut"));
    }
    for point in &points {
        let at = panel.at(point.flux_ujy.value, point.snr);
        match point.dropped {
            None => {
                panel.bars(&mut svg, "bar", point.flux_ujy, Bar::exact(point.snr));
                svg.circle("dot", at, 3.2);
            }
            Some(why) => svg.titled(why.as_str(), |svg| cross(svg, "dropped", at)),
        }
    }
    let n_dropped = points.iter().filter(|p| p.dropped.is_some()).count();
    if n_dropped > 0 {
        entries.push((Sample::Cross, "dropped", "mode that was dropped"));
    }
    legend(&mut svg, LEGEND, &entries);
    let cut = match (snr_cut, flux_cut_ujy) {
        (Some(cut), _) => format!(" The dashed line is the cut, a signal-to-noise ratio of {cut}."),
        (_, Some(cut)) => format!(" The dashed line is the cut, {cut:.1} µJy."),
        _ => String::new(),
    };
    let dropped = match n_dropped {
        0 => String::new(),
        n => format!(" and {n} modes that were dropped"),
    };
    let about = format!(
        "Signal-to-noise ratios in the visibilities against flux density, of {} sources{dropped}.{cut}",
        points.len() - n_dropped
    );
    Some(Figure::new(
        "snr_flux",
        "Signal-to-noise ratio and flux density",
        &about,
        SIZE,
        svg,
    ))
}

/// Figure 4 of Malyali et al. (2018).
fn scale(contents: &Contents) -> Option<Figure> {
    let scale =
        |row: &FoundRow| Bar::symmetric(row.scale_rad.mean / ARCSEC, row.scale_rad.err / ARCSEC);
    let rows = contents.catalogue.rows.iter();
    let points: Vec<(Bar, Bar)> = rows
        .map(|row| (flux_ujy(row), scale(row)))
        .filter(|(x, y)| x.value > 0.0 && y.value > 0.0)
        .collect();
    if points.is_empty() {
        return None;
    }
    // An error as large as the value would take a logarithm far down.
    let scales = points
        .iter()
        .flat_map(|(_, y)| [y.low.max(0.3 * y.value), y.high]);
    let panel = Panel {
        x: Axis::log(FLUX_LABEL, points.iter().flat_map(|(x, _)| x.ends())),
        y: Axis::log("Scale-length [arcsec]", scales),
        corner: CORNER,
        size: PANEL,
    };
    let mut svg = Svg::default();
    panel.frame(&mut svg);
    for (x, y) in &points {
        panel.bars(&mut svg, "bar", *x, *y);
        svg.circle("dot", panel.at(x.value, y.value), 3.2);
    }
    let about = "Scale-lengths, the harmonic mean of both axes, against flux density. Posterior means \
                 with their standard deviations.";
    Some(Figure::new(
        "scale_flux",
        "Size and flux density",
        about,
        SIZE,
        svg,
    ))
}
