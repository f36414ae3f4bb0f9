//! Several files as one: a reader that reads one after the other.
//!
//! # What must agree
//! The files look at one phase centre, given in one frame and within [`SAME_PLACE_RAD`]: each has one
//! field, or one is selected. Times, antennas, frequencies and correlations may differ.
//!
//! # Correlations
//! Where they differ only Stokes I can be made of all of them, so parallel hands alone are read: those
//! of every file stand where the first file with two hands has its own, a hand that a file lacks is
//! flagged, and a file of Stokes I has both hands alike, with half its weight each, of which the same
//! Stokes I and weight are made again ([`stokes_i`]).

use std::path::PathBuf;

use num_complex::Complex;

use crate::{Corr, Field, Observation, ReadError, StokesIRule, VisChunk, VisReader, stokes_i};

/// Phase centres closer than this are one [rad]: a hundredth of an arcsecond.
const SAME_PLACE_RAD: f64 = 4.85e-8;

/// Reads several files, one after the other.
///
/// Frequency set-ups are those of all files, in order, so that a row's set-up tells its file.
pub struct Concatenated {
    parts: Vec<Part>,
    observation: Observation,
    /// The part that is being read.
    now: usize,
    chunk: VisChunk,
}

struct Part {
    reader: Box<dyn VisReader>,
    /// Index of each antenna, and of the first set-up, in the whole.
    antennas: Vec<u32>,
    first_setup: u32,
    /// How hands are made of the correlations, where not all files have the same.
    hands: Option<StokesIRule>,
}

impl Concatenated {
    /// Puts files together; paths are for errors.
    ///
    /// # Errors
    /// There are none, their phase centres or time scales differ, or one has no Stokes I.
    pub fn new(files: Vec<(PathBuf, Box<dyn VisReader>)>) -> Result<Self, ReadError> {
        let paths: Vec<PathBuf> = files.iter().map(|(path, _)| path.clone()).collect();
        let error = |i: usize, what: String| ReadError::Unsupported {
            path: paths[i].clone(),
            place: "with the other files".to_owned(),
            what,
        };
        let list: Vec<&Observation> = files.iter().map(|(_, r)| r.observation()).collect();
        let Some(&first) = list.first() else {
            return Err(ReadError::Unsupported {
                path: PathBuf::new(),
                place: "files".to_owned(),
                what: "there are none".to_owned(),
            });
        };
        for (i, other) in list.iter().enumerate() {
            agree(first, other).map_err(|what| error(i, what))?;
        }
        let are_same = list.iter().all(|other| other.corrs == first.corrs);
        let mut rules = vec![None; list.len()];
        let mut corrs = first.corrs.clone();
        if !are_same {
            for (i, other) in list.iter().enumerate() {
                rules[i] = Some(stokes_i(&other.corrs).map_err(|e| error(i, e.to_string()))?);
            }
            corrs = hands(&list, &rules);
        }
        let mut observation = Observation {
            corrs,
            uvh5: None,
            ms: None,
            antennas: Vec::new(),
            freq_setups: Vec::new(),
            n_row: 0,
            warnings: Vec::new(),
            ..first.clone()
        };
        let mut parts = Vec::new();
        for ((path, reader), hands) in files.into_iter().zip(rules) {
            let part = reader.observation();
            let first_setup = observation.freq_setups.len() as u32;
            let antennas = add_antennas(&mut observation, part);
            observation.freq_setups.extend_from_slice(&part.freq_setups);
            observation.n_row += part.n_row;
            let warnings = part.warnings.iter();
            observation
                .warnings
                .extend(warnings.map(|w| format!("{}: {w}", path.display())));
            parts.push(Part {
                reader,
                antennas,
                first_setup,
                hands,
            });
        }
        Ok(Self {
            parts,
            observation,
            now: 0,
            chunk: VisChunk::new(1),
        })
    }

    /// The file that each frequency set-up is of, from 0.
    pub fn file_of_setup(&self) -> Vec<u32> {
        let parts = (0..).zip(&self.parts);
        parts
            .flat_map(|(i, part)| part.reader.observation().freq_setups.iter().map(move |_| i))
            .collect()
    }

    fn clear(&self, out: &mut VisChunk) {
        let n_chan = self.observation.freq_setups[0].freq_hz_f.len();
        out.clear(n_chan, self.observation.corrs.len());
    }
}

