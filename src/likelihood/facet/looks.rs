//! Where a facet works out the factors s of the instrument, and what it takes them for in between.
//!
//! s is known at the centre alone, or at the corners of a triangle, through which its values span a
//! plane, or at the corners of a pentagon and the centre, which make a paraboloid. X is linear in s and
//! interpolated like it; so is sqrt(Y), which is the length of all s together, without its fine wrinkles.
//!
//! # Formula
//! At x from the centre, with p = x·e_k/r for the corner r e_k and t = |x|/r, that corner counts
//! (1 + 2p)/3 of three, (2p + 4p² - t²)/5 of five, and the centre between five 1 - t².

use super::plan::FacetError;
use crate::coords::Lm;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Most of the factors of the instrument that is left out at the longest baseline, for likelihoods.
pub const GAIN_TERM_MAX: f64 = 5e-3;
/// Part of it that a plane may leave out: sqrt(Y) follows planes less well than paraboloids.
const PART_OF_PLANE: f64 = 0.25;

/// Radius of the ring of corners in half sides of the region: not all the way to its corners.
const RADIUS: f64 = 1.2;
/// Most places.
pub(super) const LOOKS_MAX: usize = 6;

/// How facets know the factors s of the instrument.
///
/// What is left out is that of smearing; a primary beam and a spectrum change little over a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gains {
    /// There are none, so that facets have their weights in common.
    None,
    /// Those at the centre stand for all, where that leaves out at most this.
    Centre(f64),
    /// They are followed over the region, to second order where it takes that, if that leaves out at most
    /// this.
    Followed(f64),
    /// The same for pairs, which a facet of twice the side serves: s² in the middle of two sources stands
    /// for both their factors.
    Pairs(f64),
}

/// The places of all facets of one size, from their centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Looks {
    /// Corners of the ring, and its radius [rad].
    n_corner: usize,
    radius_rad: f64,
}

impl Looks {
    /// As many as it takes for a facet of `side_rad`, where arguments of sincs change by `blur` turns for
    /// each radian.
    pub(super) fn new(gains: Gains, side_rad: f64, blur: f64) -> Result<Looks, FacetError> {
        let (most, served_rad) = match gains {
            Gains::None => (f64::INFINITY, side_rad),
            Gains::Centre(most) | Gains::Followed(most) => (most, side_rad),
            Gains::Pairs(most) => (most, 0.5 * side_rad),
        };
        let turns = blur * served_rad * FRAC_1_SQRT_2;
        // With what Taylor's formula leaves out; the n-th derivative of sinc is π^n/(n+1) at most.
        let left_out = |order: i32| {
            let factorial: f64 = (1..=order).map(f64::from).product();
            (PI * turns).powi(order) / (f64::from(order + 1) * factorial)
        };
        let (n_corner, order) = match gains {
            Gains::None | Gains::Centre(_) => (0, 1),
            _ if left_out(2) <= PART_OF_PLANE * most => (3, 2),
            _ => (5, 3),
        };
        if left_out(order) > most {
            return Err(FacetError::Gains {
                side_rad,
                left_out: left_out(order),
                most,
                largest_rad: side_rad * (most / left_out(order)).powf(1.0 / f64::from(order)),
            });
        }
        Ok(Looks {
            n_corner,
            radius_rad: RADIUS * 0.5 * served_rad,
        })
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        if self.n_corner == 5 {
            6
        } else {
            self.n_corner.max(1)
        }
    }

    /// Those of a facet about `centre`.
    pub(super) fn places(&self, centre: Lm) -> Vec<Lm> {
        let corner = |[x, y]: [f64; 2]| Lm {
            l: centre.l + self.radius_rad * x,
            m: centre.m + self.radius_rad * y,
        };
        let mut places: Vec<Lm> = self.corners().map(corner).collect();
        if places.len() < self.len() {
            places.push(centre);
        }
        places
    }

    /// What the value at each place counts at `offset` from the centre.
    pub(super) fn shares(&self, offset: Lm) -> [f64; LOOKS_MAX] {
        let (x, y) = (offset.l / self.radius_rad, offset.m / self.radius_rad);
        let t2 = x * x + y * y;
        let mut shares = [0.0; LOOKS_MAX];
        for (share, corner) in shares.iter_mut().zip(self.corners()) {
            let p = x * corner[0] + y * corner[1];
            *share = if self.n_corner == 3 {
                (1.0 + 2.0 * p) / 3.0
            } else {
                (2.0 * p + 4.0 * p * p - t2) / 5.0
            };
        }
        match self.n_corner {
            0 => shares[0] = 1.0,
            5 => shares[5] = 1.0 - t2,
            _ => {}
        }
        shares
    }

    fn corners(&self) -> impl Iterator<Item = [f64; 2]> {
        let angle = TAU / self.n_corner as f64;
        (0..self.n_corner).map(move |k| {
            let (sin, cos) = (k as f64 * angle).sin_cos();
            [cos, sin]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Planes and paraboloids are what they are for.
    #[test]
    fn polynomials_are_followed() {
        let plane = |at: Lm| 1.0 + 3e3 * at.l - 5e3 * at.m;
        let bowl = |at: Lm| plane(at) + 1e7 * at.l * at.l - 3e7 * at.l * at.m + 2e7 * at.m * at.m;
        let follow = |blur: f64, f: &dyn Fn(Lm) -> f64, at: Lm| -> f64 {
            let looks = Looks::new(Gains::Followed(GAIN_TERM_MAX), 1e-4, blur).unwrap();
            let centre = Lm { l: 2e-4, m: 1e-4 };
            let offset = Lm {
                l: at.l - centre.l,
                m: at.m - centre.m,
            };
            let places = looks.places(centre).into_iter();
            places
                .zip(looks.shares(offset))
                .map(|(p, share)| share * f(p))
                .sum()
        };
        for (l, m) in [(2e-4, 1e-4), (1.5e-4, 0.5e-4), (2.1e-4, 1.4e-4)] {
            let at = Lm { l, m };
            assert!((follow(300.0, &plane, at) - plane(at)).abs() < 1e-12);
            assert!((follow(1000.0, &bowl, at) - bowl(at)).abs() < 1e-12);
        }
    }

    #[test]
    fn more_places_are_taken_where_smearing_changes_more() {
        let len = |gains, blur| Looks::new(gains, 1e-4, blur).map(|looks| looks.len());
        assert_eq!(len(Gains::None, 1e9), Ok(1));
        assert_eq!(len(Gains::Followed(GAIN_TERM_MAX), 0.0), Ok(3));
        assert_eq!(len(Gains::Followed(GAIN_TERM_MAX), 1000.0), Ok(6));
        assert_eq!(len(Gains::Pairs(GAIN_TERM_MAX), 700.0), Ok(3));
        let too_large = len(Gains::Followed(GAIN_TERM_MAX), 3000.0);
        let Err(FacetError::Gains { largest_rad, .. }) = too_large else {
            panic!("{too_large:?}")
        };
        assert!(Looks::new(Gains::Followed(GAIN_TERM_MAX), 0.999 * largest_rad, 3000.0).is_ok());
        assert!(len(Gains::Centre(0.1), 1000.0).is_err());
    }
}
