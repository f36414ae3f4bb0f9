//! The posterior of one source: every parameter, and every pair.

mod parameters;

use std::fmt::Write as _;

use self::parameters::{Parameter, parameters};
use super::super::Contents;
use super::super::axis::Tick;
use super::super::density::{Density, histogram};
use super::super::figure::Figure;
use super::super::panel::{Panel, Sample, legend};
use super::super::svg::{Anchor, Svg, polyline, px};

/// Side of a panel, and from one to the next [px].
const SIDE: f64 = 88.0;
const STEP: f64 = 96.0;
/// Left and upper edge of the first.
const CORNER: [f64; 2] = [62.0, 22.0];
const BELOW: f64 = 58.0;
/// Width of a small letter [px].
const LETTER: f64 = 5.4;

/// Bins of a histogram, and of each side of a density.
const N_BIN: usize = 30;
const N_CELL: usize = 26;
/// What contours hold: what one and two standard deviations of a Gaussian do in two dimensions.
const PARTS: [(f64, &str); 2] = [(0.865, "outer"), (0.393, "inner")];

pub(super) fn draw(contents: &Contents, row: usize) -> Option<Figure> {
    let samples = contents.catalogue.samples.as_ref()?;
    let weights = samples
        .weight
        .get(contents.catalogue.rows[row].samples.clone())?;
    let parameters = parameters(contents, row);
    if parameters.is_empty() {
        return None;
    }
    let mut svg = Svg::default();
    frames(&mut svg, parameters.len());
    for (j, down) in parameters.iter().enumerate() {
        for (i, across) in parameters[..j].iter().enumerate() {
            pair(
                &mut svg,
                &panel(i, j, across, down),
                [across, down],
                weights,
            );
        }
        single(&mut svg, &panel(j, j, down, down), down, weights);
        numbers_below(&mut svg, j, down, parameters.len());
        if j > 0 {
            numbers_left(&mut svg, j, down);
        }
    }
    let n = parameters.len() as f64;
    let side = CORNER[0] + n * STEP;
    let mut entries = vec![
        (Sample::Area, "inner", "39%"),
        (Sample::Area, "outer", "86%"),
    ];
    entries.push((Sample::Line, "mean", "mean"));
    if parameters.iter().any(|p| p.truth.is_some()) {
        entries.push((Sample::Line, "truth", "truth"));
    }
    for (i, entry) in entries.iter().enumerate() {
        let corner = [CORNER[0] + 4.0 * STEP, CORNER[1] + 12.0 + 18.0 * i as f64];
        legend(&mut svg, corner, std::slice::from_ref(entry));
    }
    let about = format!(
        "{} weighted samples; contours hold 39% and 86% of the weight. Offsets are from the mean position.",
        weights.len()
    );
    let title = format!("Posterior of {}", contents.title(row));
    let size = [side, CORNER[1] + n * STEP + BELOW - (STEP - SIDE)];
    Some(Figure::new(
        &contents.anchor(row),
        &title,
        &about,
        size,
        svg,
    ))
}

fn panel(column: usize, line: usize, across: &Parameter, down: &Parameter) -> Panel {
    Panel {
        x: across.axis.clone(),
        y: down.axis.clone(),
        corner: [
            CORNER[0] + STEP * column as f64,
            CORNER[1] + STEP * line as f64,
        ],
        size: [SIDE, SIDE],
    }
}

/// The frames of all panels in one path.
fn frames(svg: &mut Svg, n: usize) {
    let mut d = String::new();
    for (column, line) in (0..n).flat_map(|line| (0..=line).map(move |column| (column, line))) {
        let [x, y] = [
            CORNER[0] + STEP * column as f64,
            CORNER[1] + STEP * line as f64,
        ]
        .map(px);
        let _ = write!(d, "M{x} {y}h{SIDE}v{SIDE}h-{SIDE}z");
    }
    svg.path("frame", &d);
}

/// Contours of a pair of parameters.
fn pair(svg: &mut Svg, panel: &Panel, [across, down]: [&Parameter; 2], weights: &[f64]) {
    let bins = [across.bins(N_CELL), down.bins(N_CELL)];
    let density = Density::new([&across.values, &down.values], weights, bins);
    let [left, top] = panel.corner;
    for (part, class) in PARTS {
        let mut d = String::new();
        for line in density.contour(part) {
            let place = |[x, y]: [f64; 2]| [left + SIDE * x, top + SIDE * (1.0 - y)];
            closed(&mut d, line.into_iter().map(place));
        }
        svg.path(class, &d);
    }
    marks(svg, panel, across, down);
}

/// Adds a closed line by its steps, in tenths of a pixel so that no rounding adds up; steps of nothing
/// are left out.
fn closed(d: &mut String, points: impl Iterator<Item = [f64; 2]>) {
    let mut at: Option<[i64; 2]> = None;
    for point in points {
        let to = point.map(|x| (10.0 * x).round() as i64);
        match at {
            None => {
                let [x, y] = to.map(|x| px(x as f64 / 10.0));
                let _ = write!(d, "M{x} {y}l");
            }
            Some(from) if from == to => continue,
            Some([x, y]) => {
                let [dx, dy] = [to[0] - x, to[1] - y].map(|x| px(x as f64 / 10.0));
                // A minus sign separates numbers as well as a blank does.
                let gap = if dy.starts_with('-') { "" } else { " " };
                let before = if d.ends_with('l') || dx.starts_with('-') {
                    ""
                } else {
                    " "
                };
                let _ = write!(d, "{before}{dx}{gap}{dy}");
            }
        }
        at = Some(to);
    }
    if d.ends_with('l') {
        d.push_str("0 0");
    }
    if at.is_some() {
        d.push('z');
    }
}

