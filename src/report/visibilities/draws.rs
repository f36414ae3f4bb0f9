//! Skies as the catalogue has them: its estimates, and draws from the joint posterior.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::Contents;
use crate::catalogue::FoundSamples;
use crate::config::Config;
use crate::coords::{IcrsCentre, RaDec};
use crate::rime::Source;
use crate::rime::shape::Ellipticity;

/// Seed of the draws: the same report each time.
const SEED: u64 = 1;

/// All sources of the sky, about the phase centre and the axes of the data.
pub(super) type Sky = Vec<Source>;

/// First the sky of the estimates, then `n` draws, none without samples. Sources of a group were sampled
/// together, and are drawn together.
pub(super) fn draws(contents: &Contents, config: &Config, frame: IcrsCentre, n: usize) -> Vec<Sky> {
    let found = &contents.catalogue;
    let estimates = found.rows.iter().map(|row| Source {
        lm: row.position.to_lm(frame.centre),
        flux_jy: row.flux_jy.mean,
        scale_rad: finite(row.scale_rad.mean),
        e: Ellipticity {
            e1: finite(row.e1.mean),
            e2: finite(row.e2.mean),
        },
        tilt: tilt(config, row.spectral_index.mean),
    });
    let mut skies: Vec<Sky> = vec![estimates.map(|source| native(frame, source)).collect()];
    let Some(samples) = &found.samples else {
        return skies;
    };
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..n {
        let mut part_of_group = BTreeMap::new();
        let sky = found.rows.iter().enumerate().filter_map(|(i, row)| {
            let weights = samples.weight.get(row.samples.clone())?;
            let part: f64 = rng.random();
            let group = contents.row_details(i).group_id;
            // The members of a group have the same weights, and so reach the same sample.
            let part = if group.is_nan() {
                part
            } else {
                *part_of_group.entry(group as i64).or_insert(part)
            };
            let chosen = row.samples.start + reached(weights, part)?;
            Some(native(frame, sample(samples, chosen, config, frame)))
        });
        skies.push(sky.collect());
    }
    skies
}

/// The first of the weights at which their sum reaches the part `part` of all.
fn reached(weights: &[f64], part: f64) -> Option<usize> {
    let wanted = part * weights.iter().sum::<f64>();
    let mut sum = 0.0;
    let reaches = |weight: &f64| {
        sum += weight;
        sum >= wanted
    };
    weights.iter().position(reaches)
}

fn sample(samples: &FoundSamples, i: usize, config: &Config, frame: IcrsCentre) -> Source {
    let position = RaDec {
        ra_rad: samples.ra_rad[i],
        dec_rad: samples.dec_rad[i],
    };
    Source {
        lm: position.to_lm(frame.centre),
        flux_jy: samples.flux_jy[i],
        scale_rad: samples.scale_rad[i],
        e: Ellipticity {
            e1: samples.e1[i],
            e2: samples.e2[i],
        },
        tilt: tilt(config, samples.spectral_index[i]),
    }
}

/// A spectral index less that of all sources; 0 where it was not free.
fn tilt(config: &Config, index: f64) -> f64 {
    let free = config.spectral_index.filter(|index| index.is_free());
    free.map_or(0.0, |range| finite(index - range.middle()))
}

/// A source about the axes of the data instead of those of ICRS.
fn native(frame: IcrsCentre, source: Source) -> Source {
    let back = IcrsCentre {
        north_rad: -frame.north_rad,
        ..frame
    };
    back.turn(&source)
}

/// What is not known is 0: a point, or the spectrum of all.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
