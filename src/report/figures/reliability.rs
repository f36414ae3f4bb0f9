//! Is `P_source` a probability?

use super::super::axis::Axis;
use super::super::contents::Truth;
use super::super::figure::Figure;
use super::super::panel::{Bar, Panel, Sample, legend};
use super::super::svg::{Anchor, Svg};
use super::{CORNER, LEGEND, SIZE};
use crate::evaluate::ReliabilityBin;

pub(super) fn draw(truth: &Truth) -> Option<Figure> {
    let bins = truth.evaluation.reliability.iter();
    let bins: Vec<&ReliabilityBin> = bins.filter(|bin| bin.is_true.of > 0).collect();
    if bins.is_empty() {
        return None;
    }
    let panel = Panel {
        x: Axis::linear("Mean P_source of the modes in a bin", [-0.02, 1.04]),
        y: Axis::linear("Part of them that is true", [-0.02, 1.08]),
        corner: CORNER,
        size: [336.0, 336.0],
    };
    let mut svg = Svg::default();
    panel.frame(&mut svg);
    panel.line(&mut svg, "rule", &[[0.0, 0.0], [1.0, 1.0]]);
    for bin in &bins {
        let part = bin.is_true;
        let y = Bar {
            value: part.value,
            low: part.low,
            high: part.high,
        };
        panel.bars(&mut svg, "bar", Bar::exact(bin.mean_p), y);
        let at = panel.at(bin.mean_p, part.value);
        svg.circle("dot", at, 3.6);
        let count = format!("{}/{}", part.n, part.of);
        // Beside the point, towards the middle.
        let (anchor, aside) = if bin.mean_p > 0.5 {
            (Anchor::End, -7.0)
        } else {
            (Anchor::Start, 7.0)
        };
        svg.text("small", anchor, [at[0] + aside, at[1] - 5.0], &count);
    }
    legend(
        &mut svg,
        LEGEND,
        &[(Sample::Line, "rule", "as it should be")],
    );
    let about = format!(
        "The modes of {} in tenths of P_source: how many are true, with intervals of 68%.",
        truth.evaluation.modes_table
    );
    Some(Figure::new(
        "reliability",
        "Reliability of P_source",
        &about,
        SIZE,
        svg,
    ))
}
