//! Total intensity from the correlations of a row and channel.
//!
//! # Formula
//! With parallel hands p and q (RR and LL, or XX and YY) of weights w_p and w_q:
//!
//! ```text
//! I = (p + q) / 2      w_I = 4 / (1/w_p + 1/w_q)      both unflagged
//! I = p                w_I = w_p                      q flagged or not in the file
//! ```
//!
//! The weight is the inverse variance of the mean, sigma being that of the real and of the imaginary
//! part. (WSClean's manual prints half of it, which makes no difference to an image but a factor of
//! two in a likelihood.) A hand alone holds I ± V (circular) or I ± Q (linear): it stands for I as
//! Miriad's `ii` and CASA's `pseudoI` have it, which assumes unpolarised sources.
//!
//! A file of Stokes I (code 1) is taken as it is. Files in the convention I = XX + YY cannot be told
//! from others: their hands give half of I.

use num_complex::Complex;

use crate::Corr;

/// Which correlations make Stokes I, as indices along the correlation axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StokesIRule {
    /// Stokes I itself.
    Direct(usize),
    /// Two parallel hands.
    Hands(usize, usize),
    /// One parallel hand, taken as if nothing were polarised.
    OneHand(usize),
}

/// No combination of the correlations holds Stokes I.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("correlations {corrs:?} hold no total intensity: I, RR, LL, XX or YY is needed")]
pub struct NoStokesI {
    /// What there is.
    pub corrs: Vec<Corr>,
}

/// How Stokes I is made of these correlations.
///
/// # Errors
/// There is neither Stokes I nor a parallel hand.
pub fn stokes_i(corrs: &[Corr]) -> Result<StokesIRule, NoStokesI> {
    let at = |corr| corrs.iter().position(|&c| c == corr);
    if let Some(i) = at(Corr::I) {
        return Ok(StokesIRule::Direct(i));
    }
    let pairs = [(at(Corr::Rr), at(Corr::Ll)), (at(Corr::Xx), at(Corr::Yy))];
    for hands in pairs {
        match hands {
            (Some(p), Some(q)) => return Ok(StokesIRule::Hands(p, q)),
            (Some(only), None) | (None, Some(only)) => return Ok(StokesIRule::OneHand(only)),
            (None, None) => {}
        }
    }
    Err(NoStokesI {
        corrs: corrs.to_vec(),
    })
}

impl StokesIRule {
    /// Stokes I [Jy] and its weight from the correlations of one row and channel; `None` where all
    /// that could make it is flagged.
    ///
    /// The slices run over the correlations: `vis_jy_rfp[i * n_corr..][..n_corr]` and so on.
    pub fn apply(
        self,
        vis_jy_p: &[Complex<f32>],
        weight_p: &[f32],
        flag_p: &[bool],
    ) -> Option<(Complex<f32>, f32)> {
        let usable = |i: usize| !flag_p[i] && weight_p[i] > 0.0;
        let one = |i: usize| usable(i).then(|| (vis_jy_p[i], weight_p[i]));
        match self {
            Self::Direct(i) | Self::OneHand(i) => one(i),
            Self::Hands(p, q) if usable(p) && usable(q) => {
                let mean_jy = (vis_jy_p[p] + vis_jy_p[q]) * 0.5;
                Some((mean_jy, mean_weight(weight_p[p], weight_p[q])))
            }
            Self::Hands(p, q) => one(p).or_else(|| one(q)),
        }
    }

    /// Half the difference of the hands, (p - q) / 2, with the weight that [`apply`](Self::apply)
    /// gives to I: noise alone where nothing is polarised. `None` unless both hands are good.
    pub fn half_difference(
        self,
        vis_jy_p: &[Complex<f32>],
        weight_p: &[f32],
        flag_p: &[bool],
    ) -> Option<(Complex<f32>, f32)> {
        let Self::Hands(p, q) = self else {
            return None;
        };
        let usable = |i: usize| !flag_p[i] && weight_p[i] > 0.0;
        (usable(p) && usable(q)).then(|| {
            let difference_jy = (vis_jy_p[p] - vis_jy_p[q]) * 0.5;
            (difference_jy, mean_weight(weight_p[p], weight_p[q]))
        })
    }
}

/// The inverse variance of (p + q) / 2, as 4 w_p w_q / (w_p + w_q) arranged not to overflow.
fn mean_weight(weight_p: f32, weight_q: f32) -> f32 {
    let (p, q) = (f64::from(weight_p), f64::from(weight_q));
    (4.0 * p * q / (p + q)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use Corr::{I, Ll, Lr, Q, Rl, Rr, U, V, Xx, Xy, Yx, Yy};

    const VIS_JY: [Complex<f32>; 2] = [Complex::new(3.0, 1.0), Complex::new(1.0, -1.0)];

    #[test]
    fn the_rule_follows_the_correlations() {
        assert_eq!(stokes_i(&[I, Q, U, V]), Ok(StokesIRule::Direct(0)));
        assert_eq!(stokes_i(&[Rr, Ll, Rl, Lr]), Ok(StokesIRule::Hands(0, 1)));
        assert_eq!(stokes_i(&[Xx, Xy, Yx, Yy]), Ok(StokesIRule::Hands(0, 3)));
        assert_eq!(stokes_i(&[Yy]), Ok(StokesIRule::OneHand(0)));
        assert!(stokes_i(&[Xy, Yx]).is_err());
        assert!(stokes_i(&[Q]).is_err());
        assert!(stokes_i(&[]).is_err());
    }

    #[test]
    fn two_hands_are_averaged_with_the_variance_of_the_mean() {
        let rule = StokesIRule::Hands(0, 1);
        let (vis_jy, weight) = rule.apply(&VIS_JY, &[2.0, 2.0], &[false, false]).unwrap();
        // Equal hands: twice the weight of one.
        assert_eq!((vis_jy, weight), (Complex::new(2.0, 0.0), 4.0));
        let (_, weight) = rule.apply(&VIS_JY, &[1.0, 3.0], &[false, false]).unwrap();
        assert_eq!(weight, 3.0);
        let (vis_jy, weight) = rule
            .half_difference(&VIS_JY, &[2.0, 2.0], &[false; 2])
            .unwrap();
        assert_eq!((vis_jy, weight), (Complex::new(1.0, 1.0), 4.0));
        let (_, weight) = rule.apply(&VIS_JY, &[1e30, 1e30], &[false; 2]).unwrap();
        assert_eq!(weight, 2e30);
    }

    #[test]
    fn a_hand_alone_stands_for_the_total() {
        let rule = StokesIRule::Hands(0, 1);
        let weights = [2.0, 5.0];
        assert_eq!(
            rule.apply(&VIS_JY, &weights, &[true, false]),
            Some((VIS_JY[1], 5.0))
        );
        assert_eq!(
            rule.apply(&VIS_JY, &weights, &[false, true]),
            Some((VIS_JY[0], 2.0))
        );
        assert_eq!(rule.apply(&VIS_JY, &weights, &[true, true]), None);
        assert_eq!(
            rule.apply(&VIS_JY, &[0.0, 5.0], &[false, false]),
            Some((VIS_JY[1], 5.0))
        );
        assert_eq!(
            rule.half_difference(&VIS_JY, &weights, &[true, false]),
            None
        );
        assert_eq!(
            StokesIRule::OneHand(1).apply(&VIS_JY, &weights, &[true, true]),
            None
        );
    }
}
