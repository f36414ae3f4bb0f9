//! What the sum over cells needs to know of a source in a facet.

use super::plan::FacetPlan;
use crate::coords::Lm;
use crate::rime::Source;
use crate::rime::shape::{Profile, QuadraticForm};
use std::f64::consts::{LN_2, LOG2_E, PI, TAU};

/// Smallest F that is summed.
const FACTOR_MIN: f64 = 1e-5;

/// The centre of a facet on the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Centre {
    pub(super) lm: Lm,
    /// l/n: what w takes off u.
    pub(super) slope_u: f64,
    /// m/n: what w takes off v.
    pub(super) slope_v: f64,
}

impl Centre {
    pub(super) fn new(lm: Lm) -> Centre {
        let [slope_u, slope_v] = lm.slopes();
        Centre {
            lm,
            slope_u,
            slope_v,
        }
    }

    /// Where `lm` is, from here.
    pub(super) fn offset(&self, lm: Lm) -> Lm {
        Lm {
            l: lm.l - self.lm.l,
            m: lm.m - self.lm.m,
        }
    }
}

/// A source of unit flux density in a facet.
///
/// Its visibility, with the centre's phase taken off and in the centre's u' = u - w l0/n0 and
/// v' = v - w m0/n0, is, to first order in w,
///
/// ```text
/// F(u', v') exp(2πi (u' δl + v' δm)) (1 + w (D ln F + 2πi ε))
/// D = (l0/n0 - l/n) ∂/∂u + (m0/n0 - m/n) ∂/∂v      ε = n - n0 + (l0 δl + m0 δm)/n0
/// ```
///
/// where D moves the baseline from what the centre sees to what the source at (l, m) sees, and ε is the
/// curvature of the sky over the facet. The weights are those of all facets, at the baselines that the
/// phase centre sees: there F² (1 + 2 w D0 ln F) with D0 = -l/n ∂/∂u - m/n ∂/∂v.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacetTerm {
    pub(super) profile: Profile,
    /// Offset from the centre.
    pub(super) offset: Lm,
    /// Q = (p u + r v)² + s v², scaled so that F is (1 + Q)^(-3/2) or 2^(-Q).
    pub(super) p: f64,
    pub(super) r: f64,
    pub(super) s: f64,
    /// Largest Q that is summed.
    pub(super) q_max: f64,
    /// w D ln F.
    pub(super) bend: Bend,
    /// 2 w D0 ln F.
    pub(super) weight_bend: Bend,
    /// -2π ε w in the same units.
    pub(super) curvature: f64,
    /// Scale-length of the major axis [rad].
    pub(super) major_rad: f64,
}

/// (`along` (p u + r v) + `across` v) times 1/(1 + Q) or 1, per w in units of the plan's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bend {
    pub(super) along: f64,
    pub(super) across: f64,
}

impl FacetTerm {
    pub(super) fn new(plan: &FacetPlan, centre: &Centre, source: &Source) -> FacetTerm {
        let profile = plan.needs.profile;
        // -ln F per Q at small Q, scale of Q, and Q where F is negligible
        let (slope, scale, q_max) = match profile {
            Profile::Exponential => (1.5, 4.0 * PI * PI, FACTOR_MIN.powf(-2.0 / 3.0) - 1.0),
            Profile::Gaussian => (LN_2, 2.0 * PI * PI * LOG2_E, -FACTOR_MIN.log2()),
            Profile::Point => (0.0, 0.0, f64::INFINITY),
        };
        let (p, r, s) = if scale > 0.0 {
            QuadraticForm::new(source.scale_rad, source.e).as_squares(scale)
        } else {
            (0.0, 0.0, 0.0)
        };
        let [slope_u, slope_v] = source.lm.slopes();
        let unit = -2.0 * slope * plan.needs.reach.w;
        let bend = |[du, dv]: [f64; 2]| Bend {
            along: unit * (p * du + r * dv),
            across: unit * s * dv,
        };
        let offset = centre.offset(source.lm);
        FacetTerm {
            profile,
            offset,
            p,
            r,
            s,
            q_max,
            bend: bend([centre.slope_u - slope_u, centre.slope_v - slope_v]),
            weight_bend: bend([-2.0 * slope_u, -2.0 * slope_v]),
            curvature: -TAU * curvature(centre, source.lm, offset) * plan.needs.reach.w,
            major_rad: source.scale_rad / (1.0 - source.e.modulus()),
        }
    }
}

impl FacetTerm {
    /// Q at one wavelength along the axes of the shape, the smaller first.
    pub(super) fn axes_squared(&self) -> [f64; 2] {
        let (pp, pr, rr) = (self.p * self.p, self.p * self.r, self.r * self.r + self.s);
        let (mean, half) = (0.5 * (pp + rr), (0.5 * (pp - rr)).hypot(pr));
        [(mean - half).max(0.0), mean + half]
    }
}

/// ε, with n - n0 = -(δl (l + l0) + δm (m + m0))/(n + n0), which keeps its digits.
fn curvature(centre: &Centre, lm: Lm, offset: Lm) -> f64 {
    let both = 2.0 + lm.n_minus_1() + centre.lm.n_minus_1();
    let difference = -(offset.l * (lm.l + centre.lm.l) + offset.m * (lm.m + centre.lm.m)) / both;
    difference + offset.l * centre.slope_u + offset.m * centre.slope_v
}
