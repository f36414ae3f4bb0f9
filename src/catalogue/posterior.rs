//! From the weighted samples of one source to the numbers of its row.

mod ellipse;
mod moments;

use self::moments::{Weights, circular_axis, correlation, quantile};
use super::row::{Estimate, Flags, PosteriorRow};
use crate::coords::{Lm, RaDec};
use crate::rime::Source;
use crate::rime::shape::Profile;

pub use ellipse::Ellipse;

/// One sample of the posterior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedSample {
    /// Log of the posterior weight, up to a constant.
    pub log_w: f64,
    /// ln L - ln L0.
    pub log_l: f64,
    /// The parameters.
    pub source: Source,
}

/// Means, errors and correlations of one source's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Mean position.
    pub position: RaDec,
    /// Standard deviation towards east on the sky [rad]: includes cos(dec).
    pub e_ra_rad: f64,
    /// Standard deviation towards north [rad].
    pub e_dec_rad: f64,
    /// Correlation of the two; NaN where one does not vary.
    pub corr_ra_dec: f64,
    /// Mean direction cosines.
    pub lm: Lm,
    /// Total flux density [Jy].
    pub flux_jy: Estimate,
    /// Its 16th percentile [Jy].
    pub flux_lo_jy: f64,
    /// Its 84th percentile [Jy].
    pub flux_hi_jy: f64,
    /// Scale-length [rad].
    pub scale_rad: Estimate,
    /// Ellipticity along l.
    pub e1: Estimate,
    /// Ellipticity along the diagonal.
    pub e2: Estimate,
    /// Correlation of the two; NaN where one does not vary.
    pub corr_e1_e2: f64,
    /// Major axis at half maximum [rad].
    pub maj_rad: Estimate,
    /// Minor axis at half maximum [rad].
    pub min_rad: Estimate,
    /// Position angle, north through east [rad] in [0, π): the circular mean; NaN for circles.
    pub pa_rad: Estimate,
    /// Spectral index.
    pub spectral_index: Estimate,
    /// Effective number of samples, (Σ w)² / Σ w².
    pub n_eff: f64,
}

impl Summary {
    /// The flags that follow from these numbers alone.
    pub fn flags(&self) -> Flags {
        if self.n_eff < Flags::N_EFF_LIMIT {
            Flags::LOW_N_EFF
        } else {
            Flags::default()
        }
    }
}

/// The numbers of one source from its `samples`, with (l, m) about `centre` (ICRS) and axes at half
/// maximum of a disk of this `profile`.
///
/// Means and standard deviations are those of the weighted samples. Errors of the position are taken
/// in the tangent plane at the mean position, so they hold at the pole and across 0 h.
/// `None` if no sample has weight, or one is not a number.
pub fn summarise(samples: &[WeightedSample], centre: RaDec, profile: Profile) -> Option<Summary> {
    let weights = Weights::from_logs(samples.iter().map(|s| s.log_w))?;
    let estimate =
        |value: &dyn Fn(&Source) -> f64| weights.estimate(samples.iter().map(|s| value(&s.source)));
    let lm = Lm {
        l: estimate(&|s| s.lm.l).mean,
        m: estimate(&|s| s.lm.m).mean,
    };
    let position = RaDec::from_lm(lm, centre);
    let offsets: Vec<Lm> = samples
        .iter()
        .map(|s| RaDec::from_lm(s.source.lm, centre).to_lm(position))
        .collect();
    let (east, north) = (
        || offsets.iter().map(|o| o.l),
        || offsets.iter().map(|o| o.m),
    );
    let ellipses: Vec<Ellipse> = samples
        .iter()
        .map(|s| Ellipse::new(s.source.scale_rad, s.source.e, profile))
        .collect();
    let fluxes: Vec<f64> = samples.iter().map(|s| s.source.flux_jy).collect();
    let (e1, e2) = (
        || samples.iter().map(|s| s.source.e.e1),
        || samples.iter().map(|s| s.source.e.e2),
    );
    Some(Summary {
        position,
        e_ra_rad: weights.estimate(east()).err,
        e_dec_rad: weights.estimate(north()).err,
        corr_ra_dec: correlation(&weights, east(), north()),
        lm,
        flux_jy: estimate(&|s| s.flux_jy),
        flux_lo_jy: quantile(&weights, &fluxes, 0.16),
        flux_hi_jy: quantile(&weights, &fluxes, 0.84),
        scale_rad: estimate(&|s| s.scale_rad),
        e1: weights.estimate(e1()),
        e2: weights.estimate(e2()),
        corr_e1_e2: correlation(&weights, e1(), e2()),
        maj_rad: weights.estimate(ellipses.iter().map(|e| e.maj_rad)),
        min_rad: weights.estimate(ellipses.iter().map(|e| e.min_rad)),
        pa_rad: circular_axis(&weights, &ellipses.iter().map(|e| e.pa_rad)),
        spectral_index: estimate(&|s| s.tilt),
        n_eff: weights.n_eff(),
    })
}

