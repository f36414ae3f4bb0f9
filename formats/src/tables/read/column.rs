//! Columns of a binary table: layout from the header, values from the rows.

use super::header::Header;

/// Where the columns stand in a row, and how many rows there are.
pub(super) struct Layout {
    pub(super) columns: Vec<Field>,
    pub(super) row_bytes: usize,
    pub(super) rows: usize,
}

/// One column's place and type.
pub(super) struct Field {
    pub(super) name: String,
    pub(super) unit: Option<String>,
    offset: usize,
    kind: Kind,
    scale: f64,
    zero: f64,
    null: Option<i64>,
}

/// `TFORMn`, as far as it holds one value a row (FITS 4.0 table 18).
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Logical,
    U8,
    I16,
    I32,
    I64,
    F32,
    F64,
    Str(usize),
    /// Arrays, bits, complex numbers, heap descriptors: that many bytes, not decoded.
    Other(usize),
}

/// What a column holds.
#[derive(Debug, Clone)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Strings(Vec<String>),
    NotRead,
}

impl Values {
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Numbers(_) => "numbers",
            Self::Strings(_) => "strings",
            Self::NotRead => "an array, complex, bit or empty column",
        }
    }
}

impl Layout {
    /// The layout, or what is wrong with it. The rows lie in the data unit, whose size the caller
    /// has checked against the file.
    pub(super) fn from_header(header: &Header) -> Result<Self, String> {
        let required = |key: &str| {
            let size = header.size(key)?.ok_or(format!("no {key}"))?;
            usize::try_from(size).map_err(|_| format!("{key} = {size} is too large"))
        };
        let (row_bytes, rows) = (required("NAXIS1")?, required("NAXIS2")?);
        let bytes = (row_bytes as u64).checked_mul(rows as u64);
        if bytes.is_none_or(|bytes| Some(bytes) > header.data_size().ok()) {
            return Err(
                "NAXIS1 x NAXIS2 exceeds the data unit; BITPIX, NAXIS or GCOUNT is wrong".into(),
            );
        }
        let n_columns = required("TFIELDS")?;
        if n_columns > 999 {
            return Err(format!("TFIELDS = {n_columns}: at most 999 are allowed"));
        }
        let mut offset = 0_usize;
        let mut columns = Vec::new();
        for n in 1..=n_columns {
            let field = Field::from_header(header, n, offset)?;
            offset = offset
                .checked_add(field.kind.width())
                .filter(|&end| end <= row_bytes)
                .ok_or(format!(
                    "column {n} {}: ends behind NAXIS1 = {row_bytes}",
                    field.name
                ))?;
            columns.push(field);
        }
        Ok(Self {
            columns,
            row_bytes,
            rows,
        })
    }
}

impl Field {
    fn from_header(header: &Header, n: usize, offset: usize) -> Result<Self, String> {
        let get = |key: &str| header.get(&format!("{key}{n}"));
        let form = get("TFORM").ok_or(format!("no TFORM{n}"))?;
        let number = |key: &str, default: f64| match get(key) {
            None => Ok(default),
            Some(text) => (text.replace(['D', 'd'], "E").parse())
                .map_err(|_| format!("{key}{n} = {text}: not a number")),
        };
        Ok(Self {
            name: get("TTYPE").unwrap_or_default().to_owned(),
            unit: get("TUNIT").filter(|u| !u.is_empty()).map(str::to_owned),
            offset,
            kind: Kind::parse(form).ok_or(format!("TFORM{n} = {form:?} is no column format"))?,
            scale: number("TSCAL", 1.0)?,
            zero: number("TZERO", 0.0)?,
            null: get("TNULL").and_then(|text| text.parse().ok()),
        })
    }

    /// The values in `bytes`, rows of `row_bytes` each, which hold this field.
    pub(super) fn decode(&self, bytes: &[u8], row_bytes: usize) -> Values {
        // A column without width has no rows worth counting, however many the header claims.
        if self.kind.width() == 0 || matches!(self.kind, Kind::Other(_)) {
            return Values::NotRead;
        }
        let cells = bytes
            .chunks_exact(row_bytes)
            .map(|row| &row[self.offset..self.offset + self.kind.width()]);
        match self.kind {
            Kind::Str(_) => Values::Strings(cells.map(text).collect()),
            _ => Values::Numbers(cells.map(|cell| self.number(cell)).collect()),
        }
    }

