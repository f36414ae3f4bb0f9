//! Passes over a file that is too large to hold: one thread reads and decodes, the caller computes.

use std::sync::mpsc::sync_channel;

use super::ingest::{Ingest, NoTally};
use super::{DatasetError, SAMPLE_BYTES};
use crate::likelihood::{VisBlock, subtract};
use crate::rime::Source;
use crate::rime::shape::Profile;

/// Batches alive at a time: one being read, one waiting, one in use.
const BATCHES: usize = 3;
/// Most bytes of all of them: more would make nothing faster.
const MOST_BYTES: f64 = 64e6;

pub(super) struct Stream {
    ingest: Ingest,
    blocks_per_batch: usize,
    /// Sources subtracted as the data come in.
    pub(super) removed: Vec<(Source, Profile)>,
}

impl Stream {
    pub(super) fn new(ingest: Ingest, memory_bytes: f64) -> Self {
        let block_bytes = (ingest.block_len * SAMPLE_BYTES) as f64;
        let bytes = memory_bytes.min(MOST_BYTES);
        let blocks_per_batch = (bytes / (BATCHES as f64 * block_bytes)).max(1.0) as usize;
        Self {
            ingest,
            blocks_per_batch,
            removed: Vec::new(),
        }
    }

    pub(super) fn for_each_batch(
        &mut self,
        mut visit: impl FnMut(&[VisBlock]),
    ) -> Result<(), DatasetError> {
        self.ingest.rewind()?;
        let (ingest, removed, n) = (&mut self.ingest, &self.removed, self.blocks_per_batch);
        std::thread::scope(|scope| {
            let (send, receive) = sync_channel(BATCHES - 2);
            scope.spawn(move || {
                loop {
                    let batch = read_batch(ingest, removed, n);
                    let is_last = batch.as_ref().map_or(true, Vec::is_empty);
                    // A closed channel means that the caller has given up.
                    if send.send(batch).is_err() || is_last {
                        break;
                    }
                }
            });
            for batch in receive {
                let batch = batch?;
                if !batch.is_empty() {
                    visit(&batch);
                }
            }
            Ok(())
        })
    }
}

fn read_batch(
    ingest: &mut Ingest,
    removed: &[(Source, Profile)],
    n_block: usize,
) -> Result<Vec<VisBlock>, DatasetError> {
    let mut batch = Vec::with_capacity(n_block);
    while batch.len() < n_block {
        let Some(mut block) = ingest.next_block(&mut NoTally)? else {
            break;
        };
        subtract(&mut block, removed);
        batch.push(block);
    }
    Ok(batch)
}
