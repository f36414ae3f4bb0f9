//! Reading.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::antennas::{Antennas, ArrayHeader};
use super::axes::Axes;
use super::baseline::{self, Pair};
use super::frequencies::Frequencies;
use super::groups::Layout;
use super::parameters::{Parameters, Projection, Quantity, from_ncp};
use super::sources::Sources;
use crate::chunk::RowHead;
use crate::date;
use crate::direction;
use crate::fits::header::{Header, Place};
use crate::fits::scan::{self, Hdu};
use crate::odd::OddSamples;
use crate::{Observation, ReadError, VisChunk, VisReader};

/// Bytes read from the file at a time (at least one group).
const BUFFER_BYTES: usize = 1 << 20;

/// Rows looked at to tell which way the baselines run.
const DIRECTION_ROWS: u64 = 64;
/// How UVFITS has them run.
const DIRECTION: direction::Words = direction::Words {
    coordinates: "UU, VV, WW",
    wrong_way: "from antenna 1 to antenna 2, against the UVFITS convention",
};

/// Reads a UVFITS file.
///
/// Holds one buffer of about a megabyte, or of one group where that is longer. Without INTTIM the
/// integration times are NaN. After an error the chunk is empty and the place in the file is not
/// known: [`rewind`](VisReader::rewind) before reading on.
#[derive(Debug)]
pub struct UvfitsReader {
    file: File,
    place: Place,
    observation: Observation,
    layout: Layout,
    parameters: Parameters,
    antennas: Antennas,
    frequencies: Frequencies,
    sources: Sources,
    data_offset: u64,
    next_row: u64,
    buffer: Vec<u8>,
    odd: OddSamples,
}

