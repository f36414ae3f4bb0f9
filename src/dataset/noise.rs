//! The noise level: what the file's weights say, and what the data say.

use std::collections::BTreeMap;
use std::fmt;

use num_complex::Complex;
use serde::Serialize;

use super::ingest::Sample;
use crate::config::NoiseSource;

/// Weights and data agree if the two noise levels differ by less than this factor.
const AGREEMENT: f64 = 1.2;
/// Channels followed for time differences: enough to measure the noise, few enough to hold.
const TIME_DIFFERENCE_CHANNELS: usize = 16;
/// Fewest differences that make a measurement.
const FEWEST: u64 = 30;

/// The noise level of a data set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct NoiseReport {
    /// σ of a Stokes I sample by the file's weights (1/sqrt of the mean weight) [Jy].
    pub weights_sigma_jy: f64,
    /// σ of a Stokes I sample by differences in the data [Jy]; none where nothing could be compared.
    pub data_sigma_jy: Option<f64>,
    /// How the data were compared.
    pub method: Option<DifferenceMethod>,
    /// What is used.
    pub used: NoiseUsed,
    /// The file's weights times this are used.
    pub weight_scale: f64,
}

/// Where the noise level in use comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseUsed {
    /// The file's weights.
    #[default]
    Weights,
    /// The file's relative weights, with the scale measured in the data.
    Data,
    /// The system equivalent flux density.
    Sefd,
}

/// How the noise was measured in the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DifferenceMethod {
    /// Difference of the two parallel hands.
    Hands,
    /// Difference of successive times on a baseline.
    Times,
}

impl fmt::Display for NoiseReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} mJy by the weights, ", 1e3 * self.weights_sigma_jy)?;
        match (self.data_sigma_jy, self.method) {
            (Some(sigma), Some(DifferenceMethod::Hands)) => {
                write!(f, "{:.4} mJy by the difference of the hands", 1e3 * sigma)
            }
            (Some(sigma), _) => write!(f, "{:.4} mJy by successive times", 1e3 * sigma),
            (None, _) => f.write_str("not measurable in the data"),
        }
    }
}

impl NoiseReport {
    /// True where weights and data tell different stories.
    pub fn disagrees(&self) -> bool {
        self.data_sigma_jy.is_some_and(|sigma| {
            let ratio = sigma / self.weights_sigma_jy;
            !(1.0 / AGREEMENT..=AGREEMENT).contains(&ratio)
        })
    }
}

/// Gathers differences while the file is read for the first time.
#[derive(Default)]
pub(super) struct NoiseTally {
    sum_weight: f64,
    n_sample: u64,
    hands: LogHistogram,
    times: LogHistogram,
    /// Last sample of each baseline and channel: visibility, weight.
    last: BTreeMap<(u32, u32, usize), (Complex<f32>, f32)>,
}

impl NoiseTally {
    pub(super) fn sample(&mut self, sample: &Sample) {
        self.sum_weight += f64::from(sample.weight);
        self.n_sample += 1;
        if let Some(half) = sample.half_difference_jy {
            self.hands
                .add(f64::from(sample.weight) * f64::from(half.norm_sqr()) / 2.0);
        }
        if sample.chan < TIME_DIFFERENCE_CHANNELS && self.hands.n == 0 {
            self.time_difference(sample);
        }
    }

    fn time_difference(&mut self, sample: &Sample) {
        let key = (sample.baseline.0, sample.baseline.1, sample.chan);
        let now = (sample.vis_jy, sample.weight);
        if let Some((vis_jy, weight)) = self.last.insert(key, now) {
            let variance = 1.0 / f64::from(weight) + 1.0 / f64::from(sample.weight);
            self.times
                .add(f64::from((vis_jy - sample.vis_jy).norm_sqr()) / (2.0 * variance));
        }
    }

