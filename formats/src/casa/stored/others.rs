//! Tables that are made of others: some rows of one, or all of several.

use super::keywords;
use super::stream::Stream;
use super::types::TEXT;

/// Rows of another table, in any order.
pub(super) fn check_selection(stream: &mut Stream, n_row: u64) -> Result<(), String> {
    let version = stream.object()?.version;
    let is_wide = version > 2;
    // The name of the other.
    stream.text()?;
    names(stream)?;
    if version > 1 {
        keywords::array(stream, TEXT)?;
    }
    let n_there = stream.grown(is_wide)?;
    stream.byte()?;
    let n = stream.grown(is_wide)?;
    if n != n_row {
        return Err(format!("has {n_row} rows, of which it lists {n}"));
    }
    let rows = stream.numbers(usize::try_from(n).unwrap_or(usize::MAX), is_wide)?;
    // casacore sees whether the other has that many.
    match rows.into_iter().find(|&row| row >= n_there) {
        Some(row) => Err(format!(
            "has row {row} of another table, which has {n_there}"
        )),
        None => Ok(()),
    }
}

/// What columns are called, here and in the other: an ordered map.
fn names(stream: &mut Stream) -> Result<(), String> {
    stream.object()?;
    stream.text()?;
    let n = stream.u32()?;
    stream.u32()?;
    (0..n).try_for_each(|_| stream.text().and_then(|_| stream.text()).map(drop))
}

/// Tables after one another.
pub(super) fn check_concatenation(stream: &mut Stream) -> Result<(), String> {
    stream.object()?;
    let n = stream.u32()?;
    (0..n).try_for_each(|_| stream.text().map(drop))?;
    // Those of their subtables that are put together, too.
    stream.object()?;
    let n = stream.u32()?;
    (0..n).try_for_each(|_| stream.text().map(drop))
}

#[cfg(test)]
mod tests {
    use super::super::stream::made::{numbers, object, text};
    use super::*;

    /// Rows of a table of 30, without a list of its columns.
    fn selection(rows: &[u32]) -> Vec<u8> {
        let pair = [text("UVW"), text("UVW")].concat();
        let map = [text(""), numbers(&[1, 1]), pair].concat();
        let names = [numbers(&[1, 0, 1, 1]), text("UVW")].concat();
        let inside = [
            text("./whole.ms"),
            object("SimpleOrderedMap", &map),
            object("Array", &names),
            numbers(&[30]),
            vec![1],
            numbers(&[rows.len() as u32]),
            numbers(rows),
        ];
        object("RefTable", &inside.concat())
    }

    #[test]
    fn the_rows_of_another_table_must_be_there() {
        let check = |bytes: &[u8], n| check_selection(&mut Stream::new(bytes, true), n);
        assert_eq!(check(&selection(&[29, 3]), 2), Ok(()));
        assert!(
            check(&selection(&[29, 3]), 1)
                .unwrap_err()
                .contains("lists 2")
        );
        let error = check(&selection(&[30, 3]), 2).unwrap_err();
        assert!(
            error.contains("row 30 of another table, which has 30"),
            "{error}"
        );
        let short = selection(&[29, 3]);
        assert!(check(&short[..short.len() - 1], 2).is_err());
    }
}
