//! Tests of what is written against what is read, by us and by CFITSIO.

use std::path::PathBuf;

use fitsio::FitsFile;
use proptest::prelude::*;

use super::*;
use crate::{ReadError, WriteError};

fn column(name: &str, data: ColumnData) -> Column {
    Column {
        name: name.into(),
        unit: Some("deg".into()),
        ucd: Some("pos.eq.ra;meta.main".into()),
        description: "a column".into(),
        data,
    }
}

fn cells(form: &str, values: &[f64]) -> ColumnData {
    let form = form.to_owned();
    let values = values.to_vec();
    ColumnData::Cells { form, values }
}

fn table() -> TableSpec {
    let text = |s: &str| s.to_owned();
    let integers = ColumnData::I64 {
        values: vec![Some(7), None, Some(i64::MAX)],
        null: Some(-1),
    };
    TableSpec {
        extname: "EVERY_KIND".into(),
        columns: vec![
            column("D", ColumnData::F64(vec![1.5, f64::NAN, -5e-324])),
            column("E", cells("1E", &[0.1, f64::INFINITY, f64::NAN])),
            column("K", integers),
            column("J", ColumnData::I32(vec![1, -2, 3])),
            // The bytes of T, F and nothing.
            column("L", cells("1B", &[84.0, 70.0, 0.0])),
            column("X", cells("2I", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
            column("NONE", cells("0D", &[])),
            column(
                "A",
                ColumnData::Text(vec![text("J0001"), text(""), text("3 µJy")]),
            ),
        ],
        cards: Cards {
            keywords: vec![
                Keyword::new("SEED", u64::MAX, "seed"),
                Keyword::new("LONG", "it's long ".repeat(30), "more than a card"),
            ],
            comments: vec!["a comment".into()],
            history: vec!["an option ".repeat(30)],
        },
    }
}

struct Written {
    _dir: tempfile::TempDir,
    path: PathBuf,
}

fn written(tables: &[TableSpec]) -> Written {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.fits");
    let primary = Cards {
        keywords: vec![Keyword::new("ORIGIN", "vis2cat", "who wrote this")],
        ..Cards::default()
    };
    write_tables(&path, false, &primary, tables).unwrap();
    Written { _dir: dir, path }
}

/// Start and end of every HDU.
fn hdus(bytes: &[u8]) -> Vec<std::ops::Range<usize>> {
    let blocks = bytes.len() / BLOCK_BYTES;
    let is_start = |i: &usize| {
        let block = &bytes[i * BLOCK_BYTES..];
        block.starts_with(b"SIMPLE  =") || block.starts_with(b"XTENSION=")
    };
    let mut starts: Vec<usize> = (0..blocks)
        .filter(is_start)
        .map(|i| i * BLOCK_BYTES)
        .collect();
    starts.push(bytes.len());
    starts.windows(2).map(|w| w[0]..w[1]).collect()
}

#[test]
fn every_kind_of_column_comes_back() {
    let file = written(&[table()]);
    assert!(is_fits(&file.path).unwrap());
    let back = read_table(&file.path, Some("every_kind")).unwrap();
    assert_eq!((back.rows(), back.columns().len()), (3, 8));
    let d = back.numbers("d").unwrap();
    assert!(d[0] == 1.5 && d[1].is_nan() && d[2] == -5e-324);
    assert_eq!(back.numbers("e").unwrap()[0], f64::from(0.1_f32));
    let k = back.numbers("K").unwrap();
    assert!(k[0] == 7.0 && k[1].is_nan() && k[2] == i64::MAX as f64);
    assert_eq!(back.numbers("J").unwrap(), [1.0, -2.0, 3.0]);
    assert_eq!(back.numbers("L").unwrap(), [84.0, 70.0, 0.0]);
    assert_eq!(back.cells("X").unwrap().unwrap().row(1), [3.0, 4.0]);
    assert!(back.cells("NONE").unwrap().unwrap().row(2).is_empty());
    assert_eq!(back.strings("A").unwrap(), ["J0001", "", "3 uJy"]);
    assert_eq!(back.column("A").unwrap().unit.as_deref(), Some("deg"));
    assert_eq!(back.keyword("SEED"), Some(&u64::MAX.into()));
    let long = "it's long ".repeat(30);
    assert_eq!(back.keyword("LONG"), Some(&long.trim_end().into()));
}

#[test]
fn truth_values_and_scaled_integers_are_read() {
    let mut spec = table();
    for (key, value) in [("TSCAL6", 0.5), ("TZERO6", 100.0)] {
        spec.cards.push(key, value, "");
    }
    // Stored are 1, 2, 3 and so on.
    spec.cards.push("TNULL6", 5, "");
    spec.columns[5].data = cells("2I", &[100.5, 101.0, 101.5, 102.0, 102.5, 103.0]);
    let file = written(&[spec]);
    let mut bytes = std::fs::read(&file.path).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let at = text.find("TFORM5  = '1B").unwrap() + 12;
    bytes[at] = b'L';
    std::fs::write(&file.path, &bytes).unwrap();
    let back = read_table(&file.path, None).unwrap();
    let l = back.numbers("L").unwrap();
    assert!(l[0] == 1.0 && l[1] == 0.0 && l[2].is_nan());
    let x = back.cells("X").unwrap().unwrap().values;
    assert!(x[..4] == [100.5, 101.0, 101.5, 102.0] && x[4].is_nan() && x[5] == 103.0);
}

#[test]
fn cfitsio_reads_the_same() {
    let file = written(&[table()]);
    let mut fits = FitsFile::open(&file.path).unwrap();
    let hdu = fits.hdu("EVERY_KIND").unwrap();
    let d: Vec<f64> = hdu.read_col(&mut fits, "D").unwrap();
    assert!(d[0] == 1.5 && d[1].is_nan());
    let j: Vec<i32> = hdu.read_col(&mut fits, "J").unwrap();
    assert_eq!(j, [1, -2, 3]);
    let a: Vec<String> = hdu.read_col(&mut fits, "A").unwrap();
    // It writes the empty string as blanks, and reads those as one.
    assert_eq!(a, ["J0001", " ", "3 uJy"]);
    let ucd: String = hdu.read_key(&mut fits, "TUCD1").unwrap();
    assert_eq!(ucd, "pos.eq.ra;meta.main");
}

/// Standard, appendix J, independently of CFITSIO.
fn ones_complement_sum(bytes: &[u8]) -> u32 {
    let (words, _) = bytes.as_chunks::<4>();
    words.iter().fold(0, |sum: u32, word| {
        let (sum, carry) = sum.overflowing_add(u32::from_be_bytes(*word));
        sum + u32::from(carry)
    })
}

#[test]
fn every_hdu_sums_to_minus_zero_and_its_data_to_datasum() {
    let file = written(&[table(), table()]);
    let bytes = std::fs::read(&file.path).unwrap();
    let hdus = hdus(&bytes);
    assert_eq!(hdus.len(), 3);
    for range in hdus {
        assert_eq!(ones_complement_sum(&bytes[range]), u32::MAX);
    }
}

#[test]
fn the_same_tables_give_the_same_bytes() {
    let (a, b) = (written(&[table()]), written(&[table()]));
    assert_eq!(
        std::fs::read(&a.path).unwrap(),
        std::fs::read(&b.path).unwrap()
    );
}

#[test]
fn a_table_without_rows_is_a_table() {
    let mut empty = table();
    for column in &mut empty.columns {
        column.data = ColumnData::Text(Vec::new());
    }
    let file = written(&[empty]);
    let back = read_table(&file.path, None).unwrap();
    assert!(back.rows() == 0 && back.strings("A").unwrap().is_empty());
}

#[test]
fn what_is_no_table_is_refused_by_name() {
    let path = std::env::temp_dir().join("never-written.fits");
    let refused = |change: fn(&mut TableSpec)| {
        let mut bad = table();
        change(&mut bad);
        match write_tables(&path, true, &Cards::default(), &[bad]) {
            Err(WriteError::Parameter { what, .. }) => what,
            other => panic!("{other:?}"),
        }
    };
    assert!(refused(|t| t.columns[1].data = ColumnData::I32(vec![1])).contains("1 rows"));
    assert!(refused(|t| t.columns[1].name = "d".into()).contains("twice"));
    assert!(refused(|t| t.columns[0].name = "a b".into()).contains("a b"));
    assert!(refused(|t| t.cards.keywords[0].key = "bad".into()).contains("bad"));
    assert!(
        refused(|t| {
            t.columns[2].data = ColumnData::I64 {
                values: vec![None, Some(1), Some(2)],
                null: None,
            }
        })
        .contains("lacks a value")
    );
    assert!(!path.exists());
}

#[test]
fn a_missing_column_or_table_is_named_with_its_place() {
    let file = written(&[table()]);
    let back = read_table(&file.path, None).unwrap();
    let text = back.numbers("Flux").unwrap_err().to_string();
    assert!(
        text.contains("HDU 1 (EVERY_KIND)") && text.contains("no column Flux"),
        "{text}"
    );
    let text = back.numbers("A").unwrap_err().to_string();
    assert!(
        text.contains("(EVERY_KIND): A") && text.contains("holds type A, not numbers"),
        "{text}"
    );
    let text = read_table(&file.path, Some("NOPE")).map(drop);
    let text = text.unwrap_err().to_string();
    assert!(text.contains("NOPE"), "{text}");
}

#[test]
fn rows_beyond_the_data_unit_are_not_allocated() {
    let file = written(&[table()]);
    let bytes = std::fs::read(&file.path).unwrap();
    let text = String::from_utf8_lossy(&bytes[..2 * BLOCK_BYTES]);
    let at = |key: &str| text.find(key).unwrap();
    let mut damaged = bytes.clone();
    damaged[at("NAXIS2  =") + 10..][..20].copy_from_slice(b" 9999999999999999999");
    // The second NAXIS card, that of the table, now claims that there is no data.
    let naxis = BLOCK_BYTES + text[BLOCK_BYTES..].find("NAXIS   =").unwrap();
    damaged[naxis + 29] = b'0';
    std::fs::write(&file.path, &damaged).unwrap();
    let refused = read_table(&file.path, None).map(drop);
    let text = refused.unwrap_err().to_string();
    assert!(text.contains("NAXIS"), "{text}");
}

#[test]
fn every_truncation_is_an_error() {
    let file = written(&[table()]);
    let bytes = std::fs::read(&file.path).unwrap();
    for length in 0..bytes.len() {
        if length % 7 != 0 && length % BLOCK_BYTES != 0 {
            continue;
        }
        std::fs::write(&file.path, &bytes[..length]).unwrap();
        let result = read_table(&file.path, None).map(drop);
        assert!(
            matches!(result, Err(ReadError::Malformed { .. })),
            "{length}: {result:?}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn damaged_bytes_never_panic(
        hits in proptest::collection::vec((0_usize..14_400, any::<u8>()), 1..20),
        digits in any::<bool>(),
    ) {
        let file = written(&[table()]);
        let mut bytes = std::fs::read(&file.path).unwrap();
        for (at, byte) in hits {
            let at = at % bytes.len();
            // Digits and letters in place of others keep the header parsable, and so reach deeper.
            bytes[at] = if digits { b"0123456789DKAPQX-'&"[usize::from(byte) % 19] } else { byte };
        }
        std::fs::write(&file.path, &bytes).unwrap();
        if let Ok(table) = read_table(&file.path, None) {
            let names: Vec<String> = table.columns().iter().map(|c| c.name.clone()).collect();
            for name in names {
                let _ = (table.numbers(&name), table.strings(&name));
            }
        }
    }
}
