//! Keywords of tables, columns and storage managers: values, arrays of them, and records of more.

use super::stream::Stream;
use super::types::{RECORD, TABLE, TEXT, bits, element};

/// Records in records; those of Measurement Sets are two deep.
const MAX_DEPTH: usize = 64;

/// A keyword, or what is in a record among them.
enum Field {
    /// The code of its type.
    Value(u32),
    /// One that is described where it is described itself; if not, its values are where it is.
    Record(Vec<Field>),
}

/// Passes over keywords, all of which must be there.
pub(super) fn pass(stream: &mut Stream) -> Result<(), String> {
    record(stream, 0).map_err(|what| format!("keywords: {what}"))
}

fn record(stream: &mut Stream, depth: usize) -> Result<(), String> {
    let object = stream.object()?;
    // Those of old tables are of other classes.
    if ["TableRecord", "Record"].contains(&object.name.as_str()) {
        let fields = description(stream, depth)?;
        stream.u32()?;
        values(stream, &fields, depth)?;
    }
    stream.leave(&object);
    Ok(())
}

fn description(stream: &mut Stream, depth: usize) -> Result<Vec<Field>, String> {
    if depth > MAX_DEPTH {
        return Err(format!(
            "records are in records, more than {MAX_DEPTH} deep"
        ));
    }
    let has_comments = stream.object()?.version > 1;
    let mut fields = Vec::new();
    for _ in 0..stream.u32()? {
        stream.text()?;
        let code = stream.u32()?;
        fields.push(match code {
            RECORD => Field::Record(description(stream, depth + 1)?),
            code => Field::Value(code),
        });
        if code == TABLE {
            stream.text()?;
        } else if element(code).is_some() {
            stream.shape()?;
        }
        if has_comments {
            stream.text()?;
        }
    }
    Ok(fields)
}

fn values(stream: &mut Stream, fields: &[Field], depth: usize) -> Result<(), String> {
    for field in fields {
        match field {
            Field::Record(fields) if fields.is_empty() => record(stream, depth + 1)?,
            Field::Record(fields) => values(stream, fields, depth)?,
            &Field::Value(TEXT | TABLE) => drop(stream.text()?),
            &Field::Value(code) => match (bits(code), element(code)) {
                (Some(bits), _) => stream.pass(bits.div_ceil(8))?,
                (None, Some(element)) => array(stream, element)?,
                (None, None) => return Err(format!("one is of type {code}, which is not known")),
            },
        }
    }
    Ok(())
}

/// Passes over an array of values of a type.
pub(super) fn array(stream: &mut Stream, element: u32) -> Result<(), String> {
    let has_origin = stream.object()?.version < 3;
    let n_axis = stream.u32()?;
    if has_origin {
        stream.pass(4 * u64::from(n_axis))?;
    }
    let mut n_value = 1u64;
    for _ in 0..n_axis {
        n_value = n_value.saturating_mul(stream.u32()?.into());
    }
    // An array without axes has no values.
    let n_value = if n_axis == 0 { 0 } else { n_value };
    let n_there = stream.u32()?;
    if u64::from(n_there) != n_value {
        return Err(format!(
            "an array has {n_there} values, its shape {n_value}"
        ));
    }
    match bits(element) {
        Some(bits) => stream.pass(n_value.saturating_mul(bits).div_ceil(8)),
        None => (0..n_there).try_for_each(|_| stream.text().map(drop)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::stream::made::{numbers, object, text};
    use super::*;

    /// A text, and an array of two texts with an origin.
    fn keywords(shape: u32, length: u32) -> Vec<u8> {
        let shape_said = object("IPosition", &numbers(&[1, 0, 2]));
        let described = [
            numbers(&[2]),
            [text("UNIT"), numbers(&[TEXT]), text("")].concat(),
            [text("UNITS"), numbers(&[24]), shape_said, text("")].concat(),
        ];
        let array = [
            numbers(&[1, 0, shape, 2]),
            text("m"),
            numbers(&[length]),
            b"rad".to_vec(),
        ];
        let inside = [
            object("RecordDesc", &described.concat()),
            numbers(&[0]),
            text("Hz"),
            object("Array", &array.concat()),
        ];
        object("TableRecord", &inside.concat())
    }

    #[test]
    fn keywords_must_be_there() {
        let pass = |bytes: &[u8]| pass(&mut Stream::new(bytes, true));
        assert_eq!(pass(&keywords(2, 3)), Ok(()));
        assert!(pass(&keywords(2, 4)).unwrap_err().contains("truncated"));
        let error = pass(&keywords(1 << 30, 3)).unwrap_err();
        assert!(error.contains("2 values, its shape 1073741824"), "{error}");
    }

    #[test]
    fn records_are_not_nested_without_end() {
        let mut inner = object("RecordDesc", &numbers(&[0]));
        for _ in 0..=MAX_DEPTH {
            let field = [
                numbers(&[1]),
                text("A"),
                numbers(&[RECORD]),
                inner,
                text(""),
            ];
            inner = object("RecordDesc", &field.concat());
        }
        let record = object("TableRecord", &inner);
        let error = pass(&mut Stream::new(&record, true)).unwrap_err();
        assert!(error.contains("64 deep"), "{error}");
    }
}
