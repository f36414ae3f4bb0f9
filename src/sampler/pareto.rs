//! How heavy the tail of importance weights is.

/// Largest index with which a mean over weights is still as good as its effective sample size says.
pub(super) const RELIABLE: f64 = 0.7;

/// Index k of the generalised Pareto distribution that the largest of `weights` follow: moments of
/// order below 1/k exist, and above [`RELIABLE`] no number of points helps. None for fewer than 25
/// weights or if the largest are all equal.
///
/// # Source
/// Vehtari, Simpson, Gelman, Yao & Gabry 2024 (JMLR 25, 72), section 2.4: the estimator of Zhang &
/// Stephens 2009 (Technometrics 51, 316) and a weak prior about 1/2.
pub(super) fn tail_index(weights: &[f64]) -> Option<f64> {
    let n_tail = (0.2 * weights.len() as f64).min(3.0 * (weights.len() as f64).sqrt()) as usize;
    if n_tail < 5 {
        return None;
    }
    let mut sorted = weights.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (below, tail) = sorted.split_at(sorted.len() - n_tail);
    let cut = below.last().copied().unwrap_or(0.0);
    let excess: Vec<f64> = tail.iter().map(|w| w - cut).collect();
    let (largest, quartile) = (excess[n_tail - 1], excess[(n_tail + 2) / 4 - 1]);
    if quartile <= 0.0 {
        return None;
    }
    let n = n_tail as f64;
    let index = |theta: f64| excess.iter().map(|x| (-theta * x).ln_1p()).sum::<f64>() / n;
    let n_grid = 30 + n.sqrt() as usize;
    let grid = (1..=n_grid).map(|j| {
        let theta =
            1.0 / largest + (1.0 - (n_grid as f64 / (j as f64 - 0.5)).sqrt()) / (3.0 * quartile);
        let k = index(theta);
        (theta, n * ((-theta / k).ln() - k - 1.0))
    });
    let grid: Vec<(f64, f64)> = grid.filter(|(_, log_l)| log_l.is_finite()).collect();
    let top = grid.iter().fold(f64::NEG_INFINITY, |top, g| top.max(g.1));
    let total: f64 = grid.iter().map(|(_, l)| (l - top).exp()).sum();
    let theta: f64 = grid.iter().map(|(t, l)| t * (l - top).exp()).sum::<f64>() / total;
    let k = (index(theta) * n + 5.0) / (n + 10.0);
    k.is_finite().then_some(k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn pareto_weights_have_their_index() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for k in [0.2, 0.5, 0.9] {
            let weights: Vec<f64> = (0..20_000)
                .map(|_| (1.0 - rng.random::<f64>()).powf(-k))
                .collect();
            let got = tail_index(&weights).unwrap();
            assert!((got - k).abs() < 0.12, "{got} for {k}");
        }
    }

    #[test]
    fn bounded_weights_have_no_tail() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let weights: Vec<f64> = (0..5_000).map(|_| rng.random()).collect();
        assert!(tail_index(&weights).unwrap() < 0.2);
        assert!(tail_index(&[1.0; 1000]).is_none());
        assert!(tail_index(&[]).is_none());
    }
}
