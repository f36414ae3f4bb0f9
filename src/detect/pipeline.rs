//! The whole of detection, readable aloud.

use super::accept::{Cuts, accept};
use super::certify::{Certificate, certify};
use super::density::Census;
use super::explore::{Explored, SamplerFactory, SamplerSettings, Target, Task, explore};
use super::joint::Joined;
use super::leftover::Leftovers;
use super::queue::{Queue, Search};
use super::refine::{CLOSE_BEAMS, Found, Refinement};
use super::select::{Likely, select};
use super::{DetectError, Mode, Observer, Status, Tile};
use crate::dataset::Dataset;
use crate::prior::{Region, SourcePrior, Window};
use crate::sampler::Health;

/// Rounds of screening, search and subtraction, before we let it be.
const MOST_ROUNDS: usize = 200;

/// What to look for, and how.
pub struct Settings<'a> {
    /// The field of view.
    pub field: Region,
    /// Its tiles.
    pub tiles: Vec<Tile>,
    /// Width of the beam [rad].
    pub beam_rad: f64,
    /// The whole field is one tile, and searched once.
    pub is_global: bool,
    /// Leave out tiles that cannot hold a source.
    pub screening: bool,
    /// Prior of one source.
    pub prior: SourcePrior,
    /// What makes a mode a source.
    pub cuts: Cuts,
    /// Of those, what is likely enough; none: all of them.
    pub likely: Option<Likely>,
    /// Makes the samplers.
    pub factory: &'a SamplerFactory<'a>,
    /// Live points of a tile.
    pub n_live: usize,
    /// Live points about a single source.
    pub n_live_source: usize,
    /// Sample sources again with the others removed, and search again under them.
    pub refine: bool,
    /// Seed of every random stream.
    pub seed: u64,
}

/// What was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Detection {
    /// Every mode of every tile, with its status, in order of tiles.
    pub modes: Vec<Mode>,
    /// The sources, brightest first: each with the index of its mode in `modes`.
    pub sources: Vec<Detected>,
    /// Likelihood evaluations.
    pub n_eval: u64,
    /// ln Z of one source in the tiles of each round, against no source, with the prior of the
    /// whole field.
    pub log_z: Vec<f64>,
    /// Tiles that were searched, counted again each time.
    pub n_tile_searched: usize,
    /// What was left out, if tiles were screened.
    pub screening: Option<Screening>,
    /// What tells sources from noise.
    pub census: Census,
    /// Searches that were stopped before they had the whole evidence of their tile.
    pub n_tile_unfinished: usize,
    /// How well the samplers did that searched tiles.
    pub search_health: Health,
    /// How well those did that drew the posteriors of the sources, groups apart.
    pub source_health: Health,
}

impl Detection {
    /// Tells how well the samplers did, loudly where they did not.
    fn report_health(&self) {
        if self.n_tile_unfinished > 0 {
            tracing::warn!(
                "{} searches of tiles were stopped before they had all the evidence; what they found was sampled \
                 again, but more live points (--n-live) or smaller tiles (--tile-size) would find more",
                self.n_tile_unfinished
            );
        }
        let stages = [
            ("searches", &self.search_health),
            ("posteriors", &self.source_health),
        ];
        for (stage, health) in stages.into_iter().filter(|(_, h)| h.n_run > 0) {
            tracing::info!("sampling of {stage}: {health}");
            if health.is_suspect() {
                tracing::warn!(
                    "sampling of {stage}: new points do not lie evenly among the live ones, so that evidences \
                     may be wrong; lower --efficiency, or use --sampler slice"
                );
            }
        }
    }
}

/// What came of screening the tiles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screening {
    /// Part of the field that was not searched, as it could not hold a source.
    pub skipped: f64,
    /// Part of its signal-to-noise ratio that a source shows at least, for all but 1% of the prior.
    pub seen: f64,
    /// Tiles that hold something as far below zero as the cut is above it: by symmetry, as many
    /// false sources are expected.
    pub n_negative: usize,
}

