//! Regions of sky that are evaluated many times: each by all samples, or by a facet.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Dataset, DatasetError, Request};
use crate::config::Engine;
use crate::likelihood::Xy;
use crate::likelihood::facet::{
    Facet, FacetBuilder, FacetNeeds, FacetPlan, FacetWeights, Reach, W_TERM_MAX,
};
use crate::prior::Region;
use crate::rime::Source;

/// Sizes of facets are powers of this times the beam, so that few plans serve all regions.
const SIZE_STEP: f64 = 1.25;
/// Points of a view that one core evaluates at a time.
pub(super) const POINTS_PER_TASK: usize = 8;

/// Which likelihood engine, and what it must be ready for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngineOptions {
    /// The engine.
    pub engine: Engine,
    /// Distance of the farthest corner of the field from the phase centre, sqrt(l² + m²).
    pub farthest: f64,
    /// Longest scale-length along a major axis that is ever evaluated [rad].
    pub longest_axis_rad: f64,
}

/// A region and the data that are looked at there.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewRequest {
    /// Where the points will lie.
    pub region: Region,
    /// Which of the removed sources are put back.
    pub restored: Vec<Source>,
    /// All visibilities must be used.
    pub is_exact: bool,
}

/// A region made ready.
pub struct View {
    restored: Vec<Source>,
    /// None: the points are evaluated by all samples.
    facet: Option<Facet>,
}

/// A size of facets, with what facets over the same samples share.
pub(super) struct FacetSize {
    step: i32,
    plan: Arc<FacetPlan>,
    weights: Option<Arc<FacetWeights>>,
}

impl Dataset {
    /// True if every call of [`Dataset::views`] reads all data.
    pub fn views_take_a_pass(&self) -> bool {
        self.engine.engine != Engine::Exact
    }

