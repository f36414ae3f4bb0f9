//! Which row is which true source.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use crate::coords::RaDec;
use crate::units::ARCSEC;

/// A row and a true source are one if they are no further apart than this many standard deviations of
/// the row's position ...
pub const MATCH_N_SIGMA: f64 = 3.0;
/// ... or than this, however well the position is known [rad].
pub const MATCH_FLOOR_RAD: f64 = 1.0 * ARCSEC;

/// Where something was found, and how far from there the true source may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Position, ICRS.
    pub position: RaDec,
    /// Match radius [rad].
    pub radius_rad: f64,
}

/// A row and its true source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Index of the row.
    pub row: usize,
    /// Index of the true source.
    pub truth: usize,
    /// Their distance on the sky [rad].
    pub separation_rad: f64,
}

/// [`MATCH_N_SIGMA`] times the radial error sqrt(σ_east² + σ_north²), at least [`MATCH_FLOOR_RAD`];
/// the floor alone where an error is not known.
pub fn match_radius_rad(e_ra_rad: f64, e_dec_rad: f64) -> f64 {
    // f64::max passes over NaN.
    MATCH_FLOOR_RAD.max(MATCH_N_SIGMA * e_ra_rad.hypot(e_dec_rad))
}

/// One-to-one pairs of `rows` and `truth`, in the order of rows.
///
/// Of all pairs within the row's radius, those of the row with the lowest `rank` are taken first, and
/// of these the closest; then what is left of the others. Equal ranks thus give the closest pairs,
/// whichever rows they are of. A tie goes to the earlier row, then the earlier true source.
pub fn cross_match(rows: &[Place], truth: &[RaDec], rank: impl Fn(usize) -> usize) -> Vec<Pair> {
    let mut pairs = within_radius(rows, truth);
    pairs.sort_by(|a, b| {
        (rank(a.row).cmp(&rank(b.row)))
            .then(a.separation_rad.total_cmp(&b.separation_rad))
            .then((a.row, a.truth).cmp(&(b.row, b.truth)))
    });
    let (mut row_taken, mut truth_taken) = (vec![false; rows.len()], vec![false; truth.len()]);
    pairs.retain(|pair| {
        let is_free = !row_taken[pair.row] && !truth_taken[pair.truth];
        row_taken[pair.row] |= is_free;
        truth_taken[pair.truth] |= is_free;
        is_free
    });
    pairs.sort_by_key(|pair| pair.row);
    pairs
}

