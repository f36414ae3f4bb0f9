//! Reads any visibility file and writes it again: `rewrite_vis IN OUT`.
//!
//! OUT is written as UVH5 if its name ends in `.uvh5`, as a Measurement Set if in `.ms`, as UVFITS
//! otherwise.

use std::error::Error;
use std::path::Path;

use vis2cat_formats::{
    MsWriter, Observation, UvfitsWriter, Uvh5Writer, VisChunk, VisWriter, WriteError, open,
};

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = paths.as_slice() else {
        return Err("usage: rewrite_vis IN OUT".into());
    };
    let mut reader = open(Path::new(from))?;
    let mut writer = writer(Path::new(to), reader.observation())?;
    let mut chunk = VisChunk::new(1000);
    while reader.read_chunk(&mut chunk)? > 0 {
        writer.write_chunk(&chunk)?;
    }
    writer.finish()?;
    Ok(())
}

fn writer(path: &Path, observation: &Observation) -> Result<Box<dyn VisWriter>, WriteError> {
    Ok(match path.extension().and_then(|e| e.to_str()) {
        Some("uvh5") => Box::new(Uvh5Writer::create(path, observation, true)?),
        Some("ms") => Box::new(MsWriter::create(path, observation, true)?),
        _ => Box::new(UvfitsWriter::create(path, observation, true)?),
    })
}
