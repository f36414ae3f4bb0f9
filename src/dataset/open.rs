//! The first pass over a file: selection, counts, noise, and the decision to hold or to stream.

use std::path::PathBuf;
use std::sync::Arc;

use vis2cat_formats::{Observation, ReadOptions, open_all, stokes_i};

use super::ingest::{Ingest, Sample, Tally, WeightRule};
use super::noise::{NoiseReport, NoiseTally};
use super::resident::{RESIDENT_BYTES, Resident};
use super::stream::Stream;
use super::uv_profile::UvProfile;
use super::{DataInfo, Dataset, DatasetError, EngineOptions, Store};
use crate::config::NoiseSource;
use crate::coords::{IcrsCentre, RaDec};
use crate::likelihood::VisBlock;
use crate::rime::shape::Profile;
use crate::rime::{Instrument, InstrumentTerms, pole_of};

/// What to take from a file, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenOptions {
    /// What to read of the files.
    pub read: ReadOptions,
    /// Where the noise level comes from.
    pub noise: NoiseSource,
    /// Memory for samples [byte].
    pub memory_bytes: f64,
    /// Shape of the sources that will be looked for.
    pub profile: Profile,
    /// Typical scale-length of those [rad]: the resolution that matters is what it leaves.
    pub typical_scale_rad: f64,
    /// How the likelihood of many points in a region is computed.
    pub engine: EngineOptions,
    /// Terms of the instrument.
    pub instrument: InstrumentTerms,
}