/// Mean and truth of a pair.
fn marks(svg: &mut Svg, panel: &Panel, across: &Parameter, down: &Parameter) {
    let [x, y] = panel.at(across.mean, down.mean);
    let plus = polyline(&[[x - 3.0, y], [x + 3.0, y]]) + &polyline(&[[x, y - 3.0], [x, y + 3.0]]);
    svg.path("mean", &plus);
    if let (Some(x), Some(y)) = (across.truth, down.truth)
        && panel.x.holds(x)
        && panel.y.holds(y)
    {
        let [x, y] = panel.at(x, y);
        svg.line(
            "truth",
            &[
                [x, y - 3.5],
                [x + 3.5, y],
                [x, y + 3.5],
                [x - 3.5, y],
                [x, y - 3.5],
            ],
        );
    }
}

/// The histogram of one parameter, with its mean and error above.
fn single(svg: &mut Svg, panel: &Panel, parameter: &Parameter, weights: &[f64]) {
    let counts = histogram(&parameter.values, weights, parameter.bins(N_BIN));
    let most = counts.iter().copied().fold(0.0, f64::max);
    let [left, top] = panel.corner;
    let bottom = top + SIDE;
    let step = SIDE / counts.len() as f64;
    let mut d = format!("M{} {}", px(left), px(bottom));
    for (i, count) in counts.iter().enumerate() {
        let y = bottom - 0.92 * SIDE * count / most;
        let _ = write!(d, "V{}H{}", px(y), px(left + step * (i + 1) as f64));
    }
    let _ = write!(d, "V{}z", px(bottom));
    svg.path("columns", &d);
    let mut line = |class: &str, value: f64| {
        if panel.x.holds(value) {
            let x = left + SIDE * panel.x.place(value);
            svg.line(class, &[[x, bottom], [x, top]]);
        }
    };
    line("mean", parameter.mean);
    if let Some(truth) = parameter.truth {
        line("truth", truth);
    }
    svg.text(
        "small",
        Anchor::Start,
        [left, top - 5.0],
        &parameter.estimate(),
    );
}

/// Marks, numbers and label below a column.
fn numbers_below(svg: &mut Svg, column: usize, parameter: &Parameter, n: usize) {
    let left = CORNER[0] + STEP * column as f64;
    let bottom = CORNER[1] + STEP * n as f64 - (STEP - SIDE);
    let place = |tick: &Tick| left + SIDE * tick.at;
    let ticks = parameter.axis.ticks();
    let marks = ticks.iter().map(place);
    let marks = marks.map(|x| polyline(&[[x, bottom], [x, bottom + 3.0]]));
    svg.path("mark", &marks.collect::<String>());
    let inner: Vec<(f64, &str)> = inner(&ticks)
        .map(|(tick, label)| (place(tick), label))
        .collect();
    let longest = inner.iter().map(|(_, label)| label.chars().count()).max();
    let width = LETTER * longest.unwrap_or(0) as f64 + LETTER;
    // Every second, if they would touch.
    let is_tight = inner.windows(2).any(|two| two[1].0 - two[0].0 < width);
    for (x, label) in inner.into_iter().step_by(if is_tight { 2 } else { 1 }) {
        svg.text("small", Anchor::Middle, [x, bottom + 14.0], label);
    }
    let middle = [left + 0.5 * SIDE, bottom + 32.0];
    svg.text("note", Anchor::Middle, middle, &parameter.axis.label);
}

/// The same left of a line of panels.
fn numbers_left(svg: &mut Svg, line: usize, parameter: &Parameter) {
    let top = CORNER[1] + STEP * line as f64;
    let place = |tick: &Tick| top + SIDE * (1.0 - tick.at);
    let ticks = parameter.axis.ticks();
    let marks = ticks.iter().map(place);
    let marks = marks.map(|y| polyline(&[[CORNER[0] - 3.0, y], [CORNER[0], y]]));
    svg.path("mark", &marks.collect::<String>());
    for (tick, label) in inner(&ticks) {
        let at = [CORNER[0] - 6.0, place(tick) + 3.5];
        svg.text("small", Anchor::End, at, label);
    }
    let middle = [CORNER[0] - 42.0, top + 0.5 * SIDE];
    svg.text_up("note", middle, &parameter.axis.label);
}

/// Ticks with their numbers, but for those at the ends, where there are those of the next panel.
fn inner(ticks: &[Tick]) -> impl Iterator<Item = (&Tick, &str)> {
    let inner = ticks.iter().filter(|tick| (0.1..=0.9).contains(&tick.at));
    inner.filter_map(|tick| Some((tick, tick.label.as_deref()?)))
}
