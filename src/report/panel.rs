//! A panel: two axes, and what is drawn between them.

use super::axis::Axis;
use super::svg::{Anchor, Svg, polyline};

/// Pixels between the frame and the numbers.
const GAP: f64 = 6.0;
/// Half the size of a cross.
const CROSS: f64 = 3.5;

/// A rectangle of a drawing with an axis below and one to the left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Panel {
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// Left and upper edge [px].
    pub(super) corner: [f64; 2],
    /// Width and height [px].
    pub(super) size: [f64; 2],
}

/// A value with the ends of its error bars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bar {
    pub(super) value: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Bar {
    /// A value with the same error on both sides; none where it is not known.
    pub(super) fn symmetric(value: f64, err: f64) -> Self {
        let err = if err.is_finite() { err } else { 0.0 };
        Self {
            value,
            low: value - err,
            high: value + err,
        }
    }

    /// A value without error.
    pub(super) fn exact(value: f64) -> Self {
        Self::symmetric(value, 0.0)
    }

    /// Both ends.
    pub(super) fn ends(self) -> [f64; 2] {
        [self.low, self.high]
    }
}

impl Panel {
    /// The place of a pair of values [px].
    pub(super) fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let ([left, top], [width, height]) = (self.corner, self.size);
        [
            left + width * self.x.place(x),
            top + height * (1.0 - self.y.place(y)),
        ]
    }

    /// Grid, frame, ticks, numbers and labels.
    pub(super) fn frame(&self, svg: &mut Svg) {
        self.grid(svg);
        svg.rect("frame", self.corner, self.size);
        self.numbers_below(svg);
        self.numbers_left(svg, 44.0);
    }

    /// The same without anything below: of a panel that stands on another.
    pub(super) fn upper_frame(&self, svg: &mut Svg) {
        self.grid(svg);
        svg.rect("frame", self.corner, self.size);
        self.numbers_left(svg, 44.0);
    }

    fn grid(&self, svg: &mut Svg) {
        let ([left, top], [width, height]) = (self.corner, self.size);
        let mut d = String::new();
        for tick in self.x.ticks().iter().filter(|t| t.label.is_some()) {
            let x = left + width * tick.at;
            d.push_str(&polyline(&[[x, top], [x, top + height]]));
        }
        for tick in self.y.ticks().iter().filter(|t| t.label.is_some()) {
            let y = top + height * (1.0 - tick.at);
            d.push_str(&polyline(&[[left, y], [left + width, y]]));
        }
        svg.path("grid", &d);
    }

    /// Numbers and label of the x axis.
    fn numbers_below(&self, svg: &mut Svg) {
        let ([left, top], [width, height]) = (self.corner, self.size);
        let bottom = top + height;
        let mut marks = String::new();
        for tick in self.x.ticks() {
            let x = left + width * tick.at;
            let length = if tick.label.is_some() { 4.0 } else { 2.5 };
            marks.push_str(&polyline(&[[x, bottom], [x, bottom + length]]));
            if let Some(label) = tick.label {
                svg.text("tick", Anchor::Middle, [x, bottom + GAP + 11.0], &label);
            }
        }
        svg.path("mark", &marks);
        let middle = [left + 0.5 * width, bottom + 38.0];
        svg.text("label", Anchor::Middle, middle, &self.x.label);
    }

    /// Numbers and label of the y axis, the label `away` from the frame.
    fn numbers_left(&self, svg: &mut Svg, away: f64) {
        let ([left, top], [_, height]) = (self.corner, self.size);
        let mut marks = String::new();
        for tick in self.y.ticks() {
            let y = top + height * (1.0 - tick.at);
            let length = if tick.label.is_some() { 4.0 } else { 2.5 };
            marks.push_str(&polyline(&[[left - length, y], [left, y]]));
            if let Some(label) = tick.label {
                svg.text("tick", Anchor::End, [left - GAP - 1.0, y + 4.0], &label);
            }
        }
        svg.path("mark", &marks);
        svg.text_up("label", [left - away, top + 0.5 * height], &self.y.label);
    }

    /// A line through pairs of values.
    pub(super) fn line(&self, svg: &mut Svg, class: &str, points: &[[f64; 2]]) {
        let points: Vec<[f64; 2]> = points.iter().map(|&[x, y]| self.at(x, y)).collect();
        svg.line(class, &points);
    }

    /// The area between two values of y along x.
    pub(super) fn band(&self, svg: &mut Svg, class: &str, points: &[(f64, [f64; 2])]) {
        let upper = points.iter().map(|&(x, [_, high])| self.at(x, high));
        let lower = points.iter().rev().map(|&(x, [low, _])| self.at(x, low));
        let around: Vec<[f64; 2]> = upper.chain(lower).collect();
        let mut d = polyline(&around);
        if !d.is_empty() {
            d.push('Z');
        }
        svg.path(class, &d);
    }

    /// A line across at `y`, if that is in the panel.
    pub(super) fn across(&self, svg: &mut Svg, class: &str, y: f64) {
        if self.y.holds(y) {
            let [low, high] = self.x.ends();
            self.line(svg, class, &[[low, y], [high, y]]);
        }
    }

    /// A line up at `x`, if that is in the panel.
    pub(super) fn up(&self, svg: &mut Svg, class: &str, x: f64) {
        if self.x.holds(x) {
            let [low, high] = self.y.ends();
            self.line(svg, class, &[[x, low], [x, high]]);
        }
    }

    /// Error bars through a pair of values; bars without length are left out.
    pub(super) fn bars(&self, svg: &mut Svg, class: &str, x: Bar, y: Bar) {
        let mut d = String::new();
        if x.low < x.high {
            let ends = [self.at(x.low, y.value), self.at(x.high, y.value)];
            d.push_str(&polyline(&ends));
        }
        if y.low < y.high {
            let ends = [self.at(x.value, y.low), self.at(x.value, y.high)];
            d.push_str(&polyline(&ends));
        }
        svg.path(class, &d);
    }
}

