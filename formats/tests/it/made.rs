//! UVFITS files made by hand, card by card, for the dialects that other writers speak.

use std::path::PathBuf;

use vis2cat_formats::{Observation, ReadError, VisChunk};

use crate::support::read;

/// A file under construction.
#[derive(Clone)]
pub(crate) struct Made {
    pub(crate) bitpix: i64,
    /// Name, length, value, step, reference pixel.
    pub(crate) axes: Vec<(&'static str, usize, f64, f64, f64)>,
    /// Name, scale, zero.
    pub(crate) parameters: Vec<(&'static str, f64, f64)>,
    /// Parameters and data of each group, as raw numbers.
    pub(crate) groups: Vec<Vec<f64>>,
    /// More cards of the primary header, as written.
    pub(crate) cards: Vec<String>,
    /// Extension HDUs.
    pub(crate) tables: Vec<MadeTable>,
}

/// A binary table under construction.
#[derive(Clone)]
pub(crate) struct MadeTable {
    pub(crate) name: &'static str,
    /// Name and format.
    pub(crate) columns: Vec<(&'static str, &'static str)>,
    pub(crate) rows: Vec<Vec<u8>>,
    pub(crate) cards: Vec<String>,
}

impl Default for Made {
    /// One group: antennas 1 and 2, two channels, one hand, with its weight.
    fn default() -> Self {
        Self {
            bitpix: -32,
            axes: vec![
                ("COMPLEX", 3, 1.0, 1.0, 1.0),
                ("STOKES", 1, -5.0, -1.0, 1.0),
                ("FREQ", 2, 1e9, 1e6, 1.0),
                ("RA", 1, 10.0, 1.0, 1.0),
                ("DEC", 1, -30.0, 1.0, 1.0),
            ],
            parameters: vec![
                ("UU", 1.0, 0.0),
                ("VV", 1.0, 0.0),
                ("WW", 1.0, 0.0),
                ("BASELINE", 1.0, 0.0),
                ("DATE", 1.0, 2_460_000.5),
            ],
            groups: vec![vec![
                1e-6, 2e-6, 3e-6, 258.0, 0.25, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0,
            ]],
            cards: vec![number("EPOCH", 2000.0)],
            tables: vec![antennas(&[1, 2, 3])],
        }
    }
}

/// A card with a number.
pub(crate) fn number(key: &str, value: f64) -> String {
    format!("{key:<8}= {value:>20?}").replace('e', "E")
}

/// A card with a text.
pub(crate) fn text(key: &str, value: &str) -> String {
    format!("{key:<8}= '{value:<8}'")
}

/// An antenna table with geocentric positions (1000 n, 10 n, n) m.
pub(crate) fn antennas(numbers: &[i32]) -> MadeTable {
    let row = |&n: &i32| {
        let mut row = format!("A{n:<7}").into_bytes();
        for factor in [1000.0, 10.0, 1.0] {
            row.extend((factor * f64::from(n)).to_be_bytes());
        }
        row.extend(n.to_be_bytes());
        row
    };
    MadeTable {
        name: "AIPS AN",
        columns: vec![("ANNAME", "8A"), ("STABXYZ", "3D"), ("NOSTA", "1J")],
        rows: numbers.iter().map(row).collect(),
        cards: Vec::new(),
    }
}

/// An FQ table of one IF with rows of (FRQSEL, IF FREQ, CH WIDTH, SIDEBAND).
pub(crate) fn frequencies(rows: &[(i32, f64, f32, i32)]) -> MadeTable {
    let row = |r: &(i32, f64, f32, i32)| {
        let mut row = r.0.to_be_bytes().to_vec();
        row.extend(r.1.to_be_bytes());
        row.extend(r.2.to_be_bytes());
        row.extend(r.3.to_be_bytes());
        row
    };
    MadeTable {
        name: "AIPS FQ",
        columns: vec![
            ("FRQSEL", "1J"),
            ("IF FREQ", "D"),
            ("CH WIDTH", "1E"),
            ("SIDEBAND", "1J"),
        ],
        rows: rows.iter().map(row).collect(),
        cards: Vec::new(),
    }
}

impl Made {
    /// Reads what has been made.
    pub(crate) fn read(&self) -> Result<(Observation, VisChunk), ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path: PathBuf = folder.path().join("made.uvfits");
        std::fs::write(&path, self.bytes()).unwrap();
        read(&path, 3)
    }

    /// The file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut cards = vec!["SIMPLE  =                    T".to_owned()];
        cards.push(integer("BITPIX", self.bitpix));
        cards.push(integer("NAXIS", self.axes.len() as i64 + 1));
        cards.push(integer("NAXIS1", 0));
        for (i, axis) in (2..).zip(&self.axes) {
            cards.push(integer(&format!("NAXIS{i}"), axis.1 as i64));
        }
        cards.push("GROUPS  =                    T".to_owned());
        cards.push(integer("PCOUNT", self.parameters.len() as i64));
        cards.push(integer("GCOUNT", self.groups.len() as i64));
        for (i, (name, _, value, step, pixel)) in (2..).zip(&self.axes) {
            cards.push(text(&format!("CTYPE{i}"), name));
            cards.push(number(&format!("CRVAL{i}"), *value));
            cards.push(number(&format!("CDELT{i}"), *step));
            cards.push(number(&format!("CRPIX{i}"), *pixel));
        }
        for (i, (name, scale, zero)) in (1..).zip(&self.parameters) {
            cards.push(text(&format!("PTYPE{i}"), name));
            cards.push(number(&format!("PSCAL{i}"), *scale));
            cards.push(number(&format!("PZERO{i}"), *zero));
        }
        cards.extend(self.cards.iter().cloned());
        let mut bytes = header(&cards);
        for &value in self.groups.iter().flatten() {
            match self.bitpix {
                8 => bytes.push(value as u8),
                16 => bytes.extend((value as i16).to_be_bytes()),
                32 => bytes.extend((value as i32).to_be_bytes()),
                -32 => bytes.extend((value as f32).to_be_bytes()),
                _ => bytes.extend(value.to_be_bytes()),
            }
        }
        pad(&mut bytes, 0);
        self.tables
            .iter()
            .for_each(|table| bytes.extend(table.bytes()));
        bytes
    }
}

