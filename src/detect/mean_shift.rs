//! Mean shift on mode positions (Malyali et al. 2018, section 3.4): which modes are one source.

use crate::coords::Lm;

/// Cluster of each position, numbered from 0 in order of first appearance. `bandwidth[i]` is the
/// radius of the flat kernel about position i.
///
/// # Panics
/// If the two slices differ in length.
pub(super) fn mean_shift(positions: &[Lm], bandwidth: &[f64]) -> Vec<usize> {
    assert_eq!(positions.len(), bandwidth.len());
    let centres: Vec<Lm> = positions
        .iter()
        .zip(bandwidth)
        .map(|(&start, &h)| converge(start, h, positions))
        .collect();
    let mut seen: Vec<Lm> = Vec::new();
    centres
        .iter()
        .zip(bandwidth)
        .map(|(centre, &h)| {
            seen.iter()
                .position(|other| centre.distance(*other) < h)
                .unwrap_or_else(|| {
                    seen.push(*centre);
                    seen.len() - 1
                })
        })
        .collect()
}

/// Moves to the mean of the positions within `h` until that changes no more.
fn converge(start: Lm, h: f64, positions: &[Lm]) -> Lm {
    let mut centre = start;
    for _ in 0..100 {
        let (mut sum, mut n) = (Lm::default(), 0.0);
        for p in positions.iter().filter(|p| p.distance(centre) <= h) {
            sum = Lm {
                l: sum.l + p.l,
                m: sum.m + p.m,
            };
            n += 1.0;
        }
        if n == 0.0 {
            return start;
        }
        let next = Lm {
            l: sum.l / n,
            m: sum.m / n,
        };
        let moved = next.distance(centre);
        centre = next;
        if moved < 1e-3 * h {
            break;
        }
    }
    centre
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn close_positions_share_a_cluster_and_far_ones_do_not() {
        let at = |l: f64| Lm { l, m: 0.0 };
        let positions = [at(0.0), at(5.0), at(0.1), at(5.2), at(9.0), at(0.2)];
        assert_eq!(mean_shift(&positions, &[0.5; 6]), [0, 1, 0, 1, 2, 0]);
        assert_eq!(mean_shift(&positions, &[0.01; 6]), [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn nothing_gives_nothing() {
        assert!(mean_shift(&[], &[]).is_empty());
    }
}
