//! The visibilities, weights and flags of a row.

use num_complex::Complex;

use super::columns::Weights;
use crate::casa::Table;
use crate::chunk::settle;
use crate::{ReadError, VisChunk};

/// Where they are.
#[derive(Debug)]
pub(super) struct Samples {
    /// The column of visibilities.
    pub(super) data: String,
    pub(super) weights: Weights,
}

impl Samples {
    /// Appends the samples of rows to a chunk of their shape, where `all_bad` tells which rows are bad
    /// as a whole; returns how many of each were not finite though not flagged.
    pub(super) fn append(
        &self,
        main: &mut Table,
        first: u64,
        all_bad: &[bool],
        chunk: &mut VisChunk,
    ) -> Result<Vec<u64>, ReadError> {
        let rows = || first..first + all_bad.len() as u64;
        let shape = [chunk.n_chan, chunk.n_corr];
        let vis = main.rows::<Complex<f32>>(&self.data, rows(), &shape)?;
        let flags = main.rows::<bool>("FLAG", rows(), &shape)?;
        // All channels alike have the weights of one.
        let wanted = if self.weights.by_channel {
            &shape[..]
        } else {
            &shape[1..]
        };
        let weights = main.rows::<f32>(self.weights.column, rows(), wanted)?;
        let per_row = chunk.values_per_row();
        chunk.vis_jy_rfp.reserve(vis.len());
        chunk.weight_rfp.reserve(vis.len());
        chunk.flag_rfp.reserve(vis.len());
        let values = vis.chunks_exact(per_row).zip(flags.chunks_exact(per_row));
        let weights = weights.chunks_exact(wanted.iter().product());
        let rows = values.zip(weights).zip(all_bad);
        Ok(rows
            .map(|(((vis, flags), weights), &bad)| self.append_row(vis, flags, weights, bad, chunk))
            .collect())
    }

    fn append_row(
        &self,
        vis: &[Complex<f32>],
        flags: &[bool],
        weights: &[f32],
        all_flagged: bool,
        chunk: &mut VisChunk,
    ) -> u64 {
        let mut n_odd = 0;
        for ((stored, &bad), &value) in vis.iter().zip(flags).zip(weights.iter().cycle()) {
            let bad = bad || all_flagged;
            let weight = self.weights.weight(value);
            let signed = if bad { -weight.abs() } else { weight };
            let (vis, weight, flag, odd) = settle(stored.re, stored.im, signed);
            chunk.vis_jy_rfp.push(vis);
            chunk.weight_rfp.push(weight);
            chunk.flag_rfp.push(flag);
            n_odd += u64::from(odd && !bad);
        }
        n_odd
    }
}