/// A source and where it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// Its final posterior.
    pub posterior: Mode,
    /// Index of the mode that it was found as.
    pub mode: usize,
    /// Posterior mean of S sqrt(Y).
    pub snr: f64,
    /// Largest |ln L by all visibilities - ln L by the engine that drew the samples|.
    pub max_dlog_l: f64,
    /// Sources with the same number were sampled jointly: sample k of one belongs to sample k of
    /// the others.
    pub group: usize,
    /// It is coupled to a source of another group: its errors are those for a fixed neighbour.
    pub is_conditional: bool,
}

/// Finds the sources in the data, which are left with all of them removed.
///
/// # Errors
/// The data can no longer be read, or a sampler is stuck.
pub fn detect(
    dataset: &mut Dataset,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Detection, DetectError> {
    let mut detection = Detection::default();
    let mut sources: Vec<Found> = Vec::new();
    let mut queue = Queue::new(dataset, settings)?;
    let mut leftovers = Leftovers::default();
    for round in 0..MOST_ROUNDS {
        // What the models of these leave beside them is looked for below the cut.
        let is_settled = !settings.refine || sources.iter().all(|found| found.is_full);
        let settled = if settings.refine && is_settled {
            &sources[..]
        } else {
            &[]
        };
        let searches = queue.take(dataset, settings, settled, observer)?;
        if searches.is_empty() {
            if is_settled {
                break;
            }
            let refinement = refinement(settings, round);
            let (modes, cuts) = (&mut detection.modes, &settings.cuts);
            refinement.prune(dataset, &mut sources, modes, cuts, observer)?;
            refinement.finish(dataset, &mut sources, observer)?;
            queue.reopen_faint();
            continue;
        }
        detection.n_tile_searched += searches.len();
        let (first, first_mode) = (sources.len(), detection.modes.len());
        search(
            dataset,
            settings,
            &searches,
            round,
            &mut sources,
            &mut detection,
            observer,
        )?;
        if !settings.refine {
            continue;
        }
        let refinement = refinement(settings, round);
        if sources.len() > first {
            refinement.settle(dataset, &mut sources, first, observer)?;
        }
        let (modes, cuts) = (&mut detection.modes, &settings.cuts);
        let tries = leftovers.take(modes, first_mode, &sources, settings.beam_rad);
        if !tries.is_empty() {
            let first = sources.len();
            sources.extend(tries);
            refinement.try_leftovers(dataset, &mut sources, first, modes, cuts, observer)?;
        }
        if sources.len() > first {
            // A tile in which something was found may hold more.
            let holds = |tile: &Tile| {
                sources[first..]
                    .iter()
                    .any(|found| tile.region.contains(found.mode.mean.lm))
            };
            let again = searches
                .into_iter()
                .map(|search| search.tile)
                .filter(|tile| !settings.is_global && holds(tile));
            again.for_each(|tile| queue.put_back(tile));
        }
    }
    let mut certificates = certified(dataset, settings, &mut sources, observer)?;
    detection.census = census(dataset, settings, &sources)?;
    let joined = if settings.refine {
        let refinement = refinement(settings, MOST_ROUNDS);
        refinement.join(dataset, &mut sources, &mut certificates, observer)?
    } else {
        Joined::alone(sources.len())
    };
    detection.source_health = sources.iter().map(|found| found.health).sum();
    detection.report_health();
    detection.sources = detected(sources, &certificates, &joined);
    if let Some(likely) = &settings.likely {
        select(&mut detection, likely);
    }
    detection.n_eval = dataset.n_eval();
    detection.screening = queue.screening(&settings.field);
    Ok(detection)
}

/// Every source looked at by all visibilities; those whose samples are not good enough for that are
/// sampled again by all visibilities.
fn certified(
    dataset: &mut Dataset,
    settings: &Settings,
    sources: &mut [Found],
    observer: &mut dyn Observer,
) -> Result<Vec<Certificate>, DetectError> {
    let each: Vec<Vec<usize>> = (0..sources.len()).map(|i| vec![i]).collect();
    let mut certificates = certify(dataset, sources, &each)?.concat();
    let failed: Vec<usize> = (0..sources.len())
        .filter(|&i| !certificates[i].is_valid)
        .collect();
    if !failed.is_empty() && dataset.views_take_a_pass() {
        tracing::info!(
            "{} sources are sampled again by all visibilities",
            failed.len()
        );
        let refinement = refinement(settings, MOST_ROUNDS);
        refinement.finish_exactly(dataset, sources, &failed, observer)?;
        certificates = certify(dataset, sources, &each)?.concat();
    }
    Ok(certificates)
}

/// Searches tiles and accepts what is found.
fn search(
    dataset: &mut Dataset,
    settings: &Settings,
    searches: &[Search],
    round: usize,
    sources: &mut Vec<Found>,
    detection: &mut Detection,
    observer: &mut dyn Observer,
) -> Result<(), DetectError> {
    let mut modes = search_tiles(dataset, settings, searches, round, detection, observer)?;
    let removed: Vec<_> = sources.iter().map(|found| found.mode.mean).collect();
    accept(dataset, &removed, &mut modes, &settings.cuts)?;
    let first = detection.modes.len();
    drop_repeats(&mut detection.modes, &mut modes, settings.beam_rad);
    for explained_by in modes
        .iter_mut()
        .filter_map(|mode| mode.explained_by.as_mut())
    {
        *explained_by += first;
    }
    let new = modes
        .iter()
        .enumerate()
        .filter(|(_, mode)| mode.status == Status::Kept);
    sources.extend(new.map(|(i, mode)| Found::new(first + i, mode.clone())));
    detection
        .modes
        .extend(modes.into_iter().map(Mode::without_samples));
    Ok(())
}

/// Modes below the cut that another search has found again, within the width of the beam, are
/// duplicates: the `old` ones, which saw more of the brighter sources, and those of the `new` ones that
/// are the weaker in an overlap of tiles.
fn drop_repeats(old: &mut [Mode], new: &mut [Mode], beam_rad: f64) {
    let first = old.len();
    let is_open = |mode: &Mode| matches!(mode.status, Status::Kept | Status::BelowCut);
    let is_near = |a: &Mode, b: &Mode| a.mean.lm.distance(b.mean.lm) < beam_rad;
    for mode in old.iter_mut().filter(|m| m.status == Status::BelowCut) {
        let again = new
            .iter()
            .position(|other| is_open(other) && is_near(mode, other));
        if let Some(j) = again {
            (mode.status, mode.explained_by) = (Status::F1Duplicate, Some(first + j));
        }
    }
    for i in 0..new.len() {
        let mode = &new[i];
        let is_stronger = |other: &Mode| {
            other.tile != mode.tile && (other.snr_peak(), mode.tile) > (mode.snr_peak(), other.tile)
        };
        let again = new
            .iter()
            .position(|other| is_open(other) && is_stronger(other) && is_near(mode, other));
        if let (Status::BelowCut, Some(j)) = (mode.status, again) {
            (new[i].status, new[i].explained_by) = (Status::F1Duplicate, Some(j));
        }
    }
}

/// How many sources there are to be expected, by the evidences of those found: of the modes below the
/// cut not all are known.
fn census(
    dataset: &mut Dataset,
    settings: &Settings,
    sources: &[Found],
) -> Result<Census, DetectError> {
    let Settings { field, prior, .. } = settings;
    let snr_cut = settings.cuts.snr;
    let faint = dataset.part_below(snr_cut, prior);
    // What is nearer is not beside the mode, it is the mode.
    let nearest_rad = CLOSE_BEAMS * settings.beam_rad;
    let confusion = dataset.confusion_of_one(prior, snr_cut, field, nearest_rad)?;
    let modes: Vec<&Mode> = sources.iter().map(|found| &found.mode).collect();
    Ok(Census::take(&modes, faint, confusion))
}

/// Every mode of the tiles, in order of tiles.
fn search_tiles(
    dataset: &mut Dataset,
    settings: &Settings,
    searches: &[Search],
    round: usize,
    detection: &mut Detection,
    observer: &mut dyn Observer,
) -> Result<Vec<Mode>, DetectError> {
    observer.stage("searching tiles", searches.len() as u64);
    let target = |search: &Search| Target {
        region: search.region,
        window: Window::compact(),
        restored: Vec::new(),
        is_exact: false,
        sampler: SamplerSettings {
            n_dim: settings.prior.n_dim(),
            n_live: settings.n_live,
            // What it has found when it stalls is sampled again, and the tile screened again.
            task: Task::Search,
            seed: stream_seed(settings.seed, [1, round as u64, search.tile.id as u64]),
        },
    };
    let mut found: Vec<(Vec<Mode>, f64)> = vec![(Vec::new(), f64::NEG_INFINITY); searches.len()];
    let targets = searches.iter().map(target).collect();
    let (mut n_unfinished, mut health) = (0, Health::default());
    let mut note = |explored: Explored| {
        let log_z = explored.evidence.log_z + explored.log_share(&settings.field);
        health += explored.health;
        let tile = searches[explored.index].tile.id;
        n_unfinished += usize::from(explored.is_unfinished);
        found[explored.index] = (modes_of(tile, &explored, settings), log_z);
    };
    let (prior, factory) = (&settings.prior, settings.factory);
    explore(dataset, prior, factory, targets, observer, &mut note)?;
    detection.n_tile_unfinished += n_unfinished;
    detection.search_health += health;
    detection
        .log_z
        .push(log_sum_exp(found.iter().map(|(_, log_z)| *log_z)));
    Ok(found.into_iter().flat_map(|(modes, _)| modes).collect())
}

fn modes_of(tile: usize, explored: &Explored, settings: &Settings) -> Vec<Mode> {
    let log_share = explored.log_share(&settings.field);
    explored
        .run
        .modes()
        .into_iter()
        .map(|mode| {
            let samples = explored.samples(mode.samples.iter().copied(), &settings.prior);
            let mode = Mode::new(tile, samples, mode.log_z + log_share, mode.log_z_err);
            if mode.best_log_l > 0.0 {
                mode
            } else {
                mode.without_samples()
            }
        })
        .collect()
}

fn refinement<'a>(settings: &'a Settings, round: usize) -> Refinement<'a> {
    Refinement {
        field: &settings.field,
        prior: &settings.prior,
        factory: settings.factory,
        beam_rad: settings.beam_rad,
        n_live_draft: settings.n_live.min(settings.n_live_source),
        n_live: settings.n_live_source,
        seed: stream_seed(settings.seed, [3, round as u64, 0]),
    }
}

