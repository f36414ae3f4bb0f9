//! How many independent draws the draws of several chains amount to, and whether the chains agree.
//!
//! # Source
//! Vehtari, Gelman, Simpson, Carpenter & Bürkner 2021 (Bayesian Analysis 16, 667), sections 3.1 and 3.2,
//! without ranks.

/// Variances of one coordinate: within chains, and of the whole posterior by within and between.
struct Variances {
    within: f64,
    total: f64,
}

impl Variances {
    fn of(chains: &[&[f64]]) -> Self {
        let n = chains[0].len() as f64;
        let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
        let within = mean(
            &chains
                .iter()
                .map(|chain| variance(chain))
                .collect::<Vec<_>>(),
        );
        Self {
            within,
            total: (n - 1.0) / n * within + variance(&means),
        }
    }
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn variance(x: &[f64]) -> f64 {
    let mean = mean(x);
    x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (x.len() - 1) as f64
}

/// Split R-hat: 1 if both halves of all `chains` (of one length, 4 at least) tell the same.
pub(in crate::sampler) fn split_r_hat(chains: &[Vec<f64>]) -> f64 {
    let halves = |chain: &Vec<f64>| {
        let half = chain.len() / 2;
        [0..half, chain.len() - half..chain.len()]
    };
    let split: Vec<&[f64]> = chains
        .iter()
        .flat_map(|chain| halves(chain).map(|half| &chain[half]))
        .collect();
    let Variances { within, total } = Variances::of(&split);
    (total / within).sqrt()
}

/// Effective number of draws of all `chains`, which are of one length.
pub(in crate::sampler) fn chain_ess(chains: &[Vec<f64>]) -> f64 {
    let whole: Vec<&[f64]> = chains.iter().map(Vec::as_slice).collect();
    let (n, n_chain) = (chains[0].len(), chains.len() as f64);
    let Variances { within, total } = Variances::of(&whole);
    let correlation = |lag: usize| {
        let of_chain = |chain: &Vec<f64>| {
            let mean = mean(chain);
            let pairs = chain.iter().zip(&chain[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n as f64
        };
        let covariance = chains.iter().map(of_chain).sum::<f64>() / n_chain;
        1.0 - (within - covariance) / total
    };
    // Sums of neighbouring ones are positive but for noise (Geyer 1992).
    let pairs = (0..n / 2).map(|k| correlation(2 * k) + correlation(2 * k + 1));
    let sum: f64 = pairs.take_while(|pair| *pair > 0.0).sum();
    let all = n as f64 * n_chain;
    // Draws that repel each other count for little more than one each.
    all / (2.0 * sum - 1.0).max(1.0 / all.log10())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Four chains x' = ρ x + noise, about `offset` times their number.
    fn chains(rho: f64, n: usize, offset: f64) -> Vec<Vec<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut chain = |k: usize| {
            let mut x: f64 = StandardNormal.sample(&mut rng);
            let mut next = || {
                let kick: f64 = StandardNormal.sample(&mut rng);
                x = rho * x + (1.0 - rho * rho).sqrt() * kick;
                x + offset * k as f64
            };
            (0..n).map(|_| next()).collect()
        };
        (0..4).map(&mut chain).collect()
    }

    #[test]
    fn autoregressive_chains_have_their_known_size() {
        for rho in [0.0, 0.5, 0.9] {
            let ess = chain_ess(&chains(rho, 20_000, 0.0));
            let exact = 80_000.0 * (1.0 - rho) / (1.0 + rho);
            assert!((ess / exact - 1.0).abs() < 0.15, "{rho}: {ess}, {exact}");
            assert!(split_r_hat(&chains(rho, 20_000, 0.0)) < 1.01);
        }
    }

    #[test]
    fn chains_apart_do_not_agree() {
        let apart = chains(0.0, 1000, 3.0);
        assert!(split_r_hat(&apart) > 2.0 && chain_ess(&apart) < 10.0);
    }
}
