//! Tables that are made of others: some rows of one, or all of several.

use std::path::{Path, PathBuf};

use super::keywords;
use super::stream::Stream;
use super::types::TEXT;

/// The name of the table of which this has some rows, in any order.
pub(super) fn selection(stream: &mut Stream, n_row: u64) -> Result<String, String> {
    let version = stream.object()?.version;
    let is_wide = version > 2;
    let name = stream.text()?;
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
        None => Ok(name),
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

/// The names of tables after one another.
pub(super) fn concatenation(stream: &mut Stream) -> Result<Vec<String>, String> {
    stream.object()?;
    let names = texts(stream)?;
    // Those of their subtables that are put together, too.
    stream.object()?;
    texts(stream)?;
    Ok(names)
}

fn texts(stream: &mut Stream) -> Result<Vec<String>, String> {
    let n = stream.u32()?;
    (0..n).map(|_| stream.text()).collect()
}

/// Where a table is that another calls by a name: beside that if the name begins with `./`, and in it if that is
/// there twice.
pub(super) fn place(folder: &Path, name: &str) -> PathBuf {
    let mut rest = name;
    let mut n_dot = 0;
    while let Some(shorter) = rest.strip_prefix("./") {
        (rest, n_dot) = (shorter, n_dot + 1);
    }
    match (n_dot, folder.parent()) {
        (0, _) => name.into(),
        (1, Some(beside)) => beside.join(rest),
        _ => folder.join(rest),
    }
}

#[cfg(test)]
mod tests {
    use super::super::stream::made::{numbers, object, text};
    use super::*;

    /// Rows of a table of 30, without a list of its columns.
    fn made(rows: &[u32]) -> Vec<u8> {
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
    fn another_table_is_beside_this_or_in_it() {
        let place = |name| place(Path::new("/data/part.ms"), name);
        assert_eq!(place("./whole.ms"), Path::new("/data/whole.ms"));
        assert_eq!(place("././whole.ms"), Path::new("/data/part.ms/whole.ms"));
        assert_eq!(place("/old/whole.ms"), Path::new("/old/whole.ms"));
    }

    #[test]
    fn the_rows_of_another_table_must_be_there() {
        let check = |bytes: &[u8], n| selection(&mut Stream::new(bytes, true), n);
        assert_eq!(check(&made(&[29, 3]), 2).unwrap(), "./whole.ms");
        assert!(check(&made(&[29, 3]), 1).unwrap_err().contains("lists 2"));
        let error = check(&made(&[30, 3]), 2).unwrap_err();
        assert!(
            error.contains("row 30 of another table, which has 30"),
            "{error}"
        );
        let short = made(&[29, 3]);
        assert!(check(&short[..short.len() - 1], 2).is_err());
    }
}
