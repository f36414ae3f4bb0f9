//! How large the grids of a facet are, and which of them serves which shape.
//!
//! Level j of the pyramid holds |u| < U/2^j on cells of 1/(2^j P) wavelengths: all levels have as
//! many cells, each sees twice as much sky as the one before with half the resolution. A shape is
//! cut by smooth windows in |u|,
//!
//! ```text
//! F = (1 - L_1) F + (L_1 - L_2) F + ... + L_j F      L_j falls from 1 at U/2^(j+1) to 0 at U/2^j
//! ```
//!
//! and each term summed on its own level, up to the first level j that holds the whole source: only
//! what varies slowly in uv, the far wings of a source, needs the wide sky, and it lies at short
//! baselines.

#![allow(clippy::inline_always)] // compiled anew for each instruction set

use super::fill::CHANNELS;
use super::looks::{Gains, Looks};
use super::resample::{CLEAR, Resampler, window};
use super::spread::{Spread, WIDTH};
use super::tilts::{TiltRange, Tilts};
use crate::coords::Lm;
use crate::likelihood::VisBlock;
use crate::rime::Ray;
use crate::rime::shape::Profile;
use std::f64::consts::PI;
use std::fmt;

/// Cells beyond the longest baseline that are kept: interpolation reaches as far.
pub(super) const GUARD: usize = 10;

/// Oversampling of the grid that samples are spread on: 5/4, as a ratio of transform lengths.
const FINE: [usize; 2] = [5, 4];

/// Sky beyond the facet that level 0 sees, in units of 1/(U/4), the inverse of where its inner
/// window begins.
const OUTER_MARGIN: f64 = 3.5;

/// Most of the second-order w term that is left out, (2π w ε)²/2.
pub const W_TERM_MAX: f64 = 2e-3;

/// Most cells from the middle to the edge: more is a mistake rather than a facet.
const RADIUS_MAX: usize = 2000;

/// How far the samples reach.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reach {
    /// Longest sqrt(u² + v²) [wavelength].
    pub uv: f64,
    /// Largest |w| [wavelength].
    pub w: f64,
    /// Largest change of what a smearing loss is the sinc of, phase or its rate times the extent of a
    /// sample, with direction cosines [turn].
    pub blur: f64,
}

impl Reach {
    /// The reach of the samples of `block`.
    pub fn of(block: &VisBlock) -> Reach {
        let uv2 = block.u.iter().zip(&block.v).map(|(u, v)| u * u + v * v);
        Reach {
            uv: uv2.fold(0.0, f64::max).sqrt(),
            w: block.w.iter().fold(0.0, |w, x| w.max(x.abs())),
            blur: block.blur(),
        }
    }

    /// The larger of both, each way.
    #[must_use]
    pub fn union(self, other: Reach) -> Reach {
        Reach {
            uv: self.uv.max(other.uv),
            w: self.w.max(other.w),
            blur: self.blur.max(other.blur),
        }
    }
}

/// What facets are asked to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetNeeds {
    /// Side of the square region that a facet serves [rad, in direction cosines].
    pub side_rad: f64,
    /// Distance of the farthest facet centre from the phase centre, sqrt(l² + m²).
    pub farthest: f64,
    /// Reach of the samples.
    pub reach: Reach,
    /// Longest scale-length along a major axis, α/(1-|e|), that is served [rad].
    pub longest_axis_rad: f64,
    /// The brightness profile.
    pub profile: Profile,
    /// Most of the second-order w term that may be left out, (2π w ε)²/2: [`W_TERM_MAX`] for
    /// likelihoods, more where a rough look will do.
    pub w_term_max: f64,
    /// How the factors of the instrument are known.
    pub gains: Gains,
    /// Spectral indices of the sources that are served.
    pub tilts: TiltRange,
}

