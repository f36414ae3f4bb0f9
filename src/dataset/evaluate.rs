//! X and Y of many points in one pass over the data.

use rayon::prelude::*;

use super::answers::Question;
use super::{Dataset, DatasetError, negated, with_profile};
use crate::likelihood::{SourceTerm, VisBlock, Xy, accumulate_blocks, subtract};
use crate::rime::Source;
use crate::rime::shape::Profile;

/// Points to evaluate against the data.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// Models, each evaluated as the only source in the data.
    pub points: Vec<Source>,
    /// Which of the removed sources are put back for these points.
    pub restored: Vec<Source>,
}

impl Dataset {
    /// X and Y of every point of every request, in one pass; the order of all sums is fixed by
    /// the file, not by threads or by the company a point is in.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn evaluate(&mut self, requests: &[Request]) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let n_point: Vec<usize> = requests.iter().map(|r| r.points.len()).collect();
        self.n_eval += n_point.iter().sum::<usize>() as u64;
        let ask = |question: &mut Question| {
            for request in requests {
                question.sources(&request.restored);
                question.sources(&request.points);
            }
        };
        self.answer_xy("all samples", &n_point, ask, |data| data.sum(requests))
    }

    /// The sums themselves.
    pub(super) fn sum(&mut self, requests: &[Request]) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let profile = self.profile;
        let terms: Vec<Vec<SourceTerm>> = requests
            .iter()
            .map(|r| {
                r.points
                    .iter()
                    .map(|point| SourceTerm::new(point, profile))
                    .collect()
            })
            .collect();
        let mut sums: Vec<Vec<Xy>> = terms.iter().map(|t| vec![Xy::default(); t.len()]).collect();
        self.for_each_batch(|blocks| {
            for ((request, terms), sums) in requests.iter().zip(&terms).zip(&mut sums) {
                if request.restored.is_empty() {
                    accumulate_blocks(blocks, terms, sums);
                } else {
                    accumulate_restored(blocks, &request.restored, profile, terms, sums);
                }
            }
        })?;
        Ok(sums)
    }
}

/// As [`accumulate_blocks`], with sources put back into each block before it is used.
fn accumulate_restored(
    blocks: &[VisBlock],
    restored: &[Source],
    profile: Profile,
    terms: &[SourceTerm],
    sums: &mut [Xy],
) {
    let added = with_profile(&negated(restored), profile);
    let partial: Vec<Vec<Xy>> = blocks
        .par_iter()
        .map_init(VisBlock::default, |room, block| {
            room.copy_from(block);
            subtract(room, &added);
            let mut partial = vec![Xy::default(); terms.len()];
            accumulate_blocks(std::slice::from_ref(room), terms, &mut partial);
            partial
        })
        .collect();
    for block_sums in partial {
        for (sum, part) in sums.iter_mut().zip(block_sums) {
            sum.x += part.x;
            sum.y += part.y;
        }
    }
}
