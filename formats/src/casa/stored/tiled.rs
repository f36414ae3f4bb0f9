//! Headers of tiled storage managers.
//!
//! Cells of the same shape are put together to a hypercube, which is cut into tiles; rows are found by a
//! list of where each run of them ends and in which hypercube it is.

use std::path::Path;

use super::keywords;
use super::stream::Stream;

/// Most values of a tile: casacore counts its bytes in 32 bits, and writers make tiles of a megabyte or so.
const MAX_TILE: i64 = 1 << 27;
/// Most tiles of a hypercube in a file that has not even a byte for each.
const MAX_UNWRITTEN: u64 = 1 << 24;
/// Newest layout that is known.
const VERSION: u32 = 3;

/// Looks through the header of the manager whose file it is.
pub(super) fn check(header: &[u8], path: &Path) -> Result<(), String> {
    let mut stream = Stream::new(header, true);
    let kind = stream.outermost()?.name;
    // Those whose cells have one shape say first how they are cut.
    if ["TiledColumnStMan", "TiledCellStMan"].contains(&kind.as_str()) {
        stream.shape()?;
    }
    let manager = stream.object()?;
    if manager.name != "TiledStMan" {
        return Err(format!("has a {} where a TiledStMan must be", manager.name));
    }
    let version = manager.known(0..=VERSION)?;
    let is_wide = version >= 3;
    if version >= 2 {
        stream.byte()?;
    }
    stream.u32()?;
    stream.grown(is_wide)?;
    let n_column = stream.u32()?;
    for _ in 0..n_column {
        stream.u32()?;
    }
    stream.text()?;
    stream.u32()?;
    stream.u32()?;
    let files = files(&mut stream, is_wide, path)?;
    let n_cube = stream.grown(is_wide)?;
    for i in 0..n_cube {
        cube(&mut stream, &files).map_err(|what| format!("hypercube {i}: {what}"))?;
    }
    if kind == "TiledShapeStMan" {
        stream.leave(&manager);
        stream.shape()?;
        runs(&mut stream, n_cube)?;
    }
    Ok(())
}

/// How many bytes each of the files has, if it is there.
fn files(stream: &mut Stream, is_wide: bool, path: &Path) -> Result<Vec<Option<u64>>, String> {
    let mut files = Vec::new();
    for _ in 0..stream.grown(is_wide)? {
        let mut n_byte = None;
        if stream.byte()? != 0 {
            let version = stream.u32()?;
            let name = format!("{}_TSM{}", path.display(), stream.u32()?);
            stream.grown(version > 1)?;
            n_byte = Some(std::fs::metadata(name).map_or(0, |metadata| metadata.len()));
        }
        files.push(n_byte);
    }
    Ok(files)
}

fn cube(stream: &mut Stream, files: &[Option<u64>]) -> Result<(), String> {
    let version = stream.u32()?;
    keywords::pass(stream)?;
    stream.byte()?;
    let n_axis = stream.u32()? as usize;
    let (shape, tile) = (stream.shape()?, stream.shape()?);
    let file = stream.u32()? as i32;
    stream.grown(version > 1)?;
    if shape.len() != n_axis || tile.len() != n_axis {
        return Err(format!("{shape:?} cut into {tile:?} has not {n_axis} axes"));
    }
    if shape.iter().any(|&len| len < 0) || tile.iter().any(|&len| len <= 0) {
        return Err(format!("{shape:?} cannot be cut into tiles of {tile:?}"));
    }
    let n_value = tile.iter().try_fold(1, |n: i64, &len| n.checked_mul(len));
    if n_value.is_none_or(|n| n > MAX_TILE) {
        return Err(format!(
            "is cut into tiles of {tile:?}, more than {MAX_TILE} values each"
        ));
    }
    // The first is a pattern for others, and nowhere.
    if file == -1 && n_axis == 0 {
        return Ok(());
    }
    let place = usize::try_from(file).unwrap_or(usize::MAX);
    let Some(&Some(n_byte)) = files.get(place) else {
        return Err(format!("is in file {file}, which there is not"));
    };
    // casacore makes room for a number for each tile.
    let n_tile = n_tile(&shape, &tile);
    if n_tile > n_byte.max(MAX_UNWRITTEN) {
        return Err(format!(
            "{shape:?} is cut into {n_tile} tiles, in a file of {n_byte} bytes"
        ));
    }
    Ok(())
}

fn n_tile(shape: &[i64], tile: &[i64]) -> u64 {
    let along = |(&len, &tile): (&i64, &i64)| len.unsigned_abs().div_ceil(tile.unsigned_abs());
    let along = shape.iter().zip(tile).map(along);
    along.fold(1, u64::saturating_mul)
}

/// Which rows are in which hypercube.
fn runs(stream: &mut Stream, n_cube: u64) -> Result<(), String> {
    let n_run = stream.u32()? as usize;
    let (rows, cubes, places) = (
        stream.list(false)?,
        stream.list(false)?,
        stream.list(false)?,
    );
    if [&rows, &cubes, &places]
        .iter()
        .any(|list| list.len() < n_run)
    {
        return Err(format!(
            "has not the {n_run} runs of rows that it announces"
        ));
    }
    match cubes[..n_run].iter().find(|&&cube| cube >= n_cube) {
        Some(cube) => Err(format!("has rows in hypercube {cube}, of {n_cube}")),
        None => Ok(()),
    }
}
