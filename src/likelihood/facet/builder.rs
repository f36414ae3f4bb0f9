//! Filling many facets from one stream of samples.

use super::Facet;
use super::cells::{self, Common};
use super::fill::{CHANNELS, Target, fill};
use super::plan::{FacetPlan, Reach};
use super::resample::{HalfPlane, Mirror};
use super::sorted::{Queue, Sorted};
use super::term::Centre;
use crate::coords::Lm;
use crate::likelihood::{Isa, VisBlock, subtract};
use crate::rime::Source;
use crate::rime::shape::Profile;
use num_complex::Complex;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// The grids of weights, which all facets over the same samples share.
#[derive(Debug)]
pub struct FacetWeights {
    pub(super) levels: Vec<Vec<Common>>,
}

/// Facets on their way: [`FacetBuilder::add`] for all blocks of a stream, then
/// [`FacetBuilder::finish`].
///
/// A facet sees the blocks in their order, on one core; facets are filled side by side. So the
/// result is the same for any number of threads.
#[derive(Debug)]
pub struct FacetBuilder {
    plan: Arc<FacetPlan>,
    grids: Vec<Grid>,
    /// One for all facets, or one for each.
    weights: Vec<Grid>,
    known_weights: Option<Arc<FacetWeights>>,
    queue: Queue,
}

/// The fine grids of a facet, level after level.
#[derive(Debug)]
struct Grid {
    centre: Centre,
    /// Where the factors of the instrument are those of.
    seen: Lm,
    tilt: Tilt,
    target: Target,
    cells: Vec<f32>,
    /// Sources that are added to the data, with their flux density negated.
    restored: Vec<(Source, Profile)>,
}

impl Grid {
    fn new(plan: &FacetPlan, centre: Lm) -> Grid {
        let seen = centre;
        let centre = Centre::new(centre);
        Grid {
            seen,
            tilt: Tilt::default(),
            centre,
            target: Target::new(plan, &centre),
            cells: vec![0.0; plan.grid_cells()],
            restored: Vec::new(),
        }
    }
}

/// How the factors s of the instrument change over a facet: Σ w s² and Σ w s ∂s/∂(l, m).
#[derive(Debug, Clone, Copy, Default)]
struct Tilt {
    power: f64,
    slope: [f64; 2],
}

/// Of so many samples one is looked at for the tilt.
const TILT_STEP: usize = 8;

impl Tilt {
    /// Adds samples whose factors at `lm` are `gains`; `step` is a part of the facet [rad].
    fn add(&mut self, block: &VisBlock, lm: Lm, gains: &[f32], step: f64) {
        let Lm { l, m } = lm;
        let beside = [Lm { l: l + step, m }, Lm { l, m: m + step }];
        let Some(beside) = block.extents.gains_of(beside) else {
            return;
        };
        for k in (0..block.len()).step_by(TILT_STEP) {
            let (weight, gain) = (f64::from(block.weight[k]), f64::from(gains[k]));
            self.power += weight * gain * gain;
            for (slope, beside) in self.slope.iter_mut().zip(&beside) {
                let change = f64::from(block.gain_at(beside, k)) - gain;
                *slope += weight * gain * change / step;
            }
        }
    }

    /// ∂ ln s of the mean factor.
    fn relative(&self) -> [f64; 2] {
        let per_power = if self.power > 0.0 {
            1.0 / self.power
        } else {
            0.0
        };
        self.slope.map(|slope| slope * per_power)
    }
}

impl Grid {
    /// The numbers to grid: those of the samples, or their weights, with the factors of the instrument.
    fn numbers<'a>(
        &mut self,
        block: &'a VisBlock,
        is_weights: bool,
        step: f64,
    ) -> [Cow<'a, [f32]>; 2] {
        let numbers: [Cow<[f32]>; 2] = if is_weights {
            [(&block.weight).into(), vec![0.0; block.len()].into()]
        } else {
            [(&block.weighted_re).into(), (&block.weighted_im).into()]
        };
        let Some(gains) = block.gains(self.seen) else {
            return numbers;
        };
        let seen =
            |(number, gain): (&f32, &f32)| number * if is_weights { gain * gain } else { *gain };
        let numbers = numbers.map(|n| n.iter().zip(&gains).map(seen).collect::<Vec<_>>().into());
        if !is_weights {
            self.tilt.add(block, self.seen, &gains, step);
        }
        numbers
    }

    /// The samples with the sources that this facet puts back.
    fn look_at<'a>(&self, block: &'a VisBlock) -> Cow<'a, VisBlock> {
        let mut block = Cow::Borrowed(block);
        if !self.restored.is_empty() {
            subtract(block.to_mut(), &self.restored);
        }
        block
    }
}

impl FacetBuilder {
    /// Facets about `centres`, empty.
    pub fn new(plan: Arc<FacetPlan>, centres: &[Lm]) -> FacetBuilder {
        FacetBuilder {
            weights: weight_grids(&plan, centres),
            known_weights: None,
            queue: Queue::default(),
            grids: centres.iter().map(|&lm| Grid::new(&plan, lm)).collect(),
            plan,
        }
    }

    /// The same where the weights are known from facets over the same samples, say before a source
    /// was subtracted from the data: they are not gridded again.
    pub fn with_weights(
        plan: Arc<FacetPlan>,
        centres: &[Lm],
        weights: Arc<FacetWeights>,
    ) -> FacetBuilder {
        FacetBuilder {
            weights: Vec::new(),
            known_weights: Some(weights),
            queue: Queue::default(),
            grids: centres.iter().map(|&lm| Grid::new(&plan, lm)).collect(),
            plan,
        }
    }

