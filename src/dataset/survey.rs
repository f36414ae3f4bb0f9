//! The whole field at a glance: the best X/sqrt(Y) of a few round shapes at every position.
//!
//! The field is cut into facets much larger than those that serve a likelihood. Sources of the sizes
//! that are looked for are seen by the shorter baselines, so the facets leave out the others.

use std::sync::Arc;

use rayon::prelude::*;

use super::answers::Question;
use super::snr_map::{Extremes, SnrMap};
use super::uv_profile::Binned;
use super::{Dataset, DatasetError};
use crate::coords::Lm;
use crate::likelihood::VisBlock;
use crate::likelihood::facet::{
    Facet, FacetBuilder, FacetNeeds, FacetPlan, FacetWeights, Gains, Reach, TiltRange,
};
use crate::prior::{Region, SourcePrior};
use crate::rime::Source;
use crate::rime::shape::Ellipticity;

/// Spacing of positions in widths of the beam: what a source keeps at the nearest, 0.32 beams away
/// at most, is exp(-0.32²/2).
const SPACING_BEAMS: f64 = 0.45;
const SEEN_AT_NEAREST: f64 = 0.95;
/// Part of the Y of the smallest shape that the baselines in use hold.
const PART_OF_Y: f64 = 0.97;
/// Ratio of neighbouring scale-lengths.
const SCALE_STEP: f64 = 2.0;
/// Part of the prior beyond the smallest and largest scale-length, each.
const SCALE_TAIL: f64 = 0.02;
/// Second-order w term at the corners of a facet: 0.3 radian.
const W_TERM_MAX: f64 = 0.05;
/// Most that smearing may change at the longest baseline from the centre of a facet to a corner. The ratio
/// of a source falls by half the mean square of the change over all baselines.
const GAIN_CHANGE_MAX: f64 = 0.35;
/// Most cells of a level: the larger a facet the better, until its grid falls out of the cache.
const CELLS_MAX: usize = 250_000;
/// Sources drawn from the prior to see how much of them is seen, and the part that may be seen less.
const N_DRAW: usize = 1000;
const LEAST_SEEN: f64 = 0.01;

/// What is seen of a source of the most extreme spectral index by templates of the middle one.
///
/// # Formula
/// Of t x over the band, x = ln(ν/ν0) even in |x| < h: <exp tx> / sqrt(<exp 2tx>), <exp tx> = sinh(th)/(th).
fn seen_of_tilt(tilts: TiltRange) -> f64 {
    let reach = tilts.most * tilts.half_band_ln;
    let mean = |x: f64| if x == 0.0 { 1.0 } else { x.sinh() / x };
    mean(reach) / mean(2.0 * reach).sqrt()
}

/// How the field is looked at.
pub struct Survey {
    plan: Arc<FacetPlan>,
    weights: Option<Arc<FacetWeights>>,
    facets: Vec<Region>,
    scales_rad: Vec<f64>,
    /// Baselines in use [wavelength].
    reach: Reach,
    n_side: usize,
    seen: f64,
}

impl Survey {
    /// Part of its signal-to-noise ratio that a source shows at least, for all but 1% of the prior.
    pub fn seen(&self) -> f64 {
        self.seen
    }
}