/// Why there can be no such facet.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FacetError {
    /// The neglected w term is too large.
    #[error(
        "a facet of {side_rad:e} rad leaves out a w term of {term:e} at its corners, {w_term_max:e} is allowed: take at most {largest_rad:e} rad"
    )]
    WTerm {
        /// Side asked for [rad].
        side_rad: f64,
        /// (2π w ε)²/2 at the corners.
        term: f64,
        /// What is allowed.
        w_term_max: f64,
        /// Longest side that would do [rad].
        largest_rad: f64,
    },
    /// Smearing changes too much over the facet.
    #[error(
        "over a facet of {side_rad:e} rad smearing is off by {left_out:e} of a source, {most:e} is allowed: take at most {largest_rad:e} rad"
    )]
    Gains {
        /// Side asked for [rad].
        side_rad: f64,
        /// What would be left out at the longest baseline, at the corners.
        left_out: f64,
        /// What is allowed.
        most: f64,
        /// Longest side that would do [rad].
        largest_rad: f64,
    },
    /// The grid would be too large.
    #[error(
        "a facet of {side_rad:e} rad would need {radius} cells to the edge, {RADIUS_MAX} are allowed"
    )]
    TooLarge {
        /// Side asked for [rad].
        side_rad: f64,
        /// Cells from the middle to the edge.
        radius: usize,
    },
    /// A size that is not a positive number.
    #[error("the sizes of a facet and the reach of the samples must be positive numbers")]
    Parameter,
}

/// The grids that all facets of one size have in common. It does not depend on the data.
#[derive(Debug)]
pub struct FacetPlan {
    pub(super) needs: FacetNeeds,
    /// Where the factors of the instrument are worked out.
    pub(super) looks: Looks,
    /// For which spectral indices.
    pub(super) tilts: Tilts,
    /// Levels of the pyramid.
    pub(super) levels: usize,
    /// U [wavelength]: the longest baseline as seen from the farthest facet.
    pub(super) uv_max: f64,
    /// Period P of level 0 [rad].
    pub(super) period_rad: f64,
    /// Cells from the middle of a level to its edge, without guard.
    pub(super) radius: usize,
    /// Cells from the middle to the edge in each row: of level 0, and of the others.
    edges: [Vec<f64>; 2],
    /// The kernel that spreads samples.
    pub(super) spread: Spread,
    /// From the grid that samples are spread on to a level.
    pub(super) from_fine: Resampler,
    /// From a level to the one before.
    pub(super) from_next: Resampler,
}

impl FacetPlan {
    /// Chooses the grids for `needs`.
    ///
    /// # Errors
    /// The region is so large that the neglected w term, of second order in 2π w ε with
    /// ε = |δ|²/2 at the corners, would exceed 2e-3, or that the grid would be absurd.
    pub fn new(needs: FacetNeeds) -> Result<FacetPlan, FacetError> {
        check(&needs)?;
        let slope = needs.farthest / (1.0 - needs.farthest * needs.farthest).sqrt();
        let uv_max = needs.reach.uv + slope * needs.reach.w;
        // A point has no wings, but the longest baselines are interpolated from few cells.
        let clear_rad = 0.5 * needs.side_rad + OUTER_MARGIN / (0.25 * uv_max);
        let period_rad = clear_rad / CLEAR;
        let radius = (uv_max * period_rad).ceil() as usize;
        if radius > RADIUS_MAX {
            return Err(FacetError::TooLarge {
                side_rad: needs.side_rad,
                radius,
            });
        }
        let n_fine = transform_length(radius);
        let n = n_fine / FINE[0] * FINE[1];
        let oversampling = FINE[0] as f64 / FINE[1] as f64;
        let spread = Spread::new(CLEAR / oversampling);
        let from_fine = Resampler::new(n_fine, n, |x| {
            // Where the window is gone, the kernel's transform need not be looked at.
            let window = window(x);
            if window < 1e-9 {
                0.0
            } else {
                window / spread.transform(x / oversampling)
            }
        });
        let mut plan = FacetPlan {
            needs,
            looks: Looks::new(needs.gains, needs.side_rad, needs.reach.blur)?,
            tilts: Tilts::new(needs.tilts),
            levels: 1,
            uv_max,
            period_rad,
            radius,
            edges: [disc(radius + GUARD), disc(radius)],
            spread,
            from_fine,
            from_next: Resampler::new(2 * n, n, window),
        };
        while plan.margin_rad(plan.levels - 1) < needs.longest_axis_rad * tail(needs.profile) {
            plan.levels += 1;
        }
        Ok(plan)
    }

