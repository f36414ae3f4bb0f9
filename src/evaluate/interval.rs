//! Do intervals of 68% hold the truth in 68% of all cases?

use serde::Serialize;

use super::Fraction;

/// Where intervals come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IntervalKind {
    /// From the columns of the 16th and 84th percentile.
    Columns,
    /// From the posterior samples.
    Samples,
    /// Estimate and error taken as those of a Gaussian.
    Gaussian,
}

/// How often intervals hold the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Coverage {
    /// Probability that the intervals should hold.
    pub wanted: f64,
    /// Where they come from.
    pub from: IntervalKind,
    /// How many hold the truth.
    pub covered: Fraction,
}

/// Lower tail probability that a central interval of `probability` leaves out.
fn tail(probability: f64) -> f64 {
    0.5 * (1.0 - probability)
}

/// Half the width of a Gaussian's central interval of 68% and 95%, in standard deviations: the roots
/// of erf(x / sqrt 2) = 0.68 and 0.95.
const HALF_WIDTHS: [(f64, f64); 2] = [(0.68, 0.994_457_883_209_753), (0.95, 1.959_963_984_540_054)];

/// The coverage of 68% intervals, then of 95%, for one parameter of all matched rows.
pub(super) struct Cases {
    /// (estimate - truth) / error.
    pub(super) pulls: Vec<f64>,
    /// Fraction of the posterior below the truth, where there are samples.
    pub(super) ranks: Option<Vec<f64>>,
    /// Whether the truth is between the columns of the 16th and 84th percentile, where there are any.
    pub(super) in_columns: Option<Vec<bool>>,
}

impl Cases {
    pub(super) fn coverage(&self) -> [Coverage; 2] {
        HALF_WIDTHS.map(|(wanted, half_width)| {
            let (from, covered) = match (&self.in_columns, &self.ranks) {
                (Some(inside), _) if wanted == 0.68 => {
                    (IntervalKind::Columns, Fraction::of(inside.iter().copied()))
                }
                (_, Some(ranks)) => {
                    let is_inside = |rank: &f64| (tail(wanted)..=1.0 - tail(wanted)).contains(rank);
                    let covered = Fraction::of(ranks.iter().map(is_inside));
                    (IntervalKind::Samples, covered)
                }
                _ => {
                    let inside = self.pulls.iter().map(|pull| pull.abs() <= half_width);
                    (IntervalKind::Gaussian, Fraction::of(inside))
                }
            };
            Coverage {
                wanted,
                from,
                covered,
            }
        })
    }
}

/// Fraction of the weight on values below `truth`; of equal values half.
pub(super) fn rank(
    values: impl Iterator<Item = f64>,
    weights: impl Iterator<Item = f64>,
    truth: f64,
) -> f64 {
    let (mut below, mut sum) = (0.0, 0.0);
    for (value, weight) in values.zip(weights) {
        sum += weight;
        if value < truth {
            below += weight;
        } else if value == truth {
            below += 0.5 * weight;
        }
    }
    below / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_half_widths_are_those_of_a_gaussian() {
        for (probability, x) in HALF_WIDTHS {
            let erf = puruspe::erf(x / 2.0_f64.sqrt());
            assert!((erf - probability).abs() < 1e-12);
        }
    }

    #[test]
    fn a_rank_counts_weights() {
        let values = [1.0, 2.0, 3.0];
        let weights = [0.2, 0.2, 0.4];
        let of = |truth| rank(values.into_iter(), weights.into_iter(), truth);
        assert!((of(2.5) - 0.5).abs() < 1e-15 && (of(2.0) - 0.375).abs() < 1e-15);
        assert!(of(0.0) == 0.0 && of(4.0) == 1.0);
    }

    #[test]
    fn the_best_intervals_that_there_are_count() {
        let pulls = vec![0.0, 0.99, 1.0, -1.9, 2.0];
        let counts = |cases: &Cases| cases.coverage().map(|c| (c.from, c.covered.n));
        let mut cases = Cases {
            pulls,
            ranks: None,
            in_columns: None,
        };
        let gaussian = IntervalKind::Gaussian;
        assert_eq!(counts(&cases), [(gaussian, 2), (gaussian, 4)]);
        cases.ranks = Some(vec![0.5, 0.15, 0.17, 0.98, 0.02]);
        let samples = IntervalKind::Samples;
        assert_eq!(counts(&cases), [(samples, 2), (samples, 3)]);
        cases.in_columns = Some(vec![true, true, true, false, false]);
        assert_eq!(counts(&cases), [(IntervalKind::Columns, 3), (samples, 3)]);
    }
}
