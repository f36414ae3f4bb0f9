//! Which of the sources are likely enough: selection by probabilities.

use super::{Census, Detection, Mode, Status};

/// What a source must be, and how surely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Likely {
    /// The probability must exceed this.
    pub p_cut: f64,
    /// It must be brighter than this [Jy].
    pub above_jy: Option<f64>,
}

impl Likely {
    /// Probability that a mode is a source and bright enough, in a field of this `census`.
    ///
    /// # Formula
    /// Let H1 be a source with the part of the prior of flux density above the limit, H0 one with the part
    /// below. Their evidences and prior odds are those of the whole prior, cut in two:
    /// ```text
    /// Z1 P(H1) / (Z0 P(H0)) = P(S > S_lim | data) / P(S < S_lim | data)
    /// ```
    /// so that one run has what two runs would tell, without the scatter of two evidences. Besides
    /// both hypotheses there is a third, no source.
    ///
    /// # Source
    /// Malyali et al. 2018, equation 12, which has no third hypothesis: a peak of the noise then counts as
    /// a source of H1 where it looks like one.
    pub fn probability(&self, census: &Census, mode: &Mode) -> f64 {
        let is_bright = |flux_jy: f64| self.above_jy.is_none_or(|limit| flux_jy > limit);
        let bright = mode.samples.iter().filter(|s| is_bright(s.source.flux_jy));
        census.p_source(mode) * bright.map(|s| s.weight).sum::<f64>()
    }
}

/// Takes out the sources that are not likely enough; their modes say so, with what is known of them last.
pub(super) fn select(detection: &mut Detection, likely: &Likely) {
    let Detection {
        sources,
        modes,
        census,
        ..
    } = detection;
    sources.retain(|source| {
        let is_kept = likely.probability(census, &source.posterior) > likely.p_cut;
        if !is_kept {
            modes[source.mode] = Mode {
                status: Status::Unlikely,
                explained_by: None,
                ..source.posterior.clone().without_samples()
            };
        }
        is_kept
    });
}

#[cfg(test)]
mod tests {
    use super::super::{Detected, ModeSample};
    use super::*;
    use crate::rime::Source;

    /// Flux densities of 1 to 10 uJy with equal weights.
    fn mode(log_z: f64) -> Mode {
        let sample = |i: i32| ModeSample {
            source: Source {
                flux_jy: f64::from(i) * 1e-6,
                ..Source::default()
            },
            log_l: 20.0,
            weight: 0.1,
        };
        Mode::new(0, (1..=10).map(sample).collect(), log_z, 0.1)
    }

    fn detected(mode: usize, log_z: f64) -> Detected {
        Detected {
            posterior: self::mode(log_z),
            mode,
            snr: 6.0,
            max_dlog_l: 0.0,
            group: mode,
            is_conditional: false,
        }
    }

    const CENSUS: Census = Census {
        n_expected: 1.0,
        confusion: 0.0,
    };

    #[test]
    fn the_probability_is_that_of_a_source_times_that_of_its_brightness() {
        let likely = |above_jy| Likely {
            p_cut: 0.5,
            above_jy,
        };
        let even = 0.5;
        assert!((likely(None).probability(&CENSUS, &mode(0.0)) - even).abs() < 1e-12);
        let p = likely(Some(7.5e-6)).probability(&CENSUS, &mode(0.0));
        assert!((p - 0.3 * even).abs() < 1e-12);
        assert!((likely(Some(2.5e-6)).probability(&CENSUS, &mode(50.0)) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_likely_is_a_mode_that_says_so() {
        let mut detection = Detection {
            modes: vec![mode(9.0), mode(9.0)],
            sources: vec![detected(0, 2.0), detected(1, -2.0)],
            census: CENSUS,
            ..Detection::default()
        };
        let likely = Likely {
            p_cut: 0.5,
            above_jy: None,
        };
        select(&mut detection, &likely);
        assert_eq!(detection.sources, vec![detected(0, 2.0)]);
        let statuses: Vec<Status> = detection.modes.iter().map(|m| m.status).collect();
        assert_eq!(statuses, [Status::Kept, Status::Unlikely]);
        // What it was before all others were removed is not known any more.
        assert_eq!(detection.modes[1].log_z, -2.0);
    }
}