/// All pairs within the radius of their row: the true sources are points of an R*-tree in space, where
/// an angle is a chord of the unit sphere.
fn within_radius(rows: &[Place], truth: &[RaDec]) -> Vec<Pair> {
    let point = |(i, position): (usize, &RaDec)| GeomWithData::new(position.unit_vector(), i);
    let tree = RTree::bulk_load(truth.iter().enumerate().map(point).collect());
    let mut pairs = Vec::new();
    for (row, place) in rows.iter().enumerate() {
        let half_angle = 0.5 * place.radius_rad.min(std::f64::consts::PI);
        // A hair more, for the rounding of unit vectors; the angle decides.
        let chord = 2.0 * half_angle.sin() * (1.0 + 1e-9) + 1e-15;
        for near in tree.locate_within_distance(place.position.unit_vector(), chord * chord) {
            let separation_rad = place.position.separation_rad(truth[near.data]);
            if separation_rad <= place.radius_rad {
                pairs.push(Pair {
                    row,
                    truth: near.data,
                    separation_rad,
                });
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    fn at(ra_deg: f64, dec_deg: f64) -> RaDec {
        RaDec {
            ra_rad: ra_deg * DEG,
            dec_rad: dec_deg * DEG,
        }
    }

    fn places(positions: &[RaDec], radius_arcsec: f64) -> Vec<Place> {
        let place = |position: &RaDec| Place {
            position: *position,
            radius_rad: radius_arcsec * ARCSEC,
        };
        positions.iter().map(place).collect()
    }

    fn indices(pairs: &[Pair]) -> Vec<(usize, usize)> {
        pairs.iter().map(|p| (p.row, p.truth)).collect()
    }

    #[test]
    fn the_radius_is_three_sigma_and_at_least_an_arcsecond() {
        let radius = |east: f64, north: f64| match_radius_rad(east * ARCSEC, north * ARCSEC);
        assert!((radius(0.3, 0.4) / ARCSEC - 1.5).abs() < 1e-12);
        assert!(radius(0.1, 0.1) == ARCSEC && radius(f64::NAN, 5.0) == ARCSEC);
    }

    #[test]
    fn distances_are_spherical_across_0h_and_at_high_declination() {
        // At 60 deg one arcsecond on the sky is two in right ascension.
        let a = at(0.4 / 3600.0, 60.0);
        let b = at(360.0 - 1.4 / 3600.0, 60.0);
        let near = cross_match(&places(&[a], 0.91), &[b], |_| 0);
        assert!((near[0].separation_rad / ARCSEC - 0.9).abs() < 1e-6);
        assert!(cross_match(&places(&[a], 0.89), &[b], |_| 0).is_empty());
        // Two sides of the pole.
        let pole = cross_match(
            &places(&[at(0.0, 90.0 - 1e-4)], 1.0),
            &[at(180.0, 90.0 - 1e-4)],
            |_| 0,
        );
        assert!((pole[0].separation_rad / ARCSEC - 0.72).abs() < 1e-6);
    }

    #[test]
    fn every_source_is_matched_once_and_the_closest_pair_first() {
        let north = |arcsec: f64| at(10.0, arcsec / 3600.0);
        let rows = places(&[north(0.0), north(1.0), north(9.0)], 2.0);
        let truth = [north(0.9), north(-1.5)];
        assert_eq!(
            indices(&cross_match(&rows, &truth, |_| 0)),
            [(0, 1), (1, 0)]
        );
        // The first row before all others takes what is nearest to it.
        assert_eq!(indices(&cross_match(&rows, &truth, |row| row)), [(0, 0)]);
    }

    #[test]
    fn a_tie_goes_to_the_first() {
        let rows = places(&[at(0.0, 0.0), at(0.0, 0.0)], 1.0);
        let truth = [at(0.0, 0.0)];
        assert_eq!(indices(&cross_match(&rows, &truth, |_| 0)), [(0, 0)]);
    }

    #[test]
    fn nothing_matches_nothing() {
        assert!(cross_match(&[], &[at(0.0, 0.0)], |_| 0).is_empty());
        assert!(cross_match(&places(&[at(0.0, 0.0)], 1.0), &[], |_| 0).is_empty());
    }

    /// Hundreds of sources: the tree finds the same pairs as looking at all of them.
    #[test]
    fn the_tree_overlooks_no_pair() {
        let scattered = |i: usize, salt: f64| {
            let t = (i as f64 * 0.618_033_988_75 + salt).fract();
            at(
                360.0 * t,
                ((i as f64 * 0.754_877_666 + salt).fract() - 0.5) * 0.02,
            )
        };
        let rows: Vec<RaDec> = (0..400).map(|i| scattered(i, 0.0)).collect();
        let truth: Vec<RaDec> = (0..500).map(|i| scattered(i, 0.01)).collect();
        let rows = places(&rows, 3600.0);
        let mut found = indices(&within_radius(&rows, &truth));
        found.sort_unstable();
        let all = (0..rows.len()).flat_map(|i| (0..truth.len()).map(move |j| (i, j)));
        let wanted: Vec<_> = all
            .filter(|&(i, j)| rows[i].position.separation_rad(truth[j]) <= rows[i].radius_rad)
            .collect();
        assert!(wanted.len() > 500);
        assert_eq!(found, wanted);
    }
}
