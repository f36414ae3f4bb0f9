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
    /// Appends the samples of a row to a chunk of the shape of that row; returns how many were not
    /// finite though not flagged.
    pub(super) fn append(
        &self,
        main: &mut Table,
        row: u64,
        all_flagged: bool,
        chunk: &mut VisChunk,
    ) -> Result<u64, ReadError> {
        let shape = [chunk.n_chan, chunk.n_corr];
        let vis = main.shaped::<Complex<f32>>(&self.data, row, &shape)?;
        let flags = main.shaped::<bool>("FLAG", row, &shape)?;
        let column = self.weights.column;
        // All channels alike have the weights of one.
        let wanted = if self.weights.by_channel {
            &shape[..]
        } else {
            &shape[1..]
        };
        let weights = main.shaped::<f32>(column, row, wanted)?;
        let mut n_odd = 0;
        for ((stored, &bad), &value) in vis.iter().zip(&flags).zip(weights.iter().cycle()) {
            let bad = bad || all_flagged;
            let weight = self.weights.weight(value);
            let signed = if bad { -weight.abs() } else { weight };
            let (vis, weight, flag, odd) = settle(stored.re, stored.im, signed);
            chunk.vis_jy_rfp.push(vis);
            chunk.weight_rfp.push(weight);
            chunk.flag_rfp.push(flag);
            n_odd += u64::from(odd && !bad);
        }
        Ok(n_odd)
    }
}