    /// Bytes of a finished facet.
    pub fn facet_bytes(&self) -> usize {
        self.sets() * self.levels * self.rows() * self.columns() * 4 * size_of::<f32>()
    }

    /// Bytes of a facet while it is filled, finished facet not included.
    pub fn build_bytes(&self) -> usize {
        self.sets() * self.grid_cells() * size_of::<f32>()
    }

    /// Grids of data or weights that a facet has for itself.
    fn sets(&self) -> usize {
        match self.needs.gains {
            Gains::None => 1,
            _ => 2 * self.n_look(),
        }
    }

    /// How many times the samples are looked at, as other factors of the instrument see them.
    pub(super) fn n_look(&self) -> usize {
        self.looks.len() * self.tilts.nodes().len()
    }

    /// These, for a facet about `centre`.
    pub(super) fn rays(&self, centre: Lm) -> Vec<Ray> {
        let places = self.looks.places(centre).into_iter();
        let tilts = self.tilts.nodes();
        let rays = places.flat_map(|lm| tilts.iter().map(move |&tilt| Ray { lm, tilt }));
        rays.collect()
    }

    /// What the value of each counts for a source at `offset` from the centre.
    pub(super) fn shares(&self, offset: Lm, tilt: f64) -> impl Iterator<Item = f64> {
        let (places, tilts) = (self.looks.shares(offset), self.tilts.shares(tilt));
        let n_tilt = self.tilts.nodes().len();
        (0..self.n_look()).map(move |i| places[i / n_tilt] * tilts[i % n_tilt])
    }

    /// Numbers in the fine grids of all levels.
    pub(super) fn grid_cells(&self) -> usize {
        let fine = self.fine();
        self.levels * fine.rows * fine.cols * CHANNELS
    }

    /// Side of the regions served [rad, in direction cosines].
    pub fn side_rad(&self) -> f64 {
        self.needs.side_rad
    }

    /// Cells of a level, half plane.
    pub fn level_cells(&self) -> usize {
        self.rows() * self.columns()
    }

    /// Cells of all levels together, half plane.
    pub fn cells(&self) -> usize {
        self.levels * self.rows() * self.columns()
    }

    /// Sky beyond the facet that `level` sees truly [rad].
    fn margin_rad(&self, level: usize) -> f64 {
        CLEAR * self.period_rad * 2f64.powi(level as i32) - 0.5 * self.needs.side_rad
    }

    /// The first level that holds a source of this major axis [rad] whole; the last one if none.
    pub(super) fn innermost(&self, major_rad: f64) -> usize {
        let needed = major_rad * tail(self.needs.profile);
        (0..self.levels - 1)
            .find(|&level| self.margin_rad(level) >= needed)
            .unwrap_or(self.levels - 1)
    }

    /// The deepest level that reaches the sample at (u, v) [wavelength].
    pub(super) fn level_of(&self, u: f64, v: f64) -> usize {
        let ratio = self.uv_max * self.uv_max / (u * u + v * v);
        level_of_ratio(ratio, self.levels as i32) as usize
    }

    /// Outer radius of `level` [wavelength].
    pub(super) fn reach(&self, level: usize) -> f64 {
        self.uv_max / 2f64.powi(level as i32)
    }

    /// Size of a cell of `level` [wavelength].
    pub(super) fn cell(&self, level: usize) -> f64 {
        1.0 / (self.period_rad * 2f64.powi(level as i32))
    }

    /// L of `level` at |u| = `uv`, the low-pass window; 1 at level 0.
    pub(super) fn low_pass(&self, level: usize, uv: f64) -> f64 {
        if level == 0 {
            return 1.0;
        }
        // from -1 at half the reach to 1 at the reach
        let place = 4.0 * uv / self.reach(level) - 3.0;
        if place >= 1.0 {
            0.0
        } else {
            0.5 * puruspe::erfc(3.0 * place.max(-2.0))
        }
    }

    /// Rows of a level, v >= 0.
    pub(super) fn rows(&self) -> usize {
        self.radius + GUARD + 1
    }

