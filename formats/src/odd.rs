//! Samples that a reader flags for not being finite.

/// How many there were, and where the first; they are told of once.
#[derive(Debug, Default)]
pub(crate) struct OddSamples {
    count: u64,
    first_row: u64,
    is_told: bool,
}

impl OddSamples {
    /// Counts `n` of them in `row` or soon after it.
    pub(crate) fn add(&mut self, n: u64, row: u64) {
        if n > 0 && self.count == 0 {
            self.first_row = row;
        }
        self.count += n;
    }

    /// The file is read from the start again.
    pub(crate) fn rewind(&mut self) {
        if !self.is_told {
            self.count = 0;
        }
    }

    /// At the end of a pass, the first time: adds what is to be told to `warnings`, where
    /// `first_in` is as "the first in row".
    pub(crate) fn tell(&mut self, first_in: &str, warnings: &mut Vec<String>) {
        if self.count > 0 && !self.is_told {
            warnings.push(format!(
                "{} samples have a visibility or weight that is not finite and were flagged, \
                 {first_in} {}",
                self.count,
                self.first_row + 1
            ));
            self.is_told = true;
        }
    }
}
