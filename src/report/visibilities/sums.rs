//! Sums over samples, by baseline length.

use rayon::prelude::*;

use super::draws::Sky;
use super::{UvBin, ujy};
use crate::likelihood::{VisBlock, subtract};
use crate::rime::Source;
use crate::rime::shape::Profile;

/// Fine bins of baseline length in an octave, and in all: from one wavelength to beyond any array.
const PER_OCTAVE: f64 = 4.0;
const N_FINE: usize = 4 * 36;
/// Bins that are shown, at most; each has at least its share of half of all samples.
const N_SHOWN: u64 = 24;

/// Sums of one bin.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sum {
    pub(super) n_sample: u64,
    weight: f64,
    /// Σ w |m|².
    model: f64,
    /// Σ w |d|².
    pub(super) data: f64,
    /// Σ w |d - m|².
    pub(super) left: f64,
    /// Σ w Re(d m*).
    cross: f64,
    /// The same with each draw in the place of d.
    cross_draws: Vec<f64>,
}

/// Sums of all bins, by the skies that they are for.
pub(super) struct Sums {
    profile: Profile,
    skies: Vec<Sky>,
    fine: Vec<Sum>,
}

impl Sums {
    /// Nothing yet; the first sky is the model, the others are draws.
    pub(super) fn new(profile: Profile, skies: Vec<Sky>) -> Self {
        let n_draw = skies.len().saturating_sub(1);
        Self {
            profile,
            skies,
            fine: vec![Sum::empty(n_draw); N_FINE],
        }
    }

    pub(super) fn n_draw(&self) -> usize {
        self.skies.len().saturating_sub(1)
    }

    /// Adds samples: block by block on all cores, put together in the order of the file.
    pub(super) fn add(&mut self, blocks: &[VisBlock]) {
        let added: Vec<Vec<Sum>> = blocks
            .par_iter()
            .map(|block| self.of_block(block))
            .collect();
        for block in added {
            for (sum, more) in self.fine.iter_mut().zip(&block) {
                sum.add(more);
            }
        }
    }

    fn of_block(&self, block: &VisBlock) -> Vec<Sum> {
        let mut sums = vec![Sum::empty(self.n_draw()); N_FINE];
        let bins: Vec<usize> = (0..block.len())
            .map(|k| fine_bin(block.u[k], block.v[k]))
            .collect();
        let mut skies = self.skies.iter();
        let mut model = VisBlock::default();
        predict(
            &mut model,
            block,
            skies.next().map_or(&[], Vec::as_slice),
            self.profile,
        );
        for (k, &bin) in bins
            .iter()
            .enumerate()
            .filter(|(k, _)| block.weight[*k] > 0.0)
        {
            sums[bin].sample(block, &model, k);
        }
        let mut drawn = VisBlock::default();
        for (i, sky) in skies.enumerate() {
            predict(&mut drawn, block, sky, self.profile);
            for (k, &bin) in bins
                .iter()
                .enumerate()
                .filter(|(k, _)| block.weight[*k] > 0.0)
            {
                sums[bin].cross_draws[i] += product(&drawn, &model, k);
            }
        }
        sums
    }

    /// All bins together.
    pub(super) fn whole(&self) -> Sum {
        let mut whole = Sum::empty(self.n_draw());
        self.fine.iter().for_each(|sum| whole.add(sum));
        whole
    }
}

/// The weighted visibilities of a sky at the places of the samples of `block`.
fn predict(model: &mut VisBlock, block: &VisBlock, sky: &[Source], profile: Profile) {
    model.copy_from(block);
    model.weighted_re.fill(0.0);
    model.weighted_im.fill(0.0);
    let negated = |source: &Source| Source {
        flux_jy: -source.flux_jy,
        ..*source
    };
    let negated: Vec<(Source, Profile)> = sky.iter().map(|s| (negated(s), profile)).collect();
    subtract(model, &negated);
}