impl Dataset {
    /// Reads the files once, one after the other; `progress` is told the rows done and in all.
    ///
    /// # Errors
    /// A file cannot be read, holds nothing that can be used, or does not go with the others.
    pub fn open(
        paths: &[PathBuf],
        options: &OpenOptions,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Self, DatasetError> {
        let unusable = |file: usize, what: String| DatasetError::Unusable {
            path: paths.get(file).cloned().unwrap_or_default(),
            what,
        };
        let (reader, file_of_setup) = open_all(paths, &options.read)?;
        let observation = reader.observation().clone();
        let rule = stokes_i(&observation.corrs).map_err(|e| unusable(0, e.to_string()))?;
        one_field(&observation).map_err(|what| unusable(0, what))?;
        let weights = match options.noise {
            NoiseSource::Sefd(sefd) => WeightRule::Sefd(sefd.0),
            _ => WeightRule::Scaled(1.0),
        };
        let mut ingest = Ingest::new(reader, rule, file_of_setup, vec![weights; paths.len()]);
        let instrument = instrument(&observation, &options.instrument).map(Arc::new);
        ingest.set_instrument(instrument.clone());
        let mut tallies = FirstPass::new(paths.len(), options.typical_scale_rad);
        let blocks = first_pass(&mut ingest, &mut tallies, options.memory_bytes, &mut |n| {
            progress(n, observation.n_row);
        })?;
        let mut noise = Vec::new();
        for (file, tally) in tallies.files.iter().enumerate() {
            noise.push(tally.check(options).map_err(|what| unusable(file, what))?);
        }
        let (info, uv_profile) = tallies.finish(ingest.n_row(), noise);
        let scales: Vec<f64> = info.noise.iter().map(|noise| noise.weight_scale).collect();
        if let WeightRule::Scaled(_) = weights {
            ingest.set_weights(scales.iter().copied().map(WeightRule::Scaled).collect());
        }
        let store = match blocks {
            Some(blocks) => {
                let blocks = rescaled(blocks, &mut ingest, &scales)?;
                Store::Resident(Resident::new(blocks))
            }
            None => Store::Streamed(Box::new(Stream::new(ingest, options.memory_bytes))),
        };
        Ok(Self {
            observation,
            info,
            profile: options.profile,
            store,
            removed: Vec::new(),
            subtracted: Vec::new(),
            checkpoint: None,
            n_eval: 0,
            engine: options.engine,
            memory_bytes: options.memory_bytes,
            sizes: Vec::new(),
            uv_profile,
            instrument,
        })
    }
}

/// The terms of the instrument for all rows of all files: of several, the band is that of all together.
fn instrument(observation: &Observation, terms: &InstrumentTerms) -> Option<Instrument> {
    let freqs_hz = (observation.freq_setups.iter()).flat_map(|setup| &setup.freq_hz_f);
    let band_hz = freqs_hz.fold([f64::INFINITY, 0.0], |[low, high], &freq_hz| {
        [low.min(freq_hz), f64::max(high, freq_hz)]
    });
    let field = &observation.fields[0];
    let native = RaDec {
        ra_rad: field.ra_rad,
        dec_rad: field.dec_rad,
    };
    // The pole moves by 20 arcsec a year.
    let year: Option<f64> = observation.date_obs.get(..4).and_then(|y| y.parse().ok());
    let pole = pole_of(year.unwrap_or(2000.0) + 0.5);
    let pole = IcrsCentre::new(native, field.frame).from_icrs(pole);
    Instrument::new(terms, band_hz, pole)
}

/// The blocks with their final weights: read again where the scale has changed, so that held and
/// streamed data are the same to the bit.
fn rescaled(
    mut blocks: Vec<VisBlock>,
    ingest: &mut Ingest,
    scales: &[f64],
) -> Result<Vec<VisBlock>, DatasetError> {
    if scales.iter().any(|&scale| scale != 1.0) {
        blocks.clear();
        ingest.rewind()?;
        while let Some(block) = ingest.next_block(&mut super::ingest::NoTally)? {
            blocks.push(block);
        }
    }
    Ok(blocks)
}

/// Reads everything; returns the blocks if they fit.
fn first_pass(
    ingest: &mut Ingest,
    tally: &mut FirstPass,
    memory_bytes: f64,
    progress: &mut dyn FnMut(u64),
) -> Result<Option<Vec<VisBlock>>, DatasetError> {
    let mut kept = Some(Vec::new());
    let mut n_sample = 0;
    while let Some(block) = ingest.next_block(tally)? {
        n_sample += block.len();
        let bytes = RESIDENT_BYTES + block.extents.sample_bytes();
        if (n_sample * bytes) as f64 > memory_bytes {
            kept = None;
        }
        if let Some(blocks) = &mut kept {
            blocks.push(block);
        }
        progress(ingest.n_row());
    }
    Ok(kept)
}

/// Nothing if the data are of one field; the error says what there is to choose from.
fn one_field(observation: &Observation) -> Result<(), String> {
    let fields = &observation.fields;
    if let [field] = fields.as_slice() {
        if field.drifts {
            return Err(
                "the data are not phased (drift scan), so that there is no field to search: phase them \
                 first, with pyuvdata's UVData.phase"
                    .into(),
            );
        }
        return Ok(());
    }
    let list = fields.iter().enumerate();
    let names: Vec<_> = list.map(|(i, f)| format!("{i} {}", f.name)).collect();
    Err(format!(
        "there are {} fields; choose one with --field: {}",
        fields.len(),
        names.join(", ")
    ))
}

/// Everything that is counted in the first pass.
struct FirstPass {
    files: Vec<FileTally>,
}

/// What is counted of a file.
struct FileTally {
    info: DataInfo,
    noise: NoiseTally,
    uv_profile: UvProfile,
    n_without_interval: u64,
    typical_scale_rad: f64,
    sum_weight: f64,
    sum_weight_freq: f64,
    sum_tapered: f64,
    sum_tapered_uv2: f64,
}

impl FirstPass {
    fn new(n_file: usize, typical_scale_rad: f64) -> Self {
        let files = (0..n_file).map(|_| FileTally::new(typical_scale_rad));
        Self {
            files: files.collect(),
        }
    }

