//! Filling many facets from one stream of samples.

use super::cells::{self, Common};
use super::fill::{CHANNELS, Target, fill};
use super::outskirts::Outskirts;
use super::plan::{FacetPlan, Reach};
use super::resample::{HalfPlane, Mirror};
use super::sorted::{CHUNK, Queue, Sorted};
use super::term::Centre;
use super::{Facet, Gains, Look};
use crate::coords::Lm;
use crate::likelihood::{Extents, Isa, VisBlock, subtract};
use crate::rime::shape::Profile;
use crate::rime::{Ray, Source};
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
    /// One for all facets, or one for each.
    weights: Vec<Grid>,
    known_weights: Option<Arc<FacetWeights>>,
    queue: Queue,
}

/// The imaginary part of weights.
static ZEROS: [f32; CHUNK] = [0.0; CHUNK];

/// What a grid is filled with.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Content {
    /// w s d.
    Data,
    /// w s².
    Weights,
    /// The same, as data of a point at the centre.
    Products,
}

/// The fine grids of a facet, level after level.
#[derive(Debug)]
struct Grid {
    content: Content,
    centre: Centre,
    /// Whose factors s of the instrument it is filled with.
    look: Ray,
    target: Target,
    cells: Vec<f32>,
    /// Sources that are added to the data, with their flux density negated.
    restored: Vec<(Source, Profile)>,
}

impl Grid {
    fn new(plan: &FacetPlan, content: Content, centre: Lm, look: Ray) -> Grid {
        let centre = Centre::new(centre);
        Grid {
            content,
            look,
            centre,
            target: Target::new(plan, &centre),
            cells: vec![0.0; plan.grid_cells()],
            restored: Vec::new(),
        }
    }

    /// Adds samples.
    fn fill(&mut self, plan: &FacetPlan, isa: Isa, chunk: &Sorted) {
        let block = self.look_at(&chunk.block);
        let numbers: [Cow<[f32]>; 2] = match self.content {
            Content::Weights => [(&block.weight).into(), (&ZEROS[..block.len()]).into()],
            _ => [(&block.weighted_re).into(), (&block.weighted_im).into()],
        };
        let numbers = match chunk.block.gains(isa, self.look) {
            None => numbers,
            Some(mut gains) => {
                if self.content != Content::Data {
                    for gain in &mut gains {
                        *gain *= *gain;
                    }
                }
                let seen = |n: Cow<[f32]>| n.iter().zip(&gains).map(|(n, gain)| n * gain).collect();
                numbers.map(seen)
            }
        };
        let data = [&numbers[0][..], &numbers[1][..]];
        fill(
            isa,
            &plan.spread,
            &self.target,
            chunk,
            data,
            &mut self.cells,
        );
    }

    /// The samples with the sources that this facet puts back.
    fn look_at<'a>(&self, block: &'a VisBlock) -> Cow<'a, VisBlock> {
        let mut block = Cow::Borrowed(block);
        if !self.restored.is_empty() {
            let block = block.to_mut();
            if self.content == Content::Products {
                // The point that stands for the weights has no factors of its own.
                block.extents = Extents::default();
            }
            subtract(block, &self.restored);
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
            grids: data_grids(&plan, centres),
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
            grids: data_grids(&plan, centres),
            plan,
        }
    }

    /// The same with sources added to the data of each facet, which were taken out of all.
    ///
    /// # Panics
    /// If there are not as many lists as facets.
    #[must_use]
    pub fn restoring(mut self, restored: Vec<Vec<Source>>) -> FacetBuilder {
        let grids = self.grids.chunks_exact_mut(self.plan.n_look());
        assert_eq!(restored.len(), grids.len(), "one list a facet");
        for (looks, sources) in grids.zip(restored) {
            let negated = sources.into_iter().map(|source| Source {
                flux_jy: -source.flux_jy,
                ..source
            });
            let profile = self.plan.needs.profile;
            let negated: Vec<_> = negated.map(|source| (source, profile)).collect();
            for grid in looks {
                grid.restored.clone_from(&negated);
            }
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
            reach.uv <= needs.reach.uv
                && reach.w <= needs.reach.w
                && reach.blur <= needs.reach.blur,
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
        let (isa, plan) = (Isa::detect(), &self.plan);
        let grids = self.grids.par_iter_mut().chain(&mut self.weights);
        grids.for_each(|grid| {
            for chunk in &chunks {
                grid.fill(plan, isa, chunk);
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
        let look = |(i, grid): (usize, Grid)| {
            let data = pyramid(&plan, &grid, Mirror::Even);
            let times_w = pyramid(&plan, &grid, Mirror::Odd);
            let packs = |(data, times_w)| cells::packs(&plan, data, times_w);
            let look = Look {
                levels: data.iter().zip(&times_w).map(packs).collect(),
                // Of several grids of weights each look has its own.
                weights: weights[i.min(weights.len() - 1)].clone(),
            };
            (grid.centre, look)
        };
        let looks: Vec<_> = grids.into_par_iter().enumerate().map(look).collect();
        let mut facets: Vec<Facet> = Vec::new();
        for (i, (centre, look)) in looks.into_iter().enumerate() {
            match facets.last_mut() {
                Some(facet) if i % plan.n_look() != 0 => facet.looks.push(look),
                _ => facets.push(Facet {
                    isa,
                    centre,
                    plan: plan.clone(),
                    looks: vec![look],
                }),
            }
        }
        facets
    }
}

/// Grids for the data of each facet, one for each of its looks.
fn data_grids(plan: &FacetPlan, centres: &[Lm]) -> Vec<Grid> {
    let content = match plan.needs.gains {
        Gains::Pairs(_) => Content::Products,
        _ => Content::Data,
    };
    let grids = |&centre: &Lm| {
        let looks = plan.rays(centre).into_iter();
        looks.map(move |look| Grid::new(plan, content, centre, look))
    };
    centres.iter().flat_map(grids).collect()
}

/// Grids for the weights, as the phase centre sees the baselines: one for all, or one for each look.
fn weight_grids(plan: &FacetPlan, centres: &[Lm]) -> Vec<Grid> {
    let grid = |look| Grid::new(plan, Content::Weights, Lm::default(), look);
    if plan.needs.gains == Gains::None {
        return vec![grid(Ray::default())];
    }
    let looks = centres.iter().flat_map(|&centre| plan.rays(centre));
    looks.map(grid).collect()
}

fn finish_weights(plan: &FacetPlan, grid: &Grid) -> FacetWeights {
    let levels: Vec<Vec<Common>> = pyramid(plan, grid, Mirror::Even)
        .iter()
        .zip(&pyramid(plan, grid, Mirror::Odd))
        .enumerate()
        .map(|(level, (weights, times_w))| cells::common(plan, level, weights, times_w))
        .collect();
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
