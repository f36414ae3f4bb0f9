//! Signal-to-noise ratios over a part of the field, and what is seen of regions in it.

use std::ops::Range;

use crate::coords::Lm;
use crate::prior::Region;

/// The signal-to-noise ratios over a facet.
pub(super) struct SnrMap {
    /// Where.
    pub(super) region: Region,
    /// Highest and lowest X/sqrt(Y) of all shapes, axes (m, l), at the middles of equal parts.
    pub(super) high_low: Vec<[f32; 2]>,
    pub(super) n_side: usize,
}

/// What is seen of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Highest X/sqrt(Y).
    pub high: f64,
    /// Lowest: as far below zero as noise and sidelobes go above it.
    pub low: f64,
    /// Holds every position that reaches the limit.
    pub above: Option<Region>,
}

impl Extremes {
    /// Before anything was seen.
    pub const NOTHING: Self = Self {
        high: f64::NEG_INFINITY,
        low: f64::INFINITY,
        above: None,
    };

    /// The same as numbers: those of `above` are NaN where there is none.
    pub(super) fn to_numbers(self) -> [f64; 6] {
        let edges = |r: Region| [r.low.l, r.low.m, r.high.l, r.high.m];
        let [l0, m0, l1, m1] = self.above.map_or([f64::NAN; 4], edges);
        [self.high, self.low, l0, m0, l1, m1]
    }

    /// What [`Extremes::to_numbers`] was made of.
    pub(super) fn from_numbers([high, low, l0, m0, l1, m1]: [f64; 6]) -> Self {
        let above = Region {
            low: Lm { l: l0, m: m0 },
            high: Lm { l: l1, m: m1 },
        };
        let above = (!l0.is_nan()).then_some(above);
        Self { high, low, above }
    }

    /// What is seen of two regions.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let both = self.above.zip(other.above).map(|(a, b)| a.united(&b));
        Self {
            high: self.high.max(other.high),
            low: self.low.min(other.low),
            above: both.or(self.above).or(other.above),
        }
    }
}

impl SnrMap {
    /// Highest and lowest value in `region` and half a step about it, and the rectangle about all
    /// positions there that reach `limit` and the part `part` of the highest, half a step about them
    /// included.
    pub(super) fn extremes(&self, region: &Region, limit: f64, part: f64) -> Extremes {
        let (own, wanted) = (&self.region, region);
        let columns = self.range([own.low.l, own.high.l], [wanted.low.l, wanted.high.l]);
        let rows = self.range([own.low.m, own.high.m], [wanted.low.m, wanted.high.m]);
        let places = || {
            rows.clone()
                .flat_map(|row| columns.clone().map(move |column| (row, column)))
        };
        let value = |(row, column): (usize, usize)| {
            self.high_low[row * self.n_side + column].map(f64::from)
        };
        let high_low = places().map(value);
        let [high, low] = high_low
            .fold([f64::NEG_INFINITY, f64::INFINITY], |[high, low], value| {
                [high.max(value[0]), low.min(value[1])]
            });
        let edge = |i: usize| i as f64 / self.n_side as f64;
        let cell = |(row, column): (usize, usize)| Region {
            low: own.from_unit(edge(column), edge(row)),
            high: own.from_unit(edge(column + 1), edge(row + 1)),
        };
        let bright = places().filter(|&place| value(place)[0] >= limit.max(part * high));
        Extremes {
            high,
            low,
            above: bright.map(cell).reduce(|a, b| a.united(&b)),
        }
    }

    /// The positions along an axis from `own[0]` to `own[1]` that are within half a step of `wanted`.
    fn range(&self, own: [f64; 2], wanted: [f64; 2]) -> Range<usize> {
        let place = |x: f64| (x - own[0]) / (own[1] - own[0]) * self.n_side as f64;
        let first = (place(wanted[0]) - 1.0).ceil().max(0.0) as usize;
        let end = (place(wanted[1]).floor() + 1.0).max(0.0) as usize;
        first.min(self.n_side)..end.min(self.n_side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_region_however_small_holds_a_position() {
        let field = Region::square(Lm::default(), 10.0);
        let map = SnrMap {
            region: field,
            high_low: (0..100).map(|i| [i as f32, -(i as f32)]).collect(),
            n_side: 10,
        };
        let seen = |region: &Region| map.extremes(region, 33.0, 0.0);
        assert_eq!((seen(&field).high, seen(&field).low), (99.0, -99.0));
        for i in 0..100 {
            let at = field.from_unit(f64::from(i) / 100.0, 0.33);
            let here = seen(&Region::square(at, 1e-3));
            assert!(
                (30.0..50.0).contains(&here.high) && here.low <= -30.0,
                "{i}"
            );
            assert_eq!(here.above.is_some(), here.high >= 33.0);
            if i > 40 {
                assert!(here.above.unwrap().grown(1e-9).contains(at));
            }
        }
        // The middle of the first row's last part is at (4.5, -4.5).
        let corner = seen(&Region::square(Lm { l: 4.6, m: -4.6 }, 0.1));
        assert_eq!((corner.high, corner.low, corner.above), (9.0, -9.0, None));
        let beside = seen(&Region::square(Lm { l: 7.0, m: 0.0 }, 0.1));
        assert_eq!(beside, Extremes::NOTHING);
        assert_eq!(beside.and(corner), corner);
        for seen in [corner, beside, seen(&field)] {
            assert_eq!(Extremes::from_numbers(seen.to_numbers()), seen);
        }
        // From row 3, column 3 on.
        let above = seen(&field).above.unwrap();
        assert!((above.low.m + 2.0).abs() < 1e-9 && (above.low.l + 5.0).abs() < 1e-9);
        assert_eq!(above.high, field.high);
        let half = map.extremes(&field, 33.0, 0.5).above.unwrap();
        assert!(half.low.m.abs() < 1e-9);
    }
}