/// The sources as they go into the catalogue, brightest first.
fn detected(sources: Vec<Found>, certificates: &[Certificate], joined: &Joined) -> Vec<Detected> {
    let mut detected: Vec<Detected> = sources
        .into_iter()
        .enumerate()
        .zip(certificates)
        .map(|((i, found), certificate)| Detected {
            posterior: found.mode,
            mode: found.origin,
            snr: certificate.snr,
            max_dlog_l: certificate.max_dlog_l,
            group: joined.group[i],
            is_conditional: joined.is_conditional[i],
        })
        .collect();
    detected.sort_by(|a, b| {
        let flux_jy = |d: &Detected| d.posterior.mean.flux_jy;
        flux_jy(b).total_cmp(&flux_jy(a))
    });
    detected
}

fn log_sum_exp(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = values.clone().fold(f64::NEG_INFINITY, f64::max);
    if top.is_finite() {
        top + values.map(|v| (v - top).exp()).sum::<f64>().ln()
    } else {
        top
    }
}

/// A seed for one of many streams, by the SplitMix64 finaliser (Steele, Lea & Flood 2014).
pub(super) fn stream_seed(seed: u64, key: [u64; 3]) -> u64 {
    key.into_iter().fold(seed, |state, k| {
        let mut z = state
            .wrapping_add(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(k.wrapping_mul(0xd134_2543_de82_ef95));
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}
