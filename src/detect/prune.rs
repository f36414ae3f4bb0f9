//! Sources that are only a part of a close neighbour.
//!
//! A galaxy whose first model was poor, because others still stood in its sidelobes, leaves
//! something behind that can pass for a second source; sampled in turn, the two then share the
//! galaxy between them. So every source that is close to a brighter one has to stand a test: the
//! neighbour is sampled without it, and what the data still hold of it must pass the cut. One that was
//! known to leave less (`leftover`) must fit the data, with its neighbour, better than that one alone
//! by as much as a source at the cut does.

use super::explore::{SamplerSettings, Target, Task, explore};
use super::pipeline::stream_seed;
use super::refine::{CLOSE_BEAMS, Found, Refinement, means};
use super::{Cuts, DetectError, Mode, Observer, Status};
use crate::dataset::{Dataset, Request};
use crate::prior::Window;

impl Refinement<'_> {
    /// Takes out the sources that a close neighbour explains, and says so in `modes`, which their
    /// `origin` is an index of; `dataset` is left with all that remain removed.
    pub(super) fn prune(
        &self,
        dataset: &mut Dataset,
        sources: &mut Vec<Found>,
        modes: &mut [Mode],
        cuts: &Cuts,
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        observer.stage("comparing close sources", sources.len() as u64);
        let mut faintest_first: Vec<Found> = sources.clone();
        faintest_first.sort_by(|a, b| flux_jy(a).total_cmp(&flux_jy(b)));
        for tested in faintest_first {
            let is_it = |found: &Found| found.origin == tested.origin;
            let Some(i) = sources.iter().position(is_it) else {
                continue;
            };
            let Some(j) = self.close_brighter(sources, i) else {
                continue;
            };
            let alone = self.sample_without(dataset, sources, i, j, observer)?;
            let mut without = sources.clone();
            without[j] = without[j].redrafted(alone);
            without.remove(i);
            let is_explained = if tested.is_leftover {
                gain(dataset, sources, [i, j], &without)? < 0.5 * cuts.snr * cuts.snr
            } else {
                is_explained(dataset, &tested.mode, &without, cuts)?
            };
            if is_explained {
                let mode = &mut modes[tested.origin];
                mode.status = Status::PartOfNeighbour;
                mode.explained_by = Some(sources[j].origin);
                *sources = without;
            }
        }
        dataset.set_removed(means(sources));
        Ok(())
    }

    /// The nearest of the sources that are brighter than source `i` and close to it.
    fn close_brighter(&self, sources: &[Found], i: usize) -> Option<usize> {
        let distance = |&j: &usize| sources[i].mode.mean.lm.distance(sources[j].mode.mean.lm);
        (0..sources.len())
            .filter(|&j| flux_jy(&sources[j]) > flux_jy(&sources[i]))
            .filter(|j| distance(j) < CLOSE_BEAMS * self.beam_rad)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Source `j` sampled as if there were no source `i`, wherever between and about the two it
    /// may then lie, with any shape.
    fn sample_without(
        &self,
        dataset: &mut Dataset,
        sources: &[Found],
        i: usize,
        j: usize,
        observer: &mut dyn Observer,
    ) -> Result<Mode, DetectError> {
        let mut others = sources.to_vec();
        others.remove(i);
        dataset.set_removed(means(&others));
        let (old, apart) = (
            &sources[j].mode,
            sources[i].mode.mean.lm.distance(sources[j].mode.mean.lm),
        );
        let region = self.region(old, 1.0).grown(apart).clipped(self.field);
        let target = Target {
            region,
            window: Window::FULL,
            restored: vec![old.mean],
            is_exact: false,
            sampler: SamplerSettings {
                n_dim: self.prior.n_dim(),
                n_live: self.n_live_draft,
                task: Task::Posterior,
                seed: stream_seed(self.seed, [4, sources[i].origin as u64, j as u64]),
            },
        };
        let mut alone = old.clone();
        let mut note = |explored| alone = self.refined(old, &explored);
        explore(
            dataset,
            self.prior,
            self.factory,
            vec![target],
            observer,
            &mut note,
        )?;
        Ok(alone)
    }
}

/// With the sources `without` removed, is what is left of `mode` below the cut?
fn is_explained(
    dataset: &mut Dataset,
    mode: &Mode,
    without: &[Found],
    cuts: &Cuts,
) -> Result<bool, DetectError> {
    dataset.set_removed(means(without));
    let points = mode.samples.iter().map(|sample| sample.source).collect();
    let xy = dataset.evaluate(&[Request {
        points,
        restored: Vec::new(),
    }])?;
    Ok(!xy[0].iter().any(|xy| cuts.passes_still(*xy)))
}

/// How much larger ln L is with source `i` beside source `j` than it is `without` source `i`.
fn gain(
    dataset: &mut Dataset,
    sources: &[Found],
    [i, j]: [usize; 2],
    without: &[Found],
) -> Result<f64, DetectError> {
    let mut others = sources.to_vec();
    let tested = others.remove(i).mode.best;
    dataset.set_removed(means(&others));
    let (neighbour, place) = (sources[j].mode.mean, j - usize::from(j > i));
    let alone = without[place].mode.best;
    let xy = dataset.evaluate(&[
        Request {
            points: vec![tested],
            restored: Vec::new(),
        },
        Request {
            points: vec![neighbour, alone],
            restored: vec![neighbour],
        },
    ])?;
    let with = xy[0][0].log_l(tested.flux_jy) + xy[1][0].log_l(neighbour.flux_jy);
    let gain = with - xy[1][1].log_l(alone.flux_jy);
    tracing::debug!("what its neighbour left of a source adds {gain:.1} to ln L");
    Ok(gain)
}

fn flux_jy(found: &Found) -> f64 {
    found.mode.mean.flux_jy
}
