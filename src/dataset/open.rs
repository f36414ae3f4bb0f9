//! The first pass over a file: selection, counts, noise, and the decision to hold or to stream.

use std::path::Path;
use std::sync::Arc;

use vis2cat_formats::{Observation, ReadOptions, stokes_i};

use super::ingest::{FieldChoice, Ingest, Sample, Tally, WeightRule};
use super::noise::NoiseTally;
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
    /// What to read of a file that holds more than one thing.
    pub read: ReadOptions,
    /// Name or number of the field; none = the only one.
    pub field: Option<String>,
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
    /// Reads the file once; `progress` is told the rows done and in all.
    ///
    /// # Errors
    /// The file cannot be read, or holds nothing that can be used.
    pub fn open(
        path: &Path,
        options: &OpenOptions,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Self, DatasetError> {
        let unusable = |what: String| DatasetError::Unusable {
            path: path.into(),
            what,
        };
        let reader = vis2cat_formats::open_with(path, &options.read)?;
        let observation = reader.observation().clone();
        let rule = stokes_i(&observation.corrs).map_err(|e| unusable(e.to_string()))?;
        let field = choose_field(&observation, options.field.as_deref()).map_err(unusable)?;
        let weights = match options.noise {
            NoiseSource::Sefd(sefd) => WeightRule::Sefd(sefd.0),
            _ => WeightRule::Scaled(1.0),
        };
        let mut ingest = Ingest::new(reader, rule, FieldChoice::One(field), weights);
        let instrument = instrument(&observation, field, &options.instrument).map(Arc::new);
        ingest.set_instrument(instrument.clone());
        let mut tally = FirstPass::new(options.typical_scale_rad);
        let blocks = first_pass(&mut ingest, &mut tally, options.memory_bytes, &mut |n| {
            progress(n, observation.n_row);
        })?;
        if tally.info.n_sample == 0 {
            let n = tally.info.n_flagged;
            return Err(unusable(format!(
                "no unflagged visibility is left ({n} are flagged)"
            )));
        }
        if options.instrument.smearing && ingest.n_without_interval > 0 {
            return Err(unusable(
                "there are no integration times, which --smearing needs".into(),
            ));
        }
        let noise = tally.noise.report(options.noise);
        if !(noise.weights_sigma_jy.is_finite() && noise.weight_scale.is_finite()) {
            return Err(unusable(
                "the weights are not usable; try --noise sefd=400Jy".into(),
            ));
        }
        let uv_profile = std::mem::take(&mut tally.uv_profile).scaled(noise.weight_scale);
        let info = DataInfo {
            n_row: ingest.n_row,
            noise,
            ..tally.finish()
        };
        if let WeightRule::Scaled(_) = weights {
            ingest.set_weights(WeightRule::Scaled(noise.weight_scale));
        }
        let store = match blocks {
            Some(blocks) => {
                let blocks = rescaled(blocks, &mut ingest, noise.weight_scale)?;
                Store::Resident(Resident::new(blocks))
            }
            None => Store::Streamed(Box::new(Stream::new(ingest, options.memory_bytes))),
        };
        Ok(Self {
            observation,
            field,
            info,
            profile: options.profile,
            store,
            removed: Vec::new(),
            n_eval: 0,
            engine: options.engine,
            memory_bytes: options.memory_bytes,
            sizes: Vec::new(),
            uv_profile,
            instrument,
        })
    }
}

/// The terms of the instrument for all rows of a field.
fn instrument(
    observation: &Observation,
    field: u32,
    terms: &InstrumentTerms,
) -> Option<Instrument> {
    let freqs_hz = (observation.freq_setups.iter()).flat_map(|setup| &setup.freq_hz_f);
    let band_hz = freqs_hz.fold([f64::INFINITY, 0.0], |[low, high], &freq_hz| {
        [low.min(freq_hz), f64::max(high, freq_hz)]
    });
    let field = &observation.fields[field as usize];
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
    scale: f64,
) -> Result<Vec<VisBlock>, DatasetError> {
    if scale != 1.0 {
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
        progress(ingest.n_row);
    }
    Ok(kept)
}

fn choose_field(observation: &Observation, wanted: Option<&str>) -> Result<u32, String> {
    let fields = &observation.fields;
    let names = || {
        let list = fields
            .iter()
            .enumerate()
            .map(|(i, f)| format!("{i} {}", f.name));
        list.collect::<Vec<_>>().join(", ")
    };
    match wanted {
        None if fields.len() == 1 => Ok(0),
        None => Err(format!(
            "there are {} fields; choose one with --field: {}",
            fields.len(),
            names()
        )),
        Some(wanted) => fields
            .iter()
            .position(|f| f.name.trim() == wanted)
            .or_else(|| wanted.parse().ok().filter(|i| *i < fields.len()))
            .map(|i| i as u32)
            .ok_or_else(|| format!("there is no field '{wanted}'; there are: {}", names())),
    }
}

/// Everything that is counted in the first pass.
struct FirstPass {
    info: DataInfo,
    noise: NoiseTally,
    uv_profile: UvProfile,
    typical_scale_rad: f64,
    sum_weight: f64,
    sum_weight_freq: f64,
    sum_tapered: f64,
    sum_tapered_uv2: f64,
}

impl FirstPass {
    fn new(typical_scale_rad: f64) -> Self {
        let info = DataInfo {
            first_mjd: f64::INFINITY,
            last_mjd: f64::NEG_INFINITY,
            ..DataInfo::default()
        };
        Self {
            info,
            noise: NoiseTally::default(),
            uv_profile: UvProfile::default(),
            typical_scale_rad,
            sum_weight: 0.0,
            sum_weight_freq: 0.0,
            sum_tapered: 0.0,
            sum_tapered_uv2: 0.0,
        }
    }

    fn finish(self) -> DataInfo {
        // Each of u and v has half of the mean square; the correlation of two positions falls
        // like a Gaussian of this width.
        let uv_rms = (0.5 * self.sum_tapered_uv2 / self.sum_tapered).sqrt();
        DataInfo {
            mean_freq_hz: self.sum_weight_freq / self.sum_weight,
            beam_rad: 1.0 / (std::f64::consts::TAU * uv_rms),
            ..self.info
        }
    }
}

impl Tally for FirstPass {
    fn row(&mut self) {
        self.info.n_row_used += 1;
    }

    fn flagged(&mut self) {
        self.info.n_flagged += 1;
    }

    fn sample(&mut self, sample: &Sample) {
        let info = &mut self.info;
        info.n_sample += 1;
        info.first_mjd = info.first_mjd.min(sample.time_mjd);
        info.last_mjd = info.last_mjd.max(sample.time_mjd);
        let [u, v, w] = sample.uvw;
        let uv2 = u * u + v * v;
        info.max_uv = info.max_uv.max(uv2.sqrt());
        info.max_w = info.max_w.max(w.abs());
        let weight = f64::from(sample.weight);
        self.uv_profile.add(sample.uvw, weight);
        self.sum_weight += weight;
        self.sum_weight_freq += weight * sample.freq_hz;
        // F² of an exponential disk of the typical scale-length.
        let t = 1.0 + (std::f64::consts::TAU * self.typical_scale_rad).powi(2) * uv2;
        let tapered = weight / (t * t * t);
        self.sum_tapered += tapered;
        self.sum_tapered_uv2 += tapered * uv2;
        self.noise.sample(sample);
    }
}
