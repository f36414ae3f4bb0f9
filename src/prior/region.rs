//! Where on the sky: a rectangle of direction cosines.

use crate::coords::Lm;

/// A rectangle in (l, m); positions are uniform over it. It is half-open: the lower edges belong
/// to it, the upper ones to its neighbour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Lowest l and m.
    pub low: Lm,
    /// Highest l and m.
    pub high: Lm,
}

impl Region {
    /// The square of side `side_rad` about `centre`.
    pub fn square(centre: Lm, side_rad: f64) -> Self {
        Self {
            low: centre,
            high: centre,
        }
        .grown(0.5 * side_rad)
    }

    /// The rectangle with `margin_rad` more on every side.
    #[must_use]
    pub fn grown(self, margin_rad: f64) -> Self {
        Self {
            low: Lm {
                l: self.low.l - margin_rad,
                m: self.low.m - margin_rad,
            },
            high: Lm {
                l: self.high.l + margin_rad,
                m: self.high.m + margin_rad,
            },
        }
    }

    /// The part of `self` that also lies in `other`.
    #[must_use]
    pub fn clipped(self, other: &Region) -> Self {
        Self {
            low: Lm {
                l: self.low.l.max(other.low.l),
                m: self.low.m.max(other.low.m),
            },
            high: Lm {
                l: self.high.l.min(other.high.l),
                m: self.high.m.min(other.high.m),
            },
        }
    }

    /// The smallest rectangle that holds both.
    #[must_use]
    pub fn united(self, other: &Region) -> Self {
        Self {
            low: Lm {
                l: self.low.l.min(other.low.l),
                m: self.low.m.min(other.low.m),
            },
            high: Lm {
                l: self.high.l.max(other.high.l),
                m: self.high.m.max(other.high.m),
            },
        }
    }

    /// Position at (u, v) of the unit square.
    pub fn from_unit(&self, u: f64, v: f64) -> Lm {
        Lm {
            l: self.low.l + u * (self.high.l - self.low.l),
            m: self.low.m + v * (self.high.m - self.low.m),
        }
    }

    /// The point of the unit square that is `lm`: the inverse of [`Region::from_unit`].
    pub fn to_unit(&self, lm: Lm) -> [f64; 2] {
        [
            (lm.l - self.low.l) / (self.high.l - self.low.l),
            (lm.m - self.low.m) / (self.high.m - self.low.m),
        ]
    }

    /// Area [sr, in direction cosines].
    pub fn area(&self) -> f64 {
        (self.high.l - self.low.l) * (self.high.m - self.low.m)
    }

    /// True if `lm` lies in the rectangle.
    pub fn contains(&self, lm: Lm) -> bool {
        lm.l >= self.low.l && lm.l < self.high.l && lm.m >= self.low.m && lm.m < self.high.m
    }

    /// True if the two have an inner point in common.
    pub fn overlaps(&self, other: &Region) -> bool {
        let both = self.clipped(other);
        both.low.l < both.high.l && both.low.m < both.high.m
    }

    /// Distance from `lm` to the nearest edge, negative outside.
    pub fn distance_to_edge(&self, lm: Lm) -> f64 {
        (lm.l - self.low.l)
            .min(self.high.l - lm.l)
            .min(lm.m - self.low.m)
            .min(self.high.m - lm.m)
    }
}
