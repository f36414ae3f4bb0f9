//! The sum of the product of two sources over the cells of one level.

use super::super::cells::LANES;
use super::super::lanes::Lanes;
use super::super::lanes::portable::Plain;
#[cfg(target_arch = "x86_64")]
use super::super::lanes::{avx2::Avx2, avx512::Avx512};
use super::super::span::{Row, Span};
use super::super::term::FacetTerm;
use super::{EXPONENTIAL, GAUSSIAN, Level, POINT, factor};
use crate::coords::Lm;
use crate::likelihood::Isa;
use crate::rime::shape::Profile;

/// A pair that is being summed.
#[derive(Debug)]
pub(in super::super) struct PairJob {
    /// The first one with the offset and the curvature of the first less those of the second.
    first: FacetTerm,
    second: FacetTerm,
    spans: [Span; 2],
    /// Y_ij so far.
    pub(in super::super) sum: f64,
}

impl PairJob {
    pub(in super::super) fn new([first, second]: [FacetTerm; 2]) -> PairJob {
        PairJob {
            first: FacetTerm {
                offset: Lm {
                    l: first.offset.l - second.offset.l,
                    m: first.offset.m - second.offset.m,
                },
                curvature: first.curvature - second.curvature,
                ..first
            },
            second,
            spans: Default::default(),
            sum: 0.0,
        }
    }
}

/// Adds the part of Y_ij that the cells of `level`, the last one if `is_last`, hold to the sum of
/// `job`.
///
/// # Panics
/// If the processor lacks `isa`.
pub(in super::super) fn accumulate_pair(isa: Isa, level: Level, is_last: bool, job: &mut PairJob) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    match isa {
        Isa::Portable => accumulate_with::<Plain>(level, is_last, job),
        // SAFETY: the instructions are there, it was just asserted.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { accumulate_avx2(level, is_last, job) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { accumulate_avx512(level, is_last, job) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => accumulate_with::<Plain>(level, is_last, job),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn accumulate_avx2(level: Level, is_last: bool, job: &mut PairJob) {
    accumulate_with::<Avx2>(level, is_last, job);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn accumulate_avx512(level: Level, is_last: bool, job: &mut PairJob) {
    accumulate_with::<Avx512>(level, is_last, job);
}

#[inline(always)]
fn accumulate_with<L: Lanes>(level: Level, is_last: bool, job: &mut PairJob) {
    let profile = job.first.profile;
    let offset_q = if profile == Profile::Exponential {
        1.0
    } else {
        0.0
    };
    let [first, second] = &mut job.spans;
    first.set(level.plan, level.number, &job.first, offset_q);
    second.set(level.plan, level.number, &job.second, offset_q);
    job.sum += match profile {
        Profile::Exponential => all_rows::<L, EXPONENTIAL>(level, is_last, job),
        Profile::Gaussian => all_rows::<L, GAUSSIAN>(level, is_last, job),
        Profile::Point => all_rows::<L, POINT>(level, is_last, job),
    };
}

/// Re Σ g F_i F_j (1 + w (D ln F_i F_j + 2πi (ε_i - ε_j)))* exp(-2πi (u δl + v δm)), g the weights:
/// what the sum of X is for one source.
#[inline(always)]
fn all_rows<L: Lanes, const PROFILE: u8>(level: Level, is_last: bool, job: &PairJob) -> f64 {
    let width = level.plan.columns() / LANES;
    let [first, second] = &job.spans;
    let mut sum = L::nothing();
    let rows = first.rows.iter().zip(&second.rows);
    for (number, rows) in rows.enumerate() {
        let [a, b] = row_sums::<L, PROFILE>(level, number * width, is_last, job, rows.into());
        // Re[(A + iB) exp(-2πi v δm)]
        let turned = b.mul(L::splat(rows.0.sin));
        sum = a.mul_add(L::splat(rows.0.cos), turned).add_to(sum);
    }
    L::total(sum)
}

/// A + iB over the cells of a row, the first of which is number `start`, that both sources reach.
#[inline(always)]
fn row_sums<L: Lanes, const PROFILE: u8>(
    level: Level,
    start: usize,
    is_last: bool,
    job: &PairJob,
    [row, other]: [&Row; 2],
) -> [L; 2] {
    let (first, end) = (row.first.max(other.first), row.end.min(other.end));
    let range = first as usize..end.max(first) as usize;
    let cells = start + range.start..start + range.end;
    let cells = level.packs[cells.clone()].iter().zip(&level.common[cells]);
    let [columns, others] = &job.spans;
    let columns = (columns.columns[range.clone()].iter()).zip(&others.columns[range]);
    let turn = L::splat(job.first.curvature as f32);
    let [mut a, mut b] = [L::splat(0.0); 2];
    for ((pack, common), (columns, others)) in cells.zip(columns) {
        let window = if is_last { &common.low } else { &common.band };
        for part in 0..L::PARTS {
            let [f, slope] = shape::<L, PROFILE>(L::load(&columns.pu, part), row, &job.first);
            let [g, other] = shape::<L, PROFILE>(L::load(&others.pu, part), other, &job.second);
            let slope = slope.add(other);
            let (w_re, w_im) = (L::load(&pack.w_re, part), L::load(&pack.w_im, part));
            let re = slope.mul_add(w_re, L::load(&pack.re, part));
            let im = slope.mul_add(w_im, L::load(&pack.im, part));
            let (re, im) = (turn.mul_sub_from(w_im, re), turn.mul_add(w_re, im));
            let (cos, sin) = (L::load(&columns.cos, part), L::load(&columns.sin, part));
            let windowed = f.mul(g).mul(L::load(window, part));
            a = windowed.mul_add(re.mul_add(cos, im.mul(sin)), a);
            b = windowed.mul_add(re.mul_sub_from(sin, im.mul(cos)), b);
        }
    }
    [a, b]
}

/// F and w D ln F of one source where p u is `pu`.
#[inline(always)]
fn shape<L: Lanes, const PROFILE: u8>(pu: L, row: &Row, term: &FacetTerm) -> [L; 2] {
    let k = pu.add(L::splat(row.rv));
    let [factor, slope] = factor::<L, PROFILE>(k, L::splat(row.sv2));
    let along = L::splat(term.bend.along as f32);
    [factor, slope.mul(along.mul_add(k, L::splat(row.across)))]
}
