//! What was found and what is real, by signal-to-noise ratio.

use super::super::axis::Axis;
use super::super::contents::Truth;
use super::super::figure::Figure;
use super::super::panel::{Bar, Panel, Sample, legend};
use super::super::svg::Svg;
use super::{CORNER, LEGEND, PANEL, SIZE};
use crate::evaluate::{Bin, Fraction};

pub(super) fn draw(truth: &Truth) -> Option<Figure> {
    let binned = truth.evaluation.bins.iter().find(|b| b.name == "SNR")?;
    let bins = &binned.bins;
    let edges = bins
        .iter()
        .flat_map(|bin| [bin.low, bin.high])
        .filter(|e| e.is_finite());
    let edges: Vec<f64> = edges.collect();
    if edges.is_empty() {
        return None;
    }
    // The first bin begins at 0, which has no logarithm.
    let first = bins
        .iter()
        .map(|b| b.low)
        .find(|low| *low > 0.0)
        .unwrap_or(1.0);
    let panel = Panel {
        x: Axis::log(
            "Signal-to-noise ratio",
            edges.iter().map(|edge| edge.max(0.5 * first)),
        ),
        y: Axis::linear("Fraction", [-0.03, 1.06]),
        corner: CORNER,
        size: PANEL,
    };
    let mut svg = Svg::default();
    panel.frame(&mut svg);
    series(&panel, &mut svg, bins, ["bar", "dot"], -1.0, |bin| {
        bin.completeness
    });
    series(
        &panel,
        &mut svg,
        bins,
        ["modelbar", "modeldot"],
        1.0,
        |bin| bin.purity,
    );
    let entries = [
        (Sample::Dot, "dot", "completeness, by true SNR"),
        (Sample::Dot, "modeldot", "purity, by estimated SNR"),
    ];
    legend(&mut svg, LEGEND, &entries);
    let e = &truth.evaluation;
    let about = format!(
        "{} of {} true sources in the field were found, {} of {} sources are true. Bars across are bins, \
         bars up intervals of 68%.",
        e.completeness.n, e.completeness.of, e.purity.n, e.purity.of
    );
    Some(Figure::new(
        "rates",
        "Completeness and purity",
        &about,
        SIZE,
        svg,
    ))
}

/// One fraction in all bins; the points of two series are a little apart.
fn series(
    panel: &Panel,
    svg: &mut Svg,
    bins: &[Bin],
    [bar, dot]: [&str; 2],
    side: f64,
    fraction: fn(&Bin) -> Fraction,
) {
    let [lowest, highest] = panel.x.ends();
    for bin in bins {
        let Fraction {
            n,
            of,
            value,
            low,
            high,
        } = fraction(bin);
        if of == 0 {
            continue;
        }
        let (from, to) = (bin.low.max(lowest), bin.high.min(highest));
        let x = Bar {
            value: (from * to).sqrt() * (to / from).powf(0.07 * side),
            low: from,
            high: to,
        };
        let title = format!("SNR {} to {}: {n} of {of}", bin.low, bin.high);
        svg.titled(&title, |svg| {
            panel.bars(svg, bar, x, Bar { value, low, high });
            svg.circle(dot, panel.at(x.value, value), 3.6);
        });
    }
}