impl Dataset {
    /// Plans a look at `field` for sources of `prior`.
    ///
    /// # Errors
    /// The field is too wide for facets, however small.
    pub fn plan_survey(&self, field: &Region, prior: &SourcePrior) -> Result<Survey, DatasetError> {
        let scales_rad = scales_rad(prior);
        let round = |scale: &f64| {
            let e = Ellipticity::default();
            self.uv_profile.binned(self.profile, *scale, e)
        };
        let templates: Vec<Binned> = scales_rad.iter().map(round).collect();
        let (uv, w) = self.uv_profile.reach(&templates[0], PART_OF_Y);
        let reach = Reach {
            uv: uv.min(self.info.max_uv),
            w,
            blur: self.blur(),
        };
        let (plan, n_facet) = self.survey_plan(field, reach, &scales_rad)?;
        let side_rad = plan.side_rad();
        let n_side = (side_rad / (SPACING_BEAMS * self.info.beam_rad)).ceil() as usize;
        let part = |i: usize| i as f64 / n_facet as f64;
        let cell = |i: usize| Region {
            low: field.from_unit(part(i % n_facet), part(i / n_facet)),
            high: field.from_unit(part(i % n_facet + 1), part(i / n_facet + 1)),
        };
        let survey = Survey {
            plan: Arc::new(plan),
            weights: None,
            facets: (0..n_facet * n_facet).map(cell).collect(),
            seen: SEEN_AT_NEAREST
                * self.least_seen(prior, &templates, reach.uv)
                * seen_of_tilt(self.tilts()),
            scales_rad,
            reach,
            n_side,
        };
        tracing::info!(
            "survey of {} facets by baselines up to {:.0} wavelengths, {} shapes, {:.2} of a source is seen; {}",
            survey.facets.len(),
            reach.uv,
            survey.scales_rad.len(),
            survey.seen,
            survey.plan
        );
        Ok(survey)
    }

    /// The largest facets that will do, and how many there are along a side of the field.
    fn survey_plan(
        &self,
        field: &Region,
        reach: Reach,
        scales_rad: &[f64],
    ) -> Result<(FacetPlan, usize), DatasetError> {
        let width = (field.high.l - field.low.l).max(field.high.m - field.low.m);
        let corner = Lm {
            l: field.low.l.abs().max(field.high.l.abs()),
            m: field.low.m.abs().max(field.high.m.abs()),
        };
        let mut last = None;
        for n_facet in 1..=256 {
            let plan = FacetPlan::new(FacetNeeds {
                side_rad: width / n_facet as f64,
                farthest: corner.distance(Lm::default()),
                reach,
                longest_axis_rad: scales_rad.last().copied().unwrap_or_default(),
                profile: self.profile,
                w_term_max: W_TERM_MAX,
                gains: match self.instrument {
                    Some(_) => Gains::Centre(GAIN_CHANGE_MAX),
                    None => Gains::None,
                },
                tilts: TiltRange::default(),
            });
            match plan {
                Ok(plan) if plan.level_cells() <= CELLS_MAX => return Ok((plan, n_facet)),
                Ok(_) => {}
                Err(error) => last = Some(error),
            }
        }
        Err(DatasetError::Field(
            last.map_or_else(String::new, |error| error.to_string()),
        ))
    }

    /// What all but 1% of the sources of `prior` show under the best of `templates`.
    fn least_seen(&self, prior: &SourcePrior, templates: &[Binned], reach: f64) -> f64 {
        let (uv_profile, profile) = (&self.uv_profile, self.profile);
        let seen = |source: Source| {
            let source = uv_profile.binned(profile, source.scale_rad, source.e);
            let seen = templates.iter().map(|t| uv_profile.seen(&source, t, reach));
            seen.fold(0.0, f64::max)
        };
        let sources: Vec<Source> = prior.evenly(N_DRAW).collect();
        let mut seen: Vec<f64> = sources.into_par_iter().map(seen).collect();
        seen.sort_by(f64::total_cmp);
        seen[(LEAST_SEEN * N_DRAW as f64) as usize]
    }

