//! Visibilities along the model against baseline length, and what is left of them.

use super::super::axis::Axis;
use super::super::figure::Figure;
use super::super::panel::{Bar, Panel, Sample, legend};
use super::super::svg::Svg;
use super::super::visibilities::{Check, UvBin};

const SIZE: [f64; 2] = [640.0, 590.0];
const LEFT: f64 = 70.0;
const WIDTH: f64 = 552.0;
/// Top and height of the three panels.
const ROWS: [[f64; 2]; 3] = [[34.0, 250.0], [296.0, 110.0], [418.0, 110.0]];

pub(super) fn draw(check: &Check) -> Option<Figure> {
    let bins = &check.bins;
    if bins.is_empty() {
        return None;
    }
    let mut svg = Svg::default();
    amplitudes(&mut svg, bins);
    pulls(&mut svg, bins);
    residuals(&mut svg, bins);
    let entries = [
        (Sample::Dot, "dot", "data, with the noise"),
        (Sample::Line, "model", "posterior mean"),
        (Sample::Area, "band", "1σ of the posterior"),
    ];
    legend(&mut svg, [LEFT + 2.0, 16.0], &entries);
    let about = "Top: amplitude of the visibilities, their real part after rotation by the model's phase, \
                 against baseline length, with what the posterior predicts. Middle: the difference in \
                 standard deviations of noise and posterior. Bottom: χ² of the visibilities less the model, \
                 for each real and imaginary part; 1 is noise alone, and the grey band its scatter. Where sources are faint, \
                 data lie above the prediction if they are those that the catalogue was made of: such sources \
                 are found where the noise is high.";
    Some(Figure::new(
        "visibilities",
        "Visibilities and model",
        about,
        SIZE,
        svg,
    ))
}

/// The middle of a bin, and its ends [kilowavelength].
fn length(bin: &UvBin) -> Bar {
    let [low, high] = bin.ends.map(|end| end / 1e3);
    Bar {
        value: (low * high).sqrt(),
        low,
        high,
    }
}

fn panel(bins: &[UvBin], row: usize, y: Axis) -> Panel {
    let [top, height] = ROWS[row];
    Panel {
        x: Axis::log(
            "Baseline length [kλ]",
            bins.iter().flat_map(|bin| length(bin).ends()),
        ),
        y,
        corner: [LEFT, top],
        size: [WIDTH, height],
    }
}

fn data(bin: &UvBin) -> Bar {
    Bar::symmetric(bin.data_ujy, bin.err_ujy)
}

fn amplitudes(svg: &mut Svg, bins: &[UvBin]) {
    let band = |bin: &UvBin| {
        let [mean, deviation] = bin.predicted_ujy;
        (length(bin).value, [mean - deviation, mean + deviation])
    };
    let ends = bins.iter().flat_map(|bin| data(bin).ends());
    let ends = ends
        .chain(bins.iter().flat_map(|bin| band(bin).1))
        .chain([0.0]);
    let panel = panel(bins, 0, Axis::around("Amplitude [µJy]", ends));
    panel.upper_frame(svg);
    panel.across(svg, "zero", 0.0);
    let bands: Vec<_> = bins.iter().map(band).collect();
    panel.band(svg, "band", &bands);
    let means: Vec<_> = bins
        .iter()
        .map(|bin| [length(bin).value, bin.predicted_ujy[0]])
        .collect();
    panel.line(svg, "model", &means);
    for bin in bins {
        points(svg, &panel, bin, data(bin));
    }
}

fn pulls(svg: &mut Svg, bins: &[UvBin]) {
    let y = Axis::about_zero("Pull", bins.iter().map(UvBin::pull).chain([3.0]));
    let panel = panel(bins, 1, y.with_ticks(5.0));
    panel.upper_frame(svg);
    panel.across(svg, "rule", 0.0);
    for bin in bins {
        points(svg, &panel, bin, Bar::exact(bin.pull()));
    }
}

fn residuals(svg: &mut Svg, bins: &[UvBin]) {
    let ends = bins.iter().flat_map(|bin| {
        [
            bin.chi2,
            1.0 - 2.0 * bin.chi2_err(),
            1.0 + 2.0 * bin.chi2_err(),
        ]
    });
    let panel = panel(bins, 2, Axis::around("χ²/dof", ends).with_ticks(4.0));
    panel.frame(svg);
    let band = |bin: &UvBin| {
        (
            length(bin).value,
            [1.0 - bin.chi2_err(), 1.0 + bin.chi2_err()],
        )
    };
    let bands: Vec<_> = bins.iter().map(band).collect();
    panel.band(svg, "scatter", &bands);
    panel.across(svg, "rule", 1.0);
    for bin in bins {
        points(svg, &panel, bin, Bar::exact(bin.chi2));
    }
}

fn points(svg: &mut Svg, panel: &Panel, bin: &UvBin, y: Bar) {
    let x = length(bin);
    let title = format!(
        "{:.2} to {:.2} kλ, {} samples: {:.1} ± {:.1} µJy, χ²/dof {:.3}",
        x.low, x.high, bin.n_sample, bin.data_ujy, bin.err_ujy, bin.chi2
    );
    svg.titled(&title, |svg| {
        panel.bars(svg, "bar", x, y);
        svg.circle("dot", panel.at(x.value, y.value), 3.2);
    });
}
