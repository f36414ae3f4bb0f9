//! Made-up visibilities and sources for the tests of this room.

use super::{Extents, VisBlock};
use crate::coords::Lm;
use crate::rime::shape::{Ellipticity, Profile};
use crate::rime::{Extent, Instrument, InstrumentTerms, Source};
use crate::units::ARCSEC;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, LogNormal, StandardNormal};
use std::f64::consts::TAU;
use std::sync::Arc;

pub(super) const PROFILES: [Profile; 3] = [Profile::Exponential, Profile::Gaussian, Profile::Point];

/// Longest baseline [wavelength], and the scale that makes it one of MeerKAT.
pub(super) const MEERKAT: f64 = 35e3 / REACH;
const REACH: f64 = 7.5e5;

/// `len` samples of noise of 1.85 mJy, |uv| from 100 to 750 000 wavelengths, log-uniform, w up to
/// 300 000, weights spread by a factor of three.
pub(super) fn noise(len: usize, seed: u64) -> VisBlock {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut block = VisBlock::default();
    for _ in 0..len {
        let radius = REACH * (100.0 / REACH).powf(rng.random::<f64>());
        let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
        let weight = (1.85e-3f64).powi(-2) * rng.random_range(0.5..1.5);
        let [re, im]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        block.u.push(radius * cos);
        block.v.push(radius * sin);
        block.w.push(3e5 * rng.random_range(-1.0..1.0));
        block.weight.push(weight as f32);
        block.weighted_re.push((weight.sqrt() * re) as f32);
        block.weighted_im.push((weight.sqrt() * im) as f32);
    }
    block
}

/// `count` sources over the whole prior and beyond: |l|, |m| to 0.02, scale-lengths 0.1 to 10
/// arcsec, |e| to 0.804, flux densities 3 to 200 μJy. Every fourth has an extreme size.
pub(super) fn sources(count: usize, seed: u64) -> Vec<Source> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scales = LogNormal::<f64>::new(0.266, 0.3136).unwrap();
    (0..count)
        .map(|i| {
            let scale_arcsec = match i % 4 {
                0 => 0.1 * 100f64.powf(rng.random()),
                _ => scales.sample(&mut rng).clamp(0.1, 10.0),
            };
            let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
            let e = 0.804 * rng.random::<f64>();
            Source {
                lm: Lm {
                    l: rng.random_range(-0.02..0.02),
                    m: rng.random_range(-0.02..0.02),
                },
                flux_jy: 3e-6 * (200.0f64 / 3.0).powf(rng.random()),
                scale_rad: scale_arcsec * ARCSEC,
                e: Ellipticity {
                    e1: e * cos,
                    e2: e * sin,
                },
                // What it is matters where there is an instrument that sees it.
                tilt: rng.random_range(-1.0..1.0),
            }
        })
        .collect()
}

/// All terms of the instrument, over an octave about 1.28 GHz, seen from declination -30.
pub(super) fn instrument(beam: &str) -> Instrument {
    let terms = InstrumentTerms {
        smearing: true,
        beam: Some(beam.parse().unwrap()),
        spectral_index: "-1.7:0.3".parse().ok(),
    };
    let pole = [0.0, 0.75f64.sqrt(), -0.5];
    Instrument::new(&terms, [0.856e9, 1.712e9], pole).unwrap()
}

/// The samples of `block` as MeerKAT might have seen them: 64 channels over an octave, 4 to 12 s,
/// baselines times `scale`.
pub(super) fn seen(mut block: VisBlock, scale: f64) -> VisBlock {
    block.extents = Extents::of(Some(Arc::new(instrument("meerkat"))));
    for k in 0..block.len() {
        block.extents.push(Extent {
            freq_hz: 0.856e9 * (1.0 + (k % 64) as f64 / 63.0),
            width_hz: 13.4e6,
            interval_s: 4.0 + (k % 5) as f64 * 2.0,
        });
        for of in [&mut block.u, &mut block.v, &mut block.w] {
            of[k] *= scale;
        }
    }
    block
}
