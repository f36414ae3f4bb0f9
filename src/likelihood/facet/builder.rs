//! Filling many facets from one stream of samples.

use super::Facet;
use super::cells::{self, Common};
use super::fill::{CHANNELS, Target, fill};
use super::outskirts::Outskirts;
use super::plan::{FacetPlan, Reach};
use super::resample::{HalfPlane, Mirror};
use super::sorted::{CHUNK, Queue, Sorted};
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
    pub(super) outskirts: Outskirts,
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
    weights: Option<Grid>,
    known_weights: Option<Arc<FacetWeights>>,
    queue: Queue,
}

/// The fine grids of a facet, level after level.
#[derive(Debug)]
struct Grid {
    centre: Centre,
    target: Target,
    cells: Vec<f32>,
    /// Sources that are added to the data, with their flux density negated.
    restored: Vec<(Source, Profile)>,
}

impl Grid {
    fn new(plan: &FacetPlan, centre: Lm) -> Grid {
        let centre = Centre::new(centre);
        Grid {
            centre,
            target: Target::new(plan, &centre),
            cells: vec![0.0; plan.build_bytes() / size_of::<f32>()],
            restored: Vec::new(),
        }
    }
}

impl Grid {
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
            weights: Some(Grid::new(&plan, Lm::default())),
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
            weights: None,
            known_weights: Some(weights),
            ..FacetBuilder::new(plan, centres)
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
        let zeros = vec![0.0; CHUNK];
        let data = self.grids.par_iter_mut().map(|grid| (grid, false));
        let weights = self.weights.par_iter_mut().map(|grid| (grid, true));
        data.chain(weights).for_each(|(grid, is_weights)| {
            for chunk in &chunks {
                let block = grid.look_at(&chunk.block);
                let data = if is_weights {
                    [&block.weight[..], &zeros[..block.len()]]
                } else {
                    [&block.weighted_re[..], &block.weighted_im[..]]
                };
                fill(isa, spread, &grid.target, chunk, data, &mut grid.cells);
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
        let weights = match (known_weights, weights) {
            (Some(known), _) => known,
            (None, grid) => Arc::new(finish_weights(&plan, grid.as_ref())),
        };
        grids
            .into_par_iter()
            .map(|grid| {
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
                    weights: weights.clone(),
                }
            })
            .collect()
    }
}

fn finish_weights(plan: &FacetPlan, grid: Option<&Grid>) -> FacetWeights {
    let levels: Vec<Vec<Common>> = grid.map_or_else(Vec::new, |grid| {
        pyramid(plan, grid, Mirror::Even)
            .iter()
            .zip(&pyramid(plan, grid, Mirror::Odd))
            .enumerate()
            .map(|(level, (weights, times_w))| cells::common(plan, level, weights, times_w))
            .collect()
    });
    FacetWeights {
        outskirts: Outskirts::new(plan, &levels),
        levels,
    }
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
