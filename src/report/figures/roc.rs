//! ROC curves: what a cut on one column or another would have kept.

use super::super::axis::Axis;
use super::super::contents::Truth;
use super::super::figure::Figure;
use super::super::panel::{Panel, Sample, legend};
use super::super::svg::Svg;
use super::{CORNER, LEGEND};
use crate::evaluate::Curve;

/// Room to the right for the legend.
const SIZE: [f64; 2] = [600.0, 420.0];
/// Lines of the curves, in the order of the evaluation.
const CLASSES: [&str; 3] = ["line", "model", "thirdline"];

/// None without true or without false modes: rates of nothing are not defined.
pub(super) fn draw(truth: &Truth) -> Option<Figure> {
    let curves = truth.evaluation.curves.iter();
    let curves: Vec<&Curve> = curves.filter(|c| c.n_true > 0 && c.n_false > 0).collect();
    let first = curves.first()?;
    let panel = Panel {
        x: Axis::linear("False positive rate", [-0.02, 1.02]),
        y: Axis::linear("True positive rate", [-0.02, 1.02]),
        corner: CORNER,
        size: [336.0, 336.0],
    };
    let mut svg = Svg::default();
    panel.frame(&mut svg);
    panel.line(&mut svg, "rule", &[[0.0, 0.0], [1.0, 1.0]]);
    let mut entries = Vec::new();
    for (curve, class) in curves.iter().zip(CLASSES) {
        let points = curve.points.iter();
        let points = points.map(|p| [p.false_positive_rate, p.true_positive_rate]);
        let points: Vec<[f64; 2]> = std::iter::once([0.0, 0.0]).chain(points).collect();
        panel.line(&mut svg, class, &points);
        entries.push((class, format!("{}, area {:.3}", curve.score, curve.area)));
    }
    for (i, (class, text)) in entries.iter().enumerate() {
        legend(
            &mut svg,
            [420.0, 60.0 + 20.0 * i as f64],
            &[(Sample::Line, class, text)],
        );
    }
    legend(&mut svg, LEGEND, &[(Sample::Line, "rule", "by chance")]);
    let about = format!(
        "Of {} true and {} false modes in {}, the parts that a cut on each column keeps.",
        first.n_true, first.n_false, first.table
    );
    Some(Figure::new("roc", "ROC curves", &about, SIZE, svg))
}
