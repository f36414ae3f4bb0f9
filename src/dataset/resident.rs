//! Samples that are held in memory.

use rayon::prelude::*;

use super::SAMPLE_BYTES;
use crate::likelihood::{VisBlock, subtract};
use crate::rime::Source;
use crate::rime::shape::Profile;

/// Bytes that a held sample takes: its datum is held twice.
pub(super) const RESIDENT_BYTES: usize = SAMPLE_BYTES + 2 * size_of::<f32>();

/// The blocks, with and without the removed sources.
pub(super) struct Resident {
    /// The samples less the removed sources.
    pub(super) blocks: Vec<VisBlock>,
    /// Real and imaginary part of weight times visibility of each block as read. Every change of
    /// the removed sources starts from these, so that no rounding adds up and the data are those
    /// that a stream would give.
    as_read: Vec<[Vec<f32>; 2]>,
}

impl Resident {
    pub(super) fn new(blocks: Vec<VisBlock>) -> Self {
        let datum = |block: &VisBlock| [block.weighted_re.clone(), block.weighted_im.clone()];
        let as_read = blocks.iter().map(datum).collect();
        Self { blocks, as_read }
    }

    /// Subtracts `removed`, and nothing else, from the samples as read.
    pub(super) fn set_removed(&mut self, removed: &[(Source, Profile)]) {
        let blocks = self.blocks.par_iter_mut().zip(&self.as_read);
        blocks.for_each(|(block, [re, im])| {
            block.weighted_re.copy_from_slice(re);
            block.weighted_im.copy_from_slice(im);
            subtract(block, removed);
        });
    }
}