impl UvfitsReader {
    /// Opens a file: reads its headers and tables and checks all sizes.
    ///
    /// # Errors
    /// The file is no UVFITS file, is damaged or truncated, or holds what we cannot read.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io {
            path: path.to_owned(),
            source,
        };
        let mut file = File::open(path).map_err(io)?;
        let hdus = scan::scan(path, &mut file)?;
        let primary = &hdus[0];
        let header = &primary.header;
        check_groups(primary)?;

        let mut warnings = Vec::new();
        let axes = Axes::read(header, &primary.axes[1..])?;
        let frequencies = Frequencies::read(&mut file, &hdus, &axes, &mut warnings)?;
        let ref_hz = header.need_real(&format!("CRVAL{}", axes.freq.number))?;
        let parameters = Parameters::read(header, ref_hz)?;
        let layout = Layout::read(header, &axes, parameters.n_param)?;
        let has_source = parameters.source.is_there();
        let sources = Sources::read(&mut file, &hdus, &axes, has_source, &mut warnings)?;
        let (antennas, array) = Antennas::read(&mut file, &hdus, &mut warnings)?;
        if axes.complex.len == 2 {
            warnings.push("the COMPLEX axis has no weights: all are taken as 1".into());
        }

        let mut observation = describe(header, &array);
        observation.antennas.clone_from(&antennas.list);
        observation.fields.clone_from(&sources.fields);
        observation.freq_setups.clone_from(&frequencies.setups);
        observation.corrs = axes.corrs(header)?;
        observation.n_row = header.need_count("GCOUNT")?;
        observation.warnings = warnings;
        let mut reader = Self {
            place: header.place.clone(),
            data_offset: primary.data_offset,
            file,
            observation,
            layout,
            parameters,
            antennas,
            frequencies,
            sources,
            next_row: 0,
            buffer: Vec::new(),
            odd: OddSamples::default(),
        };
        reader.judge_direction()?;
        reader.rewind()?;
        Ok(reader)
    }

    /// Appends one group to the chunk.
    fn append(&mut self, group: &[u8], chunk: &mut VisChunk) -> Result<(), ReadError> {
        let row = self.next_row;
        let head = self.head(row, group)?;
        chunk.push(&head);
        let n_odd = self.layout.append_data(group, chunk);
        chunk.n_row += 1;
        self.odd.add(n_odd, row);
        self.next_row += 1;
        Ok(())
    }

    /// What the parameters of a group say; `group` need not hold more than them.
    fn head(&self, row: u64, group: &[u8]) -> Result<RowHead, ReadError> {
        let raw = |at| self.layout.parameter(group, at);
        let parameters = &self.parameters;
        let pair = self.pair(row, raw)?;
        let field = self.index(row, "SOURCE", &parameters.source, raw, |n| {
            self.sources.find(n)
        })?;
        let freq_setup = self.index(row, "FREQSEL", &parameters.freq_sel, raw, |n| {
            self.frequencies.find(n)
        })?;
        let mut uvw_m = [0, 1, 2].map(|d| parameters.uvw[d].value(raw) * parameters.uvw_to_m);
        if parameters.projection == Projection::Ncp {
            uvw_m = from_ncp(uvw_m, self.sources.fields[field as usize].dec_rad);
        }
        let time_mjd = parameters.date.mjd(raw);
        let [u, v, w] = uvw_m;
        for (name, value) in [("UU", u), ("VV", v), ("WW", w), ("DATE", time_mjd)] {
            if !value.is_finite() {
                return Err(self.row_error(row, name, format!("{value} is not finite")));
            }
        }
        let interval_s = parameters.int_time.value(raw);
        let known = parameters.int_time.is_there() && interval_s.is_finite() && interval_s > 0.0;
        Ok(RowHead {
            uvw_m,
            time_mjd,
            interval_s: if known { interval_s } else { f64::NAN },
            ants: [
                self.antenna(row, pair.subarray, pair.ant1)?,
                self.antenna(row, pair.subarray, pair.ant2)?,
            ],
            field,
            freq_setup,
        })
    }

    /// Sets some rows' coordinates against the antenna positions, and warns where they disagree.
    fn judge_direction(&mut self) -> Result<(), ReadError> {
        let n_row = self.observation.n_row;
        let mut evidence = Vec::new();
        let mut group = vec![0; self.layout.parameter_bytes()];
        for row in (0..n_row).step_by(n_row.div_ceil(DIRECTION_ROWS) as usize) {
            let at = self.data_offset + row * self.layout.group_bytes as u64;
            self.file
                .seek(SeekFrom::Start(at))
                .map_err(|e| self.place.io(e))?;
            self.file
                .read_exact(&mut group)
                .map_err(|e| self.place.io(e))?;
            // A row that is wrong is an error when its turn comes.
            if let Ok(head) = self.head(row, &group) {
                let field = &self.sources.fields[head.field as usize];
                let positions_m = head.ants.map(|ant| self.antennas.list[ant as usize].itrf_m);
                let centre_rad = (field.ra_rad, field.dec_rad);
                evidence.extend(direction::compare(
                    head.uvw_m,
                    positions_m,
                    head.time_mjd,
                    centre_rad,
                ));
            }
        }
        self.observation
            .warnings
            .extend(direction::verdict(&evidence, &DIRECTION));
        Ok(())
    }

    /// Which antennas a row is of; ANTENNA1 and ANTENNA2 go before BASELINE.
    fn pair(&self, row: u64, raw: impl Fn(usize) -> f64 + Copy) -> Result<Pair, ReadError> {
        let parameters = &self.parameters;
        if parameters.has_antenna_pair() {
            let subarray = if parameters.subarray.is_there() {
                self.whole(row, "SUBARRAY", parameters.subarray.value(raw))?
                    .max(1)
            } else {
                1
            };
            return Ok(Pair {
                subarray,
                ant1: self.whole(row, "ANTENNA1", parameters.ant1.value(raw))?,
                ant2: self.whole(row, "ANTENNA2", parameters.ant2.value(raw))?,
            });
        }
        let value = parameters.baseline.value(raw);
        baseline::decode(value).ok_or_else(|| {
            self.row_error(row, "BASELINE", format!("{value} is no pair of antennas"))
        })
    }

    /// A parameter that must be a whole number of zero or more.
    fn whole(&self, row: u64, name: &str, value: f64) -> Result<u32, ReadError> {
        let whole = value as u32;
        if f64::from(whole) == value {
            return Ok(whole);
        }
        Err(self.row_error(
            row,
            name,
            format!("{value} is not a whole number of 0 or more"),
        ))
    }

    /// Where in its table stands the number that a row gives; the first where rows give none.
    fn index(
        &self,
        row: u64,
        name: &str,
        quantity: &Quantity,
        raw: impl Fn(usize) -> f64,
        find: impl Fn(i64) -> Option<u32>,
    ) -> Result<u32, ReadError> {
        if !quantity.is_there() {
            return Ok(0);
        }
        let value = quantity.value(raw);
        let known = if value.is_finite() {
            find(value.round() as i64)
        } else {
            None
        };
        known.ok_or_else(|| self.row_error(row, name, format!("{value} is not in its table")))
    }

    fn antenna(&self, row: u64, subarray: u32, number: u32) -> Result<u32, ReadError> {
        self.antennas.find(subarray, number).ok_or_else(|| {
            let what =
                format!("antenna {number} of subarray {subarray} is not in the AIPS AN table");
            self.row_error(row, "BASELINE", what)
        })
    }

    fn row_error(&self, row: u64, name: &str, what: impl Into<String>) -> ReadError {
        let at = format!("group {} of {}: {name}", row + 1, self.observation.n_row);
        self.place.malformed(&at, what)
    }
}

