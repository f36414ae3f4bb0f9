//! X and Y of a source from the cells of one level, with the widest instructions at hand.
#![allow(clippy::inline_always)] // one loop is compiled anew for each instruction set
#![allow(unsafe_code)] // entering code compiled for an instruction set

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

/// One level of a facet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level<'a> {
    pub(super) plan: &'a FacetPlan,
    pub(super) number: usize,
    pub(super) packs: &'a [Pack],
    pub(super) common: &'a [Common],
    /// True if a level further in takes the middle.
    pub(super) is_band: bool,
}

/// X and Y of `term` over the cells of `level`.
///
/// # Panics
/// If the processor lacks `isa`.
pub(super) fn sums(isa: Isa, level: Level, term: &FacetTerm, span: &mut Span) -> Xy {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    match isa {
        Isa::Portable => sums_of::<Plain>(level, term, span),
        // SAFETY: the instructions are there, it was just asserted.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { sums_avx2(level, term, span) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { sums_avx512(level, term, span) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => sums_of::<Plain>(level, term, span),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn sums_avx2(level: Level, term: &FacetTerm, span: &mut Span) -> Xy {
    sums_of::<Avx2>(level, term, span)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn sums_avx512(level: Level, term: &FacetTerm, span: &mut Span) -> Xy {
    sums_of::<Avx512>(level, term, span)
}

#[inline(always)]
fn sums_of<L: Lanes>(level: Level, term: &FacetTerm, span: &mut Span) -> Xy {
    let offset_q = if term.profile == Profile::Exponential {
        1.0
    } else {
        0.0
    };
    span.set(level.plan, level.number, term, offset_q);
    match term.profile {
        Profile::Exponential => rows::<L, EXPONENTIAL>(level, term, span),
        Profile::Gaussian => rows::<L, GAUSSIAN>(level, term, span),
        Profile::Point => rows::<L, POINT>(level, term, span),
    }
}

#[inline(always)]
fn rows<L: Lanes, const PROFILE: u8>(level: Level, term: &FacetTerm, span: &Span) -> Xy {
    let packs_per_row = span.columns.len();
    let (mut x, mut y) = (L::nothing(), L::nothing());
    for row in &span.rows {
        let (first, end) = (
            row.row * packs_per_row + row.first,
            row.row * packs_per_row + row.end,
        );
        let cells = level.packs[first..end]
            .iter()
            .zip(&level.common[first..end])
            .zip(&span.columns[row.first..row.end]);
        let sums = if level.is_band {
            row_sums::<L, PROFILE>(cells, |common| &common.band, row, term)
        } else {
            row_sums::<L, PROFILE>(cells, |common| &common.low, row, term)
        };
        // Re[(A + iB) exp(-2πi v δm)]
        let [a, b, part] = sums;
        x = a
            .mul(L::splat(row.cos))
            .add(b.mul(L::splat(row.sin)))
            .add_to(x);
        y = part.add_to(y);
    }
    Xy {
        x: L::total(x),
        y: L::total(y),
    }
}

/// A + iB = Σ g F (1 + w ...) exp(-2πi u δl) over a row, and the part of Y.
#[inline(always)]
fn row_sums<'a, L: Lanes, const PROFILE: u8>(
    cells: impl Iterator<Item = ((&'a Pack, &'a Common), &'a Columns)>,
    window: impl Fn(&Common) -> &[f32; LANES],
    row: &Row,
    term: &FacetTerm,
) -> [L; 3] {
    let zero = L::splat(0.0);
    let (rv, sv2, across) = (L::splat(row.rv), L::splat(row.sv2), L::splat(row.across));
    let (along, turn) = (L::splat(term.along as f32), L::splat(term.curvature as f32));
    let [mut a, mut b, mut y] = [zero; 3];
    for ((pack, common), columns) in cells {
        for part in 0..L::PARTS {
            let load = |from: &[f32; LANES]| L::load(from, part);
            let k = load(&columns.pu).add(rv);
            let [factor, slope] = factor::<L, PROFILE>(k, sv2);
            let slope = slope.mul(along.mul_add(k, across));
            let (w_re, w_im) = (load(&pack.w_re), load(&pack.w_im));
            let re = turn.mul_sub_from(w_im, slope.mul_add(w_re, load(&pack.re)));
            let im = turn.mul_add(w_re, slope.mul_add(w_im, load(&pack.im)));
            let (cos, sin) = (load(&columns.cos), load(&columns.sin));
            let windowed = factor.mul(load(window(common)));
            a = windowed.mul_add(re.mul_add(cos, im.mul(sin)), a);
            b = windowed.mul_add(re.mul_sub_from(sin, im.mul(cos)), b);
            y = load(&common.weight).mul(factor).mul_add(windowed, y);
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
