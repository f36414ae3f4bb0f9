//! The structure of a file: every header read, every size proved against the file's length.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::card::parse;
use super::header::{Header, Place};
use super::tform::Tform;
use super::{BLOCK_BYTES, CARD_BYTES, padded};
use crate::ReadError;

/// Most blocks in one header: 36 million cards would be no header.
const MAX_HEADER_BLOCKS: usize = 20_000;
/// Most axes and columns that the standard allows.
const MAX_COUNT: u64 = 999;

/// One header-data unit.
#[derive(Debug)]
pub(crate) struct Hdu {
    /// Its header.
    pub(crate) header: Header,
    /// First byte of the data.
    pub(crate) data_offset: u64,
    /// Bytes of data, without padding.
    pub(crate) data_bytes: u64,
    /// NAXIS1 and on; empty where NAXIS = 0.
    pub(crate) axes: Vec<u64>,
}

impl Hdu {
    /// Whether this is an extension of that name.
    pub(crate) fn is_named(&self, name: &str) -> bool {
        self.header
            .text("EXTNAME")
            .is_some_and(|n| n.eq_ignore_ascii_case(name))
    }
}

/// Walks all HDUs of a file.
///
/// # Errors
/// The file is no FITS, a header is wrong, or an HDU is longer than the file.
pub(crate) fn scan(path: &Path, file: &mut File) -> Result<Vec<Hdu>, ReadError> {
    let whole = Place::file(path);
    let file_bytes = file.metadata().map_err(|e| whole.io(e))?.len();
    let mut hdus: Vec<Hdu> = Vec::new();
    let mut offset = 0;
    while offset < file_bytes {
        // Bytes after the last HDU that start no extension are "special records" (section 3.5).
        if !hdus.is_empty() && !starts_extension(&whole, file, offset)? {
            break;
        }
        let hdu = read_hdu(&whole, file, offset, hdus.len())?;
        offset = end_of(&hdu, file_bytes)?;
        hdus.push(hdu);
    }
    if hdus.is_empty() {
        return Err(whole.malformed("", "is empty"));
    }
    Ok(hdus)
}

/// Whether the block at `offset` starts with (the visible part of) `XTENSION`.
fn starts_extension(whole: &Place, file: &mut File, offset: u64) -> Result<bool, ReadError> {
    let mut start = Vec::new();
    file.seek(SeekFrom::Start(offset))
        .map_err(|e| whole.io(e))?;
    file.by_ref()
        .take(8)
        .read_to_end(&mut start)
        .map_err(|e| whole.io(e))?;
    Ok(b"XTENSION".starts_with(&start))
}

/// First byte after the padded data, which must be inside the file.
fn end_of(hdu: &Hdu, file_bytes: u64) -> Result<u64, ReadError> {
    let end = padded(hdu.data_bytes).and_then(|bytes| hdu.data_offset.checked_add(bytes));
    match end {
        Some(end) if end <= file_bytes => Ok(end),
        _ => Err(hdu.header.place.malformed(
            "data",
            format!(
                "the header announces {} bytes of data (padded to blocks of {BLOCK_BYTES}), the \
                 file has {} left: it is truncated or the header is wrong",
                hdu.data_bytes,
                file_bytes - hdu.data_offset
            ),
        )),
    }
}

/// Reads the header at `offset` and works out its data's size.
fn read_hdu(whole: &Place, file: &mut File, offset: u64, index: usize) -> Result<Hdu, ReadError> {
    file.seek(SeekFrom::Start(offset))
        .map_err(|e| whole.io(e))?;
    let mut header = Header::new(Place {
        path: whole.path.clone(),
        hdu: if index == 0 {
            "primary HDU".into()
        } else {
            format!("HDU {index}")
        },
    });
    let blocks = read_header(file, &mut header, index == 0)?;
    if let (true, Some(name)) = (index > 0, header.text("EXTNAME")) {
        header.place.hdu = format!("HDU {index} ({name})");
    }
    let axes = read_axes(&header)?;
    let data_bytes = data_bytes(&header, &axes, index)?;
    Ok(Hdu {
        data_offset: offset + (blocks * BLOCK_BYTES) as u64,
        data_bytes,
        axes,
        header,
    })
}

/// Reads blocks up to the END card; returns how many.
fn read_header(file: &mut File, header: &mut Header, primary: bool) -> Result<usize, ReadError> {
    let mut last = String::new();
    for n_block in 0..MAX_HEADER_BLOCKS {
        let mut block = [0u8; BLOCK_BYTES];
        if let Err(source) = file.read_exact(&mut block) {
            return Err(match source.kind() {
                std::io::ErrorKind::UnexpectedEof => header
                    .place
                    .malformed("header", "the file ends before the END card"),
                _ => header.place.io(source),
            });
        }
        let (cards, _) = block.as_chunks::<CARD_BYTES>();
        if n_block == 0 {
            let wanted = if primary { "SIMPLE" } else { "XTENSION" };
            if parse::keyword(&cards[0]) != wanted {
                let what = format!("does not start with {wanted}: this is no FITS file");
                return Err(header.place.malformed("header", what));
            }
        }
        for card in cards {
            match parse::keyword(card).as_str() {
                "END" => return Ok(n_block + 1),
                "XTENSION" if primary => {
                    let what = "an extension starts before the END card";
                    return Err(header.place.malformed("header", what));
                }
                "HISTORY" => header.history.push(parse::commentary(card)),
                "COMMENT" | "" => {}
                "CONTINUE" => {
                    if let Some(more) = parse::continuation(card) {
                        header.extend(&last, &more);
                    }
                }
                key => {
                    if let Some(value) = parse::value(card) {
                        header.insert(key.to_owned(), value);
                        key.clone_into(&mut last);
                    }
                }
            }
        }
    }
    Err(header.place.unsupported(
        "header",
        format!("is longer than {MAX_HEADER_BLOCKS} blocks"),
    ))
}