    fn number(&self, cell: &[u8]) -> f64 {
        let integer = match self.kind {
            Kind::Logical => {
                return match cell[0] {
                    b'T' => 1.0,
                    b'F' => 0.0,
                    _ => f64::NAN,
                };
            }
            Kind::F32 => return self.scaled(f32::from_be_bytes(array(cell)).into()),
            Kind::F64 => return self.scaled(f64::from_be_bytes(array(cell))),
            Kind::U8 => cell[0].into(),
            Kind::I16 => i16::from_be_bytes(array(cell)).into(),
            Kind::I32 => i32::from_be_bytes(array(cell)).into(),
            Kind::I64 | Kind::Str(_) | Kind::Other(_) => i64::from_be_bytes(array(cell)),
        };
        if self.null == Some(integer) {
            return f64::NAN;
        }
        self.scaled(integer as f64)
    }

    fn scaled(&self, value: f64) -> f64 {
        value * self.scale + self.zero
    }
}

impl Kind {
    fn parse(form: &str) -> Option<Self> {
        let form = form.trim();
        let digits = form.find(|c: char| !c.is_ascii_digit())?;
        let repeat: usize = match &form[..digits] {
            "" => 1,
            number => number.parse().ok()?,
        };
        let single = |kind: Self| match repeat {
            1 => Some(kind),
            _ => Some(Self::Other(repeat.checked_mul(kind.width())?)),
        };
        match form[digits..].chars().next()? {
            'L' => single(Self::Logical),
            'B' => single(Self::U8),
            'I' => single(Self::I16),
            'J' => single(Self::I32),
            'K' => single(Self::I64),
            'E' => single(Self::F32),
            'D' => single(Self::F64),
            'A' => Some(Self::Str(repeat)),
            'X' => Some(Self::Other(repeat.div_ceil(8))),
            'C' | 'P' => Some(Self::Other(repeat.checked_mul(8)?)),
            'M' | 'Q' => Some(Self::Other(repeat.checked_mul(16)?)),
            _ => None,
        }
    }

    /// Bytes in a row.
    fn width(self) -> usize {
        match self {
            Self::Logical | Self::U8 => 1,
            Self::I16 => 2,
            Self::I32 | Self::F32 => 4,
            Self::I64 | Self::F64 => 8,
            Self::Str(n) | Self::Other(n) => n,
        }
    }
}

/// The first N bytes; zeros where the cell is shorter.
fn array<const N: usize>(cell: &[u8]) -> [u8; N] {
    let mut array = [0; N];
    for (to, from) in array.iter_mut().zip(cell) {
        *to = *from;
    }
    array
}

/// A string: up to the first NUL, without trailing spaces.
fn text(cell: &[u8]) -> String {
    let end = cell.iter().position(|&b| b == 0).unwrap_or(cell.len());
    String::from_utf8_lossy(&cell[..end]).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognised_with_their_width() {
        for (form, kind) in [
            ("D", Kind::F64),
            ("1E", Kind::F32),
            ("12A", Kind::Str(12)),
            ("12A4", Kind::Str(12)),
            ("3D", Kind::Other(24)),
            ("0J", Kind::Other(0)),
            ("9X", Kind::Other(2)),
            ("1PE(7)", Kind::Other(8)),
            ("1QD(7)", Kind::Other(16)),
        ] {
            assert_eq!(Kind::parse(form), Some(kind), "{form}");
        }
        for bad in [
            "",
            "7",
            "Z",
            "99999999999999999999D",
            "18446744073709551615D",
        ] {
            assert_eq!(Kind::parse(bad), None, "{bad}");
        }
    }

    #[test]
    fn scaling_and_nulls_are_applied() {
        let field = Field {
            name: "X".into(),
            unit: None,
            offset: 1,
            kind: Kind::I16,
            scale: 0.5,
            zero: 32768.0,
            null: Some(-1),
        };
        let rows = [9, 0, 4, 9, 0xff, 0xff]; // Two rows of three bytes: 4 and null.
        let Values::Numbers(values) = field.decode(&rows, 3) else {
            panic!("numbers expected");
        };
        assert!(values[0] == 32770.0 && values[1].is_nan());
    }
}
