//! Which cells of a level a source is summed over, and its phases there.

use super::cells::LANES;
use super::plan::FacetPlan;
use super::term::FacetTerm;
use crate::likelihood::kernel::numbers::{SQRT2_COS_PI, SQRT2_SIN_PI, horner};

/// Sixteen columns of a level.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Columns {
    /// cos and sin of 2π u δl.
    pub(super) cos: [f32; LANES],
    pub(super) sin: [f32; LANES],
    /// p u.
    pub(super) pu: [f32; LANES],
}

/// A run of cells in a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Index of the row.
    pub(super) row: usize,
    /// First pack of the row that is summed, and one past the last.
    pub(super) first: usize,
    pub(super) end: usize,
    /// cos and sin of 2π v δm.
    pub(super) cos: f32,
    pub(super) sin: f32,
    /// r v.
    pub(super) rv: f32,
    /// s v² plus what the profile adds to Q.
    pub(super) sv2: f32,
    /// The part of D ln F that goes with v.
    pub(super) across: f32,
}

/// Room to work in.
#[derive(Debug, Default)]
pub(super) struct Span {
    pub(super) columns: Vec<Columns>,
    pub(super) rows: Vec<Row>,
    phases: Vec<[f32; 2]>,
}

impl Span {
    /// Sets the cells of `level` for `term`, `offset_q` being what the profile adds to Q.
    #[inline(always)]
    pub(super) fn set(&mut self, plan: &FacetPlan, level: usize, term: &FacetTerm, offset_q: f64) {
        self.set_columns(plan, level, term);
        self.set_rows(plan, level, term, offset_q);
    }

    #[inline(always)]
    fn set_columns(&mut self, plan: &FacetPlan, level: usize, term: &FacetTerm) {
        let (cell, half) = (plan.cell(level), plan.columns() as i32 / 2);
        let (turns, pu) = (cell * term.offset.l, cell * term.p);
        self.columns.clear();
        self.columns.extend((0..plan.columns() / LANES).map(|i| {
            let first = i as i32 * LANES as i32 - half;
            let at: [f64; LANES] = std::array::from_fn(|k| f64::from(first + k as i32));
            let phases = at.map(|c| cos_sin(c * turns));
            Columns {
                cos: phases.map(|p| p[0]),
                sin: phases.map(|p| p[1]),
                pu: at.map(|c| (c * pu) as f32),
            }
        }));
    }

    #[inline(always)]
    fn set_rows(&mut self, plan: &FacetPlan, level: usize, term: &FacetTerm, offset_q: f64) {
        let (cell, edge) = (plan.cell(level), plan.edge(level));
        let half = plan.columns() as f64 / 2.0;
        let turns = cell * term.offset.m;
        self.phases.clear();
        self.phases
            .extend((0..=edge).map(|row| cos_sin(row as f64 * turns)));
        self.rows.clear();
        for (row, &[cos, sin]) in self.phases.iter().enumerate() {
            let v = cell * row as f64;
            let sv2 = term.s * v * v;
            let Some([low, high]) = ends(term, v, sv2, cell) else {
                break;
            };
            let disc = ((edge * edge - row * row) as f64).sqrt();
            let (low, high) = (low.max(-disc), high.min(disc));
            if low > high {
                continue;
            }
            self.rows.push(Row {
                row,
                first: (low + half) as usize / LANES,
                end: (high + half) as usize / LANES + 1,
                cos,
                sin,
                rv: (term.r * v) as f32,
                sv2: (sv2 + offset_q) as f32,
                across: (term.across * v) as f32,
            });
        }
    }
}

/// The cells of the row at `v` between which Q stays below its limit; `None` above the last row
/// where it does.
#[inline(always)]
fn ends(term: &FacetTerm, v: f64, sv2: f64, cell: f64) -> Option<[f64; 2]> {
    let rest = term.q_max - sv2;
    if rest < 0.0 {
        return None;
    }
    if term.p <= 0.0 {
        return Some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let (middle, half) = (-term.r * v / term.p, rest.sqrt() / term.p);
    Some([(middle - half) / cell, (middle + half) / cell])
}

/// Cosine and sine of `turns` turns, to 3e-7.
#[inline(always)]
fn cos_sin(turns: f64) -> [f32; 2] {
    let x = (turns - turns.round_ties_even()) as f32;
    let sine = x * horner(&SQRT2_SIN_PI, x * x);
    [1.0 - sine * sine, sine * horner(&SQRT2_COS_PI, x * x)]
}
