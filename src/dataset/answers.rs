//! Questions to the data, and a checkpoint that may know the answers.

use super::{Dataset, DatasetError};
use crate::checkpoint::{Checkpoint, QuestionId};
use crate::likelihood::Xy;
use crate::rime::Source;

/// What the data are asked.
pub(super) struct Question(blake3::Hasher);

impl Question {
    fn new(kind: &str, removed: &[Source]) -> Self {
        let mut question = Self(blake3::Hasher::new());
        question.0.update(kind.as_bytes());
        question.sources(removed);
        question
    }

    /// More of what it is made of.
    pub(super) fn numbers<const N: usize>(&mut self, numbers: [f64; N]) {
        for number in numbers {
            self.0.update(&number.to_le_bytes());
        }
    }

    /// The same, a list with its length.
    pub(super) fn sources(&mut self, sources: &[Source]) {
        self.0.update(&(sources.len() as u64).to_le_bytes());
        for s in sources {
            self.numbers([s.lm.l, s.lm.m, s.flux_jy, s.scale_rad]);
            self.numbers([s.e.e1, s.e.e2, s.tilt]);
        }
    }

    fn id(&self) -> QuestionId {
        let mut id = QuestionId::default();
        self.0.finalize_xof().fill(&mut id);
        id
    }
}

impl Dataset {
    /// Gives answers from `checkpoint` as long as it has any, and adds those that are worked out.
    pub fn set_checkpoint(&mut self, checkpoint: Checkpoint) {
        self.checkpoint = Some(checkpoint);
    }

    /// The checkpoint, which is not used any more.
    pub fn take_checkpoint(&mut self) -> Option<Checkpoint> {
        self.checkpoint.take()
    }

    /// The answer to what `ask` says, a question of some `kind`: that of the checkpoint if it has one,
    /// else what `work_out` gives.
    pub(super) fn answer(
        &mut self,
        kind: &str,
        ask: impl FnOnce(&mut Question),
        work_out: impl FnOnce(&mut Self) -> Result<Vec<f64>, DatasetError>,
    ) -> Result<Vec<f64>, DatasetError> {
        let Some(checkpoint) = &mut self.checkpoint else {
            return work_out(self);
        };
        let mut question = Question::new(kind, &self.removed);
        ask(&mut question);
        let question = question.id();
        if let Some(answer) = checkpoint.recall(question)? {
            return Ok(answer);
        }
        let answer = work_out(self)?;
        if let Some(checkpoint) = &mut self.checkpoint {
            checkpoint.record(question, &answer)?;
        }
        Ok(answer)
    }

    /// An answer that has X and Y of as many points as `n_point` says, list by list.
    pub(super) fn answer_xy(
        &mut self,
        kind: &str,
        n_point: &[usize],
        ask: impl FnOnce(&mut Question),
        work_out: impl FnOnce(&mut Self) -> Result<Vec<Vec<Xy>>, DatasetError>,
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let numbers = self.answer(kind, ask, |dataset| Ok(to_numbers(&work_out(dataset)?)))?;
        let (pairs, _) = numbers.as_chunks();
        let mut xy = pairs.iter().map(|&[x, y]| Xy { x, y });
        Ok(n_point
            .iter()
            .map(|&n| xy.by_ref().take(n).collect())
            .collect())
    }
}

fn to_numbers(xy: &[Vec<Xy>]) -> Vec<f64> {
    xy.iter().flatten().flat_map(|xy| [xy.x, xy.y]).collect()
}