/// A cross about a place, for what is not a source.
pub(super) fn cross(svg: &mut Svg, class: &str, [x, y]: [f64; 2]) {
    let c = CROSS;
    let mut d = polyline(&[[x - c, y - c], [x + c, y + c]]);
    d.push_str(&polyline(&[[x - c, y + c], [x + c, y - c]]));
    svg.path(class, &d);
}

/// A plus about a place, for what is true.
pub(super) fn plus(svg: &mut Svg, class: &str, [x, y]: [f64; 2]) {
    let c = CROSS * 2.0;
    let mut d = polyline(&[[x - c, y], [x + c, y]]);
    d.push_str(&polyline(&[[x, y - c], [x, y + c]]));
    svg.path(class, &d);
}

/// How an entry of a legend looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sample {
    Dot,
    Cross,
    Plus,
    Line,
    Area,
}

/// Entries in a row from `corner` on: how they look, their class, what they mean.
pub(super) fn legend(svg: &mut Svg, corner: [f64; 2], entries: &[(Sample, &str, &str)]) {
    let [mut x, y] = corner;
    for (sample, class, meaning) in entries {
        let at = [x + 6.0, y];
        match sample {
            Sample::Dot => svg.circle(class, at, 4.0),
            Sample::Cross => cross(svg, class, at),
            Sample::Plus => plus(svg, class, at),
            Sample::Line => svg.line(class, &[[x - 4.0, y], [x + 14.0, y]]),
            Sample::Area => svg.rect(class, [x - 4.0, y - 5.0], [18.0, 10.0]),
        }
        svg.text("tick", Anchor::Start, [x + 19.0, y + 4.0], meaning);
        // What a letter takes on the mean, and room between entries.
        x += 19.0 + 6.3 * meaning.chars().count() as f64 + 22.0;
    }
}
