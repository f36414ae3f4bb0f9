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
mod map;
mod plan;
mod resample;
mod sorted;
mod span;
mod spread;
mod term;
mod turns;

pub use builder::{FacetBuilder, FacetWeights};
pub use cross::{CrossBuilder, CrossFacet};
pub use map::FacetMap;
pub use plan::{FacetError, FacetNeeds, FacetPlan, Reach, W_TERM_MAX};

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
    levels: Vec<Vec<Pack>>,
    weights: Arc<FacetWeights>,
    /// What the mean factor of the instrument gains with l and m, relative to that at the centre [rad⁻¹].
    tilt: [f64; 2],
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
        (!self.plan.needs.has_gains).then(|| self.weights.clone())
    }

    /// The mean factor of the instrument for a source at `lm`, relative to that at the centre, which the
    /// grids hold.
    fn relative_gain(&self, lm: Lm) -> f64 {
        let centre = self.centre.lm;
        let change = self.tilt[0] * (lm.l - centre.l) + self.tilt[1] * (lm.m - centre.m);
        // Beyond this, near a null of the beam, it is a guess anyway.
        change.clamp(-1.0, 1.0).exp()
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
    /// Factors of the instrument are those at the centre, but for their mean, which follows the source; see
    /// `docs/studies.md`.
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
        let term = FacetTerm::new(&self.plan, &self.centre, source);
        let mut span = Span::default();
        (0..=self.plan.innermost(term.major_rad))
            .map(|level| {
                span.set(&self.plan, level, &term, 0.0);
                let packs = span.rows.iter().map(|row| row.end - row.first);
                packs.sum::<u32>() as usize * cells::LANES
            })
            .sum()
    }

    fn xy_group(&self, sources: &[Source]) -> Vec<Xy> {
        let job = |source| {
            let term = FacetTerm::new(&self.plan, &self.centre, source);
            Job::new(term, self.plan.innermost(term.major_rad))
        };
        let mut jobs: Vec<_> = sources.iter().map(job).collect();
        let last = jobs.iter().map(|job| job.last).max().unwrap_or(0);
        for number in 0..=last {
            accumulate(self.isa, self.level(number), &mut jobs);
        }
        let seen = |(job, source): (&Job, &Source)| {
            let gain = self.relative_gain(source.lm);
            Xy {
                x: gain * job.sum.x,
                y: gain * gain * job.sum.y,
            }
        };
        jobs.iter().zip(sources).map(seen).collect()
    }

    fn level(&self, number: usize) -> Level<'_> {
        Level {
            plan: &self.plan,
            number,
            packs: &self.levels[number],
            common: &self.weights.levels[number],
        }
    }
}

#[cfg(test)]
mod tests;
