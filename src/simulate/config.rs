//! What to simulate.

use vis2cat_formats::Corr;

use super::{Array, SimulateError};
use crate::coords::RaDec;
use crate::rime::InstrumentTerms;
use crate::rime::shape::Profile;

/// Most samples in time (115 days of 1 s), so that a slip in a unit does not run for ever.
const MAX_TIME: usize = 10_000_000;

/// What to simulate; everything in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulateConfig {
    /// Array.
    pub array: Array,
    /// Name of the field.
    pub field_name: String,
    /// Phase centre, ICRS.
    pub centre: RaDec,
    /// Start of the first sample, UTC as modified Julian date [day]; `None`: the observation is
    /// centred on the transit of the phase centre on 2020-01-01, to the whole second.
    pub start_mjd: Option<f64>,
    /// Length of the observation [s], rounded to whole samples (at least one).
    pub duration_s: f64,
    /// Length of a sample [s].
    pub interval_s: f64,
    /// Middle of the band [Hz].
    pub freq_hz: f64,
    /// Width of the band [Hz].
    pub bandwidth_hz: f64,
    /// Channels that the band is cut into.
    pub n_chan: usize,
    /// What each row holds: the two parallel hands, one of them, or Stokes I.
    pub corrs: Vec<Corr>,
    /// System equivalent flux density of every dish [Jy]; `None`: each dish's own.
    pub sefd_jy: Option<f64>,
    /// System efficiency eta.
    pub efficiency: f64,
    /// False: the weights are those of the noise, the visibilities free of it.
    pub noise: bool,
    /// Seed of the noise.
    pub seed: u64,
    /// Smearing, primary beam, spectral index.
    pub instrument: InstrumentTerms,
    /// Radial profile of the sources.
    pub profile: Profile,
    /// UT1-UTC [s]; `None`: that of the built-in table, and an error outside it.
    pub ut1_utc_s: Option<f64>,
}

impl Default for SimulateConfig {
    /// Eight hours through transit in samples of a minute, 1280-1520 MHz in one channel, XX and YY;
    /// array and phase centre are to be filled in.
    fn default() -> Self {
        Self {
            array: Array::default(),
            field_name: "SIMULATED".to_owned(),
            centre: RaDec::default(),
            start_mjd: None,
            duration_s: 8.0 * 3600.0,
            interval_s: 60.0,
            freq_hz: 1.4e9,
            bandwidth_hz: 240e6,
            n_chan: 1,
            corrs: vec![Corr::Xx, Corr::Yy],
            sefd_jy: None,
            efficiency: 0.9,
            noise: true,
            seed: 0,
            instrument: InstrumentTerms::default(),
            profile: Profile::default(),
            ut1_utc_s: None,
        }
    }
}

impl SimulateConfig {
    /// Number of samples in time.
    pub fn n_time(&self) -> usize {
        ((self.duration_s / self.interval_s).round() as usize).max(1)
    }

    /// Width of a channel [Hz].
    pub fn chan_width_hz(&self) -> f64 {
        self.bandwidth_hz / self.n_chan as f64
    }

    /// Centre of each channel [Hz].
    pub fn freq_hz_f(&self) -> Vec<f64> {
        let width_hz = self.chan_width_hz();
        let first_hz = self.freq_hz - 0.5 * (self.bandwidth_hz - width_hz);
        (0..self.n_chan)
            .map(|chan| first_hz + chan as f64 * width_hz)
            .collect()
    }

    /// Checks every field by itself and against the others.
    pub(super) fn check(&self) -> Result<(), SimulateError> {
        check_positive("duration", self.duration_s)?;
        check_positive("sample length", self.interval_s)?;
        check_positive("frequency", self.freq_hz)?;
        check_positive("bandwidth", self.bandwidth_hz)?;
        check_positive("efficiency", self.efficiency)?;
        if let Some(sefd_jy) = self.sefd_jy {
            check_positive("SEFD", sefd_jy)?;
        }
        if !self.start_mjd.unwrap_or_default().is_finite() {
            return Err(SimulateError::parameter("the start is not a time"));
        }
        if self.duration_s / self.interval_s > MAX_TIME as f64 {
            return Err(SimulateError::parameter(format!(
                "{:.0} samples in time are more than {MAX_TIME}; take longer samples",
                self.duration_s / self.interval_s
            )));
        }
        let refuse = |what: &str| Err(SimulateError::parameter(what));
        if self.array.dishes.len() < 2 {
            return refuse("an array has two dishes or more");
        }
        if self.n_chan == 0 {
            return refuse("there must be a channel");
        }
        if self.bandwidth_hz >= 2.0 * self.freq_hz {
            return refuse("the band reaches below 0 Hz");
        }
        if !(self.centre.ra_rad.is_finite()
            && self.centre.dec_rad.abs() <= std::f64::consts::FRAC_PI_2)
        {
            return refuse("the phase centre's declination lies between -90 and +90 degrees");
        }
        if !hands_are_known(&self.corrs) {
            return refuse("the hands are XX and YY, RR and LL, one of these, or I");
        }
        Ok(())
    }
}

fn check_positive(name: &str, value: f64) -> Result<(), SimulateError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(SimulateError::parameter(format!(
        "the {name} must be above zero, not {value}"
    )))
}

fn hands_are_known(corrs: &[Corr]) -> bool {
    use Corr::{I, Ll, Rr, Xx, Yy};
    matches!(
        corrs,
        [I | Xx | Yy | Rr | Ll] | [Xx, Yy] | [Yy, Xx] | [Rr, Ll] | [Ll, Rr]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> SimulateConfig {
        SimulateConfig {
            array: Array::find("atca-6a").unwrap(),
            ..SimulateConfig::default()
        }
    }

    #[test]
    fn channels_fill_the_band() {
        let config = SimulateConfig {
            n_chan: 4,
            ..good()
        };
        assert_eq!(config.freq_hz_f(), [1.31e9, 1.37e9, 1.43e9, 1.49e9]);
        assert_eq!(config.chan_width_hz(), 60e6);
    }

    #[test]
    fn senseless_values_are_refused() {
        assert!(good().check().is_ok());
        let edits: [fn(&mut SimulateConfig); 8] = [
            |c| c.duration_s = 0.0,
            |c| c.freq_hz = f64::NAN,
            |c| c.n_chan = 0,
            |c| c.corrs = vec![Corr::Xx, Corr::Ll],
            |c| c.centre.dec_rad = 2.0,
            |c| c.bandwidth_hz = 3e9,
            |c| c.start_mjd = Some(f64::NAN),
            |c| c.interval_s = 1e-6,
        ];
        for edit in edits {
            let mut config = good();
            edit(&mut config);
            assert!(config.check().is_err());
        }
    }
}
