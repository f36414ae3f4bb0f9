//! Stokes I from the correlations of a sample.

use num_complex::Complex;

use crate::Corr;

/// How Stokes I is made of the correlations of a file.
///
/// | correlations | Stokes I | weight |
/// |---|---|---|
/// | I | itself | its own |
/// | both parallel hands p, q good | (p + q)/2 | 4/(1/w_p + 1/w_q): inverse variance of the mean |
/// | one parallel hand, the other missing or flagged | that hand | its own |
///
/// The last is pseudo-I: right for unpolarised emission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StokesI {
    first: usize,
    second: Option<usize>,
}

/// Correlations without Stokes I in them.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no Stokes I in the correlations {corrs:?}; I, or a parallel hand, is needed")]
pub struct NoStokesI {
    /// What there is.
    pub corrs: Vec<Corr>,
}

/// A sample of Stokes I.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StokesSample {
    /// Stokes I [Jy].
    pub vis_jy: Complex<f32>,
    /// Weight in the scale of the file's.
    pub weight: f32,
    /// (p - q)/2 [Jy], which has the noise of Stokes I and no unpolarised sky; where both hands
    /// are good.
    pub half_difference_jy: Option<Complex<f32>>,
}

impl StokesI {
    /// The rule for samples of these correlations.
    ///
    /// # Errors
    /// There is neither I nor a parallel hand.
    pub fn new(corrs: &[Corr]) -> Result<Self, NoStokesI> {
        let place = |corr: Corr| corrs.iter().position(|c| *c == corr);
        let hands = |p: Corr, q: Corr| match (place(p), place(q)) {
            (Some(first), second) => Some(Self { first, second }),
            (None, Some(first)) => Some(Self { first, second: None }),
            (None, None) => None,
        };
        place(Corr::I)
            .map(|first| Self { first, second: None })
            .or_else(|| hands(Corr::Rr, Corr::Ll))
            .or_else(|| hands(Corr::Xx, Corr::Yy))
            .ok_or_else(|| NoStokesI { corrs: corrs.to_vec() })
    }

    /// Stokes I of one sample, given its values, axis (correlation); none where flagged.
    ///
    /// `hand_weight` stands for the file's weight of each correlation where given.
    pub fn apply(
        self,
        vis_jy_p: &[Complex<f32>],
        weight_p: &[f32],
        flag_p: &[bool],
        hand_weight: Option<f32>,
    ) -> Option<StokesSample> {
        let hand = |p: usize| {
            let weight = hand_weight.unwrap_or(weight_p[p]);
            (!flag_p[p] && weight > 0.0).then_some((vis_jy_p[p], weight))
        };
        let alone = |(vis_jy, weight)| StokesSample { vis_jy, weight, half_difference_jy: None };
        match (hand(self.first), self.second.and_then(hand)) {
            (Some((p, w_p)), Some((q, w_q))) => Some(StokesSample {
                vis_jy: (p + q) * 0.5,
                weight: 4.0 / (1.0 / w_p + 1.0 / w_q),
                half_difference_jy: Some((p - q) * 0.5),
            }),
            (Some(one), None) | (None, Some(one)) => Some(alone(one)),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIS: [Complex<f32>; 2] = [Complex::new(3.0, 1.0), Complex::new(1.0, 5.0)];

    #[test]
    fn both_hands_give_the_mean_with_the_weight_of_a_mean() {
        let rule = StokesI::new(&[Corr::Xx, Corr::Yy]).unwrap();
        let sample = rule.apply(&VIS, &[2.0, 2.0], &[false, false], None).unwrap();
        assert_eq!(sample.vis_jy, Complex::new(2.0, 3.0));
        // Two samples of variance 1/2 have a mean of variance 1/4.
        assert_eq!(sample.weight, 4.0);
        assert_eq!(sample.half_difference_jy, Some(Complex::new(1.0, -2.0)));
    }

    #[test]
    fn a_flagged_hand_leaves_the_other() {
        let rule = StokesI::new(&[Corr::Rr, Corr::Ll]).unwrap();
        let sample = rule.apply(&VIS, &[2.0, 3.0], &[true, false], None).unwrap();
        assert_eq!((sample.vis_jy, sample.weight), (VIS[1], 3.0));
        assert_eq!(sample.half_difference_jy, None);
        assert_eq!(rule.apply(&VIS, &[2.0, 3.0], &[true, true], None), None);
        assert_eq!(rule.apply(&VIS, &[0.0, 3.0], &[false, true], None), None);
    }

    #[test]
    fn given_weights_stand_for_the_files() {
        let rule = StokesI::new(&[Corr::Yx, Corr::I]).unwrap();
        let sample = rule.apply(&VIS, &[9.0, 9.0], &[false, false], Some(7.0)).unwrap();
        assert_eq!((sample.vis_jy, sample.weight), (VIS[1], 7.0));
    }

    #[test]
    fn cross_hands_alone_are_an_error_that_names_them() {
        let error = StokesI::new(&[Corr::Xy, Corr::Yx]).unwrap_err();
        assert!(error.to_string().contains("Xy"), "{error}");
    }
}