impl VisReader for UvfitsReader {
    fn observation(&self) -> &Observation {
        &self.observation
    }

    fn read_chunk(&mut self, chunk: &mut VisChunk) -> Result<usize, ReadError> {
        let n_chan = self.observation.freq_setups[0].freq_hz_f.len();
        chunk.clear(n_chan, self.observation.corrs.len());
        let group_bytes = self.layout.group_bytes;
        let per_read = (BUFFER_BYTES / group_bytes).max(1);
        let left = self.observation.n_row - self.next_row;
        let wanted = usize::try_from(left)
            .unwrap_or(usize::MAX)
            .min(chunk.max_row.max(1));
        let mut buffer = std::mem::take(&mut self.buffer);
        let mut result = Ok(wanted);
        while chunk.n_row < wanted && result.is_ok() {
            let n_group = (wanted - chunk.n_row).min(per_read);
            buffer.resize(n_group * group_bytes, 0);
            result = self
                .file
                .read_exact(&mut buffer)
                .map_err(|e| self.place.io(e))
                .and_then(|()| {
                    buffer
                        .chunks_exact(group_bytes)
                        .try_for_each(|group| self.append(group, chunk))
                })
                .map(|()| wanted);
        }
        self.buffer = buffer;
        if result.is_err() {
            chunk.clear(n_chan, self.observation.corrs.len());
        } else if self.next_row == self.observation.n_row {
            let warnings = &mut self.observation.warnings;
            self.odd.tell("the first in group", warnings);
        }
        result
    }

    fn rewind(&mut self) -> Result<(), ReadError> {
        self.next_row = 0;
        self.odd.rewind();
        self.file
            .seek(SeekFrom::Start(self.data_offset))
            .map_err(|e| self.place.io(e))?;
        Ok(())
    }

    fn n_row_read(&self) -> u64 {
        self.next_row
    }
}

/// Tells random groups from everything else that a FITS file may be.
fn check_groups(primary: &Hdu) -> Result<(), ReadError> {
    let header = &primary.header;
    if scan::is_uv_table_form(primary) {
        let what = "visibilities in a table (the AIPS FITAB form) are not read; write random \
                    groups instead, with FITTP in AIPS or with a converter";
        return Err(header.place.unsupported("NAXIS1 = 777777701", what));
    }
    if !header.logical("GROUPS") || primary.axes.first() != Some(&0) || primary.axes.len() < 2 {
        let what =
            "this FITS file has no random groups (GROUPS = T with NAXIS1 = 0): no UVFITS file";
        return Err(header.place.malformed("GROUPS", what));
    }
    if header.need_count("GCOUNT")? == 0 {
        return Err(header
            .place
            .malformed("GCOUNT", "is 0: the file holds no visibilities"));
    }
    Ok(())
}

/// What the primary header and the antenna table say about the observation.
fn describe(header: &Header, array: &ArrayHeader) -> Observation {
    let text = |key| header.text(key).unwrap_or("").to_owned();
    let telescope = header
        .text("TELESCOP")
        .map_or_else(|| array.name.clone(), str::to_owned);
    let day = header.text("DATE-OBS").and_then(date::parse_day);
    let mut earth = array.earth;
    // Sidereal time is at 0 h of the reference day: without a day it says nothing, and it would
    // be misread beside the day of another date.
    if array.reference_day.is_none() || day.is_some() && day != array.reference_day {
        earth.gst0_deg = None;
    }
    Observation {
        telescope,
        instrument: text("INSTRUME"),
        observer: text("OBSERVER"),
        date_obs: day
            .or_else(|| array.reference_day.clone())
            .unwrap_or_default(),
        array_position_m: array.position_m,
        time_scale: array.time_scale,
        earth,
        history: header.history.clone(),
        ..Observation::default()
    }
}
