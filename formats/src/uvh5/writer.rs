//! Writing.

use std::collections::HashSet;
use std::path::Path;

use num_complex::Complex;

use super::apparent::{Place, Places};
use super::header::{self, Counts};
use super::layout::{Layout, MAX_CHUNK_ROWS};
use crate::date::MJD_ZERO_JD;
use crate::fits::{PendingFile, refuse_existing};
use crate::h5::{Growing, NewFile, NewGroup, Packing};
use crate::{Observation, VisChunk, VisWriter, WriteError};

/// Writes a UVH5 file.
///
/// Rows go to a hidden file beside the target, which takes the target's name in
/// [`finish`](VisWriter::finish); dropped before, the writer leaves nothing. The number of rows need
/// not be known. Rows are gathered to whole chunks of the file, so that its bytes do not depend on
/// the sizes in which they came.
///
/// Weights become nsamples, with those of flagged samples kept.
#[derive(Debug)]
pub struct Uvh5Writer {
    // Closed in this order: what is in a file before the file, and that before it is removed.
    arrays: Option<Arrays>,
    groups: Option<Groups>,
    file: Option<NewFile>,
    pending: PendingFile,
    observation: Observation,
    layout: Layout,
    /// Rows that do not fill a chunk yet.
    gathered: VisChunk,
    places: Places,
    tally: Tally,
}

#[derive(Debug)]
struct Groups {
    header: NewGroup,
    data: NewGroup,
}

/// The arrays that grow with the rows.
#[derive(Debug)]
struct Arrays {
    vis: Growing,
    flags: Growing,
    nsamples: Growing,
    uvw: Growing,
    time: Growing,
    interval: Growing,
    ant1: Growing,
    ant2: Growing,
    phase_centre: Growing,
    app_ra: Growing,
    app_dec: Growing,
    frame_pa: Growing,
}

/// What must be counted on the way.
#[derive(Debug, Default)]
struct Tally {
    rows: usize,
    times: HashSet<u64>,
    baselines: HashSet<(u32, u32)>,
}

impl Uvh5Writer {
    /// Starts a file for `observation`.
    ///
    /// # Errors
    /// The target exists and `overwrite` is false, its folder cannot be written, or the
    /// observation cannot be put into a UVH5 file.
    pub fn create(
        path: &Path,
        observation: &Observation,
        overwrite: bool,
    ) -> Result<Self, WriteError> {
        refuse_existing(path, overwrite)?;
        let layout = Layout::new(observation).map_err(|what| WriteError::Parameter {
            path: path.to_owned(),
            what,
        })?;
        let pending = PendingFile::create(path, overwrite)?;
        let hdf5 = |what| hdf5_error(path, what);
        let file = NewFile::create(pending.temp_path()).map_err(hdf5)?;
        let groups = Groups {
            header: file.group("Header").map_err(hdf5)?,
            data: file.group("Data").map_err(hdf5)?,
        };
        let mut gathered = VisChunk::new(layout.chunk_rows);
        gathered.clear(layout.spw_f.len(), observation.corrs.len());
        Ok(Self {
            arrays: None,
            groups: Some(groups),
            file: Some(file),
            pending,
            observation: observation.clone(),
            places: Places::new(layout.geodetic[0], layout.geodetic[1]),
            layout,
            gathered,
            tally: Tally::default(),
        })
    }

    /// Writes the rows gathered. The first time the arrays are made: their chunks are as high as a
    /// chunk may be or, in a file of fewer rows, as the file.
    fn flush(&mut self) -> Result<(), String> {
        let rows = &self.gathered;
        if self.arrays.is_none() {
            let groups = self.groups.as_ref().ok_or("the file is finished")?;
            let made = Arrays::create(groups, &self.layout, rows)?;
            self.arrays = Some(made);
        }
        if let Some(arrays) = &mut self.arrays {
            let places: Vec<Place> = (0..rows.n_row)
                .map(|row| {
                    let index = rows.field_r[row];
                    let field = &self.observation.fields[index as usize];
                    self.places.at(index, field, rows.time_mjd_r[row])
                })
                .collect();
            arrays.append(rows, &self.layout, &places)?;
        }
        self.tally.add(rows);
        let (n_chan, n_corr) = (rows.n_chan, rows.n_corr);
        self.gathered.clear(n_chan, n_corr);
        Ok(())
    }

    /// Writes what is left and closes the file.
    fn complete(&mut self) -> Result<(), String> {
        if self.gathered.n_row > 0 {
            self.flush()?;
        }
        if let Some(groups) = &self.groups {
            let counts = self.tally.counts();
            header::write(&groups.header, &self.observation, &self.layout, counts)?;
        }
        self.arrays = None;
        self.groups = None;
        self.file.take().map_or(Ok(()), NewFile::close)
    }
}

