//! Values that were worked out lately, and may be wanted again.

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

/// What is not asked for in so many calls is forgotten.
const LONGEST: usize = 32;

/// The values of keys that were asked for in the last calls.
#[derive(Debug)]
pub(super) struct Memo<K, V> {
    new: HashMap<K, V>,
    old: HashMap<K, V>,
    n_call: usize,
}

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self {
            new: HashMap::new(),
            old: HashMap::new(),
            n_call: 0,
        }
    }
}

/// Things that are asked for.
pub(super) struct Asked<T, K> {
    keys: Vec<K>,
    unknown: Vec<K>,
    /// Those of which the value is not known, each once.
    pub(super) wanted: Vec<T>,
}

impl<K: Copy + Eq + Hash, V: Copy> Memo<K, V> {
    /// Asks for the values of `things`; those with the same key have the same one.
    pub(super) fn ask<T>(
        &mut self,
        things: impl Iterator<Item = T>,
        key: impl Fn(&T) -> K,
    ) -> Asked<T, K> {
        self.n_call += 1;
        if self.n_call.is_multiple_of(LONGEST) {
            self.old = std::mem::take(&mut self.new);
        }
        let mut asked = Asked {
            keys: Vec::new(),
            unknown: Vec::new(),
            wanted: Vec::new(),
        };
        let mut seen = HashSet::new();
        for thing in things {
            let key = key(&thing);
            if let Some(value) = self.old.get(&key) {
                self.new.insert(key, *value);
            }
            if !self.new.contains_key(&key) && seen.insert(key) {
                asked.unknown.push(key);
                asked.wanted.push(thing);
            }
            asked.keys.push(key);
        }
        asked
    }

    /// Takes the values of what was wanted, and gives those of all that was asked for.
    ///
    /// # Panics
    /// If they are not as many.
    pub(super) fn complete<T>(&mut self, asked: &Asked<T, K>, values: &[V]) -> Vec<V> {
        assert_eq!(values.len(), asked.unknown.len(), "a value for each");
        let known = asked.unknown.iter().copied();
        self.new.extend(known.zip(values.iter().copied()));
        asked.keys.iter().map(|key| self.new[key]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The squares of `keys`, and which of them were worked out.
    fn squares(memo: &mut Memo<i64, i64>, keys: &[i64]) -> (Vec<i64>, Vec<i64>) {
        let asked = memo.ask(keys.iter().copied(), |key| *key);
        let values: Vec<i64> = asked.wanted.iter().map(|key| key * key).collect();
        (memo.complete(&asked, &values), asked.wanted)
    }

    #[test]
    fn values_are_worked_out_once_and_kept_as_long_as_they_are_used() {
        let mut memo = Memo::default();
        assert_eq!(squares(&mut memo, &[3, 2, 3]), (vec![9, 4, 9], vec![3, 2]));
        for i in 0..10 * LONGEST as i64 {
            let (all, worked_out) = squares(&mut memo, &[3, 100 + i]);
            assert_eq!((all[0], worked_out), (9, vec![100 + i]));
        }
        assert_eq!(squares(&mut memo, &[2]).1, [2], "not used for long");
        assert!(memo.new.len() + memo.old.len() < 3 * LONGEST);
    }
}