impl MadeTable {
    fn bytes(&self) -> Vec<u8> {
        let mut cards = vec![
            text("XTENSION", "BINTABLE"),
            integer("BITPIX", 8),
            integer("NAXIS", 2),
        ];
        cards.push(integer(
            "NAXIS1",
            self.rows.first().map_or(0, Vec::len) as i64,
        ));
        cards.push(integer("NAXIS2", self.rows.len() as i64));
        cards.extend([integer("PCOUNT", 0), integer("GCOUNT", 1)]);
        cards.push(integer("TFIELDS", self.columns.len() as i64));
        for (i, (name, form)) in (1..).zip(&self.columns) {
            cards.push(text(&format!("TTYPE{i}"), name));
            cards.push(text(&format!("TFORM{i}"), form));
        }
        cards.push(text("EXTNAME", self.name));
        cards.extend(self.cards.iter().cloned());
        let mut bytes = header(&cards);
        bytes.extend(self.rows.concat());
        pad(&mut bytes, 0);
        bytes
    }
}

fn integer(key: &str, value: i64) -> String {
    format!("{key:<8}= {value:>20}")
}

fn header(cards: &[String]) -> Vec<u8> {
    let mut bytes: Vec<u8> = cards
        .iter()
        .flat_map(|card| format!("{card:<80}").into_bytes())
        .collect();
    bytes.extend(format!("{:<80}", "END").into_bytes());
    pad(&mut bytes, b' ');
    bytes
}

fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().next_multiple_of(2880), with);
}
