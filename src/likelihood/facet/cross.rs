//! What two sources in a small patch of sky have in common, from regular grids.
//!
//! A point of 1 Jy at the centre of a facet, rotated to the centre, leaves Σ w. What X is in a facet
//! of such data, Y_ij is of a "source" that has the product of two shapes and their difference in
//! place. Seen from each other, two sources lie up to twice as far off as from the centre: the
//! grids are those of a facet of twice the side.

use super::evaluate::{PairJob, accumulate_pair};
use super::{Facet, FacetBuilder, FacetNeeds, FacetPlan, FacetTerm, Gains, Look, TiltRange};
use crate::coords::Lm;
use crate::likelihood::VisBlock;
use crate::rime::Source;
use std::sync::Arc;

/// The weights as a patch of sky sees them.
#[derive(Debug)]
pub struct CrossFacet(Facet);

/// Facets on their way, as [`FacetBuilder`].
#[derive(Debug)]
pub struct CrossBuilder(FacetBuilder);

impl CrossFacet {
    /// What a plan must be made for so that pairs of sources in regions of `needs` are served.
    ///
    /// The product of two shapes is as wide on the sky as both together. The w term, which goes
    /// with the fourth power of the side, is still that of sources in the region.
    pub fn needs(needs: FacetNeeds) -> FacetNeeds {
        FacetNeeds {
            side_rad: 2.0 * needs.side_rad,
            longest_axis_rad: 2.0 * needs.longest_axis_rad,
            w_term_max: 16.0 * needs.w_term_max,
            gains: match needs.gains {
                Gains::Followed(most) => Gains::Pairs(most),
                other => other,
            },
            // There the factors of both are multiplied.
            tilts: TiltRange {
                half_band_ln: 2.0 * needs.tilts.half_band_ln,
                ..needs.tilts
            },
            ..needs
        }
    }

    /// Y_ij = Σ w F_i F_j cos 2π(φ_i - φ_j) [Jy⁻²] of each of `pairs`, on one core.
    ///
    /// # Precision
    /// Against the exact engine all over the prior, on SKA1-MID, relative to sqrt(Y_i Y_j): 4e-7 at
    /// the phase centre, 7e-6 for points, 1e-5 at 0.5 degrees from it.
    ///
    /// # Not valid when
    /// As for X and Y of a [`Facet`].
    pub fn cross_batch(&self, pairs: &[[Source; 2]]) -> Vec<f64> {
        pairs.iter().map(|pair| self.cross(pair)).collect()
    }

    fn cross(&self, pair: &[Source; 2]) -> f64 {
        let Self(facet) = self;
        let terms = pair.map(|source| FacetTerm::new(&facet.plan, &facet.centre, &source));
        let last = (facet.plan).innermost(terms[0].major_rad + terms[1].major_rad);
        let [a, b] = pair.map(|source| facet.centre.offset(source.lm));
        let middle = Lm {
            l: 0.5 * (a.l + b.l),
            m: 0.5 * (a.m + b.m),
        };
        let look = |(look, share): (&Look, f64)| {
            let mut job = PairJob::new(terms);
            for number in 0..=last {
                let level = facet.level(look, number);
                accumulate_pair(facet.isa, level, number == last, &mut job);
            }
            share * job.sum
        };
        let tilt = 0.5 * (pair[0].tilt + pair[1].tilt);
        (facet.looks.iter().zip(facet.plan.shares(middle, tilt)))
            .map(look)
            .sum()
    }
}

impl CrossBuilder {
    /// Facets about `centres`, empty; `plan` is made for [`CrossFacet::needs`].
    pub fn new(plan: Arc<FacetPlan>, centres: &[Lm]) -> CrossBuilder {
        let point = |&lm: &Lm| {
            vec![Source {
                lm,
                flux_jy: 1.0,
                ..Source::default()
            }]
        };
        let points = centres.iter().map(point).collect();
        CrossBuilder(FacetBuilder::new(plan, centres).restoring(points))
    }

    /// Adds the next blocks of the stream, whose data do not matter, on the current rayon pool.
    ///
    /// # Panics
    /// If a sample lies beyond the reach that the plan was made for.
    pub fn add(&mut self, blocks: &[VisBlock]) {
        let blank = |block: &VisBlock| VisBlock {
            weighted_re: vec![0.0; block.len()],
            weighted_im: vec![0.0; block.len()],
            ..block.clone()
        };
        let blank: Vec<VisBlock> = blocks.iter().map(blank).collect();
        self.0.add(&blank);
    }

    /// The facets, in the order of their centres.
    pub fn finish(self) -> Vec<CrossFacet> {
        self.0.finish().into_iter().map(CrossFacet).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{CENTRE, CORNER, needs, reach, ska1_mid, sources};
    use super::*;
    use crate::likelihood::Isa;
    use crate::likelihood::{PairTerm, accumulate_pairs, plain_xy};
    use crate::prior::Region;
    use crate::rime::shape::Profile;
    use crate::units::ARCSEC;

    /// Largest error of Y_ij over sqrt(Y_i Y_j) for pairs all over the region of a facet.
    fn worst(centre: Lm, scale_arcsec: [f64; 2], profile: Profile) -> f64 {
        let blocks = ska1_mid(4);
        let side_arcsec = 15.0;
        let needs = CrossFacet::needs(needs(side_arcsec, reach(&blocks), profile));
        let plan = Arc::new(FacetPlan::new(needs).unwrap());
        let mut builder = CrossBuilder::new(plan, &[centre]);
        builder.add(&blocks);
        let mut facet = builder.finish().remove(0);
        let region = Region::square(centre, side_arcsec * ARCSEC);
        let sources = sources(&region, 60, scale_arcsec, 0.804);
        let pairs: Vec<[Source; 2]> = sources.chunks(2).map(|two| [two[0], two[1]]).collect();
        let terms: Vec<_> = pairs.iter().map(|p| PairTerm::new(p, profile)).collect();
        let mut exact = vec![0.0; pairs.len()];
        accumulate_pairs(&blocks, &terms, &mut exact);
        let y = |source| -> f64 { blocks.iter().map(|b| plain_xy(b, source, profile).y).sum() };
        let scale: Vec<f64> = pairs.iter().map(|[a, b]| (y(a) * y(b)).sqrt()).collect();
        let mut worst: f64 = 0.0;
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            facet.0.isa = isa;
            let got = facet.cross_batch(&pairs);
            let errors = got.iter().zip(&exact).zip(&scale);
            worst = errors.fold(worst, |worst, ((a, b), scale)| {
                worst.max((a - b).abs() / scale)
            });
        }
        worst
    }

    #[test]
    fn products_agree_with_the_exact_engine() {
        for scale_arcsec in [[0.1, 1.0], [1.0, 10.0]] {
            let worst = worst(CENTRE, scale_arcsec, Profile::Exponential);
            assert!(worst < 2e-6, "{scale_arcsec:?}: {worst:e}");
        }
        for (profile, bound) in [(Profile::Gaussian, 2e-6), (Profile::Point, 2e-5)] {
            let worst = worst(CENTRE, [0.5, 2.0], profile);
            assert!(worst < bound, "{profile:?}: {worst:e}");
        }
    }

    #[test]
    fn products_agree_at_the_corner_of_a_field_too() {
        for scale_arcsec in [[0.1, 1.0], [1.0, 10.0]] {
            let worst = worst(CORNER, scale_arcsec, Profile::Exponential);
            assert!(worst < 3e-5, "{scale_arcsec:?}: {worst:e}");
        }
    }
}
