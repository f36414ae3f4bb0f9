//! Axes: from values to places along them, and round numbers to label them with.

use super::format::number;

/// Largest number of labelled ticks.
const MOST_TICKS: f64 = 7.0;
/// Range of a logarithmic axis from which its numbers are 1, 2 and 5 times powers of ten: there are too few of
/// these in a smaller one.
const LOG_TICKS_FROM: f64 = 4.0;
/// Part of the range that is left free at either end.
const MARGIN: f64 = 0.05;

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Spread {
    Linear,
    Log,
}

/// One axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// What it shows, with the unit in brackets.
    pub(super) label: String,
    spread: Spread,
    low: f64,
    high: f64,
    is_reversed: bool,
    most_ticks: f64,
}

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// Its place, 0 to 1.
    pub(super) at: f64,
    /// Its number; none between two numbers.
    pub(super) label: Option<String>,
}

impl Axis {
    /// A linear axis from `low` to `high`.
    pub(super) fn linear(label: &str, [low, high]: [f64; 2]) -> Self {
        let (low, high) = if low < high {
            (low, high)
        } else {
            (low - 0.5, low + 0.5)
        };
        Self {
            label: label.to_owned(),
            spread: Spread::Linear,
            low,
            high,
            is_reversed: false,
            most_ticks: MOST_TICKS,
        }
    }

    /// A linear axis over all finite `values`, with some room about them.
    pub(super) fn around(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let [low, high] = range(values).unwrap_or([0.0, 1.0]);
        let room = MARGIN * (high - low);
        Self::linear(label, [low - room, high + room])
    }

    /// A linear axis that 0 is the middle of.
    pub(super) fn about_zero(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let most = range(values).map_or(1.0, |[low, high]| low.abs().max(high.abs()));
        let most = (1.0 + 2.0 * MARGIN) * if most > 0.0 { most } else { 1.0 };
        Self::linear(label, [-most, most])
    }

    /// A logarithmic axis over all finite `values` above 0, with some room about them.
    pub(super) fn log(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let positive = values.into_iter().filter(|v| *v > 0.0);
        let [low, high] = range(positive).unwrap_or([1.0, 10.0]);
        // At least a factor of two, so that there is a round number in it.
        let room = (high / low).powf(MARGIN).max((2.0 * low / high).sqrt());
        Self {
            spread: Spread::Log,
            ..Self::linear(label, [low / room, high * room])
        }
    }

    /// The same with its low end on the right, as right ascension has it.
    pub(super) fn reversed(self) -> Self {
        Self {
            is_reversed: true,
            ..self
        }
    }

    /// The same with at most so many numbers.
    pub(super) fn with_ticks(self, most_ticks: f64) -> Self {
        Self { most_ticks, ..self }
    }

    /// Both ends.
    pub(super) fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The place of a value, 0 at the low end and 1 at the high one; what lies outside is moved to the
    /// end.
    pub(super) fn place(&self, value: f64) -> f64 {
        let along = match self.spread {
            Spread::Linear => (value - self.low) / (self.high - self.low),
            // A logarithm of what is not above 0 lies below every other.
            Spread::Log if value <= 0.0 => 0.0,
            Spread::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        let along = along.clamp(0.0, 1.0);
        if self.is_reversed { 1.0 - along } else { along }
    }

    /// Whether a value lies between the ends.
    pub(super) fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Marks from the low to the high end.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        let ticks = match self.spread {
            Spread::Log if self.high > LOG_TICKS_FROM * self.low => self.log_ticks(),
            _ => self.linear_ticks(),
        };
        let tick = |(value, label): (f64, Option<String>)| Tick {
            at: self.place(value),
            label,
        };
        ticks.into_iter().map(tick).collect()
    }

    fn linear_ticks(&self) -> Vec<(f64, Option<String>)> {
        let step = round_step((self.high - self.low) / self.most_ticks);
        let (first, last) = ((self.low / step).ceil(), (self.high / step).floor());
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let mut ticks = Vec::new();
        let mut i = first;
        while i <= last {
            ticks.push((i * step, Some(number(i * step, decimals))));
            i += 1.0;
        }
        ticks
    }