    /// The same with sources added to the data of each facet, which were taken out of all.
    ///
    /// # Panics
    /// If there are not as many lists as facets.
    #[must_use]
    pub fn restoring(mut self, restored: Vec<Vec<Source>>) -> FacetBuilder {
        assert_eq!(restored.len(), self.grids.len(), "one list a facet");
        for (grid, sources) in self.grids.iter_mut().zip(restored) {
            let negated = sources.into_iter().map(|source| Source {
                flux_jy: -source.flux_jy,
                ..source
            });
            let profile = self.plan.needs.profile;
            grid.restored = negated.map(|source| (source, profile)).collect();
        }
        self
    }

    /// Adds the next blocks of the stream, on the current rayon pool.
    ///
    /// # Panics
    /// If a sample lies beyond the reach that the plan was made for.
    pub fn add(&mut self, blocks: &[VisBlock]) {
        let needs = &self.plan.needs;
        let reach = blocks
            .par_iter()
            .map(Reach::of)
            .reduce(Reach::default, Reach::union);
        assert!(
            reach.uv <= needs.reach.uv && reach.w <= needs.reach.w,
            "samples reach to {reach:?}, the facets to {:?}",
            needs.reach
        );
        for block in blocks {
            self.queue.push(block);
        }
        self.flush(false);
    }

    /// Grids the samples that wait: those of full chunks, or all.
    fn flush(&mut self, everything: bool) {
        let chunks: Vec<_> = self
            .queue
            .take(everything)
            .into_par_iter()
            .map(|chunk| Sorted::new(&self.plan, &chunk))
            .collect();
        if chunks.is_empty() {
            return;
        }
        let (isa, spread) = (Isa::detect(), &self.plan.spread);
        let step = 0.25 * self.plan.needs.side_rad;
        let data = self.grids.par_iter_mut().map(|grid| (grid, false));
        let weights = self.weights.par_iter_mut().map(|grid| (grid, true));
        data.chain(weights).for_each(|(grid, is_weights)| {
            for chunk in &chunks {
                let block = grid.look_at(&chunk.block);
                let numbers = grid.numbers(&block, is_weights, step);
                let [re, im] = &numbers;
                fill(isa, spread, &grid.target, chunk, [re, im], &mut grid.cells);
            }
        });
    }

    /// The facets, in the order of their centres.
    pub fn finish(mut self) -> Vec<Facet> {
        self.flush(true);
        let FacetBuilder {
            plan,
            grids,
            weights,
            known_weights,
            ..
        } = self;
        let isa = Isa::detect();
        let weights: Vec<Arc<FacetWeights>> = match known_weights {
            Some(known) => vec![known],
            None => (weights.into_par_iter())
                .map(|grid| Arc::new(finish_weights(&plan, &grid)))
                .collect(),
        };
        grids
            .into_par_iter()
            .enumerate()
            .map(|(i, grid)| {
                let data = pyramid(&plan, &grid, Mirror::Even);
                let times_w = pyramid(&plan, &grid, Mirror::Odd);
                Facet {
                    isa,
                    centre: grid.centre,
                    levels: data
                        .iter()
                        .zip(&times_w)
                        .map(|(data, times_w)| cells::packs(&plan, data, times_w))
                        .collect(),
                    plan: plan.clone(),
                    weights: weights[i.min(weights.len() - 1)].clone(),
                    tilt: grid.tilt.relative(),
                }
            })
            .collect()
    }
}

/// Grids for the weights, as the phase centre sees the baselines.
fn weight_grids(plan: &FacetPlan, centres: &[Lm]) -> Vec<Grid> {
    let grid = |&seen: &Lm| Grid {
        seen,
        ..Grid::new(plan, Lm::default())
    };
    if plan.needs.has_gains {
        centres.iter().map(grid).collect()
    } else {
        vec![grid(&Lm::default())]
    }
}

fn finish_weights(plan: &FacetPlan, grid: &Grid) -> FacetWeights {
    let levels = {
        pyramid(plan, grid, Mirror::Even)
            .iter()
            .zip(&pyramid(plan, grid, Mirror::Odd))
            .enumerate()
            .map(|(level, (weights, times_w))| cells::common(plan, level, weights, times_w))
            .collect()
    };
    FacetWeights { levels }
}

/// The levels of `grid`, of its data or of these times w: those further in added to those before.
fn pyramid(plan: &FacetPlan, grid: &Grid, mirror: Mirror) -> Vec<HalfPlane> {
    let channel = match mirror {
        Mirror::Even => 0,
        Mirror::Odd => 2,
    };
    let fine = plan.fine();
    let size = fine.rows * fine.cols * CHANNELS;
    let mut levels: Vec<HalfPlane> = Vec::new();
    for cells in grid.cells.chunks_exact(size).rev() {
        let mut level = HalfPlane::resampled(
            &plan.from_fine,
            mirror,
            [fine.rows, fine.cols],
            [fine.first_row, fine.first_col],
            |row, col| {
                let at = (row * fine.cols + col) * CHANNELS + channel;
                Complex::new(f64::from(cells[at]), f64::from(cells[at + 1]))
            },
        );
        if let Some(next) = levels.last() {
            level.add(&next.coarsened(&plan.from_next));
        }
        levels.push(level);
    }
    levels.reverse();
    levels
}
