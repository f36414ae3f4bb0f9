//! The elliptical radius in the uv-plane.

use super::Ellipticity;

/// q(u, v) = a u² + b u v + c v², positive definite: α²(k1² + k2²) of a source.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct QuadraticForm {
    /// Coefficient of u² [wavelength⁻²].
    pub a: f64,
    /// Coefficient of u v [wavelength⁻²].
    pub b: f64,
    /// Coefficient of v² [wavelength⁻²].
    pub c: f64,
}

impl QuadraticForm {
    /// The form of a source of scale-length `scale_rad` [rad] and ellipticity `e`.
    ///
    /// # Formula
    /// ```text
    /// a = α² ((1+e1)² + e2²)/det²   b = 4 α² e2/det²   c = α² ((1-e1)² + e2²)/det²
    /// ```
    ///
    /// # Not valid when
    /// |e| is 1 or more.
    pub fn new(scale_rad: f64, e: Ellipticity) -> QuadraticForm {
        let Ellipticity { e1, e2 } = e;
        let per_det = scale_rad / (1.0 - e1 * e1 - e2 * e2);
        let norm = per_det * per_det;
        QuadraticForm {
            a: norm * ((1.0 + e1) * (1.0 + e1) + e2 * e2),
            b: norm * 4.0 * e2,
            c: norm * ((1.0 - e1) * (1.0 - e1) + e2 * e2),
        }
    }

    /// q at the baseline (u, v) [wavelength].
    pub fn at(self, u: f64, v: f64) -> f64 {
        (self.a * u + self.b * v) * u + self.c * v * v
    }

    /// (p, r, s) with `factor` x q = (p u + r v)² + s v²: two terms that cannot cancel, which
    /// single precision needs for long ellipses.
    pub fn as_squares(self, factor: f64) -> (f64, f64, f64) {
        if self.a <= 0.0 {
            return (0.0, 0.0, factor * self.c);
        }
        let p = (factor * self.a).sqrt();
        let r = factor * self.b / (2.0 * p);
        let s = factor * (self.c - self.b * self.b / (4.0 * self.a));
        (p, r, s.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_formula_of_the_paper() {
        let (alpha, e1, e2) = (3e-6, 0.31, -0.57);
        let form = QuadraticForm::new(alpha, Ellipticity { e1, e2 });
        let (u, v) = (2.3e5, -6.1e5);
        let det = 1.0 - e1 * e1 - e2 * e2;
        let k1 = ((1.0 + e1) * u + e2 * v) / det;
        let k2 = (e2 * u + (1.0 - e1) * v) / det;
        let q = alpha * alpha * (k1 * k1 + k2 * k2);
        assert!((form.at(u, v) / q - 1.0).abs() < 1e-14);
    }

    #[test]
    fn circular_sources_have_a_circular_form() {
        let form = QuadraticForm::new(2.0, Ellipticity::default());
        assert_eq!((form.a, form.b, form.c), (4.0, 0.0, 4.0));
    }

    #[test]
    fn squares_add_up_to_the_form() {
        let form = QuadraticForm::new(1.5, Ellipticity { e1: -0.5, e2: 0.6 });
        let (p, r, s) = form.as_squares(7.0);
        let (u, v) = (0.3, -0.8);
        let k = p * u + r * v;
        assert!((k * k + s * v * v - 7.0 * form.at(u, v)).abs() < 1e-12);
    }

    #[test]
    fn squares_of_a_point_vanish() {
        let form = QuadraticForm::new(0.0, Ellipticity { e1: 0.1, e2: 0.2 });
        assert_eq!(form.as_squares(3.0), (0.0, 0.0, 0.0));
    }
}
