//! Reading tables of dishes with a header line.

use std::collections::HashSet;
use std::path::Path;

use csv::StringRecord;

use super::Dish;
use crate::simulate::SimulateError;

/// Distances from the Earth's centre that a dish may have [m].
const EARTH_RADIUS_M: std::ops::RangeInclusive<f64> = 6.3e6..=6.4e6;

/// A row of a table with its header.
pub(super) struct Row<'a> {
    path: &'a Path,
    header: &'a StringRecord,
    record: &'a StringRecord,
}

impl<'a> Row<'a> {
    /// The text in `column`; `None` where the table has no such column or the field is empty.
    pub(super) fn text(&self, column: &str) -> Option<&'a str> {
        let index = self.header.iter().position(|name| name == column)?;
        self.record.get(index).filter(|text| !text.is_empty())
    }

    fn required(&self, column: &str) -> Result<&'a str, SimulateError> {
        self.text(column)
            .ok_or_else(|| self.malformed(column, "empty"))
    }

    fn number(&self, column: &str) -> Result<Option<f64>, SimulateError> {
        let Some(text) = self.text(column) else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.malformed(column, &format!("expected a number, found \"{text}\""))),
        }
    }

    fn required_number(&self, column: &str) -> Result<f64, SimulateError> {
        self.required(column)?;
        Ok(self.number(column)?.unwrap_or_default())
    }

    fn positive(&self, column: &str) -> Result<Option<f64>, SimulateError> {
        let value = self.number(column)?;
        match value {
            Some(value) if value <= 0.0 => Err(self.malformed(
                column,
                &format!("expected a number above zero, found {value}"),
            )),
            _ => Ok(value),
        }
    }

    fn malformed(&self, column: &str, what: &str) -> SimulateError {
        let line = self.record.position().map_or(0, csv::Position::line);
        SimulateError::Malformed {
            path: self.path.to_owned(),
            place: format!("line {line}, column {column}"),
            what: what.to_owned(),
        }
    }

    fn dish(&self) -> Result<Dish, SimulateError> {
        let dish = Dish {
            name: self.required("name")?.to_owned(),
            itrf_m: [
                self.required_number("x_m")?,
                self.required_number("y_m")?,
                self.required_number("z_m")?,
            ],
            diameter_m: self.positive("diameter_m")?,
            sefd_jy: self.positive("sefd_jy")?,
        };
        let radius_m = dish.itrf_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !EARTH_RADIUS_M.contains(&radius_m) {
            return Err(self.malformed(
                "x_m, y_m, z_m",
                &format!(
                    "expected geocentric ITRF metres, found a place {radius_m:.0} m from the Earth's \
                     centre; local east-north-up offsets must be converted first"
                ),
            ));
        }
        Ok(dish)
    }
}

/// The dishes of the table `bytes` whose row `keep` accepts; `path` is for error messages.
pub(super) fn read(
    bytes: &[u8],
    path: &Path,
    keep: impl Fn(&Row) -> bool,
) -> Result<Vec<Dish>, SimulateError> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(bytes);
    let header = reader
        .headers()
        .map_err(|error| csv_error(path, &error))?
        .clone();
    for column in ["name", "x_m", "y_m", "z_m"] {
        if !header.iter().any(|name| name == column) {
            return Err(missing_column(path, column, &header));
        }
    }
    let mut dishes = Vec::new();
    let mut names = HashSet::new();
    for record in reader.records() {
        let record = record.map_err(|error| csv_error(path, &error))?;
        let row = Row {
            path,
            header: &header,
            record: &record,
        };
        if keep(&row) {
            let dish = row.dish()?;
            if !names.insert(dish.name.clone()) {
                return Err(row.malformed("name", &format!("\"{}\" stands twice", dish.name)));
            }
            dishes.push(dish);
        }
    }
    if dishes.len() < 2 {
        return Err(SimulateError::Malformed {
            path: path.to_owned(),
            place: "table".to_owned(),
            what: format!("expected two dishes or more, found {}", dishes.len()),
        });
    }
    Ok(dishes)
}

fn missing_column(path: &Path, column: &str, header: &StringRecord) -> SimulateError {
    let found = header.iter().collect::<Vec<_>>().join(", ");
    SimulateError::Malformed {
        path: path.to_owned(),
        place: "header line".to_owned(),
        what: format!("expected the columns name, x_m, y_m, z_m; {column} is missing from {found}"),
    }
}

fn csv_error(path: &Path, error: &csv::Error) -> SimulateError {
    let line = error.position().map_or(0, csv::Position::line);
    let what = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!("expected {expected_len} fields, found {len}"),
        csv::ErrorKind::Utf8 { .. } => "not UTF-8 text".to_owned(),
        _ => error.to_string(),
    };
    SimulateError::Malformed {
        path: path.to_owned(),
        place: format!("line {line}"),
        what,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "name,x_m,y_m,z_m,diameter_m\n";
    const GOOD: &str = "A,5109272.0,2006809.1,-3239131.1,13.5\n";

    fn message(table: &str) -> String {
        read(table.as_bytes(), Path::new("t.csv"), |_| true)
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn columns_may_stand_in_any_order_beside_others() {
        let table = "# ours\nz_m, name, u_m, x_m, y_m\n-3239131.1, A, 0, 5109272.0, 2006809.1\n\
                     -3239100.2, B, 0, 5109284.9, 2006824.3\n";
        let dishes = read(table.as_bytes(), Path::new("t.csv"), |_| true).unwrap();
        assert_eq!(dishes.len(), 2);
        assert_eq!(dishes[1].name, "B");
        assert_eq!(dishes[1].itrf_m, [5109284.9, 2006824.3, -3239100.2]);
        assert_eq!(dishes[1].diameter_m, None);
    }

    #[test]
    fn errors_name_line_and_column() {
        let bad_number = format!("{HEAD}{GOOD}B,5109284.9,east,-3239100.2,13.5\n");
        assert_eq!(
            message(&bad_number),
            "t.csv: line 3, column y_m: expected a number, found \"east\""
        );
        let short = format!("{HEAD}{GOOD}B,5109284.9\n");
        assert_eq!(message(&short), "t.csv: line 3: expected 5 fields, found 2");
        let twice = format!("{HEAD}{GOOD}{GOOD}");
        assert_eq!(
            message(&twice),
            "t.csv: line 3, column name: \"A\" stands twice"
        );
        let empty = format!("{HEAD}{GOOD}B,,2006824.3,-3239100.2,13.5\n");
        assert_eq!(message(&empty), "t.csv: line 3, column x_m: empty");
        let flat = format!("{HEAD}{GOOD}B,5109284.9,2006824.3,-3239100.2,0\n");
        assert!(message(&flat).contains("column diameter_m: expected a number above zero"));
    }

    #[test]
    fn local_offsets_are_not_taken_for_geocentric_positions() {
        let local = format!("{HEAD}A,-8.264,-207.29,8.5965,13.5\n");
        assert!(message(&local).contains("geocentric ITRF"));
    }

    #[test]
    fn a_table_without_a_column_or_dishes_is_an_error() {
        assert!(message("name,x_m,y_m\n").contains("z_m is missing from name, x_m, y_m"));
        assert!(message("").contains("header line"));
        assert!(message(&format!("{HEAD}{GOOD}")).contains("two dishes or more, found 1"));
    }
}
