//! Reads any visibility file and writes it again: `rewrite_vis IN OUT`.
//!
//! OUT is written as UVH5 if its name ends in `.uvh5`, as a Measurement Set if in `.ms`, as UVFITS
//! otherwise.

use std::error::Error;
use std::path::Path;

use vis2cat_formats::{VisChunk, create, open};

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = paths.as_slice() else {
        return Err("usage: rewrite_vis IN OUT".into());
    };
    let mut reader = open(Path::new(from))?;
    let mut writer = create(Path::new(to), reader.observation(), true)?;
    let mut chunk = VisChunk::new(1000);
    while reader.read_chunk(&mut chunk)? > 0 {
        writer.write_chunk(&chunk)?;
    }
    writer.finish()?;
    Ok(())
}
