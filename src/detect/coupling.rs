//! How much overlapping sources depend on each other, and who belongs together.
//!
//! With the models of all others removed, the errors of a source are those for fixed neighbours. How
//! much that matters is the part of the joint ln L that neither source has alone,
//!
//! ```text
//! ⟨δV_i, δV_j⟩ = Σ w Re[δV_i δV_j*]      δV: model of a sample less the mean model of the source
//! ```
//!
//! For Gaussian posteriors its rms over independent samples of both, the coupling of the pair, is the
//! root of the sum of the squares of the canonical correlations ρ of their parameters; a conditional
//! error is sqrt(1 - ρ²) of the joint one. Groups of coupled sources are sampled again together (`joint`).

use nalgebra::DMatrix;

use super::DetectError;
use super::certify::choose;
use super::refine::{Found, Refinement};
use crate::dataset::Dataset;
use crate::rime::Source;

/// Sources farther apart than this many widths of the beam are not looked at.
const FAR_BEAMS: f64 = 12.0;
/// Samples of each source that a coupling is measured with.
const N_TABLE: usize = 12;
/// Coupling from which a pair is sampled jointly: the errors would be 5% too small.
const LEAST_COUPLING: f64 = 0.3;
/// Most sources in a group; of more, the most strongly coupled are kept together.
const MOST_MEMBERS: usize = 6;

/// Two sources and their coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coupling {
    pub(super) pair: [usize; 2],
    pub(super) strength: f64,
}

impl Refinement<'_> {
    /// The pairs of sources that are coupled.
    pub(super) fn couplings(
        &self,
        dataset: &mut Dataset,
        sources: &[Found],
    ) -> Result<Vec<Coupling>, DetectError> {
        let is_near = |[i, j]: &[usize; 2]| {
            let lm = |i: usize| sources[i].mode.mean.lm;
            lm(*i).distance(lm(*j)) < FAR_BEAMS * self.beam_rad
        };
        let near: Vec<[usize; 2]> = crate::likelihood::pairs(sources.len())
            .filter(is_near)
            .collect();
        let drawn = |i: usize| -> Vec<Source> {
            let samples = &sources[i].mode.samples;
            // The last one is the best, which is no draw.
            let mut chosen = choose(samples, N_TABLE);
            chosen.pop();
            chosen.into_iter().map(|k| samples[k].source).collect()
        };
        let tables: Vec<[Vec<Source>; 2]> = near.iter().map(|pair| pair.map(drawn)).collect();
        let table = |[first, second]: &[Vec<Source>; 2]| -> Vec<[Source; 2]> {
            let row = |a: &Source| second.iter().map(|b| [*a, *b]).collect::<Vec<_>>();
            first.iter().flat_map(row).collect()
        };
        let wanted: Vec<[Source; 2]> = tables.iter().flat_map(table).collect();
        let mut cross = dataset.cross(&wanted)?.into_iter();
        let measured = near
            .into_iter()
            .zip(&tables)
            .map(|(pair, [first, second])| {
                let products = first.iter().flat_map(|a| {
                    let flux = move |b: &Source| a.flux_jy * b.flux_jy;
                    second.iter().map(flux)
                });
                let products = products.zip(cross.by_ref()).map(|(flux, y)| flux * y);
                let table = DMatrix::from_row_iterator(first.len(), second.len(), products);
                let strength = interaction(table);
                Coupling { pair, strength }
            });
        let couplings = measured.filter(|c| c.strength > LEAST_COUPLING).collect();
        tracing::debug!("coupled sources: {couplings:?}");
        Ok(couplings)
    }
}

/// The rms of what is left of a table without the means of its rows and columns.
fn interaction(mut table: DMatrix<f64>) -> f64 {
    let (rows, columns) = table.shape();
    if rows < 2 || columns < 2 {
        return 0.0;
    }
    let (of_row, of_column, mean) = (table.column_mean(), table.row_mean(), table.mean());
    for ((i, j), value) in (0..columns)
        .flat_map(|j| (0..rows).map(move |i| (i, j)))
        .zip(table.iter_mut())
    {
        *value += mean - of_row[i] - of_column[j];
    }
    table.norm() / ((rows - 1) as f64 * (columns - 1) as f64).sqrt()
}

/// Groups of at least two of `count` sources, each a connected part of the couplings: joined in
/// order of strength, but for those that would make a group of more than [`MOST_MEMBERS`].
pub(super) fn groups(count: usize, couplings: &[Coupling]) -> Vec<Vec<usize>> {
    let mut strongest_first = couplings.to_vec();
    strongest_first.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    let mut groups: Vec<Vec<usize>> = (0..count).map(|i| vec![i]).collect();
    for Coupling { pair, .. } in strongest_first {
        let [a, b] = pair.map(|i| groups.iter().position(|group| group.contains(&i)));
        if let (Some(a), Some(b)) = (a, b)
            && a != b
            && groups[a].len() + groups[b].len() <= MOST_MEMBERS
        {
            let mut other = groups.remove(a.max(b));
            groups[a.min(b)].append(&mut other);
        }
    }
    for group in &mut groups {
        group.sort_unstable();
    }
    groups.retain(|group| group.len() > 1);
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coupling(i: usize, j: usize, strength: f64) -> Coupling {
        Coupling {
            pair: [i, j],
            strength,
        }
    }

    #[test]
    fn coupled_sources_make_groups_and_the_strongest_stay_together() {
        let chain: Vec<Coupling> = (0..=MOST_MEMBERS)
            .map(|i| coupling(i, i + 1, 0.9 - 0.05 * i as f64))
            .collect();
        assert_eq!(groups(9, &chain[..2]), [vec![0, 1, 2]]);
        let cut = groups(MOST_MEMBERS + 3, &chain);
        let strongest: Vec<usize> = (0..MOST_MEMBERS).collect();
        assert_eq!(cut, [strongest, vec![MOST_MEMBERS, MOST_MEMBERS + 1]]);
        let crossed = [coupling(0, 2, 0.5), coupling(1, 3, 0.6)];
        assert_eq!(groups(4, &crossed), [vec![0, 2], vec![1, 3]]);
        assert!(groups(3, &[]).is_empty());
    }

    /// ln L of two Gaussians of correlation ρ is -ρ x y off the diagonal.
    #[test]
    fn the_coupling_of_gaussians_is_their_correlation() {
        let x = [-1.5, -0.5, 0.5, 1.5].map(|x: f64| x * (3.0f64 / 5.0).sqrt());
        let table = DMatrix::from_fn(4, 4, |i, j| 0.4 * x[i] * x[j] + 7.0 * x[i] - 3.0);
        assert!((interaction(table) - 0.4).abs() < 1e-12);
        assert_eq!(interaction(DMatrix::zeros(1, 5)), 0.0);
    }
}
