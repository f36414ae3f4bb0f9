//! Thermal noise.

use num_complex::Complex;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vis2cat_formats::Corr;

use super::{Array, SimulateConfig, SimulateError};

/// Standard deviation [Jy] of the real and of the imaginary part of a sample of one hand.
///
/// # Formula
/// ```text
/// sigma = SEFD / (eta sqrt(2 dnu tau))
/// ```
/// # Source
/// Wrobel & Walker (1999), Synthesis Imaging in Radio Astronomy II, ASP Conf. 180, eq. 9-14.
pub(super) fn sigma_hand_jy(
    sefd_jy: f64,
    efficiency: f64,
    chan_width_hz: f64,
    interval_s: f64,
) -> f64 {
    sefd_jy / (efficiency * (2.0 * chan_width_hz * interval_s).sqrt())
}

/// Standard deviation [Jy] of each baseline's samples of one of `config.corrs`.
///
/// The SEFD of a baseline is the geometric mean of those of its dishes. Stokes I is the mean of two
/// hands, so its noise is that of a hand by sqrt(2).
///
/// # Errors
/// A dish has no SEFD and the configuration gives none.
pub(super) fn sigma_jy_b(
    config: &SimulateConfig,
    baselines: &[(u32, u32)],
) -> Result<Vec<f64>, SimulateError> {
    let sefd_jy = match config.sefd_jy {
        Some(sefd_jy) => vec![sefd_jy; config.array.dishes.len()],
        None => own_sefds_jy(&config.array)?,
    };
    let hands: f64 = if config.corrs == [Corr::I] { 2.0 } else { 1.0 };
    let sigma_1_jy = sigma_hand_jy(
        1.0,
        config.efficiency,
        config.chan_width_hz(),
        config.interval_s,
    ) / hands.sqrt();
    Ok(baselines
        .iter()
        .map(|&(i, j)| sigma_1_jy * (sefd_jy[i as usize] * sefd_jy[j as usize]).sqrt())
        .collect())
}

fn own_sefds_jy(array: &Array) -> Result<Vec<f64>, SimulateError> {
    let sefd_jy = |dish: &super::Dish| {
        dish.sefd_jy.ok_or_else(|| {
            SimulateError::parameter(format!(
                "the SEFD of {} of {} is not known; give --sefd or a column sefd_jy",
                dish.name, array.name
            ))
        })
    };
    array.dishes.iter().map(sefd_jy).collect()
}

/// The noise of each row: a stream of its own, so that neither threads nor chunks matter.
#[derive(Debug, Clone)]
pub(super) struct NoiseSource {
    rng: ChaCha8Rng,
}

impl NoiseSource {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Adds noise of standard deviation `sigma_jy` in each part to the values of row `row` of the
    /// observation.
    pub(super) fn add_to(&self, row: u64, sigma_jy: f64, vis_jy_fp: &mut [Complex<f32>]) {
        let mut rng = self.rng.clone();
        rng.set_stream(row);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        for vis_jy in vis_jy_fp {
            let (re, im) = (normal(), normal());
            vis_jy.re = (f64::from(vis_jy.re) + sigma_jy * re) as f32;
            vis_jy.im = (f64::from(vis_jy.im) + sigma_jy * im) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_the_paper() {
        // Malyali et al. (2018): 400 Jy, 240 MHz, 60 s give 2.62 mJy a hand
        let sigma_jy = sigma_hand_jy(400.0, 0.9, 240e6, 60.0);
        assert!((sigma_jy - 2.619e-3).abs() < 1e-6, "{sigma_jy}");
    }

    #[test]
    fn a_mixed_baseline_has_the_geometric_mean() {
        let config = SimulateConfig {
            array: Array::find("ska1-mid").unwrap(),
            ..SimulateConfig::default()
        };
        let sigma_jy = sigma_jy_b(&config, &[(0, 1), (0, 196), (195, 196)]).unwrap();
        assert!((sigma_jy[1].powi(2) - sigma_jy[0] * sigma_jy[2]).abs() < 1e-12);
        assert!((sigma_jy[2] - 2.619e-3).abs() < 1e-6);
        let stokes_i = SimulateConfig {
            corrs: vec![Corr::I],
            ..config
        };
        let half = sigma_jy_b(&stokes_i, &[(195, 196)]).unwrap()[0];
        assert!((half - sigma_jy[2] / 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn an_array_without_sefd_asks_for_one() {
        let config = SimulateConfig {
            array: Array::find("atca-6a").unwrap(),
            ..SimulateConfig::default()
        };
        let message = sigma_jy_b(&config, &[(0, 1)]).unwrap_err().to_string();
        assert!(message.contains("--sefd"), "{message}");
    }

    #[test]
    fn noise_has_the_variance_asked_for_and_a_row_its_own_stream() {
        let source = NoiseSource::new(7);
        let mut sums = [0.0; 3];
        let n_row = 20_000;
        for row in 0..n_row {
            let mut vis_jy = [Complex::new(1.0_f32, 2.0); 2];
            source.add_to(row, 0.5, &mut vis_jy);
            for vis_jy in vis_jy {
                sums[0] += f64::from(vis_jy.re) - 1.0;
                sums[1] += (f64::from(vis_jy.re) - 1.0).powi(2);
                sums[2] += (f64::from(vis_jy.im) - 2.0).powi(2);
            }
        }
        let n = 2.0 * n_row as f64;
        // four standard deviations of a mean, and of a variance, of n draws
        assert!((sums[0] / n).abs() < 4.0 * 0.5 / n.sqrt());
        for sum in &sums[1..] {
            assert!((sum / n - 0.25).abs() < 4.0 * 0.25 * (2.0 / n).sqrt());
        }
        let draw = |seed, row| {
            let mut vis_jy = [Complex::default(); 1];
            NoiseSource::new(seed).add_to(row, 1.0, &mut vis_jy);
            vis_jy[0]
        };
        assert_eq!(draw(7, 3), draw(7, 3));
        assert_ne!(draw(7, 3), draw(7, 4));
        assert_ne!(draw(7, 3), draw(8, 3));
    }
}
