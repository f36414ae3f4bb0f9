//! Priors: the unit cube to source parameters (method section 2; Malyali et al. 2018, section 3.2).

mod ellipticity;
mod flux;
mod region;
mod scale;
mod window;

pub use ellipticity::EllipticityPrior;
pub use flux::FluxPrior;
pub use region::Region;
pub use scale::{ScalePrior, ScaleRelation};
pub use window::Window;

use crate::coords::Lm;
use crate::rime::Source;

/// Most dimensions of the unit cube of one source: [`SourcePrior::n_dim`] says how many there are.
pub const MAX_DIM: usize = 7;
/// The dimensions that define modes: the position.
pub const MODE_DIMS: [usize; 2] = [0, 1];

/// Prior of one source but for its position, which is uniform over a [`Region`].
///
/// | dimension | parameter |
/// |---|---|
/// | 0, 1 | l, m |
/// | 2 | flux density |
/// | 3 | scale-length, given the flux density |
/// | 4, 5 | ellipticity (e1, e2) |
/// | 6 | spectral index, uniform, where it is free |
#[derive(Debug, Clone, PartialEq)]
pub struct SourcePrior {
    /// Flux density.
    pub flux: FluxPrior,
    /// Scale-length.
    pub scale: ScalePrior,
    /// Ellipticity.
    pub ellipticity: EllipticityPrior,
    /// Largest [`Source::tilt`] to either side, if spectral indices are free.
    pub tilt: Option<f64>,
}

impl SourcePrior {
    /// Dimensions of the unit cube.
    pub fn n_dim(&self) -> usize {
        if self.tilt.is_some() { 7 } else { 6 }
    }

    /// The source at `u`, one coordinate in [0, 1] for each dimension, with its position in `region`.
    pub fn source(&self, region: &Region, u: &[f64]) -> Source {
        let flux_jy = self.flux.from_unit(u[2]);
        Source {
            lm: region.from_unit(u[0], u[1]),
            flux_jy,
            scale_rad: self.scale.from_unit(u[3], flux_jy),
            e: self.ellipticity.from_unit(u[4], u[5]),
            tilt: self.tilt.map_or(0.0, |most| most * (2.0 * u[6] - 1.0)),
        }
    }

    /// `n` sources that cover the prior of flux density and shape evenly, at the phase centre and with the
    /// middle of spectral indices: an additive recurrence by the golden ratio of four dimensions (Roberts 2018).
    pub fn evenly(&self, n: usize) -> impl Iterator<Item = Source> + '_ {
        const STEP: [f64; 4] = [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_597_2];
        (0..n).map(|i| {
            let [flux, scale, e1, e2] = STEP.map(|step| (0.5 + step * i as f64).fract());
            let flux_jy = self.flux.from_unit(flux);
            Source {
                lm: Lm::default(),
                flux_jy,
                scale_rad: self.scale.from_unit(scale, flux_jy),
                e: self.ellipticity.from_unit(e1, e2),
                tilt: 0.0,
            }
        })
    }

    /// The point of the unit cube that is `source`: the inverse of [`SourcePrior::source`].
    pub fn unit(&self, region: &Region, source: &Source) -> Vec<f64> {
        let [u, v] = region.to_unit(source.lm);
        let [x, y] = self.ellipticity.to_unit(source.e);
        let flux = self.flux.to_unit(source.flux_jy);
        let scale = self.scale.to_unit(source.scale_rad, source.flux_jy);
        let tilt = self.tilt.map(|most| 0.5 * (source.tilt / most + 1.0));
        [u, v, flux, scale, x, y].into_iter().chain(tilt).collect()
    }
}
