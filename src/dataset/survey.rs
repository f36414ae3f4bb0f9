//! The whole field at a glance: the best X/sqrt(Y) of a few round shapes at every position.
//!
//! The field is cut into facets much larger than those that serve a likelihood. Sources of the sizes
//! that are looked for are seen by the shorter baselines, so the facets leave out the others.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::uv_profile::Binned;
use super::{Dataset, DatasetError};
use crate::coords::Lm;
use crate::likelihood::VisBlock;
use crate::likelihood::facet::{Facet, FacetBuilder, FacetNeeds, FacetPlan, FacetWeights, Reach};
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
/// Most cells of a level: the larger a facet the better, until its grid falls out of the cache.
const CELLS_MAX: usize = 250_000;
/// Sources drawn from the prior to see how much of them is seen, and the part that may be seen less.
const N_DRAW: usize = 1000;
const LEAST_SEEN: f64 = 0.01;

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

/// The signal-to-noise ratios over a facet.
pub struct SnrMap {
    /// Where.
    pub region: Region,
    /// Highest and lowest X/sqrt(Y) of all shapes, axes (m, l), at the middles of equal parts.
    high_low: Vec<[f32; 2]>,
    n_side: usize,
}

/// What is seen of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Highest X/sqrt(Y).
    pub high: f64,
    /// Lowest: as far below zero as noise and sidelobes go above it.
    pub low: f64,
    /// Holds every position that reaches the limit.
    pub above: Option<Region>,
}

impl Extremes {
    /// Before anything was seen.
    pub const NOTHING: Self = Self {
        high: f64::NEG_INFINITY,
        low: f64::INFINITY,
        above: None,
    };

    /// What is seen of two regions.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let both = self.above.zip(other.above).map(|(a, b)| a.united(&b));
        Self {
            high: self.high.max(other.high),
            low: self.low.min(other.low),
            above: both.or(self.above).or(other.above),
        }
    }
}

impl SnrMap {
    /// Highest and lowest value in `region` and half a step about it, and the rectangle about all
    /// positions there that reach `limit` and the part `part` of the highest, half a step about them
    /// included.
    pub fn extremes(&self, region: &Region, limit: f64, part: f64) -> Extremes {
        let (own, wanted) = (&self.region, region);
        let columns = self.range([own.low.l, own.high.l], [wanted.low.l, wanted.high.l]);
        let rows = self.range([own.low.m, own.high.m], [wanted.low.m, wanted.high.m]);
        let places = || {
            rows.clone()
                .flat_map(|row| columns.clone().map(move |column| (row, column)))
        };
        let value = |(row, column): (usize, usize)| {
            self.high_low[row * self.n_side + column].map(f64::from)
        };
        let high_low = places().map(value);
        let [high, low] = high_low
            .fold([f64::NEG_INFINITY, f64::INFINITY], |[high, low], value| {
                [high.max(value[0]), low.min(value[1])]
            });
        let edge = |i: usize| i as f64 / self.n_side as f64;
        let cell = |(row, column): (usize, usize)| Region {
            low: own.from_unit(edge(column), edge(row)),
            high: own.from_unit(edge(column + 1), edge(row + 1)),
        };
        let bright = places().filter(|&place| value(place)[0] >= limit.max(part * high));
        Extremes {
            high,
            low,
            above: bright.map(cell).reduce(|a, b| a.united(&b)),
        }
    }

    /// The positions along an axis from `own[0]` to `own[1]` that are within half a step of `wanted`.
    fn range(&self, own: [f64; 2], wanted: [f64; 2]) -> Range<usize> {
        let place = |x: f64| (x - own[0]) / (own[1] - own[0]) * self.n_side as f64;
        let first = (place(wanted[0]) - 1.0).ceil().max(0.0) as usize;
        let end = (place(wanted[1]).floor() + 1.0).max(0.0) as usize;
        first.min(self.n_side)..end.min(self.n_side)
    }
}

impl Survey {
    /// Part of its signal-to-noise ratio that a source shows at least, for all but 1% of the prior.
    pub fn seen(&self) -> f64 {
        self.seen
    }

    /// The parts of the field that are looked at on their own.
    pub fn facets(&self) -> &[Region] {
        &self.facets
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
            seen: SEEN_AT_NEAREST * self.least_seen(prior, &templates, reach.uv),
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
                has_gains: self.instrument.is_some(),
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

    /// Part of the sources of `prior` that are expected to stay below a matched-filter signal-to-noise
    /// ratio of `cut`.
    ///
    /// A source of ratio ρ shows sqrt(ρ² + 2) on average, as its position follows the noise, with a
    /// scatter of 1.
    pub fn part_below(&self, cut: f64, prior: &SourcePrior) -> f64 {
        let below = |source: Source| {
            let binned = self
                .uv_profile
                .binned(self.profile, source.scale_rad, source.e);
            let snr2 = source.flux_jy * source.flux_jy * self.uv_profile.y(&binned);
            0.5 * puruspe::erfc(((snr2 + 2.0).sqrt() - cut) * FRAC_1_SQRT_2)
        };
        prior.evenly(N_DRAW).map(below).sum::<f64>() / N_DRAW as f64
    }

    /// Looks at the facets number `which` of `survey`, less the removed sources, and hands each map
    /// to `visit`, in order; in as many passes over the data as the memory budget demands.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn survey(
        &mut self,
        survey: &mut Survey,
        which: &[usize],
        mut visit: impl FnMut(SnrMap),
    ) -> Result<(), DatasetError> {
        let bytes = survey.plan.build_bytes() + survey.plan.facet_bytes();
        for which in which.chunks(self.at_a_time(bytes)) {
            let regions: Vec<Region> = which.iter().map(|&i| survey.facets[i]).collect();
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
                .map(|(facet, region)| snr_map(&facet, region, survey))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_region_however_small_holds_a_position() {
        let field = Region::square(Lm::default(), 10.0);
        let map = SnrMap {
            region: field,
            high_low: (0..100).map(|i| [i as f32, -(i as f32)]).collect(),
            n_side: 10,
        };
        let seen = |region: &Region| map.extremes(region, 33.0, 0.0);
        assert_eq!((seen(&field).high, seen(&field).low), (99.0, -99.0));
        for i in 0..100 {
            let at = field.from_unit(f64::from(i) / 100.0, 0.33);
            let here = seen(&Region::square(at, 1e-3));
            assert!(
                (30.0..50.0).contains(&here.high) && here.low <= -30.0,
                "{i}"
            );
            assert_eq!(here.above.is_some(), here.high >= 33.0);
            if i > 40 {
                assert!(here.above.unwrap().grown(1e-9).contains(at));
            }
        }
        // The middle of the first row's last part is at (4.5, -4.5).
        let corner = seen(&Region::square(Lm { l: 4.6, m: -4.6 }, 0.1));
        assert_eq!((corner.high, corner.low, corner.above), (9.0, -9.0, None));
        let beside = seen(&Region::square(Lm { l: 7.0, m: 0.0 }, 0.1));
        assert_eq!(beside, Extremes::NOTHING);
        assert_eq!(beside.and(corner), corner);
        // From row 3, column 3 on.
        let above = seen(&field).above.unwrap();
        assert!((above.low.m + 2.0).abs() < 1e-9 && (above.low.l + 5.0).abs() < 1e-9);
        assert_eq!(above.high, field.high);
        let half = map.extremes(&field, 33.0, 0.5).above.unwrap();
        assert!(half.low.m.abs() < 1e-9);
    }
}
