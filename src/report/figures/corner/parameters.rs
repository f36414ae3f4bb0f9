//! The parameters of a corner plot, with their values in all samples of a source.

use super::super::super::Contents;
use super::super::super::axis::Axis;
use super::super::super::density::{Bins, quantiles};
use super::super::super::format::{error_decimals, number, with_error};
use crate::catalogue::{CatalogueSource, Estimate, FoundRow, FoundSamples};
use crate::coords::{Lm, RaDec};
use crate::units::{ARCSEC, MICROJY};

/// Parts of the weight outside the panels at either end.
const TAILS: [f64; 2] = [0.002, 0.998];

/// A parameter, and where its values come from.
struct Kind {
    label: &'static str,
    unit: &'static str,
    /// Size of the unit.
    one: f64,
    of_row: fn(&FoundRow) -> Estimate,
    of_sample: fn(&FoundSamples, usize, &FoundRow) -> f64,
    of_truth: fn(&CatalogueSource, &FoundRow) -> f64,
}

const KINDS: [Kind; 7] = [
    Kind {
        label: "Δl",
        unit: "arcsec",
        one: ARCSEC,
        of_row: |row| about_zero(row.e_ra_rad),
        of_sample: |samples, i, row| offset(samples, i, row).l,
        of_truth: |source, row| source.position.to_lm(row.position).l,
    },
    Kind {
        label: "Δm",
        unit: "arcsec",
        one: ARCSEC,
        of_row: |row| about_zero(row.e_dec_rad),
        of_sample: |samples, i, row| offset(samples, i, row).m,
        of_truth: |source, row| source.position.to_lm(row.position).m,
    },
    Kind {
        label: "Flux",
        unit: "µJy",
        one: MICROJY,
        of_row: |row| row.flux_jy,
        of_sample: |samples, i, _| samples.flux_jy[i],
        of_truth: |source, _| source.flux_jy,
    },
    Kind {
        label: "Scale",
        unit: "arcsec",
        one: ARCSEC,
        of_row: |row| row.scale_rad,
        of_sample: |samples, i, _| samples.scale_rad[i],
        of_truth: |source, _| source.scale_rad,
    },
    Kind {
        label: "e₁",
        unit: "",
        one: 1.0,
        of_row: |row| row.e1,
        of_sample: |samples, i, _| samples.e1[i],
        of_truth: |source, _| source.e.e1,
    },
    Kind {
        label: "e₂",
        unit: "",
        one: 1.0,
        of_row: |row| row.e2,
        of_sample: |samples, i, _| samples.e2[i],
        of_truth: |source, _| source.e.e2,
    },
    Kind {
        label: "β",
        unit: "",
        one: 1.0,
        of_row: |row| row.spectral_index,
        of_sample: |samples, i, _| samples.spectral_index[i],
        of_truth: |source, _| source.spectral_index,
    },
];

fn about_zero(err: f64) -> Estimate {
    Estimate { mean: 0.0, err }
}

/// Where a sample is from the mean position.
fn offset(samples: &FoundSamples, i: usize, row: &FoundRow) -> Lm {
    let position = RaDec {
        ra_rad: samples.ra_rad[i],
        dec_rad: samples.dec_rad[i],
    };
    position.to_lm(row.position)
}

/// A parameter of one source, in its unit.
pub(super) struct Parameter {
    label: &'static str,
    unit: &'static str,
    pub(super) values: Vec<f64>,
    pub(super) mean: f64,
    err: f64,
    pub(super) truth: Option<f64>,
    pub(super) axis: Axis,
}

/// The parameters of a row that vary; empty without samples.
pub(super) fn parameters(contents: &Contents, row: usize) -> Vec<Parameter> {
    let Some(samples) = &contents.catalogue.samples else {
        return Vec::new();
    };
    let found = &contents.catalogue.rows[row];
    let truth = contents.match_of(row).and_then(|matched| {
        let list = &contents.truth.as_ref()?.list;
        let is_known = |label: &str| match label {
            "Scale" => list.has_scale,
            "e₁" | "e₂" => list.has_ellipticity,
            _ => true,
        };
        Some((list.sources[matched.truth_row - 1], is_known))
    });
    let parameter = |kind: &Kind| {
        let truth = truth.as_ref().filter(|(_, is_known)| is_known(kind.label));
        let truth = truth.map(|(source, _)| (kind.of_truth)(source, found) / kind.one);
        Parameter::new(
            kind,
            samples,
            found,
            truth.filter(|truth| truth.is_finite()),
        )
    };
    KINDS.iter().filter_map(parameter).collect()
}

impl Parameter {
    /// None if the values do not vary, as the shape of a point does not, or are not known.
    fn new(
        kind: &Kind,
        samples: &FoundSamples,
        row: &FoundRow,
        truth: Option<f64>,
    ) -> Option<Self> {
        let Kind {
            label, unit, one, ..
        } = *kind;
        let own = row.samples.clone();
        let weights = samples.weight.get(own.clone())?;
        let values: Vec<f64> = own
            .map(|i| (kind.of_sample)(samples, i, row) / one)
            .collect();
        let [low, high] = quantiles(&values, weights, TAILS)?;
        let room = 0.08 * (high - low);
        let title = match unit {
            "" => label.to_owned(),
            unit => format!("{label} [{unit}]"),
        };
        let estimate = (kind.of_row)(row);
        (high > low).then(|| Self {
            axis: Axis::linear(&title, [low - room, high + room]).with_ticks(4.3),
            label,
            unit,
            values,
            mean: estimate.mean / one,
            err: estimate.err / one,
            truth,
        })
    }

    /// The range of its axis in `n` bins.
    pub(super) fn bins(&self, n: usize) -> Bins {
        let [low, high] = self.axis.ends();
        Bins { low, high, n }
    }

    /// Mean and error with two digits of the error; of an offset the error alone.
    pub(super) fn estimate(&self) -> String {
        let Self {
            label,
            unit,
            mean,
            err,
            ..
        } = self;
        let unit = if *unit == "arcsec" { "″" } else { unit };
        match *label {
            "Δl" | "Δm" => format!("{label} ± {}{unit}", number(*err, error_decimals(*err))),
            // There is room for the unit or the name.
            "Flux" => format!("{} {unit}", with_error(*mean, *err)),
            _ => format!("{label} {}{unit}", with_error(*mean, *err)),
        }
    }
}
