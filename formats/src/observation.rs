//! What a visibility file is about.

use serde::Serialize;

/// What the rows of a file have in common.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Observation {
    /// Telescope or array name.
    pub telescope: String,
    /// Instrument or correlator, where given.
    pub instrument: String,
    /// Observer, where given.
    pub observer: String,
    /// First day of the observation as the file gives it (`YYYY-MM-DD`), where given.
    pub date_obs: String,
    /// Array reference position, geocentric ITRF [m]; zero where the antennas' own are absolute.
    pub array_position_m: [f64; 3],
    /// Antennas, in the order of the file's table.
    pub antennas: Vec<Antenna>,
    /// Phase centres.
    pub fields: Vec<Field>,
    /// Frequency set-ups (UVFITS FREQSEL, MS spectral windows), each with its channels.
    pub freq_setups: Vec<FreqSetup>,
    /// Correlations of every row, in order.
    pub corrs: Vec<Corr>,
    /// Rows (baseline times time) in the file, before any selection or averaging.
    pub n_row: u64,
    /// Scale of the times.
    pub time_scale: TimeScale,
    /// Earth orientation as stored, where stored.
    pub earth: EarthOrientation,
    /// Free text history.
    pub history: Vec<String>,
    /// What the reader found odd but could live with, in words for the user.
    pub warnings: Vec<String>,
    /// What only UVH5 files say; `None` for other formats.
    pub uvh5: Option<Uvh5Notes>,
    /// What only Measurement Sets say; `None` for other formats.
    pub ms: Option<MsNotes>,
}

impl Observation {
    /// Nothing if all data are phased; `format` cannot hold others, which is told in words.
    pub(crate) fn check_phased(&self, format: &str) -> Result<(), String> {
        match self.fields.iter().find(|field| field.drifts) {
            Some(field) => Err(format!(
                "the data of '{}' are not phased (drift scan), which {format} cannot hold: write UVH5, or \
                 phase them first, with pyuvdata's UVData.phase",
                field.name
            )),
            None => Ok(()),
        }
    }

    /// The array's own position, or the mean of its antennas' where these are all there is [m].
    pub(crate) fn array_or_mean_m(&self) -> [f64; 3] {
        if self.array_position_m != [0.0; 3] {
            return self.array_position_m;
        }
        let n_antenna = self.antennas.len() as f64;
        [0, 1, 2].map(|d| self.antennas.iter().map(|a| a.itrf_m[d]).sum::<f64>() / n_antenna)
    }
}

/// Which columns of a Measurement Set were read.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct MsNotes {
    /// Column of the visibilities.
    pub data_column: String,
    /// Column of the weights, or of the standard deviations that they were made of.
    pub weight_column: String,
    /// Row in the table `SPECTRAL_WINDOW` of each frequency set-up.
    pub spw_s: Vec<u32>,
}

/// What only UVH5 files say of an observation.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Uvh5Notes {
    /// Number of the spectral window of each channel.
    pub spw_f: Vec<i64>,
    /// Unit of the visibilities: `Jy`, `K str` or `uncalib`.
    pub vis_units: String,
    /// Whether I is the sum or the mean of the parallel hands: `sum` or `avg`, where given.
    pub pol_convention: Option<String>,
    /// What the first linear feed points at: `east` or `north`, where given.
    pub x_orientation: Option<String>,
}

/// One antenna.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Antenna {
    /// Number in the file's own counting.
    pub number: u32,
    /// Name or station.
    pub name: String,
    /// Geocentric ITRF position [m].
    pub itrf_m: [f64; 3],
    /// Dish diameter [m], where given.
    pub diameter_m: Option<f64>,
}

/// A phase centre.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Field {
    /// Source name.
    pub name: String,
    /// Right ascension [rad] in `frame`.
    pub ra_rad: f64,
    /// Declination [rad] in `frame`.
    pub dec_rad: f64,
    /// Celestial frame.
    pub frame: Frame,
    /// The data are not phased: (u, v, w) are those of a direction that goes with the Earth, and there
    /// is neither right ascension nor declination.
    pub drifts: bool,
}

/// Celestial frame of a direction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub enum Frame {
    /// International Celestial Reference System.
    #[default]
    Icrs,
    /// FK5 with its equinox [Julian year].
    Fk5(f64),
    /// FK4 with its equinox [Besselian year].
    Fk4(f64),
}

/// The channels of one frequency set-up, IF after IF.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FreqSetup {
    /// Centre of each channel [Hz].
    pub freq_hz_f: Vec<f64>,
    /// Width of each channel [Hz], negative where the frequency falls with the channel number.
    pub chan_width_hz_f: Vec<f64>,
    /// Number of IFs (sub-bands) that the channels are made of.
    pub n_if: usize,
}

/// A correlation product or Stokes parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "UPPERCASE")]
#[allow(missing_docs)]
pub enum Corr {
    I,
    Q,
    U,
    V,
    Rr,
    Ll,
    Rl,
    Lr,
    Xx,
    Yy,
    Xy,
    Yx,
}

/// Scale of the times in a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum TimeScale {
    /// Coordinated universal time.
    #[default]
    Utc,
    /// International atomic time.
    Tai,
    /// Something else, taken as UTC with a warning.
    Other,
}

/// Earth orientation of the reference day.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EarthOrientation {
    /// UT1 - UTC [s].
    pub ut1_utc_s: Option<f64>,
    /// Polar motion (x, y) [arcsec].
    pub polar_motion_arcsec: Option<[f64; 2]>,
    /// Greenwich apparent sidereal time at 0 h UTC of the reference date [deg].
    pub gst0_deg: Option<f64>,
}