    /// All of 1 to 9 times powers of ten; with numbers at those of 1, of 1, 2 and 5, or of all, as they
    /// fit.
    fn log_ticks(&self) -> Vec<(f64, Option<String>)> {
        let (from, to) = (
            self.low.log10().floor() as i32,
            self.high.log10().ceil() as i32,
        );
        let digits = (from..=to).flat_map(|power| (1..10).map(move |digit| (digit, power)));
        let inside: Vec<(i32, i32)> = digits
            .filter(|&(digit, power)| self.holds(f64::from(digit) * 10f64.powi(power)))
            .collect();
        let choices: [&[i32]; 3] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 5], &[1]];
        let fits = |chosen: &&&[i32]| {
            inside
                .iter()
                .filter(|(digit, _)| chosen.contains(digit))
                .count() as f64
                <= self.most_ticks
        };
        let chosen = choices.iter().find(fits).unwrap_or(&choices[2]);
        let label = |(digit, power): (i32, i32)| {
            let value = f64::from(digit) * 10f64.powi(power);
            (value, chosen.contains(&digit).then(|| decade(digit, power)))
        };
        inside.into_iter().map(label).collect()
    }
}

/// The lowest and the highest of all finite values, if there are any.
pub(super) fn range(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.into_iter().filter(|v| v.is_finite());
    finite.fold(None, |range, v| {
        let [low, high] = range.unwrap_or([v, v]);
        Some([low.min(v), high.max(v)])
    })
}

/// 1, 2 or 5 times a power of ten, at least `least`.
pub(super) fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let digits = [1.0, 2.0, 5.0].map(|digit| digit * power);
    digits
        .into_iter()
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// `digit` times a power of ten: written out where that is short.
fn decade(digit: i32, power: i32) -> String {
    match power {
        0..=3 => format!("{digit}{}", "0".repeat(power as usize)),
        -3..0 => number(f64::from(digit) * 10f64.powi(power), -power as usize),
        _ if digit == 1 => format!("10{}", superscript(power)),
        _ => format!("{digit}×10{}", superscript(power)),
    }
}

fn superscript(power: i32) -> String {
    let letter = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    power.to_string().chars().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        let axis = Axis::linear("x", [-0.25, 0.31]);
        assert_eq!(labels(&axis), ["−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(&Axis::linear("x", [0.0, 30.0])).len(), 7);
    }

    #[test]
    fn logarithmic_ticks_thin_out() {
        let axis = Axis::log("x", [8.0, 16.0]);
        assert_eq!(labels(&axis), ["8", "10", "12", "14", "16"]);
        let axis = Axis::log("x", [1.0, 100.0]);
        assert_eq!(labels(&axis), ["1", "2", "5", "10", "20", "50", "100"]);
        let axis = Axis::log("x", [1e-5, 1e5]);
        assert_eq!(labels(&axis).first().map(String::as_str), Some("10⁻⁵"));
    }

    #[test]
    fn one_value_and_none_still_make_an_axis() {
        for axis in [
            Axis::log("x", [50.0]),
            Axis::log("x", [f64::NAN, -1.0]),
            Axis::around("x", [3.0]),
            Axis::about_zero("x", [0.0]),
            Axis::around("x", []),
        ] {
            let [low, high] = axis.ends();
            assert!(low < high && !labels(&axis).is_empty(), "{axis:?}");
        }
    }

    #[test]
    fn values_outside_are_moved_to_the_end() {
        let axis = Axis::log("x", [1.0, 10.0]);
        assert_eq!([axis.place(-5.0), axis.place(1e9)], [0.0, 1.0]);
        let axis = Axis::linear("x", [0.0, 4.0]).reversed();
        assert_eq!([axis.place(0.0), axis.place(1.0)], [1.0, 0.75]);
    }
}
