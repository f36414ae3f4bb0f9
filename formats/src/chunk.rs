//! The block of rows that moves between a file and the program.

use num_complex::Complex;

/// A block of rows, owned by the caller and re-used from read to read.
///
/// Axes, slowest first: `r` row, `f` channel (all IFs of a set-up one after the other), `p`
/// correlation (in the order of [`crate::Observation::corrs`]).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VisChunk {
    /// Most rows that one read may bring.
    pub max_row: usize,
    /// Rows held now.
    pub n_row: usize,
    /// Channels in each row.
    pub n_chan: usize,
    /// Correlations in each channel.
    pub n_corr: usize,
    /// Baseline coordinates [m], one (u, v, w) a row.
    pub uvw_m_r: Vec<[f64; 3]>,
    /// Mid-point of the sample, modified Julian date [day] in the observation's time scale.
    pub time_mjd_r: Vec<f64>,
    /// Integration time [s]; NaN where the file does not say.
    pub interval_s_r: Vec<f64>,
    /// First antenna: index into [`crate::Observation::antennas`].
    pub ant1_r: Vec<u32>,
    /// Second antenna: index into [`crate::Observation::antennas`].
    pub ant2_r: Vec<u32>,
    /// Index into [`crate::Observation::fields`].
    pub field_r: Vec<u32>,
    /// Index into [`crate::Observation::freq_setups`].
    pub freq_setup_r: Vec<u32>,
    /// Visibilities [Jy].
    pub vis_jy_rfp: Vec<Complex<f32>>,
    /// Weights, in the file's own scale, never negative; Jy⁻² where the file keeps to the memo.
    pub weight_rfp: Vec<f32>,
    /// True = bad. A non-finite visibility or weight, or a weight of zero or less, is flagged.
    pub flag_rfp: Vec<bool>,
}

impl VisChunk {
    /// An empty chunk that takes at most `max_row` rows a read (at least one).
    pub fn new(max_row: usize) -> Self {
        Self {
            max_row: max_row.max(1),
            ..Self::default()
        }
    }

    /// Forgets the rows and sets the shape of those to come; keeps the allocations.
    pub fn clear(&mut self, n_chan: usize, n_corr: usize) {
        self.n_row = 0;
        self.n_chan = n_chan;
        self.n_corr = n_corr;
        self.uvw_m_r.clear();
        self.time_mjd_r.clear();
        self.interval_s_r.clear();
        self.ant1_r.clear();
        self.ant2_r.clear();
        self.field_r.clear();
        self.freq_setup_r.clear();
        self.vis_jy_rfp.clear();
        self.weight_rfp.clear();
        self.flag_rfp.clear();
    }

    /// Values in one row: channels times correlations.
    pub fn values_per_row(&self) -> usize {
        self.n_chan * self.n_corr
    }
}