/// w Re(a b*) of sample `k`.
fn product(a: &VisBlock, b: &VisBlock, k: usize) -> f64 {
    let re = f64::from(a.weighted_re[k]) * f64::from(b.weighted_re[k]);
    let im = f64::from(a.weighted_im[k]) * f64::from(b.weighted_im[k]);
    (re + im) / f64::from(a.weight[k])
}

impl Sum {
    fn empty(n_draw: usize) -> Self {
        Self {
            cross_draws: vec![0.0; n_draw],
            ..Self::default()
        }
    }

    fn sample(&mut self, block: &VisBlock, model: &VisBlock, k: usize) {
        let [data, cross, own] = [
            product(block, block, k),
            product(block, model, k),
            product(model, model, k),
        ];
        self.n_sample += 1;
        self.weight += f64::from(block.weight[k]);
        self.model += own;
        self.data += data;
        self.cross += cross;
        self.left += data - 2.0 * cross + own;
    }

    fn add(&mut self, other: &Self) {
        self.n_sample += other.n_sample;
        self.weight += other.weight;
        self.model += other.model;
        self.data += other.data;
        self.left += other.left;
        self.cross += other.cross;
        for (sum, more) in self.cross_draws.iter_mut().zip(&other.cross_draws) {
            *sum += more;
        }
    }

    /// What these sums say of baselines from one length to another [wavelength].
    pub(super) fn bin(&self, ends: [f64; 2]) -> UvBin {
        let norm = (self.weight * self.model).sqrt();
        let amplitude = |cross: f64| if norm > 0.0 { ujy(cross / norm) } else { 0.0 };
        let model_ujy = amplitude(self.model);
        let n = self.cross_draws.len() as f64;
        let predicted = self.cross_draws.iter().map(|cross| amplitude(*cross));
        let predicted: Vec<f64> = predicted.collect();
        let mean = predicted.iter().sum::<f64>() / n;
        let squares: f64 = predicted.iter().map(|a| (a - mean).powi(2)).sum();
        UvBin {
            ends,
            n_sample: self.n_sample,
            data_ujy: amplitude(self.cross),
            err_ujy: ujy(1.0 / self.weight.sqrt()),
            model_ujy,
            predicted_ujy: if predicted.is_empty() {
                [model_ujy, 0.0]
            } else {
                [mean, (squares / (n - 1.0).max(1.0)).sqrt()]
            },
            chi2: self.left / (2.0 * self.n_sample as f64),
        }
    }
}

fn fine_bin(u: f64, v: f64) -> usize {
    let octaves = 0.5 * (u * u + v * v).max(1.0).log2();
    ((octaves * PER_OCTAVE) as usize).min(N_FINE - 1)
}

/// Bins of enough samples, with the lengths that they are of.
pub(super) fn merged(sums: &Sums) -> Vec<([f64; 2], Sum)> {
    let all = sums.whole().n_sample;
    let least = (all / (2 * N_SHOWN)).max(1);
    let edge = |i: usize| 2f64.powf(i as f64 / PER_OCTAVE);
    let filled = (0..N_FINE).filter(|&i| sums.fine[i].n_sample > 0);
    let mut bins: Vec<([f64; 2], Sum)> = Vec::new();
    for i in filled {
        match bins.last_mut() {
            Some((ends, sum)) if sum.n_sample < least => {
                ends[1] = edge(i + 1);
                sum.add(&sums.fine[i]);
            }
            _ => bins.push(([edge(i), edge(i + 1)], sums.fine[i].clone())),
        }
    }
    // A few of the longest baselines belong to those before.
    if let Some((ends, sum)) = bins.pop_if(|(_, sum)| sum.n_sample < least) {
        match bins.last_mut() {
            Some((last, before)) => {
                last[1] = ends[1];
                before.add(&sum);
            }
            None => bins.push((ends, sum)),
        }
    }
    bins
}