    /// What is seen of each of `regions` with the removed sources out of the data, and where it reaches
    /// `limit` and the part `part` of the highest; in as many passes over the data as the memory budget
    /// demands. `progress` is told the facets looked at and in all.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn survey(
        &mut self,
        survey: &mut Survey,
        regions: &[Region],
        [limit, part]: [f64; 2],
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Vec<Extremes>, DatasetError> {
        let ask = |question: &mut Question| {
            question.numbers([limit, part]);
            for region in regions {
                let Region { low, high } = region;
                question.numbers([low.l, low.m, high.l, high.m]);
            }
        };
        let numbers = self.answer("survey", ask, |dataset| {
            let mut seen = vec![Extremes::NOTHING; regions.len()];
            let holds = |facet: &Region| regions.iter().any(|region| facet.overlaps(region));
            let facets = survey
                .facets
                .iter()
                .copied()
                .filter(holds)
                .collect::<Vec<_>>();
            let mut n_done = 0;
            progress(0, facets.len() as u64);
            dataset.maps(survey, &facets, |map| {
                for (seen, region) in seen.iter_mut().zip(regions) {
                    if region.overlaps(&map.region) {
                        *seen = seen.and(map.extremes(region, limit, part));
                    }
                }
                n_done += 1;
                progress(n_done, facets.len() as u64);
            })?;
            Ok(seen.into_iter().flat_map(Extremes::to_numbers).collect())
        })?;
        let (each, _) = numbers.as_chunks();
        Ok(each
            .iter()
            .map(|numbers| Extremes::from_numbers(*numbers))
            .collect())
    }

    /// Hands the map of each of `facets`, which are some of `survey`, to `visit`, in order.
    fn maps(
        &mut self,
        survey: &mut Survey,
        facets: &[Region],
        mut visit: impl FnMut(SnrMap),
    ) -> Result<(), DatasetError> {
        let bytes = survey.plan.build_bytes() + survey.plan.facet_bytes();
        for regions in facets.chunks(self.at_a_time(bytes)) {
            let centres: Vec<Lm> = regions.iter().map(|r| r.from_unit(0.5, 0.5)).collect();
            let plan = survey.plan.clone();
            let mut builder = match survey.weights.clone() {
                Some(weights) => FacetBuilder::with_weights(plan, &centres, weights),
                None => FacetBuilder::new(plan, &centres),
            };
            let reach = survey.reach.uv;
            self.for_few_blocks(|blocks| {
                let short: Vec<_> = blocks.par_iter().map(|block| below(block, reach)).collect();
                builder.add(&short);
            })?;
            let facets = builder.finish();
            survey.weights = facets.first().and_then(Facet::weights);
            let maps: Vec<SnrMap> = facets
                .into_par_iter()
                .zip(regions)
                .map(|(facet, region)| snr_map(&facet, *region, survey))
                .collect();
            maps.into_iter().for_each(&mut visit);
        }
        Ok(())
    }
}

/// Scale-lengths that those of the prior lie between, each so many times the one before.
fn scales_rad(prior: &SourcePrior) -> Vec<f64> {
    let low = prior.scale.from_unit(SCALE_TAIL, prior.flux.low_jy);
    let high = prior.scale.from_unit(1.0 - SCALE_TAIL, prior.flux.high_jy);
    let n = ((high / low).ln() / SCALE_STEP.ln()).ceil().max(1.0);
    (0..=n as i32)
        .map(|i| low * (high / low).powf(f64::from(i) / n))
        .collect()
}

fn snr_map(facet: &Facet, region: Region, survey: &Survey) -> SnrMap {
    let mut high_low = vec![[f32::NEG_INFINITY, f32::INFINITY]; survey.n_side * survey.n_side];
    for &scale_rad in &survey.scales_rad {
        let map = facet.map(scale_rad, survey.n_side);
        let per_x = if map.y > 0.0 { 1.0 / map.y.sqrt() } else { 0.0 };
        for (value, x) in high_low.iter_mut().zip(&map.x) {
            let snr = x * per_x as f32;
            *value = [value[0].max(snr), value[1].min(snr)];
        }
    }
    SnrMap {
        region,
        high_low,
        n_side: survey.n_side,
    }
}

/// The samples of baselines below `reach` [wavelength].
fn below(block: &VisBlock, reach: f64) -> VisBlock {
    let is_short = |k: &u32| {
        let (u, v) = (block.u[*k as usize], block.v[*k as usize]);
        u * u + v * v < reach * reach
    };
    let which: Vec<u32> = (0..block.len() as u32).filter(is_short).collect();
    block.select(&which)
}
