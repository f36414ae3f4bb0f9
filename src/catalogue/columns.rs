//! The columns of every table: name, unit, UCD, meaning, and where in a row the value is.
//!
//! UCDs are words of the IVOA list UCD1+ 1.5; `{band}` stands for the part of the spectrum.

mod catalogue;
mod modes;
mod posterior;
mod run;
mod truth;

use vis2cat_formats::fits::{Column, ColumnData};

pub(super) use catalogue::{CATALOGUE, is_of_beam, is_of_flux_cut, is_of_spectrum};
pub(super) use modes::MODES;
pub(super) use posterior::POSTERIOR;
pub(super) use run::RUN;
pub(super) use truth::TRUTH;

/// One column of rows `R`.
pub(super) struct ColumnDef<R> {
    name: &'static str,
    /// Empty where the value has none.
    unit: &'static str,
    ucd: &'static str,
    about: &'static str,
    get: Get<R>,
}

/// Type of a column, and its value in a row.
enum Get<R> {
    Real(fn(&R) -> f64),
    Int(fn(&R) -> i64),
    /// An integer that may be missing: then -1, which `TNULL` declares.
    MaybeInt(fn(&R) -> Option<i64>),
    Bits(fn(&R) -> i32),
    Text(fn(&R) -> &str),
}

/// What stands for a missing identifier.
const MISSING_ID: i64 = -1;

const fn real<R>(
    name: &'static str,
    unit: &'static str,
    ucd: &'static str,
    about: &'static str,
    get: fn(&R) -> f64,
) -> ColumnDef<R> {
    ColumnDef {
        name,
        unit,
        ucd,
        about,
        get: Get::Real(get),
    }
}

const fn plain<R>(
    name: &'static str,
    ucd: &'static str,
    about: &'static str,
    get: Get<R>,
) -> ColumnDef<R> {
    ColumnDef {
        name,
        unit: "",
        ucd,
        about,
        get,
    }
}

/// The columns `defs` of `rows`, of data taken in the part `band` of the spectrum.
pub(super) fn build<R>(defs: &[ColumnDef<R>], rows: &[R], band: &str) -> Vec<Column> {
    let column = |def: &ColumnDef<R>| Column {
        name: def.name.to_owned(),
        unit: (!def.unit.is_empty()).then(|| def.unit.to_owned()),
        ucd: Some(def.ucd.replace("{band}", band)),
        description: def.about.to_owned(),
        data: values(&def.get, rows),
    };
    defs.iter().map(column).collect()
}

fn values<R>(get: &Get<R>, rows: &[R]) -> ColumnData {
    match get {
        Get::Real(get) => ColumnData::F64(rows.iter().map(get).collect()),
        Get::Int(get) => ColumnData::I64 {
            values: rows.iter().map(|row| Some(get(row))).collect(),
            null: None,
        },
        Get::MaybeInt(get) => ColumnData::I64 {
            values: rows.iter().map(get).collect(),
            null: Some(MISSING_ID),
        },
        Get::Bits(get) => ColumnData::I32(rows.iter().map(get).collect()),
        Get::Text(get) => ColumnData::Text(rows.iter().map(|row| get(row).to_owned()).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names<R>(defs: &[ColumnDef<R>]) -> Vec<&'static str> {
        defs.iter().map(|d| d.name).collect()
    }

    #[test]
    fn positions_have_the_names_that_tools_look_for() {
        for names in [names(CATALOGUE), names(MODES), names(TRUTH)] {
            assert!(names.contains(&"RA") && names.contains(&"DEC"));
        }
        assert!(names(POSTERIOR).contains(&"ra"));
    }

    #[test]
    fn the_truth_is_spelled_as_in_the_catalogue() {
        let catalogue = names(CATALOGUE);
        assert!(names(TRUTH).iter().all(|n| catalogue.contains(n)));
    }

    #[test]
    fn no_description_is_too_long_for_its_card() {
        let about = |defs: &[(&str, &str)]| {
            for (name, about) in defs {
                assert!(!about.is_empty() && about.len() <= 68, "{name}: {about}");
            }
        };
        about(
            &CATALOGUE
                .iter()
                .map(|d| (d.name, d.about))
                .collect::<Vec<_>>(),
        );
        about(&MODES.iter().map(|d| (d.name, d.about)).collect::<Vec<_>>());
        about(
            &POSTERIOR
                .iter()
                .map(|d| (d.name, d.about))
                .collect::<Vec<_>>(),
        );
        about(&TRUTH.iter().map(|d| (d.name, d.about)).collect::<Vec<_>>());
        about(&RUN.iter().map(|d| (d.name, d.about)).collect::<Vec<_>>());
    }
}
