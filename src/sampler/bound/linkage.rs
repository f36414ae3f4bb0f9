//! Single linkage with the cut where the lengths jump.

use super::friends::Sets;

/// Two lengths of the tree this far apart are of different kinds: within and between clumps.
const JUMP: f64 = 1.5;

/// Parts of points, axes (point, dimension), after removing the long edges of their minimum spanning
/// tree: one partition for each jump in the sorted lengths that leaves at least a quarter of the
/// edges, coarsest first.
pub(super) fn partitions(z: &[f64], n_dim: usize) -> Vec<Vec<Vec<usize>>> {
    let mut edges = spanning_tree(z, n_dim);
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let jumps = (edges.len().div_ceil(4)..edges.len())
        .filter(|&i| i > 0 && edges[i].0 > JUMP * JUMP * edges[i - 1].0);
    jumps
        .rev()
        .map(|i| components(&edges[..i], z.len() / n_dim))
        .collect()
}

/// Connected parts of `n` points under some edges.
fn components(edges: &[(f64, usize, usize)], n: usize) -> Vec<Vec<usize>> {
    let mut sets = Sets::new(n);
    for &(_, a, b) in edges {
        sets.join(a, b);
    }
    sets.parts()
}

/// Edges of the minimum spanning tree as (length², end, end): Prim's algorithm, O(n²).
fn spanning_tree(z: &[f64], n_dim: usize) -> Vec<(f64, usize, usize)> {
    let n = z.len() / n_dim;
    let row = |i: usize| &z[i * n_dim..(i + 1) * n_dim];
    let mut nearest = vec![(f64::INFINITY, 0); n];
    let mut outside: Vec<usize> = (1..n).collect();
    let mut edges = Vec::with_capacity(n.saturating_sub(1));
    let mut last = 0;
    while !outside.is_empty() {
        let mut best = 0;
        for (k, &i) in outside.iter().enumerate() {
            let gap2 = row(i)
                .iter()
                .zip(row(last))
                .map(|(a, b)| (a - b) * (a - b))
                .sum::<f64>();
            if gap2 < nearest[i].0 {
                nearest[i] = (gap2, last);
            }
            if nearest[i].0 < nearest[outside[best]].0 {
                best = k;
            }
        }
        last = outside.swap_remove(best);
        edges.push((nearest[last].0, nearest[last].1, last));
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clumps_of_two_and_three_are_parted_at_the_jump() {
        let z = [0.10, 0.11, 0.50, 0.512, 0.521, 0.90, 0.91];
        let parts = partitions(&z, 1);
        assert!(parts.contains(&vec![vec![0, 1], vec![2, 3, 4], vec![5, 6]]));
    }

    #[test]
    fn an_even_row_has_no_jump() {
        let z: Vec<f64> = (0..50).map(|i| (i as f64 / 50.0).powf(1.2)).collect();
        assert!(partitions(&z[2..], 1).is_empty());
    }
}