impl VisWriter for Uvh5Writer {
    fn write_chunk(&mut self, chunk: &VisChunk) -> Result<(), WriteError> {
        if chunk.n_row == 0 {
            return Ok(());
        }
        let before = (self.tally.rows + self.gathered.n_row) as u64;
        (chunk.check(&self.observation, before)).map_err(|what| WriteError::Parameter {
            path: self.pending.path().to_owned(),
            what,
        })?;
        let mut from = 0;
        while from < chunk.n_row {
            let room = self.layout.chunk_rows - self.gathered.n_row;
            let to = (from + room).min(chunk.n_row);
            self.gathered.append(chunk, from, to);
            from = to;
            if self.gathered.n_row == self.layout.chunk_rows {
                self.flush()
                    .map_err(|what| hdf5_error(self.pending.path(), what))?;
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        if self.tally.rows + self.gathered.n_row == 0 {
            return Err(WriteError::Parameter {
                path: self.pending.path().to_owned(),
                what: "no row was written; UVH5 cannot be empty".into(),
            });
        }
        self.complete()
            .map_err(|what| hdf5_error(self.pending.path(), what))?;
        self.pending.commit()
    }
}

impl Arrays {
    fn create(groups: &Groups, layout: &Layout, rows: &VisChunk) -> Result<Self, String> {
        let Groups { header, data } = groups;
        let shape = [rows.n_chan, rows.n_corr];
        let chunk = [rows.n_row, layout.chunk_chans, rows.n_corr];
        let packed = Packing::ShuffleDeflate;
        // Rows have little beside their visibilities: chunks of many, unless the file has few.
        let height = if rows.n_row < layout.chunk_rows {
            rows.n_row
        } else {
            MAX_CHUNK_ROWS
        };
        let real = |name| header.growing::<f64>(name, &[], &[height], packed);
        let whole = |name| header.growing::<i64>(name, &[], &[height], packed);
        Ok(Self {
            vis: data.growing::<Complex<f32>>("visdata", &shape, &chunk, Packing::None)?,
            flags: data.growing::<bool>("flags", &shape, &chunk, packed)?,
            nsamples: data.growing::<f32>("nsamples", &shape, &chunk, packed)?,
            uvw: header.growing::<f64>("uvw_array", &[3], &[height, 3], packed)?,
            time: real("time_array")?,
            interval: real("integration_time")?,
            ant1: whole("ant_1_array")?,
            ant2: whole("ant_2_array")?,
            phase_centre: whole("phase_center_id_array")?,
            app_ra: real("phase_center_app_ra")?,
            app_dec: real("phase_center_app_dec")?,
            frame_pa: real("phase_center_frame_pa")?,
        })
    }

    /// Appends rows, with the baselines turned round: a chunk has them from antenna 2 to antenna 1.
    fn append(&mut self, rows: &VisChunk, layout: &Layout, places: &[Place]) -> Result<(), String> {
        let vis: Vec<Complex<f32>> = rows.vis_jy_rfp.iter().map(Complex::conj).collect();
        self.vis.append(&vis)?;
        self.flags.append(&rows.flag_rfp)?;
        self.nsamples.append(&rows.weight_rfp)?;
        let uvw_m: Vec<f64> = rows.uvw_m_r.iter().flatten().map(|x| -x).collect();
        self.uvw.append(&uvw_m)?;
        let time_jd: Vec<f64> = rows
            .time_mjd_r
            .iter()
            .map(|mjd| mjd + MJD_ZERO_JD)
            .collect();
        self.time.append(&time_jd)?;
        self.interval.append(&rows.interval_s_r)?;
        let numbers = |ants: &[u32]| -> Vec<i64> {
            ants.iter()
                .map(|&ant| layout.antenna_numbers[ant as usize])
                .collect()
        };
        self.ant1.append(&numbers(&rows.ant1_r))?;
        self.ant2.append(&numbers(&rows.ant2_r))?;
        let fields: Vec<i64> = rows.field_r.iter().map(|&field| field.into()).collect();
        self.phase_centre.append(&fields)?;
        let part = |f: fn(&Place) -> f64| -> Vec<f64> { places.iter().map(f).collect() };
        self.app_ra.append(&part(|place| place.ra_rad))?;
        self.app_dec.append(&part(|place| place.dec_rad))?;
        self.frame_pa.append(&part(|place| place.frame_pa_rad))
    }
}

impl Tally {
    fn add(&mut self, rows: &VisChunk) {
        self.rows += rows.n_row;
        self.times.extend(
            rows.time_mjd_r
                .iter()
                .map(|mjd| (mjd + MJD_ZERO_JD).to_bits()),
        );
        let pairs = rows.ant1_r.iter().copied().zip(rows.ant2_r.iter().copied());
        self.baselines.extend(pairs);
    }

    fn counts(&self) -> Counts {
        let antennas: HashSet<u32> = self.baselines.iter().flat_map(|&(a, b)| [a, b]).collect();
        Counts {
            rows: self.rows,
            times: self.times.len(),
            baselines: self.baselines.len(),
            antennas: antennas.len(),
        }
    }
}

fn hdf5_error(path: &Path, what: String) -> WriteError {
    WriteError::Io {
        path: path.to_owned(),
        source: std::io::Error::other(what),
    }
}
