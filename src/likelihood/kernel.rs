//! X and Y of a batch of sources over one block, with the widest instructions at hand.
//!
//! ```text
//! block -> tiles of 512 samples -> every source over the tile -> f64 sums of the block
//! ```
//!
//! For a sample and a source: φ - angle(d) in f64, whose low bits are the phase in fixed point
//! (`numbers.rs`); from there on f32. Lanes add up 32 terms in f32, tiles add up in f64. A source's
//! sums never depend on which other sources are in the batch.
#![allow(clippy::inline_always)] // plain loops must be compiled anew for each instruction set

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod cross;
mod isa;
mod model;
pub(in crate::likelihood) mod numbers;
mod portable;
mod slow;
mod term;
mod tile;

pub use cross::PairTerm;
pub use isa::Isa;
pub use term::SourceTerm;

use super::extents::Gain;
use super::{VisBlock, Xy};
use crate::rime::shape::Profile;
use crate::rime::{Ray, Source};
use model::Model;

/// Adds X and Y at unit flux density of each of `terms` over `block` to `out`, on one core.
///
/// The sums over the block are formed from zero and then added, so that a partial sum a block,
/// added in the order of blocks, gives the same bits as calling this block after block.
///
/// # Precision
/// ln L within 1e-5 max(|ln L|, SNR²/2, SNR) of the plain f64 sum, SNR = S sqrt(Y), for data that
/// noise dominates. Measured over the prior: 3e-6 at worst. The error of X is a random walk of
/// about 1e-7 w|d|F a sample, so that data far brighter than their noise make it larger in that
/// proportion.
///
/// # Panics
/// If `out` is not as long as `terms` or if the processor lacks `isa`.
pub fn accumulate(isa: Isa, block: &VisBlock, terms: &[SourceTerm], out: &mut [Xy]) {
    assert_eq!(terms.len(), out.len(), "one sum a source");
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    let gains = gains(block, terms.iter().map(SourceTerm::ray));
    let mut sums = vec![Xy::default(); terms.len()];
    match isa {
        Isa::Portable => portable::accumulate(block, terms, &gains, &mut sums),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => avx2::accumulate(block, terms, &gains, &mut sums),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => avx512::accumulate(block, terms, &gains, &mut sums),
        #[cfg(not(target_arch = "x86_64"))]
        _ => portable::accumulate(block, terms, &gains, &mut sums),
    }
    for (out, sum) in out.iter_mut().zip(sums) {
        out.x += sum.x;
        out.y += sum.y;
    }
}

/// The factors of sources; none where the block has no terms of the instrument.
fn gains(block: &VisBlock, rays: impl Iterator<Item = Ray>) -> Vec<Gain> {
    rays.map_while(|ray| block.extents.gain(ray)).collect()
}

/// Works out the factors of the instrument for all samples of `block`, which has extents.
///
/// # Panics
/// If the processor lacks `isa`.
pub(super) fn look(isa: Isa, block: &VisBlock, gain: &Gain, gains: &mut [f32]) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    match isa {
        Isa::Portable => model::look(block, gain, gains),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => avx2::look(block, gain, gains),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => avx512::look(block, gain, gains),
        #[cfg(not(target_arch = "x86_64"))]
        _ => model::look(block, gain, gains),
    }
}

/// Adds Y_ij = Σ w F_i F_j cos 2π(φ_i - φ_j) at unit flux density of each of `terms` over `block` to
/// `sums`, on one core.
///
/// # Precision
/// 2e-6 sqrt(Y_i Y_j).
///
/// # Panics
/// If the processor lacks `isa`.
pub fn accumulate_pairs(isa: Isa, block: &VisBlock, terms: &[PairTerm], sums: &mut [f64]) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    let gains = gains(block, terms.iter().flat_map(PairTerm::rays));
    match isa {
        Isa::Portable => cross::accumulate(block, terms, &gains, sums),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => avx2::accumulate_pairs(block, terms, &gains, sums),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => avx512::accumulate_pairs(block, terms, &gains, sums),
        #[cfg(not(target_arch = "x86_64"))]
        _ => cross::accumulate(block, terms, &gains, sums),
    }
}

/// Subtracts the visibilities of `sources` from `block`, on one core: w d becomes w (d - Σ V).
///
/// # Precision
/// 1e-6 of Σ|V| and the f32 rounding of w d.
///
/// # Panics
/// If the processor lacks `isa`.
pub fn subtract(isa: Isa, block: &mut VisBlock, sources: &[(Source, Profile)]) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    let model = |source| Model::new(source, &block.extents);
    let models: Vec<_> = sources.iter().map(model).collect();
    match isa {
        Isa::Portable => model::subtract(block, &models),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => avx2::subtract(block, &models),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => avx512::subtract(block, &models),
        #[cfg(not(target_arch = "x86_64"))]
        _ => model::subtract(block, &models),
    }
}

#[cfg(test)]
mod tests;
