//! X and Y of many points in one pass over the data.

use rayon::prelude::*;

use super::answers::Question;
use super::{BLOCK_LEN, Dataset, DatasetError, negated, with_profile};
use crate::likelihood::{SourceTerm, VisBlock, Xy, accumulate_blocks, subtract};
use crate::rime::Source;
use crate::rime::shape::Profile;

/// Blocks that a glimpse looks at, or more.
const GLIMPSE_BLOCKS: usize = 128;

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
        self.answer_requests("all samples", requests, |data| data.sum(requests))
    }

    /// X and Y as [`Dataset::evaluate`] gives them, estimated from every n-th block of the samples where
    /// these are many: to see what changes as other sources are removed. There is more noise in them, but
    /// the same each time.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn glimpse(&mut self, requests: &[Request]) -> Result<Vec<Vec<Xy>>, DatasetError> {
        self.answer_requests("some samples", requests, |data| data.sum_some(requests))
    }

    fn answer_requests(
        &mut self,
        kind: &str,
        requests: &[Request],
        work_out: impl FnOnce(&mut Self) -> Result<Vec<Vec<Xy>>, DatasetError>,
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let n_point: Vec<usize> = requests.iter().map(|r| r.points.len()).collect();
        self.n_eval += n_point.iter().sum::<usize>() as u64;
        let ask = |question: &mut Question| {
            for request in requests {
                question.sources(&request.restored);
                question.sources(&request.points);
            }
        };
        self.answer_xy(kind, &n_point, ask, work_out)
    }

    /// The sums themselves.
    pub(super) fn sum(&mut self, requests: &[Request]) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let profile = self.profile;
        let terms = terms(requests, profile);
        let mut sums = zeros(requests);
        self.for_each_batch(|blocks| {
            for ((request, terms), sums) in requests.iter().zip(&terms).zip(&mut sums) {
                if request.restored.is_empty() {
                    accumulate_blocks(blocks, terms, sums);
                } else {
                    let blocks: Vec<&VisBlock> = blocks.iter().collect();
                    accumulate_restored(&blocks, &request.restored, profile, terms, sums);
                }
            }
        })?;
        Ok(sums)
    }

    /// Sums over every n-th block, times n.
    fn sum_some(&mut self, requests: &[Request]) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let profile = self.profile;
        let terms = terms(requests, profile);
        let mut sums = zeros(requests);
        let n_block = (self.info.n_sample as usize).div_ceil(BLOCK_LEN);
        let step = (n_block / GLIMPSE_BLOCKS).max(1);
        let mut first = 0;
        self.for_each_batch(|blocks| {
            let numbered = (first..).zip(blocks);
            let chosen: Vec<&VisBlock> = numbered
                .filter_map(|(i, block)| (i % step == 0).then_some(block))
                .collect();
            first += blocks.len();
            for ((request, terms), sums) in requests.iter().zip(&terms).zip(&mut sums) {
                accumulate_restored(&chosen, &request.restored, profile, terms, sums);
            }
        })?;
        let scale = first as f64 / first.div_ceil(step).max(1) as f64;
        for sum in sums.iter_mut().flatten() {
            *sum = Xy {
                x: scale * sum.x,
                y: scale * sum.y,
            };
        }
        Ok(sums)
    }
}

fn terms(requests: &[Request], profile: Profile) -> Vec<Vec<SourceTerm>> {
    let of_request = |request: &Request| -> Vec<SourceTerm> {
        let points = request.points.iter();
        points
            .map(|point| SourceTerm::new(point, profile))
            .collect()
    };
    requests.iter().map(of_request).collect()
}

fn zeros(requests: &[Request]) -> Vec<Vec<Xy>> {
    let zeros = |request: &Request| vec![Xy::default(); request.points.len()];
    requests.iter().map(zeros).collect()
}

/// As [`accumulate_blocks`], with sources put back into each block before it is used.
fn accumulate_restored(
    blocks: &[&VisBlock],
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
