//! Is `P_source` a probability?

use serde::Serialize;

use super::Fraction;
use super::candidates::{Candidate, Candidates};

/// Bins of probability between 0 and 1.
const N_BIN: usize = 10;

/// The modes with a probability between two values: if it is one, `mean_p` of them are true.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReliabilityBin {
    /// Lower end, which belongs to it.
    pub low: f64,
    /// Upper end, which belongs to the last bin alone.
    pub high: f64,
    /// Mean probability; NaN of none.
    pub mean_p: f64,
    /// Modes in it that are true.
    pub is_true: Fraction,
}

/// The reliability diagram of the modes; of the rows where there are no modes.
///
/// Modes that a brighter source explains are left out: their evidence is from before it was subtracted.
/// Empty if nothing has a probability.
pub(super) fn report(candidates: &Candidates) -> Vec<ReliabilityBin> {
    let known = |c: &&Candidate| !c.p_source.is_nan();
    let known: Vec<&Candidate> = candidates.list.iter().filter(known).collect();
    if known.is_empty() {
        return Vec::new();
    }
    let bin_of = |c: &Candidate| ((c.p_source * N_BIN as f64) as usize).min(N_BIN - 1);
    let bin = |i: usize| {
        let own: Vec<&&Candidate> = known.iter().filter(|c| bin_of(c) == i).collect();
        ReliabilityBin {
            low: i as f64 / N_BIN as f64,
            high: (i + 1) as f64 / N_BIN as f64,
            mean_p: own.iter().map(|c| c.p_source).sum::<f64>() / own.len() as f64,
            is_true: Fraction::of(own.iter().map(|c| c.truth.is_some())),
        }
    };
    (0..N_BIN).map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_fall_into_their_bins() {
        let candidate = |p_source: f64, truth| Candidate {
            snr: 5.0,
            flux_ujy: 10.0,
            log_z: 3.0,
            p_source,
            truth,
        };
        let mut candidates = Candidates {
            table: "MODES",
            snr_column: "SNR_peak",
            list: vec![
                candidate(0.44, Some(0)),
                candidate(0.46, None),
                candidate(1.0, Some(1)),
                candidate(0.0, None),
                candidate(f64::NAN, None),
            ],
            n_left_out: 0,
            in_field: vec![true; 2],
            in_population: vec![true; 2],
        };
        let bins = report(&candidates);
        let counts: Vec<usize> = bins.iter().map(|b| b.is_true.of).collect();
        assert_eq!(counts, [1, 0, 0, 0, 2, 0, 0, 0, 0, 1]);
        assert!((bins[4].mean_p - 0.45).abs() < 1e-15 && bins[4].is_true.n == 1);
        assert!(bins[1].mean_p.is_nan() && bins[9].high == 1.0);
        candidates.list.truncate(0);
        assert!(report(&candidates).is_empty());
    }
}