/// NAXIS and NAXISn.
fn read_axes(header: &Header) -> Result<Vec<u64>, ReadError> {
    header.once("NAXIS")?;
    let n_axis = header.need_count("NAXIS")?;
    if n_axis > MAX_COUNT {
        let what = format!("is {n_axis}, the standard allows {MAX_COUNT}");
        return Err(header.place.malformed("NAXIS", what));
    }
    let mut axes = Vec::new();
    for i in 1..=n_axis {
        let key = format!("NAXIS{i}");
        header.once(&key)?;
        axes.push(header.need_count(&key)?);
    }
    Ok(axes)
}

/// Bytes of data: |BITPIX|/8 · GCOUNT · (PCOUNT + product of the axes).
///
/// # Source
/// Standard, equations 2 (extensions) and 4 (random groups, where NAXIS1 = 0 is left out).
fn data_bytes(header: &Header, axes: &[u64], index: usize) -> Result<u64, ReadError> {
    for key in [
        "BITPIX", "PCOUNT", "GCOUNT", "GROUPS", "XTENSION", "TFIELDS",
    ] {
        header.once(key)?;
    }
    let bitpix = header
        .integer("BITPIX")?
        .ok_or_else(|| header.place.malformed("BITPIX", "keyword is missing"))?;
    if ![8, 16, 32, 64, -32, -64].contains(&bitpix) {
        return Err(header
            .place
            .malformed("BITPIX", format!("is {bitpix}, which no FITS data can be")));
    }
    let groups = index == 0 && header.logical("GROUPS") && axes.first() == Some(&0);
    if index > 0 && header.text("XTENSION") == Some("BINTABLE") {
        check_columns(header, axes)?;
    }
    let counted = groups || index > 0;
    let p_count = if counted {
        header.need_count("PCOUNT")?
    } else {
        0
    };
    let g_count = if counted {
        header.need_count("GCOUNT")?
    } else {
        1
    };
    let used = if groups { &axes[1..] } else { axes };
    let product = used
        .iter()
        .try_fold(1u64, |product, &n| product.checked_mul(n));
    let product = if axes.is_empty() { Some(0) } else { product };
    product
        .and_then(|values| values.checked_add(p_count))
        .and_then(|values| values.checked_mul(g_count))
        .and_then(|values| values.checked_mul(bitpix.unsigned_abs() / 8))
        .ok_or_else(|| {
            let what = "NAXISn, PCOUNT and GCOUNT multiply to more bytes than any file has";
            header.place.malformed("NAXIS", what)
        })
}

/// The columns of a binary table must add up to its row, or CFITSIO would read beside it.
fn check_columns(header: &Header, axes: &[u64]) -> Result<(), ReadError> {
    let place = &header.place;
    let &[row_bytes, _] = axes else {
        return Err(place.malformed("NAXIS", format!("a table has 2 axes, found {}", axes.len())));
    };
    let n_column = header.need_count("TFIELDS")?;
    if n_column > MAX_COUNT {
        return Err(place.malformed(
            "TFIELDS",
            format!("is {n_column}, at most {MAX_COUNT} can be"),
        ));
    }
    let mut sum = 0u64;
    for i in 1..=n_column {
        let key = format!("TFORM{i}");
        header.once(&key)?;
        header.once(&format!("TTYPE{i}"))?;
        let text = header
            .text(&key)
            .ok_or_else(|| place.malformed(&key, "keyword is missing"))?;
        let bytes = Tform::parse(text).and_then(Tform::bytes);
        sum = bytes
            .and_then(|bytes| sum.checked_add(bytes))
            .ok_or_else(|| {
                place.malformed(&key, format!("'{text}' is no format of a table column"))
            })?;
    }
    if sum != row_bytes {
        let what = format!("is {row_bytes}, but the columns add up to {sum} bytes a row");
        return Err(place.malformed("NAXIS1", what));
    }
    if header.integer("BITPIX")? != Some(8) || header.integer("GCOUNT")? != Some(1) {
        return Err(place.malformed("BITPIX", "a table must have BITPIX = 8 and GCOUNT = 1"));
    }
    Ok(())
}

/// Whether the header of an open file marks visibilities in a table, the AIPS `FITAB` form.
pub(crate) fn is_uv_table_form(hdu: &Hdu) -> bool {
    hdu.axes == [777_777_701, 0]
}