/// The rows of `POSTERIOR` for one source, weights summing to 1; empty where [`summarise`] is `None`.
pub fn posterior_rows(
    samples: &[WeightedSample],
    source_id: i64,
    mode_id: i64,
    centre: RaDec,
    profile: Profile,
) -> Vec<PosteriorRow> {
    let Some(weights) = Weights::from_logs(samples.iter().map(|s| s.log_w)) else {
        return Vec::new();
    };
    let row = |(sample, weight): (&WeightedSample, &f64)| PosteriorRow {
        source_id,
        mode_id,
        weight: *weight,
        log_l: sample.log_l,
        position: RaDec::from_lm(sample.source.lm, centre),
        source: sample.source,
        ellipse: Ellipse::new(sample.source.scale_rad, sample.source.e, profile),
    };
    samples.iter().zip(weights.each()).map(row).collect()
}

/// `n` samples of equal weight, drawn systematically: each comes floor or ceil of `n w` times.
/// `offset` in [0, 1) is the one random number that this takes.
pub fn equal_weight(samples: &[WeightedSample], n: usize, offset: f64) -> Vec<WeightedSample> {
    let Some(weights) = Weights::from_logs(samples.iter().map(|s| s.log_w)) else {
        return Vec::new();
    };
    let mut drawn = Vec::with_capacity(n);
    let mut sum = 0.0;
    for (sample, weight) in samples.iter().zip(weights.each()) {
        sum += weight * n as f64;
        while drawn.len() < n && drawn.len() as f64 + offset < sum {
            drawn.push(WeightedSample {
                log_w: 0.0,
                ..*sample
            });
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rime::shape::Ellipticity;
    use crate::units::{ARCSEC, DEG};

    fn sample(log_w: f64, l: f64, m: f64, flux_jy: f64) -> WeightedSample {
        let source = Source {
            lm: Lm { l, m },
            flux_jy,
            scale_rad: ARCSEC,
            e: Ellipticity { e1: 0.1, e2: 0.2 },
            tilt: 0.0,
        };
        WeightedSample {
            log_w,
            log_l: 50.0,
            source,
        }
    }

    fn centre(dec_deg: f64) -> RaDec {
        RaDec {
            ra_rad: 0.0,
            dec_rad: dec_deg * DEG,
        }
    }

    #[test]
    fn two_samples_have_the_moments_of_two_samples() {
        // Weights 3/4 and 1/4: mean 3/4 a + b/4, standard deviation sqrt(3)/4 |a - b|.
        let samples = [
            sample(-1000.0 + 3.0_f64.ln(), 1e-5, 2e-5, 40e-6),
            sample(-1000.0, 5e-5, 4e-5, 80e-6),
        ];
        let s = summarise(&samples, centre(-60.0), Profile::Exponential).unwrap();
        let sd = 3.0_f64.sqrt() / 4.0;
        assert!((s.lm.l - 2e-5).abs() < 1e-18 && (s.lm.m - 2.5e-5).abs() < 1e-18);
        assert!((s.flux_jy.mean - 50e-6).abs() < 1e-18);
        assert!((s.flux_jy.err - sd * 40e-6).abs() < 1e-18);
        assert!((s.n_eff - 1.6).abs() < 1e-12);
        assert!((s.corr_ra_dec - 1.0).abs() < 1e-6);
        assert!(s.corr_e1_e2.is_nan() && s.scale_rad.err < 1e-20);
        // The error towards east is that of l, not of RA, which at -60 deg is twice as large.
        assert!((s.e_ra_rad / (sd * 4e-5) - 1.0).abs() < 1e-4);
        assert!((s.e_dec_rad / (sd * 2e-5) - 1.0).abs() < 1e-4);
        assert!(s.flags().contains(Flags::LOW_N_EFF));
    }

    #[test]
    fn errors_hold_at_the_pole_and_across_0h() {
        for dec in [-90.0, 0.0, 89.9999] {
            let samples = [-1e-5, 0.0, 1e-5].map(|l| sample(0.0, l, 0.0, 1e-5));
            let s = summarise(&samples, centre(dec), Profile::Point).unwrap();
            let expected = (2.0_f64 / 3.0).sqrt() * 1e-5;
            assert!((s.e_ra_rad / expected - 1.0).abs() < 1e-5, "dec {dec}");
            assert!(s.e_dec_rad < 1e-9);
        }
    }

    #[test]
    fn no_weight_or_no_number_is_no_summary() {
        let none = summarise(&[], centre(0.0), Profile::Point);
        let zero = summarise(
            &[sample(f64::NEG_INFINITY, 0.0, 0.0, 1.0)],
            centre(0.0),
            Profile::Point,
        );
        let nan = summarise(
            &[sample(f64::NAN, 0.0, 0.0, 1.0)],
            centre(0.0),
            Profile::Point,
        );
        assert!(none.is_none() && zero.is_none() && nan.is_none());
    }

    #[test]
    fn rows_of_a_source_sum_to_one() {
        let samples = [sample(-5.0, 0.0, 0.0, 1e-5), sample(-6.0, 1e-6, 0.0, 2e-5)];
        let rows = posterior_rows(&samples, 7, 9, centre(10.0), Profile::Exponential);
        assert_eq!((rows[1].source_id, rows[1].mode_id), (7, 9));
        assert!((rows.iter().map(|r| r.weight).sum::<f64>() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn equal_weights_come_in_proportion() {
        let samples = [
            sample(0.7_f64.ln(), 0.0, 0.0, 1.0),
            sample(0.3_f64.ln(), 0.0, 0.0, 2.0),
        ];
        let drawn = equal_weight(&samples, 10, 0.5);
        let bright = drawn.iter().filter(|s| s.source.flux_jy == 2.0).count();
        assert_eq!((drawn.len(), bright), (10, 3));
    }
}
