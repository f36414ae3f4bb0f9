//! Provenance: what the headers say about data and run.

use vis2cat_formats::fits::{Cards, Keyword};

use super::row::Flags;
use crate::coords::RaDec;
use crate::rime::shape::Profile;
use crate::units::DEG;

/// What the observation was and how the run was configured.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueHeader {
    /// Telescope.
    pub telescope: Option<String>,
    /// Name of the field or its source.
    pub object: Option<String>,
    /// Start of the observation, UTC, `yyyy-mm-ddThh:mm:ss`.
    pub date_obs: Option<String>,
    /// The same as modified Julian date [d].
    pub mjd_obs: Option<f64>,
    /// Frequency to which the flux densities belong [Hz].
    pub ref_freq_hz: Option<f64>,
    /// Where l = m = 0, ICRS.
    pub phase_centre: RaDec,
    /// Family of shapes that was fitted.
    pub profile: Profile,
    /// Seed of all randomness.
    pub seed: u64,
    /// A primary beam was applied: there are `App_flux` and `PB_gain`.
    pub has_beam: bool,
    /// Sources were selected by the probability to be bright: there is `P_above`.
    pub has_p_above: bool,
    /// Spectral indices were free: there are columns of them.
    pub has_spectral_index: bool,
    /// Ranges of the priors.
    pub priors: Vec<PriorRange>,
    /// The configuration in full, one line each.
    pub config: Vec<String>,
}

/// Range of one parameter's prior.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorRange {
    /// Parameter, as the columns call it.
    pub parameter: String,
    /// Unit of the two ends; empty if there is none.
    pub unit: String,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Shape, such as `power law, index -1.34`.
    pub form: String,
}

impl CatalogueHeader {
    /// Header of the primary HDU: everything.
    pub(super) fn primary(&self) -> Cards {
        Cards {
            history: self.config.clone(),
            ..self.table()
        }
    }

    /// Header of a table of positions: everything but the configuration.
    pub(super) fn table(&self) -> Cards {
        let mut keywords = vec![
            Keyword::new("ORIGIN", "vis2cat", "program that made this file"),
            Keyword::new("CREATOR", creator(), "program and version"),
            Keyword::new("RADESYS", "ICRS", "frame of all positions"),
        ];
        keywords.extend(self.observation());
        keywords.push(Keyword::new("SEED", self.seed, "seed of all randomness"));
        for (i, prior) in self.priors.iter().enumerate() {
            keywords.extend(prior.keywords(i + 1));
        }
        Cards {
            keywords,
            ..Cards::default()
        }
    }

    /// Header of `CATALOGUE`: also what the columns mean beyond a line.
    pub(super) fn catalogue(&self) -> Cards {
        let factor = self.profile.shape().fwhm_per_scale();
        let profile = format!("{:?}", self.profile).to_lowercase();
        let mut comments = vec![
            format!("Shapes are {profile}: Maj and Min are full widths at half maximum,"),
            format!("{factor:.5} times the scale-length of that axis."),
            "Errors are standard deviations of the posterior.".to_owned(),
            "NaN is a value that is missing or not defined.".to_owned(),
            "Sources of one Group_id overlap and were sampled jointly: they have equally"
                .to_owned(),
            "many rows in POSTERIOR, and row k of each is one joint draw.".to_owned(),
            "Flags is the sum of:".to_owned(),
        ];
        for (bit, meaning) in Flags::MEANING {
            comments.push(format!("{:>5}  {meaning}", bit.0));
        }
        Cards {
            comments,
            ..self.table()
        }
    }

    fn observation(&self) -> Vec<Keyword> {
        let text = |key, value: &Option<String>, comment| {
            value
                .as_ref()
                .map(|v| Keyword::new(key, v.as_str(), comment))
        };
        let number = |key, value: Option<f64>, comment| {
            let finite = value.filter(|v| v.is_finite());
            finite.map(|v| Keyword::new(key, v, comment))
        };
        let dated = self.date_obs.is_some() || self.mjd_obs.is_some();
        let centre = self.phase_centre;
        [
            text("TELESCOP", &self.telescope, "telescope"),
            text("OBJECT", &self.object, "field"),
            dated.then(|| Keyword::new("TIMESYS", "UTC", "time scale of the dates")),
            text("DATE-OBS", &self.date_obs, "start of the observation"),
            number("MJD-OBS", self.mjd_obs, "[d] start of the observation"),
            number(
                "RESTFRQ",
                self.ref_freq_hz,
                "[Hz] frequency of the flux densities",
            ),
            number(
                "PHASERA",
                Some(centre.ra_rad / DEG),
                "[deg] RA where l = m = 0, ICRS",
            ),
            number(
                "PHASEDEC",
                Some(centre.dec_rad / DEG),
                "[deg] DEC where l = m = 0, ICRS",
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl PriorRange {
    fn keywords(&self, n: usize) -> Vec<Keyword> {
        let key = |stem: &str| format!("{stem}{n}");
        let mut keywords = vec![Keyword::new(
            &key("PRNAM"),
            self.parameter.as_str(),
            "parameter with a prior",
        )];
        if !self.form.is_empty() {
            keywords.push(Keyword::new(&key("PRFRM"), self.form.as_str(), "its prior"));
        }
        let unit = match self.unit.as_str() {
            "" => String::new(),
            unit => format!("[{unit}] "),
        };
        let ends = [
            ("PRMIN", self.low, "lower end"),
            ("PRMAX", self.high, "upper end"),
        ];
        for (stem, value, comment) in ends.into_iter().filter(|(_, v, _)| v.is_finite()) {
            keywords.push(Keyword::new(&key(stem), value, &format!("{unit}{comment}")));
        }
        keywords
    }
}

fn creator() -> String {
    format!("vis2cat {}", env!("CARGO_PKG_VERSION"))
}

/// Header of tables that need no more than who made them.
pub(super) fn minimal() -> Cards {
    Cards {
        keywords: vec![
            Keyword::new("ORIGIN", "vis2cat", "program that made this file"),
            Keyword::new("CREATOR", creator(), "program and version"),
        ],
        ..Cards::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_is_one_bit_of_its_own() {
        let mut all = 0;
        for (flag, _) in Flags::MEANING {
            assert!(flag.0.count_ones() == 1 && all & flag.0 == 0);
            all |= flag.0;
        }
    }

    #[test]
    fn the_limit_in_the_text_is_the_limit() {
        assert!(
            Flags::MEANING[0]
                .1
                .contains(&Flags::N_EFF_LIMIT.to_string())
        );
    }
}
