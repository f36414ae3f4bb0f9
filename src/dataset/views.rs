//! Regions of sky that are evaluated many times: each by all samples, or by a facet.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::answers::Question;
use super::{Dataset, DatasetError, Request};
use crate::config::Engine;
use crate::likelihood::Xy;
use crate::likelihood::facet::{
    Facet, FacetBuilder, FacetNeeds, FacetPlan, FacetWeights, GAIN_TERM_MAX, Gains, Reach,
    TiltRange, W_TERM_MAX,
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
    /// Largest [`Source::tilt`] that is ever evaluated.
    pub most_tilt: f64,
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

/// A region that is looked at: made ready when it is evaluated for the first time.
pub struct View {
    request: ViewRequest,
    /// None inside: the points are evaluated by all samples.
    facet: OnceLock<Option<Facet>>,
}

impl View {
    /// The region, with the data as they are from now on until it is evaluated for the last time.
    pub fn new(request: ViewRequest) -> Self {
        Self {
            request,
            facet: OnceLock::new(),
        }
    }

    /// The facet of a view that is ready, if it has one.
    fn facet(&self) -> Option<&Facet> {
        self.facet.get()?.as_ref()
    }
}

/// A size of facets, with what facets over the same samples share.
pub(super) struct FacetSize {
    step: i32,
    plan: Arc<FacetPlan>,
    weights: Option<Arc<FacetWeights>>,
}

impl Dataset {
    /// True if views that are evaluated for the first time take passes over all data, the same for few
    /// as for many.
    pub fn views_take_a_pass(&self) -> bool {
        self.engine.engine != Engine::Exact
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
        let n_point: Vec<usize> = jobs.iter().map(|(_, points)| points.len()).collect();
        self.n_eval += n_point.iter().sum::<usize>() as u64;
        let ask = |question: &mut Question| ask_views(question, jobs);
        self.answer_xy("views", &n_point, ask, |data| data.sum_views(jobs))
    }

    /// The sums themselves.
    pub(super) fn sum_views(
        &mut self,
        jobs: &[(&View, &[Source])],
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let evaluated = jobs.iter().filter(|(_, points)| !points.is_empty());
        self.make_ready(&evaluated.map(|(view, _)| *view).collect::<Vec<_>>())?;
        let mut sums = self.sum_without_facets(jobs)?;
        let tasks: Vec<(&Facet, &[Source], &mut [Xy])> = jobs
            .iter()
            .zip(&mut sums)
            .filter_map(|((view, points), sums)| Some((view.facet()?, *points, sums)))
            .flat_map(|(facet, points, sums)| {
                let points = points.chunks(POINTS_PER_TASK);
                let sums = sums.chunks_mut(POINTS_PER_TASK);
                points
                    .zip(sums)
                    .map(move |(points, sums)| (facet, points, sums))
            })
            .collect();
        tasks
            .into_par_iter()
            .for_each(|(facet, points, sums)| sums.copy_from_slice(&facet.xy_batch(points)));
        Ok(sums)
    }

    /// Fills the facets of those of `views` that are evaluated for the first time, in as many passes
    /// over the data as the memory budget demands.
    fn make_ready(&mut self, views: &[&View]) -> Result<(), DatasetError> {
        let is_new = |view: &&&View| view.facet.get().is_none();
        let views: Vec<&View> = views.iter().filter(is_new).copied().collect();
        let sizes: Vec<Option<usize>> = views.iter().map(|v| self.size_for(&v.request)).collect();
        for size in 0..self.sizes.len() {
            let of_size = views.iter().zip(&sizes).filter(|(_, s)| **s == Some(size));
            let of_size: Vec<&View> = of_size.map(|(view, _)| *view).collect();
            let at_a_time = self.at_a_time(self.sizes[size].plan.build_bytes());
            for views in of_size.chunks(at_a_time) {
                let facets = self.facets(size, views)?;
                for (view, facet) in views.iter().zip(facets) {
                    view.facet.get_or_init(|| Some(facet));
                }
            }
        }
        for view in views {
            view.facet.get_or_init(|| None);
        }
        Ok(())
    }

    /// One pass for all views without a facet; those that see the same data share a request. The
    /// sums of the others are zero.
    fn sum_without_facets(
        &mut self,
        jobs: &[(&View, &[Source])],
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let mut requests: Vec<Request> = Vec::new();
        let mut place = Vec::with_capacity(jobs.len());
        for (view, points) in jobs {
            if view.facet().is_some() {
                place.push(None);
                continue;
            }
            let same = requests
                .iter()
                .position(|r| r.restored == view.request.restored);
            let r = same.unwrap_or_else(|| {
                requests.push(Request {
                    points: Vec::new(),
                    restored: view.request.restored.clone(),
                });
                requests.len() - 1
            });
            place.push(Some((r, requests[r].points.len())));
            requests[r].points.extend_from_slice(points);
        }
        let xy = if requests.is_empty() {
            Vec::new()
        } else {
            self.sum(&requests)?
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
                blur: self.blur(),
            },
            longest_axis_rad: self.engine.longest_axis_rad,
            profile: self.profile,
            w_term_max: W_TERM_MAX,
            gains: match self.instrument {
                Some(_) => Gains::Followed(GAIN_TERM_MAX),
                None => Gains::None,
            },
            tilts: self.tilts(),
        }
    }

    /// Spectral indices that are evaluated.
    pub(super) fn tilts(&self) -> TiltRange {
        TiltRange {
            most: self.engine.most_tilt,
            half_band_ln: (self.instrument.as_ref()).map_or(0.0, |i| i.half_band_ln()),
        }
    }

    /// Reach of smearing: that of the samples, in single precision.
    pub(super) fn blur(&self) -> f64 {
        let is_smeared = self
            .instrument
            .as_ref()
            .is_some_and(|i| i.smearing.is_some());
        if is_smeared {
            self.info.max_blur * (1.0 + 1e-6)
        } else {
            0.0
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

    /// Facets of one size for `views`, in one pass.
    fn facets(&mut self, size: usize, views: &[&View]) -> Result<Vec<Facet>, DatasetError> {
        let requests = || views.iter().map(|view| &view.request);
        let centres: Vec<_> = requests().map(|r| r.region.from_unit(0.5, 0.5)).collect();
        let restored = requests().map(|r| r.restored.clone()).collect();
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

/// What is asked of views.
pub(super) fn ask_views(question: &mut Question, jobs: &[(&View, &[Source])]) {
    for (view, points) in jobs {
        let Region { low, high } = view.request.region;
        question.numbers([low.l, low.m, high.l, high.m]);
        question.numbers([f64::from(u8::from(view.request.is_exact))]);
        question.sources(&view.request.restored);
        question.sources(points);
    }
}
