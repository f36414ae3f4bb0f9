//! Everything that a reader brings, in a form that scripts can compare: `dump_vis IN OUT`.
//!
//! OUT gets one line of JSON, the observation with `n_chan`, `n_corr` and the number of rows read,
//! and then the arrays, little-endian, one after the other over all rows: uvw (f64 x 3), time (f64),
//! interval (f64), ant1, ant2, field, set-up (u32), visibilities (f32 x 2), weights (f32), flags (u8).

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use vis2cat_formats::{VisChunk, open};

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = paths.as_slice() else {
        return Err("usage: dump_vis IN OUT".into());
    };
    let mut reader = open(Path::new(from))?;
    let mut all = VisChunk::default();
    let mut chunk = VisChunk::new(777);
    while reader.read_chunk(&mut chunk)? > 0 {
        append(&mut all, &chunk);
    }
    let observation = serde_json::to_value(reader.observation())?;
    let line = serde_json::json!({
        "observation": observation,
        "n_read": all.n_row,
        "n_chan": all.n_chan,
        "n_corr": all.n_corr,
    });
    let mut out = BufWriter::new(File::create(to)?);
    writeln!(out, "{line}")?;
    write_arrays(&mut out, &all)?;
    out.flush()?;
    Ok(())
}

fn append(all: &mut VisChunk, chunk: &VisChunk) {
    (all.n_chan, all.n_corr) = (chunk.n_chan, chunk.n_corr);
    all.n_row += chunk.n_row;
    all.uvw_m_r.extend(&chunk.uvw_m_r);
    all.time_mjd_r.extend(&chunk.time_mjd_r);
    all.interval_s_r.extend(&chunk.interval_s_r);
    all.ant1_r.extend(&chunk.ant1_r);
    all.ant2_r.extend(&chunk.ant2_r);
    all.field_r.extend(&chunk.field_r);
    all.freq_setup_r.extend(&chunk.freq_setup_r);
    all.vis_jy_rfp.extend(&chunk.vis_jy_rfp);
    all.weight_rfp.extend(&chunk.weight_rfp);
    all.flag_rfp.extend(&chunk.flag_rfp);
}

fn write_arrays(out: &mut impl Write, all: &VisChunk) -> std::io::Result<()> {
    let doubles = all
        .uvw_m_r
        .iter()
        .flatten()
        .chain(&all.time_mjd_r)
        .chain(&all.interval_s_r);
    for value in doubles {
        out.write_all(&value.to_le_bytes())?;
    }
    let indices = all
        .ant1_r
        .iter()
        .chain(&all.ant2_r)
        .chain(&all.field_r)
        .chain(&all.freq_setup_r);
    for value in indices {
        out.write_all(&value.to_le_bytes())?;
    }
    let parts = all.vis_jy_rfp.iter().flat_map(|vis| [vis.re, vis.im]);
    for value in parts.chain(all.weight_rfp.iter().copied()) {
        out.write_all(&value.to_le_bytes())?;
    }
    let flags: Vec<u8> = all.flag_rfp.iter().map(|&flag| flag.into()).collect();
    out.write_all(&flags)
}
