//! Which cells of a level a source is summed over, and its phases there.
//!
//! Plain loops without closures: a closure would be compiled for the least of processors.
#![allow(clippy::inline_always, clippy::needless_range_loop)]

use super::cells::LANES;
use super::plan::FacetPlan;
use super::term::FacetTerm;
use super::turns::cos_sin;

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

/// The cells of one source on one level: rows from v = 0 up.
#[derive(Debug, Default)]
pub(super) struct Span {
    pub(super) columns: Vec<Columns>,
    pub(super) rows: Vec<Row>,
}

impl Columns {
    const ZERO: Columns = Columns {
        cos: [0.0; LANES],
        sin: [0.0; LANES],
        pu: [0.0; LANES],
    };
}

impl Span {
    /// Sets the cells of `level` for `term`, `offset_q` being what the profile adds to Q.
    #[inline(always)]
    pub(super) fn set(&mut self, plan: &FacetPlan, level: usize, term: &FacetTerm, offset_q: f64) {
        self.set_columns(plan, level, term);
        self.set_rows(plan, level, term, offset_q);
    }

    /// No cells.
    pub(super) fn clear(&mut self) {
        self.rows.clear();
    }

    #[inline(always)]
    fn set_columns(&mut self, plan: &FacetPlan, level: usize, term: &FacetTerm) {
        let (cell, half) = (plan.cell(level), plan.columns() as i32 / 2);
        let (turns, pu) = (cell * term.offset.l, cell * term.p);
        self.columns.resize(plan.columns() / LANES, Columns::ZERO);
        for (i, columns) in self.columns.iter_mut().enumerate() {
            let first = i as i32 * LANES as i32 - half;
            for k in 0..LANES {
                let c = f64::from(first + k as i32);
                let [cos, sin] = cos_sin(c * turns);
                columns.cos[k] = cos;
                columns.sin[k] = sin;
                columns.pu[k] = (c * pu) as f32;
            }
        }
    }

    /// In a row, Q stays below its limit for |p u + r v| < sqrt(q_max - s v²).
    #[inline(always)]
    fn set_rows(&mut self, plan: &FacetPlan, level: usize, term: &FacetTerm, offset_q: f64) {
        let (cell, half) = (plan.cell(level), plan.columns() as f64 / 2.0);
        let turns = cell * term.offset.m;
        let per_cell = 1.0 / (term.p * cell).max(f64::MIN_POSITIVE);
        self.rows.clear();
        for (row, &edge) in plan.edges(level).iter().enumerate() {
            let v = cell * row as f64;
            let sv2 = term.s * v * v;
            let rest = term.q_max - sv2;
            if rest < 0.0 {
                break;
            }
            let middle = -term.r * v * per_cell;
            let reach = rest.sqrt() * per_cell;
            let low = (middle - reach).clamp(-edge, edge) + half;
            let high = (middle + reach).clamp(-edge, edge) + half;
            let [cos, sin] = cos_sin(row as f64 * turns);
            self.rows.push(Row {
                first: low as u32 as usize / LANES,
                end: high as u32 as usize / LANES + 1,
                cos,
                sin,
                rv: (term.r * v) as f32,
                sv2: (sv2 + offset_q) as f32,
                across: (term.across * v) as f32,
            });
        }
    }
}