    /// The verdict, given what the user asked for.
    pub(super) fn report(&self, source: NoiseSource) -> NoiseReport {
        let weights_sigma_jy = (self.n_sample as f64 / self.sum_weight).sqrt();
        let (variance_ratio, method) = if self.hands.n >= FEWEST {
            (
                self.hands.exponential_scale(),
                Some(DifferenceMethod::Hands),
            )
        } else if self.times.n >= FEWEST {
            (
                self.times.exponential_scale(),
                Some(DifferenceMethod::Times),
            )
        } else {
            (None, None)
        };
        let mut report = NoiseReport {
            weights_sigma_jy,
            data_sigma_jy: variance_ratio.map(|r| weights_sigma_jy * r.sqrt()),
            method,
            used: NoiseUsed::Weights,
            weight_scale: 1.0,
        };
        let rescale = match source {
            NoiseSource::Auto => report.disagrees(),
            NoiseSource::Data => true,
            NoiseSource::Weights | NoiseSource::Sefd(_) => false,
        };
        if let (true, Some(ratio)) = (rescale, variance_ratio) {
            report.used = NoiseUsed::Data;
            report.weight_scale = 1.0 / ratio;
        }
        if let NoiseSource::Sefd(_) = source {
            report.used = NoiseUsed::Sefd;
        }
        report
    }
}

/// Histogram of positive numbers over 1e-30..1e30 in logarithmic bins of one per cent.
struct LogHistogram {
    bins: Vec<u64>,
    n: u64,
}

const BIN: f64 = 0.01;
const LOG_LOW: f64 = -69.0;
const N_BIN: usize = 13_800;

impl Default for LogHistogram {
    fn default() -> Self {
        Self {
            bins: vec![0; N_BIN],
            n: 0,
        }
    }
}

impl LogHistogram {
    fn add(&mut self, value: f64) {
        if value > 0.0 && value.is_finite() {
            let bin = ((value.ln() - LOG_LOW) / BIN) as usize;
            self.bins[bin.min(N_BIN - 1)] += 1;
            self.n += 1;
        }
    }

    /// Scale of the exponential distribution with the same median: deaf to outliers.
    fn exponential_scale(&self) -> Option<f64> {
        let half = self.n as f64 / 2.0;
        let mut below = 0.0;
        for (i, &count) in self.bins.iter().enumerate() {
            let count = count as f64;
            if below + count >= half && count > 0.0 {
                let log_median = LOG_LOW + BIN * (i as f64 + (half - below) / count);
                return Some(log_median.exp() / std::f64::consts::LN_2);
            }
            below += count;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_of_an_exponential_is_found_among_outliers() {
        let mut histogram = LogHistogram::default();
        let n = 100_000;
        for i in 0..n {
            let p = (f64::from(i) + 0.5) / f64::from(n);
            histogram.add(-3.0e-6 * p.ln());
        }
        (0..500).for_each(|_| histogram.add(1e9));
        let scale = histogram.exponential_scale().unwrap();
        assert!((scale / 3.0e-6 - 1.0).abs() < 0.02, "{scale}");
    }

    #[test]
    fn weights_are_kept_only_when_they_agree() {
        let tally = |weight: f32| {
            let mut tally = NoiseTally::default();
            for i in 0..10_000 {
                // A unit exponential by quantiles: |h|² = 2 σ² t with σ = 1 Jy.
                let t = -((f64::from(i) + 0.5) / 1e4).ln();
                tally.sample(&Sample {
                    file: 0,
                    baseline: (0, 1),
                    chan: 0,
                    time_mjd: 0.0,
                    extent: crate::rime::Extent {
                        freq_hz: 1e9,
                        width_hz: 1e6,
                        interval_s: 10.0,
                    },
                    uvw: [0.0; 3],
                    vis_jy: Complex::default(),
                    weight,
                    half_difference_jy: Some(Complex::new((2.0 * t).sqrt() as f32, 0.0)),
                });
            }
            tally
        };
        let kept = tally(1.1).report(NoiseSource::Auto);
        assert_eq!((kept.used, kept.weight_scale), (NoiseUsed::Weights, 1.0));
        let scaled = tally(100.0).report(NoiseSource::Auto);
        assert_eq!(scaled.used, NoiseUsed::Data);
        assert!((scaled.weight_scale * 100.0 - 1.0).abs() < 0.01);
        assert!(scaled.disagrees());
        assert_eq!(tally(100.0).report(NoiseSource::Weights).weight_scale, 1.0);
    }
}