    /// Counts and scales of all files, with the weights that are used.
    fn finish(self, n_row: u64, noise: Vec<NoiseReport>) -> (DataInfo, UvProfile) {
        let mut uv_profile = UvProfile::default();
        let mut info = empty_info();
        let [mut weight, mut weight_freq, mut tapered, mut tapered_uv2] = [0.0; 4];
        for (file, noise) in self.files.iter().zip(&noise) {
            let scale = noise.weight_scale;
            uv_profile.add_scaled(&file.uv_profile, scale);
            weight += scale * file.sum_weight;
            weight_freq += scale * file.sum_weight_freq;
            tapered += scale * file.sum_tapered;
            tapered_uv2 += scale * file.sum_tapered_uv2;
            info = DataInfo {
                n_row_used: info.n_row_used + file.info.n_row_used,
                n_sample: info.n_sample + file.info.n_sample,
                n_flagged: info.n_flagged + file.info.n_flagged,
                first_mjd: info.first_mjd.min(file.info.first_mjd),
                last_mjd: info.last_mjd.max(file.info.last_mjd),
                max_uv: info.max_uv.max(file.info.max_uv),
                max_w: info.max_w.max(file.info.max_w),
                max_blur: info.max_blur.max(file.info.max_blur),
                ..info
            };
        }
        // Each of u and v has half of the mean square; the correlation of two positions falls
        // like a Gaussian of this width.
        let uv_rms = (0.5 * tapered_uv2 / tapered).sqrt();
        let info = DataInfo {
            n_row,
            mean_freq_hz: weight_freq / weight,
            beam_rad: 1.0 / (std::f64::consts::TAU * uv_rms),
            noise,
            ..info
        };
        (info, uv_profile)
    }
}

fn empty_info() -> DataInfo {
    DataInfo {
        first_mjd: f64::INFINITY,
        last_mjd: f64::NEG_INFINITY,
        ..DataInfo::default()
    }
}

impl FileTally {
    fn new(typical_scale_rad: f64) -> Self {
        Self {
            info: empty_info(),
            noise: NoiseTally::default(),
            uv_profile: UvProfile::default(),
            n_without_interval: 0,
            typical_scale_rad,
            sum_weight: 0.0,
            sum_weight_freq: 0.0,
            sum_tapered: 0.0,
            sum_tapered_uv2: 0.0,
        }
    }

    /// The noise of a file that can be used; why it cannot is told in words.
    fn check(&self, options: &OpenOptions) -> Result<NoiseReport, String> {
        if self.info.n_sample == 0 {
            let n = self.info.n_flagged;
            return Err(format!("no unflagged visibility is left ({n} are flagged)"));
        }
        if options.instrument.smearing && self.n_without_interval > 0 {
            return Err("there are no integration times, which --smearing needs".into());
        }
        let noise = self.noise.report(options.noise);
        if !(noise.weights_sigma_jy.is_finite() && noise.weight_scale.is_finite()) {
            return Err("the weights are not usable; try --noise sefd=400Jy".into());
        }
        Ok(noise)
    }

    fn add(&mut self, sample: &Sample) {
        let info = &mut self.info;
        info.n_sample += 1;
        info.first_mjd = info.first_mjd.min(sample.time_mjd);
        info.last_mjd = info.last_mjd.max(sample.time_mjd);
        let [u, v, w] = sample.uvw;
        let uv2 = u * u + v * v;
        info.max_uv = info.max_uv.max(uv2.sqrt());
        info.max_w = info.max_w.max(w.abs());
        let blur = sample.extent.blur();
        self.n_without_interval += u64::from(blur.is_nan());
        info.max_blur = info.max_blur.max((uv2 + w * w).sqrt() * blur);
        let weight = f64::from(sample.weight);
        self.uv_profile.add(sample.uvw, weight);
        self.sum_weight += weight;
        self.sum_weight_freq += weight * sample.extent.freq_hz;
        // F² of an exponential disk of the typical scale-length.
        let t = 1.0 + (std::f64::consts::TAU * self.typical_scale_rad).powi(2) * uv2;
        let tapered = weight / (t * t * t);
        self.sum_tapered += tapered;
        self.sum_tapered_uv2 += tapered * uv2;
        self.noise.sample(sample);
    }
}

impl Tally for FirstPass {
    fn row(&mut self, file: usize) {
        self.files[file].info.n_row_used += 1;
    }

    fn flagged(&mut self, file: usize) {
        self.files[file].info.n_flagged += 1;
    }

    fn sample(&mut self, sample: &Sample) {
        self.files[sample.file].add(sample);
    }
}
