//! X and Y of a source from the cells of one level, with the widest instructions at hand.
#![allow(clippy::inline_always)] // one loop is compiled anew for each instruction set
#![allow(unsafe_code)] // entering code compiled for an instruction set

mod cross;

pub(super) use cross::{PairJob, accumulate_pair};

use super::cells::{Common, LANES, Pack};
use super::lanes::Lanes;
use super::lanes::portable::Plain;
#[cfg(target_arch = "x86_64")]
use super::lanes::{avx2::Avx2, avx512::Avx512};
use super::plan::FacetPlan;
use super::span::{Columns, Row, Span};
use super::term::FacetTerm;
use crate::likelihood::{Isa, Xy};
use crate::rime::shape::Profile;

const EXPONENTIAL: u8 = 0;
const GAUSSIAN: u8 = 1;
const POINT: u8 = 2;

/// Sources that are summed side by side, so that a row of cells is fetched once for all of them.
pub(super) const GROUP: usize = 8;

/// One level of a facet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level<'a> {
    pub(super) plan: &'a FacetPlan,
    pub(super) number: usize,
    pub(super) packs: &'a [Pack],
    pub(super) common: &'a [Common],
}

/// A source that is being summed.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) term: FacetTerm,
    /// The last level that it is summed over.
    pub(super) last: usize,
    /// X and Y so far.
    pub(super) sum: Xy,
    span: Span,
}

impl Job {
    pub(super) fn new(term: FacetTerm, last: usize) -> Job {
        Job {
            term,
            last,
            sum: Xy::default(),
            span: Span::default(),
        }
    }
}

/// Adds X and Y of up to [`GROUP`] jobs over the cells of `level` to their sums.
///
/// # Panics
/// If the processor lacks `isa`.
pub(super) fn accumulate(isa: Isa, level: Level, jobs: &mut [Job]) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    match isa {
        Isa::Portable => accumulate_with::<Plain>(level, jobs),
        // SAFETY: the instructions are there, it was just asserted.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { accumulate_avx2(level, jobs) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { accumulate_avx512(level, jobs) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => accumulate_with::<Plain>(level, jobs),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn accumulate_avx2(level: Level, jobs: &mut [Job]) {
    accumulate_with::<Avx2>(level, jobs);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn accumulate_avx512(level: Level, jobs: &mut [Job]) {
    accumulate_with::<Avx512>(level, jobs);
}

#[inline(always)]
fn accumulate_with<L: Lanes>(level: Level, jobs: &mut [Job]) {
    let Some(profile) = jobs.first().map(|job| job.term.profile) else {
        return;
    };
    let offset_q = if profile == Profile::Exponential {
        1.0
    } else {
        0.0
    };
    for job in jobs.iter_mut() {
        if level.number <= job.last {
            job.span.set(level.plan, level.number, &job.term, offset_q);
        } else {
            job.span.clear();
        }
    }
    match profile {
        Profile::Exponential => all_rows::<L, EXPONENTIAL>(level, jobs),
        Profile::Gaussian => all_rows::<L, GAUSSIAN>(level, jobs),
        Profile::Point => all_rows::<L, POINT>(level, jobs),
    }
}

#[inline(always)]
fn all_rows<L: Lanes, const PROFILE: u8>(level: Level, jobs: &mut [Job]) {
    let width = level.plan.columns() / LANES;
    let mut sums = [[L::nothing(); 2]; GROUP];
    let cells = level.packs.chunks_exact(width);
    for (number, (packs, common)) in cells.zip(level.common.chunks_exact(width)).enumerate() {
        for (job, [x, y]) in jobs.iter().zip(&mut sums) {
            let Some(row) = job.span.rows.get(number) else {
                continue;
            };
            let cells = (packs, common, &job.span.columns[..]);
            let [a, b, part] = if level.number < job.last {
                row_sums::<L, PROFILE, true>(cells, row, &job.term)
            } else {
                row_sums::<L, PROFILE, false>(cells, row, &job.term)
            };
            // Re[(A + iB) exp(-2πi v δm)]
            let turned = b.mul(L::splat(row.sin));
            *x = a.mul_add(L::splat(row.cos), turned).add_to(*x);
            *y = part.add_to(*y);
        }
    }
    for (job, [x, y]) in jobs.iter_mut().zip(sums) {
        job.sum.x += L::total(x);
        job.sum.y += L::total(y);
    }
}

/// A + iB = Σ g F (1 + w ...) exp(-2πi u δl) over a row, and the part of Y. In a band, a level
/// further in takes the middle.
#[inline(always)]
fn row_sums<L: Lanes, const PROFILE: u8, const IS_BAND: bool>(
    (packs, common, columns): (&[Pack], &[Common], &[Columns]),
    row: &Row,
    term: &FacetTerm,
) -> [L; 3] {
    let zero = L::splat(0.0);
    let (rv, sv2, turn) = (
        L::splat(row.rv),
        L::splat(row.sv2),
        L::splat(term.curvature as f32),
    );
    let (along, across) = (L::splat(term.bend.along as f32), L::splat(row.across));
    let weight_along = L::splat(term.weight_bend.along as f32);
    let weight_across = L::splat(row.weight_across);
    let [mut a, mut b, mut y] = [zero; 3];
    let range = row.first as usize..row.end as usize;
    let cells = packs[range.clone()].iter().zip(&common[range.clone()]);
    for ((pack, common), columns) in cells.zip(&columns[range]) {
        let window = if IS_BAND { &common.band } else { &common.low };
        for part in 0..L::PARTS {
            let k = L::load(&columns.pu, part).add(rv);
            let [factor, slope] = factor::<L, PROFILE>(k, sv2);
            let weight_slope = slope.mul(weight_along.mul_add(k, weight_across));
            let slope = slope.mul(along.mul_add(k, across));
            let (w_re, w_im) = (L::load(&pack.w_re, part), L::load(&pack.w_im, part));
            let re = slope.mul_add(w_re, L::load(&pack.re, part));
            let im = slope.mul_add(w_im, L::load(&pack.im, part));
            let (re, im) = (turn.mul_sub_from(w_im, re), turn.mul_add(w_re, im));
            let (cos, sin) = (L::load(&columns.cos, part), L::load(&columns.sin, part));
            let windowed = factor.mul(L::load(window, part));
            a = windowed.mul_add(re.mul_add(cos, im.mul(sin)), a);
            b = windowed.mul_add(re.mul_sub_from(sin, im.mul(cos)), b);
            let (weight, weight_w) = (
                L::load(&common.weight, part),
                L::load(&common.weight_w, part),
            );
            let weight = weight_slope.mul_add(weight_w, weight);
            y = weight.mul(factor).mul_add(windowed, y);
        }
    }
    [a, b, y]
}

/// F, and what times (`along` k + `across` v) is w D ln F, at k = p u + r v.
#[inline(always)]
fn factor<L: Lanes, const PROFILE: u8>(k: L, sv2: L) -> [L; 2] {
    let one = L::splat(1.0);
    match PROFILE {
        EXPONENTIAL => {
            let root = k.mul_add(k, sv2).rsqrt();
            let inverse = root.mul(root);
            [inverse.mul(root), inverse]
        }
        GAUSSIAN => [k.mul_add(k, sv2).exp2_neg(), one],
        _ => [one, L::splat(0.0)],
    }
}
