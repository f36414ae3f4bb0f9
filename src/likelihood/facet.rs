//! X and Y of sources in a small patch of sky from a few regular grids instead of all samples.
//!
//! ```text
//! samples -> rotated to the facet's centre -> spread on fine grids, one pass for many facets
//!         -> image plane: divided by the kernel's transform, cut to the patch -> a pyramid of grids
//! source  -> window by window, Σ over cells of g F exp(-2πi (u δl + v δm)) -> X, Y
//! ```
//!
//! The phase is a product of one factor a column and one a row; half of the plane is enough, the
//! other half being its mirror image.

mod builder;
mod cells;
mod cross;
mod evaluate;
mod fill;
mod lanes;
mod looks;
mod map;
mod outskirts;
mod plan;
mod resample;
mod sorted;
mod span;
mod spread;
mod term;
mod tilts;
mod turns;

pub use builder::{FacetBuilder, FacetWeights};
pub use cross::{CrossBuilder, CrossFacet};
pub use looks::{GAIN_TERM_MAX, Gains};
pub use map::FacetMap;
pub use plan::{FacetError, FacetNeeds, FacetPlan, Reach, W_TERM_MAX};
pub use tilts::TiltRange;

use super::{Isa, Xy};
use crate::coords::Lm;
use crate::prior::Region;
use crate::rime::Source;
use cells::Pack;
use evaluate::{GROUP, Job, Level, accumulate};
use span::Span;
use std::sync::Arc;
use term::{Centre, FacetTerm};

/// The samples as a patch of sky sees them.
#[derive(Debug)]
pub struct Facet {
    isa: Isa,
    centre: Centre,
    plan: Arc<FacetPlan>,
    /// One, or one for each of [`FacetPlan::rays`].
    looks: Vec<Look>,
}

/// The samples with the factors that the instrument has for one place and spectrum.
#[derive(Debug)]
struct Look {
    levels: Vec<Vec<Pack>>,
    weights: Arc<FacetWeights>,
}

impl Facet {
    /// The region that it serves.
    pub fn region(&self) -> Region {
        Region::square(self.centre.lm, self.plan.needs.side_rad)
    }

    /// The centre.
    pub fn centre(&self) -> Lm {
        self.centre.lm
    }

    /// The grids of weights, for facets over the same samples.
    /// None where they hold the factors of the instrument, which are those of this facet only.
    pub fn weights(&self) -> Option<Arc<FacetWeights>> {
        let is_shared = self.plan.needs.gains == Gains::None;
        is_shared.then(|| self.looks[0].weights.clone())
    }

    /// X and Y of each of `sources` at unit flux density, on one core.
    ///
    /// A source's sums do not depend on the others. The region's upper edges are served too.
    ///
    /// # Precision
    /// Against the exact engine over the whole prior of the paper, to 0.7 degrees from the phase centre,
    /// beside sources of SNR 140 inside and outside, on SKA1-MID: ln L is within a quarter of
    /// 1e-4 SNR²/2 + 0.01.
    ///
    /// Factors s of the instrument change over a facet. They are known at three places, and in between they
    /// are on the plane through these: X, which is linear in s, is interpolated, and sqrt(Y), which is linear
    /// in what all s have in common. At 0.7 degrees, 64 channels over an octave, on MeerKAT, ln L is within
    /// the same bound for facets as large as [`Gains::Followed`] allows with [`GAIN_TERM_MAX`].
    ///
    /// # Not valid when
    /// The source lies outside of the region, or its major axis is longer than the plan's: then the
    /// sums are those of a sky that repeats itself.
    pub fn xy_batch(&self, sources: &[Source]) -> Vec<Xy> {
        sources
            .chunks(GROUP)
            .flat_map(|sources| self.xy_group(sources))
            .collect()
    }

    /// Cells that a likelihood call for `source` sums over.
    pub fn cells_of(&self, source: &Source) -> usize {
        let term = self.term(&self.looks[0], source);
        let mut span = Span::default();
        (0..=self.plan.innermost(term.major_rad))
            .map(|level| {
                span.set(&self.plan, level, &term, 0.0);
                let packs = span.rows.iter().map(|row| row.end - row.first);
                packs.sum::<u32>() as usize * cells::LANES
            })
            .sum()
    }

    /// `source`, with nothing summed that does not matter in `look`.
    fn term(&self, look: &Look, source: &Source) -> FacetTerm {
        let term = FacetTerm::new(&self.plan, &self.centre, source);
        FacetTerm {
            q_max: look.weights.outskirts.q_max(&term),
            ..term
        }
    }

    fn xy_group(&self, sources: &[Source]) -> Vec<Xy> {
        if let [look] = &self.looks[..] {
            return self.xy_look(look, sources);
        }
        let looks: Vec<_> = self
            .looks
            .iter()
            .map(|l| self.xy_look(l, sources))
            .collect();
        let between = |(i, source): (usize, &Source)| {
            let offset = self.centre.offset(source.lm);
            let (mut x, mut root_y) = (0.0, 0.0);
            for (share, xy) in self.plan.shares(offset, source.tilt).zip(&looks) {
                x += share * xy[i].x;
                root_y += share * xy[i].y.max(0.0).sqrt();
            }
            Xy {
                x,
                y: root_y * root_y,
            }
        };
        sources.iter().enumerate().map(between).collect()
    }

    fn xy_look(&self, look: &Look, sources: &[Source]) -> Vec<Xy> {
        let job = |source| {
            let term = self.term(look, source);
            Job::new(term, self.plan.innermost(term.major_rad))
        };
        let mut jobs: Vec<_> = sources.iter().map(job).collect();
        let last = jobs.iter().map(|job| job.last).max().unwrap_or(0);
        for number in 0..=last {
            accumulate(self.isa, self.level(look, number), &mut jobs);
        }
        jobs.iter().map(|job| job.sum).collect()
    }

    fn level<'a>(&'a self, look: &'a Look, number: usize) -> Level<'a> {
        Level {
            plan: &self.plan,
            number,
            packs: &look.levels[number],
            common: &look.weights.levels[number],
        }
    }
}

#[cfg(test)]
mod tests;
