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
    pub(super) first: u32,
    pub(super) end: u32,
    /// cos and sin of 2π v δm.
    pub(super) cos: f32,
    pub(super) sin: f32,
    /// r v.
    pub(super) rv: f32,
    /// s v² plus what the profile adds to Q.
    pub(super) sv2: f32,
    /// The parts of the bends of X and Y that go with v.
    pub(super) across: f32,
    pub(super) weight_across: f32,
}

/// The cells of one source on one level: rows from v = 0 up.
#[derive(Debug, Default)]
pub(super) struct Span {
    pub(super) columns: Vec<Columns>,
    pub(super) rows: Vec<Row>,
}

impl Row {
    const ZERO: Row = Row {
        first: 0,
        end: 0,
        cos: 0.0,
        sin: 0.0,
        rv: 0.0,
        sv2: 0.0,
        across: 0.0,
        weight_across: 0.0,
    };
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
        let per_cell = 1.0 / (term.p * cell).max(f64::MIN_POSITIVE);
        let edges = plan.edges(level);
        let [rv, sv2] = [term.r * cell, term.s * cell * cell];
        // Rows up to where s v² alone exceeds the limit.
        let last = (term.q_max / sv2.max(f64::MIN_POSITIVE)).sqrt();
        let count = edges.len().min(last as u32 as usize + 1);
        self.rows.resize(count, Row::ZERO);
        for (number, (row, &edge)) in self.rows.iter_mut().zip(edges).enumerate() {
            let v = f64::from(number as u32);
            let rest = (term.q_max - sv2 * v * v).max(0.0);
            let middle = -rv * v * per_cell;
            let reach = rest.sqrt() * per_cell;
            let low = (middle - reach).max(-edge).min(edge) + half;
            let high = (middle + reach).max(-edge).min(edge) + half;
            row.first = low as u32 / LANES as u32;
            row.end = high as u32 / LANES as u32 + 1;
            row.rv = (rv * v) as f32;
            row.sv2 = (sv2 * v * v + offset_q) as f32;
            row.across = (term.bend.across * cell * v) as f32;
            row.weight_across = (term.weight_bend.across * cell * v) as f32;
        }
        self.set_row_phases(cell * term.offset.m);
    }

    #[inline(always)]
    fn set_row_phases(&mut self, turns: f64) {
        for (i, rows) in self.rows.chunks_mut(LANES).enumerate() {
            let (mut cos, mut sin) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..LANES {
                let row = f64::from((i * LANES + k) as i32);
                [cos[k], sin[k]] = cos_sin(row * turns);
            }
            for (k, row) in rows.iter_mut().enumerate() {
                (row.cos, row.sin) = (cos[k], sin[k]);
            }
        }
    }
}