    /// Columns of a level, u = 0 in the middle; a multiple of 32.
    pub(super) fn columns(&self) -> usize {
        2 * (self.radius + GUARD + 1).next_multiple_of(16)
    }

    /// For every row of `level`, the cells from the middle to its edge, guard included.
    pub(super) fn edges(&self, level: usize) -> &[f64] {
        &self.edges[level.min(1)]
    }

    /// The grid that samples are spread on.
    pub(super) fn fine(&self) -> Fine {
        let ratio = FINE[0] as f64 / FINE[1] as f64;
        let half = (self.radius as f64 * ratio).ceil() as usize + WIDTH / 2 + 1;
        Fine {
            rows: half + WIDTH / 2 + 1,
            cols: 2 * half,
            first_row: -(WIDTH as i64 / 2 + 1),
            first_col: -(half as i64),
            cells_per_wavelength: self.period_rad * ratio,
        }
    }
}

impl fmt::Display for FacetPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} levels of {} x {} cells, {:.1} MB a facet, {:.1} MB more while it is filled",
            self.levels,
            self.rows(),
            self.columns(),
            1e-6 * self.facet_bytes() as f64,
            1e-6 * self.build_bytes() as f64
        )
    }
}

/// Shape of the half-plane that samples are spread on; the same for all levels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fine {
    pub(super) rows: usize,
    pub(super) cols: usize,
    /// v of the first row [cells].
    pub(super) first_row: i64,
    /// u of the first column [cells].
    pub(super) first_col: i64,
    /// Inverse of a cell of level 0.
    pub(super) cells_per_wavelength: f64,
}

/// Major axes beyond which nothing of a source is left to speak of.
fn tail(profile: Profile) -> f64 {
    match profile {
        Profile::Exponential => 10.0,
        Profile::Gaussian => 5.0,
        Profile::Point => 0.0,
    }
}

/// Largest |n - n0 + (l0 δl + m0 δm)/n0| over a facet: its curvature on the sphere, which is
/// (|δ|² + (l0 δl + m0 δm)²/n0²)/(2 n0).
fn curvature(needs: &FacetNeeds) -> f64 {
    let diagonal2 = 0.5 * needs.side_rad * needs.side_rad;
    let n2 = 1.0 - needs.farthest * needs.farthest;
    diagonal2 / (2.0 * n2 * n2.sqrt())
}

/// Level of (U/|u|)²: half its exponent.
#[inline(always)]
pub(super) fn level_of_ratio(ratio: f64, levels: i32) -> i32 {
    let exponent = (ratio.to_bits() >> 52) as i32 - 1023;
    (exponent >> 1).clamp(0, levels - 1)
}

/// Half the width of each row of a disc.
fn disc(radius: usize) -> Vec<f64> {
    (0..=radius)
        .map(|row| ((radius * radius - row * row) as f64).sqrt())
        .collect()
}

fn check(needs: &FacetNeeds) -> Result<(), FacetError> {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let known = positive(needs.side_rad)
        && positive(needs.reach.uv)
        && needs.reach.w.is_finite()
        && (0.0..1.0).contains(&needs.farthest)
        && (0.0..PI).contains(&needs.longest_axis_rad);
    if !known {
        return Err(FacetError::Parameter);
    }
    let turn = 2.0 * PI * needs.reach.w * curvature(needs);
    let term = 0.5 * turn * turn;
    if term > needs.w_term_max {
        return Err(FacetError::WTerm {
            side_rad: needs.side_rad,
            term,
            w_term_max: needs.w_term_max,
            largest_rad: needs.side_rad * (needs.w_term_max / term).powf(0.25),
        });
    }
    Ok(())
}

/// Length of the transforms of the fine grid: a multiple of 10 without prime factors beyond 5.
fn transform_length(radius: usize) -> usize {
    let least = 2 * (radius + GUARD + 4) * FINE[0] / FINE[1];
    let smooth = |mut n: usize| {
        for p in [2, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    let mut tens = least.div_ceil(10);
    while !smooth(tens) {
        tens += 1;
    }
    10 * tens
}
