//! The observation: set up once, then run chunk after chunk into a writer.

use std::f64::consts::TAU;

use num_complex::Complex;
use rayon::prelude::*;
use sofars::consts::DAYSEC;
use vis2cat_formats::{Observation, VisChunk, VisWriter};

use super::rows::RowModel;
use super::{
    EarthTable, Pointing, SimulateConfig, SimulateError, Site, UvwFrame, describe, format_utc,
    noise,
};
use crate::rime::Source;
use crate::units::{DEG, SPEED_OF_LIGHT};

/// Day whose transit an observation without a start is centred on: 2020-01-01.
const DEFAULT_DAY_MJD: f64 = 58849.0;
/// Visibilities in a chunk (about 13 bytes each, and 16 more while at work).
const VALUES_PER_CHUNK: usize = 1 << 20;
/// Sidereal rotation of the Earth in turns per UT1 day (IAU 2000).
const TURNS_PER_DAY: f64 = 1.002_737_811_911_354_6;

/// A simulation that is ready to run.
#[derive(Debug, Clone)]
pub struct Simulation {
    config: SimulateConfig,
    observation: Observation,
    start_mjd: f64,
    pointing_t: Vec<Pointing>,
    baselines: Vec<(u32, u32)>,
    sigma_jy_b: Vec<f64>,
}

/// What was simulated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SimulationSummary {
    /// Rows (baseline times time) written.
    pub n_row: u64,
    /// Samples in time.
    pub n_time: usize,
    /// Visibilities written: rows times channels times correlations.
    pub n_vis: u64,
    /// Start of the first sample, UTC [MJD, day].
    pub start_mjd: f64,
    /// End of the last sample, UTC [MJD, day].
    pub end_mjd: f64,
    /// Lowest and highest elevation of the phase centre [rad].
    pub elevation_rad: [f64; 2],
    /// Lowest and highest noise of a visibility [Jy], each of real and imaginary part.
    pub sigma_jy: [f64; 2],
    /// Longest projected baseline at the highest channel [wavelengths].
    pub uv_max_lambda: f64,
    /// Signal-to-noise ratio S sqrt(Σ w F²) of each source, in the order given.
    pub snr_s: Vec<f64>,
    /// What is odd, in words for the user.
    pub warnings: Vec<String>,
}

/// What `config` observes, as it goes into the file.
///
/// # Errors
/// As [`Simulation::new`].
pub fn observation(config: &SimulateConfig) -> Result<Observation, SimulateError> {
    Simulation::new(config).map(|simulation| simulation.observation)
}

