//! Faint neighbours that the model of a brighter source has taken in.
//!
//! One long disk can stand for a galaxy and a fainter one beside it, so well that what it leaves of
//! the fainter is below the cut, or below the prior's range of flux densities. So a mode close to a
//! source is given a try although it is fainter than the cut: the neighbour is sampled without what
//! the mode stands for, then the mode itself, until both stand still. It is a source if it then passes
//! as any other.

use super::pipeline::stream_seed;
use super::refine::{CLOSE_BEAMS, Depth, Found, Refinement};
use super::{Cuts, DetectError, Mode, Observer, Status};
use crate::coords::Lm;
use crate::dataset::{Dataset, Request};
use crate::likelihood::Xy;

/// Lowest matched-filter signal-to-noise ratio that is given a try: noise should reach it beside one
/// source in a thousand (25 independent values about each, an estimate).
pub(super) const LEAST_SNR: f64 = 4.0;

/// Modes that are given a try, and where there has been one.
#[derive(Debug, Default)]
pub(super) struct Leftovers {
    tried: Vec<Lm>,
}

impl Leftovers {
    /// Those of `modes`, the last of a list from number `first` on, that are worth a try.
    pub(super) fn take(
        &mut self,
        modes: &[Mode],
        first: usize,
        sources: &[Found],
        beam_rad: f64,
    ) -> Vec<Found> {
        let mut taken = Vec::new();
        for (i, mode) in modes.iter().enumerate().skip(first) {
            let at = mode.mean.lm;
            let is_dropped = matches!(mode.status, Status::WorseThanNoSource | Status::BelowCut);
            let is_left = is_dropped && mode.snr_peak() >= LEAST_SNR;
            let is_close = |found: &Found| found.mode.mean.lm.distance(at) < CLOSE_BEAMS * beam_rad;
            let is_known = self.tried.iter().any(|lm| lm.distance(at) < beam_rad);
            if is_left && !is_known && sources.iter().any(is_close) {
                self.tried.push(at);
                let mut found = Found::new(i, mode.clone());
                found.is_leftover = true;
                taken.push(found);
            }
        }
        taken
    }
}

impl Refinement<'_> {
    /// Gives the sources from `first` on, which are leftovers, a try; those that are none are taken out
    /// again, the others are marked in `modes`. `dataset` is left with all that remain removed.
    pub(super) fn try_leftovers(
        &self,
        dataset: &mut Dataset,
        sources: &mut Vec<Found>,
        first: usize,
        modes: &mut [Mode],
        cuts: &Cuts,
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        let is_beside = |i: &usize| {
            let distance = |found: &Found| found.mode.mean.lm.distance(sources[*i].mode.mean.lm);
            (sources[first..].iter()).any(|found| distance(found) < CLOSE_BEAMS * self.beam_rad)
        };
        let beside: Vec<usize> = (0..first).filter(is_beside).collect();
        let seed = stream_seed(self.seed, [7, first as u64, 0]);
        self.round(dataset, sources, &beside, Depth::Draft, seed, observer)?;
        self.settle(dataset, sources, first, observer)?;
        let tried = sources.split_off(first);
        let stand = stand(dataset, &tried, cuts)?;
        for (found, stands) in tried.into_iter().zip(stand) {
            tracing::debug!("what a source has left of a neighbour is a source: {stands}");
            if stands {
                modes[found.origin].status = Status::Kept;
                sources.push(found);
            }
        }
        // Without those taken out their neighbours are disturbed.
        let all = sources.len();
        self.settle(dataset, sources, all, observer)
    }
}

/// Whether each of `found` passes as a source, all others removed.
fn stand(dataset: &mut Dataset, found: &[Found], cuts: &Cuts) -> Result<Vec<bool>, DetectError> {
    let request = |found: &Found| Request {
        points: vec![found.mode.best],
        restored: vec![found.mode.mean],
    };
    let requests: Vec<Request> = found.iter().map(request).collect();
    let xy = dataset.evaluate(&requests)?;
    let passes = |(found, xy): (&Found, &Vec<Xy>)| {
        xy[0].log_l(found.mode.best.flux_jy) > 0.0 && cuts.passes_still(xy[0])
    };
    Ok(found.iter().zip(&xy).map(passes).collect())
}