/// What keeps `other` from being read with `first`, in words.
fn agree(first: &Observation, other: &Observation) -> Result<(), String> {
    let one = |observation: &Observation| match observation.fields.as_slice() {
        [field] => Ok(field.clone()),
        several => Err(format!(
            "there are {} fields; of files that are read together each must have one: choose it with \
             --field",
            several.len()
        )),
    };
    let (here, there) = (one(first)?, one(other)?);
    other.check_phased("a likelihood of several files")?;
    if here.frame != there.frame || distance_rad(&here, &there) > SAME_PLACE_RAD {
        let place = |field: &Field| {
            let (ra, dec) = (field.ra_rad.to_degrees(), field.dec_rad.to_degrees());
            format!("RA {ra:.6} deg, DEC {dec:.6} deg ({:?})", field.frame)
        };
        return Err(format!(
            "the phase centre is {}, that of the first file {}; files that are read together must \
             have the same: phase them to one, with CASA's phaseshift or pyuvdata's UVData.phase",
            place(&there),
            place(&here)
        ));
    }
    if first.time_scale != other.time_scale {
        return Err(format!(
            "times are in {:?}, in the first file in {:?}",
            other.time_scale, first.time_scale
        ));
    }
    Ok(())
}

fn distance_rad(a: &Field, b: &Field) -> f64 {
    let vector = |field: &Field| {
        let ((sin_ra, cos_ra), (sin_dec, cos_dec)) =
            (field.ra_rad.sin_cos(), field.dec_rad.sin_cos());
        [cos_dec * cos_ra, cos_dec * sin_ra, sin_dec]
    };
    let (a, b) = (vector(a), vector(b));
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    square.sqrt()
}

/// The hands that stand for those of all files.
fn hands(list: &[&Observation], rules: &[Option<StokesIRule>]) -> Vec<Corr> {
    let two = list
        .iter()
        .zip(rules)
        .find_map(|(observation, rule)| match rule {
            Some(StokesIRule::Hands(p, q)) => {
                Some(vec![observation.corrs[*p], observation.corrs[*q]])
            }
            _ => None,
        });
    two.unwrap_or_else(|| vec![Corr::Xx, Corr::Yy])
}

/// The index of each antenna of a part, those that are new appended: an antenna is known by its name
/// and its place.
fn add_antennas(whole: &mut Observation, part: &Observation) -> Vec<u32> {
    let n_before = whole.antennas.len();
    let mut indices = Vec::with_capacity(part.antennas.len());
    for antenna in &part.antennas {
        let known = whole.antennas[..n_before]
            .iter()
            .position(|other| other.name == antenna.name && other.itrf_m == antenna.itrf_m);
        indices.push(known.unwrap_or_else(|| {
            whole.antennas.push(antenna.clone());
            whole.antennas.len() - 1
        }) as u32);
    }
    indices
}

impl Part {
    /// Appends the rows of a chunk of this file to a chunk of the whole.
    fn append(&self, chunk: &VisChunk, out: &mut VisChunk) {
        for row in 0..chunk.n_row {
            let mut head = chunk.head(row);
            head.ants = head.ants.map(|ant| self.antennas[ant as usize]);
            head.freq_setup += self.first_setup;
            out.push(&head);
        }
        out.n_row += chunk.n_row;
        let Some(rule) = self.hands else {
            out.vis_jy_rfp.extend(&chunk.vis_jy_rfp);
            out.weight_rfp.extend(&chunk.weight_rfp);
            out.flag_rfp.extend(&chunk.flag_rfp);
            return;
        };
        for first in (0..chunk.vis_jy_rfp.len()).step_by(chunk.n_corr) {
            let sample = |p: usize, share: f32| {
                let at = first + p;
                (
                    chunk.vis_jy_rfp[at],
                    share * chunk.weight_rfp[at],
                    chunk.flag_rfp[at],
                )
            };
            let pair = match rule {
                StokesIRule::Direct(i) => [sample(i, 0.5), sample(i, 0.5)],
                StokesIRule::Hands(p, q) => [sample(p, 1.0), sample(q, 1.0)],
                StokesIRule::OneHand(p) => [sample(p, 1.0), (Complex::default(), 0.0, true)],
            };
            for (vis, weight, flag) in pair {
                out.vis_jy_rfp.push(vis);
                out.weight_rfp.push(weight);
                out.flag_rfp.push(flag);
            }
        }
    }
}

impl VisReader for Concatenated {
    fn observation(&self) -> &Observation {
        &self.observation
    }

    fn read_chunk(&mut self, chunk: &mut VisChunk) -> Result<usize, ReadError> {
        self.clear(chunk);
        while let Some(part) = self.parts.get_mut(self.now) {
            (self.chunk).take_at_most(chunk.max_row, part.reader.observation());
            let n_row = part.reader.read_chunk(&mut self.chunk)?;
            if n_row > 0 {
                chunk.clear(self.chunk.n_chan, self.observation.corrs.len());
                part.append(&self.chunk, chunk);
                return Ok(n_row);
            }
            self.now += 1;
        }
        Ok(0)
    }

    fn rewind(&mut self) -> Result<(), ReadError> {
        self.now = 0;
        self.parts
            .iter_mut()
            .try_for_each(|part| part.reader.rewind())
    }

    fn n_row_read(&self) -> u64 {
        self.parts.iter().map(|part| part.reader.n_row_read()).sum()
    }
}
