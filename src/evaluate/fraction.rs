//! Fractions and means with their uncertainty.

use serde::Serialize;

/// Some of many.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fraction {
    /// How many.
    pub n: usize,
    /// Of how many.
    pub of: usize,
    /// `n / of`; NaN of none.
    pub value: f64,
    /// Lower end of the 68% interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Fraction {
    /// `n` of `of`, with the interval of Wilson's score at one standard deviation.
    ///
    /// # Source
    /// Wilson 1927, JASA 22, 209.
    pub fn new(n: usize, of: usize) -> Self {
        let (k, total) = (n as f64, of as f64);
        let value = k / total;
        let centre = (k + 0.5) / (total + 1.0);
        let half = (value * (1.0 - value) * total + 0.25).sqrt() / (total + 1.0);
        Self {
            n,
            of,
            value,
            // Of all, the interval ends at 1, whatever rounding says.
            low: if n == 0 { value } else { centre - half },
            high: if n == of { value } else { centre + half },
        }
    }

    /// How many of `items` are so.
    pub(super) fn of(items: impl IntoIterator<Item = bool>) -> Self {
        let (mut n, mut of) = (0, 0);
        for is_so in items {
            n += usize::from(is_so);
            of += 1;
        }
        Self::new(n, of)
    }
}

/// A mean of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mean {
    /// How many numbers.
    pub n: usize,
    /// Their mean; NaN of none.
    pub value: f64,
    /// Its standard error, by the scatter of the numbers; NaN of fewer than two.
    pub err: f64,
}

impl Mean {
    pub(super) fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
        let err = if values.len() < 2 {
            f64::NAN
        } else {
            (squares / (n - 1.0) / n).sqrt()
        };
        Self {
            n: values.len(),
            value,
            err,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_by_hand() {
        // (k + 1/2) / (n + 1) ± sqrt(k (n - k) / n + 1/4) / (n + 1), for 1 of 4.
        let f = Fraction::new(1, 4);
        assert!(f.value == 0.25 && (f.low - 0.1).abs() < 1e-15 && (f.high - 0.5).abs() < 1e-15);
        let all = Fraction::new(3, 3);
        assert!(all.value == 1.0 && all.high == 1.0 && (all.low - 0.75).abs() < 1e-15);
        let none = Fraction::new(0, 3);
        assert!(none.low == 0.0 && (none.high - 0.25).abs() < 1e-15);
        let of_none = Fraction::new(0, 0);
        assert!(of_none.value.is_nan() && of_none.low.is_nan() && of_none.high.is_nan());
    }

    #[test]
    fn the_error_of_a_mean_by_hand() {
        let mean = Mean::of(&[1.0, 2.0, 6.0]);
        assert!(mean.value == 3.0 && (mean.err - (7.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert!(Mean::of(&[1.0]).err.is_nan() && Mean::of(&[]).value.is_nan());
    }
}
