//! From positions on the Earth to (u, v, w).

use super::Pointing;

/// The frame of (u, v, w) at one time: u east, v north, w towards the phase centre.
///
/// # Formula
/// With H the Greenwich hour angle and δ the apparent declination, p the position angle of the frame:
///
/// ```text
/// u0 =  sin H x + cos H y                                 u = cos p u0 - sin p v0
/// v0 = -sin δ cos H x + sin δ sin H y + cos δ z           v = sin p u0 + cos p v0
/// w  =  cos δ cos H x - cos δ sin H y + sin δ z
/// ```
///
/// # Source
/// Thompson, Moran & Swenson, Interferometry and Synthesis in Radio Astronomy (3rd ed., 2017),
/// eq. 4.1, with x towards longitude 0; the rotation by p is pyuvdata's `frame_pa`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UvwFrame {
    rows: [[f64; 3]; 3],
}

impl UvwFrame {
    /// The frame of `pointing`.
    pub fn new(pointing: &Pointing) -> Self {
        let (sin_h, cos_h) = pointing.gha_rad.sin_cos();
        let (sin_d, cos_d) = pointing.dec_rad.sin_cos();
        let (sin_p, cos_p) = pointing.frame_pa_rad.sin_cos();
        let u0 = [sin_h, cos_h, 0.0];
        let v0 = [-sin_d * cos_h, sin_d * sin_h, cos_d];
        let w = [cos_d * cos_h, -cos_d * sin_h, sin_d];
        let mix = |a: f64, b: f64| std::array::from_fn(|k| a * u0[k] + b * v0[k]);
        Self {
            rows: [mix(cos_p, -sin_p), mix(sin_p, cos_p), w],
        }
    }

    /// (u, v, w) [m] of a position or difference of positions, ITRF [m].
    ///
    /// The (u, v, w) of a baseline as stored beside the data is that of r(ant1) - r(ant2).
    pub fn apply(&self, itrf_m: [f64; 3]) -> [f64; 3] {
        self.rows
            .map(|row| row[0] * itrf_m[0] + row[1] * itrf_m[1] + row[2] * itrf_m[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    #[test]
    fn u_is_east_v_north_and_w_towards_the_source() {
        // source on the Greenwich meridian at declination +30, seen from longitude 0: east is +y
        let pointing = Pointing {
            dec_rad: 30.0 * DEG,
            ..Pointing::default()
        };
        let frame = UvwFrame::new(&pointing);
        assert_eq!(frame.apply([0.0, 100.0, 0.0]), [100.0, 0.0, 0.0]);
        let up = frame.apply([100.0 * (30.0 * DEG).cos(), 0.0, 50.0]);
        assert!(up[1].abs() < 1e-12 && (up[2] - 100.0).abs() < 1e-12);
        let north = frame.apply([-50.0, 0.0, 100.0 * (30.0 * DEG).cos()]);
        assert!((north[1] - 100.0).abs() < 1e-12 && north[2].abs() < 1e-12);
    }

    #[test]
    fn lengths_are_kept() {
        let frame = UvwFrame::new(&Pointing {
            gha_rad: 1.1,
            dec_rad: -0.5,
            frame_pa_rad: 0.01,
            elevation_rad: 1.0,
        });
        let length_m = frame
            .apply([3.0, -4.0, 12.0])
            .map(|x| x * x)
            .iter()
            .sum::<f64>();
        assert!((length_m - 169.0).abs() < 1e-11);
    }
}
