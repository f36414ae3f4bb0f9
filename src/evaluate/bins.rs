//! What was found and what is real, by strength and size.

use serde::Serialize;

use super::{Fraction, Matched, Mean, Pair};
use crate::catalogue::{CatalogueSource, FoundRow};
use crate::units::{ARCSEC, MICROJY};

/// Completeness and purity in bins of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Binned {
    /// Column of the quantity.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Bins one after the other, from the first that is not empty to the last.
    pub bins: Vec<Bin>,
}

/// The sources between two values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bin {
    /// Lower end, which belongs to it.
    pub low: f64,
    /// Upper end, which does not; infinite in the last bin.
    pub high: f64,
    /// Of the true sources with a true value in it, how many were found.
    pub completeness: Fraction,
    /// Of the rows with an estimate in it, how many are true.
    pub purity: Fraction,
    /// Flux density, estimate over truth, of the found sources with a true value in it.
    pub flux_ratio: Mean,
}

/// A quantity by which sources are sorted: its value in a true source and in a row.
struct Quantity {
    name: &'static str,
    unit: &'static str,
    edges: Vec<f64>,
    of_truth: fn(&CatalogueSource) -> f64,
    of_row: fn(&FoundRow) -> f64,
}

/// Edges of bins of signal-to-noise ratio: narrow where detection begins.
const SNR_EDGES: [f64; 17] = [
    0.0,
    3.0,
    4.0,
    5.0,
    6.0,
    7.0,
    8.0,
    10.0,
    15.0,
    20.0,
    30.0,
    50.0,
    100.0,
    200.0,
    500.0,
    1000.0,
    f64::INFINITY,
];

/// 0, then 1, 2 and 5 of all powers of ten from 10^-3 to 10^9, then infinity.
fn edges_1_2_5() -> Vec<f64> {
    let decade = |power: i32| [1.0, 2.0, 5.0].map(|digit| digit * 10.0_f64.powi(power));
    std::iter::once(0.0)
        .chain((-3..10).flat_map(decade))
        .chain([f64::INFINITY])
        .collect()
}

fn quantities(matched: &Matched) -> Vec<Quantity> {
    let snr = Quantity {
        name: "SNR",
        unit: "",
        edges: SNR_EDGES.to_vec(),
        of_truth: |source| source.snr,
        of_row: |row| row.snr,
    };
    let flux = Quantity {
        name: "Total_flux",
        unit: "uJy",
        edges: edges_1_2_5(),
        of_truth: |source| source.flux_jy / MICROJY,
        of_row: |row| row.flux_jy.mean / MICROJY,
    };
    let size = Quantity {
        name: "Scale_length",
        unit: "arcsec",
        edges: edges_1_2_5(),
        of_truth: |source| source.scale_rad / ARCSEC,
        of_row: |row| row.scale_rad.mean / ARCSEC,
    };
    let mut quantities = vec![snr, flux];
    quantities.extend(matched.truth.has_scale.then_some(size));
    quantities
}

/// Completeness and purity by signal-to-noise ratio, flux density and, where the truth has it, size.
pub(super) fn report(matched: &Matched) -> Vec<Binned> {
    quantities(matched)
        .iter()
        .map(|quantity| binned(matched, quantity))
        .collect()
}

fn binned(matched: &Matched, quantity: &Quantity) -> Binned {
    let bins: Vec<Bin> = (quantity.edges.windows(2))
        .map(|edges| bin(matched, quantity, edges[0], edges[1]))
        .collect();
    let is_used = |bin: &Bin| bin.completeness.of + bin.purity.of > 0;
    let first = bins.iter().position(is_used).unwrap_or(bins.len());
    let last = bins.iter().rposition(is_used).map_or(first, |i| i + 1);
    Binned {
        name: quantity.name,
        unit: quantity.unit,
        bins: bins[first..last].to_vec(),
    }
}

fn bin(matched: &Matched, quantity: &Quantity, low: f64, high: f64) -> Bin {
    let inside = |value: f64| low <= value && value < high;
    let is_found = matched.is_found();
    let truth = matched.population(|source| inside((quantity.of_truth)(source)));
    let truth_of_row = matched.truth_of_row();
    let rows =
        (0..truth_of_row.len()).filter(|&i| inside((quantity.of_row)(&matched.found.rows[i])));
    let ratio = |pair: &Pair| matched.row(pair).flux_jy.mean / matched.source(pair).flux_jy;
    let ratios: Vec<f64> = (matched.pairs.iter())
        .filter(|pair| inside((quantity.of_truth)(matched.source(pair))))
        .map(ratio)
        .filter(|ratio| ratio.is_finite())
        .collect();
    Bin {
        low,
        high,
        completeness: Fraction::of(truth.into_iter().map(|i| is_found[i])),
        purity: Fraction::of(rows.map(|i| truth_of_row[i].is_some())),
        flux_ratio: Mean::of(&ratios),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_rise_and_lie_on_round_numbers() {
        let edges = edges_1_2_5();
        for edges in [&edges, &SNR_EDGES.to_vec()] {
            assert!(edges[0] == 0.0 && edges.windows(2).all(|e| e[0] < e[1]));
        }
        for round in [0.1, 0.2, 0.5, 1.0, 20.0, 500.0] {
            let is_round = |edge: &f64| (edge / round - 1.0).abs() < 1e-15;
            assert!(edges.iter().any(is_round), "{round}");
        }
    }
}