/// Simulates `config` with `sources` into `writer`, which stays to be finished by the caller.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::run`].
pub fn simulate(
    config: &SimulateConfig,
    sources: &[Source],
    writer: &mut dyn VisWriter,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<SimulationSummary, SimulateError> {
    Simulation::new(config)?.run(sources, writer, progress)
}

impl Simulation {
    /// Checks `config` and works out times, pointings and noise.
    ///
    /// # Errors
    /// A value makes no sense, an SEFD or the Earth's orientation is not known, or the phase centre
    /// is never above the horizon.
    pub fn new(config: &SimulateConfig) -> Result<Self, SimulateError> {
        config.check()?;
        let table = EarthTable::builtin()?;
        let orientation = |mjd: f64| match config.ut1_utc_s {
            Some(ut1_utc_s) => Ok(table.with_ut1_utc(mjd, ut1_utc_s)),
            None => table.at(mjd),
        };
        let site = Site::from_itrf(config.array.centre_m())?;
        let point = |mjd: f64| Pointing::at(config.centre, site, mjd, orientation(mjd)?);
        let start_mjd = match config.start_mjd {
            Some(start_mjd) => start_mjd,
            None => start_about_transit(config, site, &point)?,
        };
        let pointing_t = (0..config.n_time())
            .into_par_iter()
            .map(|t| point(mid_mjd(config, start_mjd, t)))
            .collect::<Result<Vec<_>, _>>()?;
        let baselines = config.array.baselines();
        let earth = describe::earth_of_day(start_mjd, orientation(start_mjd.floor())?)?;
        let n_row = (baselines.len() * pointing_t.len()) as u64;
        let mut simulation = Self {
            observation: describe::describe(config, start_mjd, earth, n_row),
            sigma_jy_b: noise::sigma_jy_b(config, &baselines)?,
            config: config.clone(),
            start_mjd,
            pointing_t,
            baselines,
        };
        simulation.check_horizon()?;
        Ok(simulation)
    }

    /// What is observed, as it goes into the file.
    pub fn observation(&self) -> &Observation {
        &self.observation
    }

    /// Simulates `sources` into `writer`; `progress` hears of the rows done and the rows in all.
    ///
    /// Positions of the sources are about the phase centre. Noise depends on the seed and the row
    /// only, so the outcome is the same for any number of threads.
    ///
    /// # Errors
    /// A chunk could not be written.
    pub fn run(
        &self,
        sources: &[Source],
        writer: &mut dyn VisWriter,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<SimulationSummary, SimulateError> {
        let model = RowModel::new(&self.config, self.start_mjd, sources);
        let mut chunk = VisChunk::new(VALUES_PER_CHUNK / model.values_per_row());
        let mut sum_wf2_s = vec![0.0; sources.len()];
        let mut uv_max_m: f64 = 0.0;
        let mut n_row = 0;
        for t in 0..self.pointing_t.len() {
            let uvw_m_a = self.antenna_uvw_m(t);
            for (pairs, sigma_jy_r) in self
                .baselines
                .chunks(chunk.max_row)
                .zip(self.sigma_jy_b.chunks(chunk.max_row))
            {
                self.fill_rows(t, pairs, &uvw_m_a, &mut chunk);
                model.fill(n_row, sigma_jy_r, &mut chunk, &mut sum_wf2_s);
                uv_max_m = uv_max_m.max(longest_uv_m(&chunk));
                writer.write_chunk(&chunk)?;
                n_row += pairs.len() as u64;
                progress(n_row, self.observation.n_row);
            }
        }
        let snr_s = sources
            .iter()
            .zip(&sum_wf2_s)
            .map(|(source, sum_wf2)| source.flux_jy * sum_wf2.sqrt())
            .collect();
        Ok(self.summary(n_row, uv_max_m, snr_s))
    }

    /// (u, v, w) [m] of every antenna's position at time `t`.
    fn antenna_uvw_m(&self, t: usize) -> Vec<[f64; 3]> {
        let frame = UvwFrame::new(&self.pointing_t[t]);
        let centre_m = self.config.array.centre_m();
        let offset_m = |itrf_m: [f64; 3]| std::array::from_fn(|k| itrf_m[k] - centre_m[k]);
        let dishes = self.config.array.dishes.iter();
        dishes
            .map(|dish| frame.apply(offset_m(dish.itrf_m)))
            .collect()
    }

    /// Everything of the rows of `pairs` at time `t` but the values.
    fn fill_rows(
        &self,
        t: usize,
        pairs: &[(u32, u32)],
        uvw_m_a: &[[f64; 3]],
        chunk: &mut VisChunk,
    ) {
        chunk.clear(self.config.n_chan, self.config.corrs.len());
        let n_row = pairs.len();
        for &(i, j) in pairs {
            let (p, q) = (uvw_m_a[i as usize], uvw_m_a[j as usize]);
            chunk.uvw_m_r.push([p[0] - q[0], p[1] - q[1], p[2] - q[2]]);
            chunk.ant1_r.push(i);
            chunk.ant2_r.push(j);
        }
        let mjd = mid_mjd(&self.config, self.start_mjd, t);
        chunk.n_row = n_row;
        chunk.time_mjd_r.resize(n_row, mjd);
        chunk.interval_s_r.resize(n_row, self.config.interval_s);
        chunk.field_r.resize(n_row, 0);
        chunk.freq_setup_r.resize(n_row, 0);
        let n_value = n_row * chunk.values_per_row();
        chunk.vis_jy_rfp.resize(n_value, Complex::default());
        chunk.weight_rfp.resize(n_value, 0.0);
        chunk.flag_rfp.resize(n_value, false);
    }

    fn summary(&self, n_row: u64, uv_max_m: f64, snr_s: Vec<f64>) -> SimulationSummary {
        let n_time = self.pointing_t.len();
        let freq_hz = self.config.freq_hz_f().into_iter().fold(0.0, f64::max);
        let end_mjd = self.start_mjd + n_time as f64 * self.config.interval_s / DAYSEC;
        SimulationSummary {
            n_row,
            n_time,
            n_vis: n_row * (self.config.n_chan * self.config.corrs.len()) as u64,
            start_mjd: self.start_mjd,
            end_mjd,
            elevation_rad: self.elevation_rad(),
            sigma_jy: extremes(self.sigma_jy_b.iter().copied()),
            uv_max_lambda: uv_max_m * freq_hz / SPEED_OF_LIGHT,
            snr_s,
            warnings: self.observation.warnings.clone(),
        }
    }

    fn elevation_rad(&self) -> [f64; 2] {
        extremes(
            self.pointing_t
                .iter()
                .map(|pointing| pointing.elevation_rad),
        )
    }

    /// An error where the phase centre is never up, a warning where it is not always.
    fn check_horizon(&mut self) -> Result<(), SimulateError> {
        let [lowest_deg, highest_deg] = self.elevation_rad().map(|rad| rad / DEG);
        if highest_deg <= 0.0 {
            return Err(SimulateError::parameter(format!(
                "the phase centre is below the horizon of {} all the time from {} on (highest \
                 elevation {highest_deg:.1} deg); choose another start, array or centre",
                self.config.array.name,
                format_utc(self.start_mjd)
            )));
        }
        if lowest_deg < 0.0 {
            let below = |pointing: &&Pointing| pointing.elevation_rad < 0.0;
            self.observation.warnings.push(format!(
                "the phase centre is below the horizon in {} of {} samples in time",
                self.pointing_t.iter().filter(below).count(),
                self.pointing_t.len()
            ));
        }
        Ok(())
    }
}

/// Start [MJD, day, to the whole second] of an observation centred on the transit of the phase centre
/// on [`DEFAULT_DAY_MJD`].
fn start_about_transit(
    config: &SimulateConfig,
    site: Site,
    point: &impl Fn(f64) -> Result<Pointing, SimulateError>,
) -> Result<f64, SimulateError> {
    let mut transit_mjd = DEFAULT_DAY_MJD + 0.5;
    for _ in 0..3 {
        let hour_angle_turns = (point(transit_mjd)?.gha_rad + site.lon_rad) / TAU;
        transit_mjd -= (hour_angle_turns - hour_angle_turns.round()) / TURNS_PER_DAY;
    }
    let length_s = config.n_time() as f64 * config.interval_s;
    Ok((transit_mjd * DAYSEC - 0.5 * length_s).round() / DAYSEC)
}

/// Mid-point [MJD, day] of sample `t`.
fn mid_mjd(config: &SimulateConfig, start_mjd: f64, t: usize) -> f64 {
    start_mjd + (t as f64 + 0.5) * config.interval_s / DAYSEC
}

/// Longest projected baseline [m].
fn longest_uv_m(chunk: &VisChunk) -> f64 {
    let lengths_m = chunk.uvw_m_r.iter().map(|[u, v, _]| u.hypot(*v));
    lengths_m.fold(0.0, f64::max)
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coords::Lm;
    use crate::rime::InstrumentTerms;
    use crate::rime::shape::Profile;
    use crate::simulate::Array;

    /// Keeps what it is given.
    #[derive(Default)]
    struct Kept(Vec<Complex<f64>>);

    impl VisWriter for Kept {
        fn write_chunk(&mut self, chunk: &VisChunk) -> Result<(), vis2cat_formats::WriteError> {
            let wide = |vis: &Complex<f32>| Complex::new(f64::from(vis.re), f64::from(vis.im));
            self.0.extend(chunk.vis_jy_rfp.iter().map(wide));
            Ok(())
        }

        fn finish(self: Box<Self>) -> Result<(), vis2cat_formats::WriteError> {
            Ok(())
        }
    }

    fn run(config: &SimulateConfig) -> Vec<Complex<f64>> {
        let source = Source {
            lm: Lm {
                l: 0.007,
                m: -0.009,
            },
            flux_jy: 1.0,
            ..Source::default()
        };
        let mut kept = Kept::default();
        simulate(config, &[source], &mut kept, &mut |_, _| {}).unwrap();
        kept.0
    }

    /// One smeared sample of every baseline against the mean of 21 x 21 points in time and frequency.
    #[test]
    fn smearing_is_the_mean_over_the_sample() {
        let smeared = SimulateConfig {
            array: Array::find("meerkat").unwrap(),
            centre: crate::coords::RaDec {
                ra_rad: 53.1 * DEG,
                dec_rad: -30.0 * DEG,
            },
            start_mjd: Some(58_849.75),
            duration_s: 8.0,
            interval_s: 8.0,
            freq_hz: 1.28e9,
            bandwidth_hz: 2e6,
            corrs: vec![vis2cat_formats::Corr::I],
            noise: false,
            profile: Profile::Point,
            instrument: InstrumentTerms {
                smearing: true,
                ..InstrumentTerms::default()
            },
            ..SimulateConfig::default()
        };
        let n = 21;
        let fine = SimulateConfig {
            interval_s: 8.0 / f64::from(n),
            n_chan: n as usize,
            instrument: InstrumentTerms::default(),
            ..smeared.clone()
        };
        let (got, points) = (run(&smeared), run(&fine));
        let (n_row, n) = (got.len(), n as usize);
        let mut most_lost: f64 = 0.0;
        for (row, got) in got.iter().enumerate() {
            let of_time = |t: usize| {
                points[(t * n_row + row) * n..][..n]
                    .iter()
                    .sum::<Complex<f64>>()
            };
            let mean: Complex<f64> = (0..n).map(of_time).sum::<Complex<f64>>() / (n * n) as f64;
            most_lost = most_lost.max(1.0 - mean.norm());
            assert!((got - mean).norm() < 2e-3, "{row}: {got} {mean}");
        }
        assert!(most_lost > 0.3, "no test of smearing: {most_lost}");
    }
}