    /// Makes regions ready, in as many passes over the data as the memory budget demands.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn views(&mut self, requests: &[ViewRequest]) -> Result<Vec<View>, DatasetError> {
        let sizes: Vec<Option<usize>> = requests.iter().map(|r| self.size_for(r)).collect();
        let mut views: Vec<View> = requests
            .iter()
            .map(|r| View {
                restored: r.restored.clone(),
                facet: None,
            })
            .collect();
        for size in 0..self.sizes.len() {
            let which: Vec<usize> = (0..requests.len())
                .filter(|&i| sizes[i] == Some(size))
                .collect();
            let at_a_time = self.at_a_time(self.sizes[size].plan.build_bytes());
            for which in which.chunks(at_a_time) {
                let facets = self.facets(size, which, requests)?;
                for (&i, facet) in which.iter().zip(facets) {
                    views[i].facet = Some(facet);
                }
            }
        }
        Ok(views)
    }

    /// X and Y of the points of each view; the removed sources must be those of the time when the
    /// views were made.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn evaluate_views(
        &mut self,
        jobs: &[(&View, &[Source])],
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let mut sums = self.evaluate_without_facets(jobs)?;
        let tasks: Vec<(&Facet, &[Source], &mut [Xy])> = jobs
            .iter()
            .zip(&mut sums)
            .filter_map(|((view, points), sums)| Some((view.facet.as_ref()?, *points, sums)))
            .flat_map(|(facet, points, sums)| {
                let points = points.chunks(POINTS_PER_TASK);
                let sums = sums.chunks_mut(POINTS_PER_TASK);
                points
                    .zip(sums)
                    .map(move |(points, sums)| (facet, points, sums))
            })
            .collect();
        self.n_eval += tasks
            .iter()
            .map(|(_, points, _)| points.len() as u64)
            .sum::<u64>();
        tasks
            .into_par_iter()
            .for_each(|(facet, points, sums)| sums.copy_from_slice(&facet.xy_batch(points)));
        Ok(sums)
    }

    /// One pass for all views without a facet; those that see the same data share a request. The
    /// sums of the others are zero.
    fn evaluate_without_facets(
        &mut self,
        jobs: &[(&View, &[Source])],
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let mut requests: Vec<Request> = Vec::new();
        let mut place = Vec::with_capacity(jobs.len());
        for (view, points) in jobs {
            if view.facet.is_some() {
                place.push(None);
                continue;
            }
            let same = requests.iter().position(|r| r.restored == view.restored);
            let r = same.unwrap_or_else(|| {
                requests.push(Request {
                    points: Vec::new(),
                    restored: view.restored.clone(),
                });
                requests.len() - 1
            });
            place.push(Some((r, requests[r].points.len())));
            requests[r].points.extend_from_slice(points);
        }
        let xy = if requests.is_empty() {
            Vec::new()
        } else {
            self.evaluate(&requests)?
        };
        let jobs = jobs.iter().zip(place);
        Ok(jobs
            .map(|((_, points), place)| match place {
                Some((r, first)) => xy[r][first..first + points.len()].to_vec(),
                None => vec![Xy::default(); points.len()],
            })
            .collect())
    }

    /// The size of facet that serves a region; none if all samples serve it better.
    fn size_for(&mut self, request: &ViewRequest) -> Option<usize> {
        if request.is_exact {
            return None;
        }
        let step = self.size_step(&request.region);
        if let Some(known) = self.sizes.iter().position(|size| size.step == step) {
            return Some(known);
        }
        let plan = self.plan(self.facet_needs(step))?;
        tracing::debug!("facets of {:.1} beams: {}", SIZE_STEP.powi(step), plan);
        self.sizes.push(FacetSize {
            step,
            plan: Arc::new(plan),
            weights: None,
        });
        Some(self.sizes.len() - 1)
    }

    /// The smallest power of [`SIZE_STEP`] that, times the beam, is as large as `region`.
    pub(super) fn size_step(&self, region: &Region) -> i32 {
        let side_rad = (region.high.l - region.low.l).max(region.high.m - region.low.m);
        ((side_rad / self.info.beam_rad).ln() / SIZE_STEP.ln()).ceil() as i32
    }

    /// What facets of this size must do.
    pub(super) fn facet_needs(&self, step: i32) -> FacetNeeds {
        FacetNeeds {
            side_rad: self.info.beam_rad * SIZE_STEP.powi(step),
            farthest: self.engine.farthest,
            reach: Reach {
                uv: self.info.max_uv,
                w: self.info.max_w,
            },
            longest_axis_rad: self.engine.longest_axis_rad,
            profile: self.profile,
            w_term_max: W_TERM_MAX,
            has_gains: self.instrument.is_some(),
        }
    }

    /// The plan of such facets. Regions too large for a facet, or with fewer samples than the cells
    /// of the two levels that most sources are summed over, are left to all samples.
    pub(super) fn plan(&self, needs: FacetNeeds) -> Option<FacetPlan> {
        if self.engine.engine == Engine::Exact {
            return None;
        }
        let plan = FacetPlan::new(needs).ok()?;
        let is_forced = self.engine.engine == Engine::Facet;
        let is_worth_it = self.info.n_sample as usize >= 2 * plan.level_cells();
        (is_forced || is_worth_it).then_some(plan)
    }

    /// Facets of one size for the requests `which`, in one pass.
    fn facets(
        &mut self,
        size: usize,
        which: &[usize],
        requests: &[ViewRequest],
    ) -> Result<Vec<Facet>, DatasetError> {
        let centres: Vec<_> = which
            .iter()
            .map(|&i| requests[i].region.from_unit(0.5, 0.5))
            .collect();
        let restored = which
            .iter()
            .map(|&i| requests[i].restored.clone())
            .collect();
        let FacetSize { plan, weights, .. } = &self.sizes[size];
        let builder = match weights {
            Some(weights) => FacetBuilder::with_weights(plan.clone(), &centres, weights.clone()),
            None => FacetBuilder::new(plan.clone(), &centres),
        };
        let mut builder = builder.restoring(restored);
        self.for_few_blocks(|blocks| builder.add(blocks))?;
        let facets = builder.finish();
        self.sizes[size].weights = facets.first().and_then(Facet::weights);
        Ok(facets)
    }
}
