//! The field cut into tiles, each with a margin in which its neighbours look as well.

use crate::coords::Lm;
use crate::prior::Region;

/// Live points that should fall into the basin of a source.
const LIVE_POINTS_PER_BASIN: f64 = 18.0;
/// Radius of a basin in widths of the beam: there, a source twice above the noise peaks still
/// rises above them.
const BASIN_RADIUS_BEAMS: f64 = 1.5;
/// Margin in widths of the beam: the peak of a source on the border is whole on both sides.
const MARGIN_BEAMS: f64 = 0.7;

/// A part of the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tile {
    /// Number, row after row from the south-west.
    pub id: usize,
    /// The tile itself.
    pub core: Region,
    /// The part of the sky that is sampled: the tile and its margin, inside the field.
    pub region: Region,
}

/// Cuts `field` into at least `n_tile` tiles (the next square number).
pub fn tiles(field: &Region, n_tile: usize, beam_rad: f64) -> Vec<Tile> {
    let n_side = (n_tile as f64).sqrt().ceil() as usize;
    let margin = MARGIN_BEAMS * beam_rad;
    let edge = |i: usize| i as f64 / n_side as f64;
    let cell = |id: usize| {
        let (column, row) = (id % n_side, id / n_side);
        let core = Region {
            low: field.from_unit(edge(column), edge(row)),
            high: field.from_unit(edge(column + 1), edge(row + 1)),
        };
        Tile {
            id,
            core,
            region: core.grown(margin).clipped(field),
        }
    };
    (0..n_side * n_side).map(cell).collect()
}

/// Side of a tile in which a source's basin gets enough of `n_live` live points [rad].
pub fn side_for_basin(n_live: usize, beam_rad: f64) -> f64 {
    let basin = std::f64::consts::PI * (BASIN_RADIUS_BEAMS * beam_rad).powi(2);
    (n_live as f64 * basin / LIVE_POINTS_PER_BASIN).sqrt()
}

/// The square of side `fov_rad` about the phase centre.
pub fn field_of_view(fov_rad: f64) -> Region {
    Region::square(Lm::default(), fov_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_field_and_overlap_by_their_margins() {
        let field = field_of_view(1e-2);
        let tiles = tiles(&field, 14, 1e-5);
        assert_eq!(tiles.len(), 16);
        for i in 0..50 {
            for j in 0..50 {
                let lm = field.from_unit(f64::from(i) / 50.0, f64::from(j) / 50.0);
                assert!(tiles.iter().any(|tile| tile.region.contains(lm)));
            }
        }
        let covered: f64 = tiles.iter().map(|tile| tile.region.area()).sum();
        assert!(covered > field.area() && covered < 1.1 * field.area());
    }

    #[test]
    fn one_tile_is_the_whole_field() {
        let field = field_of_view(1e-2);
        assert_eq!(tiles(&field, 1, 1e-5)[0].region, field);
    }
}
