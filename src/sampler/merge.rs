//! Several runs of one problem as one run with more live points.

use super::{ModeNode, NestedRun};

/// Why runs cannot be merged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// Nothing to merge.
    #[error("there are no runs to merge")]
    Empty,
    /// The runs are of different problems.
    #[error("run {run} has {n_dim} dimensions, the first has {first}")]
    Dimensions {
        /// Which run, from 0.
        run: usize,
        /// Its dimensions.
        n_dim: usize,
        /// Those of the first.
        first: usize,
    },
    /// A run was divided into modes.
    #[error(
        "run {run} is divided into modes, each with its own density of points and contour, so that its \
         points do not fit among those of another run; run it with mode_dims empty"
    )]
    Modes {
        /// Which run, from 0.
        run: usize,
    },
}

impl NestedRun {
    /// One run of all points of several, which differ in the seed only (live points may differ too).
    ///
    /// Live counts follow from the birth contours, so it is enough to sort the points. A run with
    /// a division into modes cannot be merged.
    ///
    /// # Errors
    /// No runs, different dimensions, or modes.
    ///
    /// # Source
    /// Skilling 2006, section 7; Higson et al. 2018 (Bayesian Analysis 13, 873).
    pub fn merge(runs: Vec<Self>) -> Result<Self, MergeError> {
        let first = runs.first().ok_or(MergeError::Empty)?.n_dim;
        for (run, NestedRun { n_dim, tree, .. }) in runs.iter().enumerate() {
            let n_dim = *n_dim;
            if n_dim != first {
                return Err(MergeError::Dimensions { run, n_dim, first });
            }
            if tree.len() != 1 {
                return Err(MergeError::Modes { run });
            }
        }
        let n_live = runs.iter().map(|run| run.tree[0].n_split).sum();
        let n_eval = runs.iter().map(|run| run.n_eval).sum();
        let mut dead: Vec<_> = runs.into_iter().flat_map(|run| run.dead).collect();
        dead.sort_by(|a, b| a.log_l.total_cmp(&b.log_l));
        Ok(Self {
            n_dim: first,
            n_eval,
            dead,
            tree: vec![ModeNode::root(n_live)],
        })
    }
}
