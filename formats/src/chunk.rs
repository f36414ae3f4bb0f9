//! The block of rows that moves between a file and the program.

use num_complex::Complex;

use crate::Observation;

/// Times beyond this have no calendar day [day].
const MAX_MJD: f64 = 1e6;
/// Coordinates beyond this are mistakes: the Moon is at 4e8 m.
const MAX_UVW_M: f64 = 1e15;

/// Values of a chunk between two readers: 13 MB.
const MAX_VALUES: usize = 1 << 20;

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
    /// Baseline coordinates [m], one (u, v, w) a row, of r(ant1) - r(ant2).
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

/// A row without its visibilities, in the senses of a [`VisChunk`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowHead {
    pub(crate) uvw_m: [f64; 3],
    pub(crate) time_mjd: f64,
    pub(crate) interval_s: f64,
    pub(crate) ants: [u32; 2],
    pub(crate) field: u32,
    pub(crate) freq_setup: u32,
}

impl VisChunk {
    /// An empty chunk that takes at most `max_row` rows a read (at least one).
    pub fn new(max_row: usize) -> Self {
        Self {
            max_row: max_row.max(1),
            ..Self::default()
        }
    }

    /// For a reader over another reader: takes as many rows as whoever asks wants, but never so many
    /// that the values of `observation` are too many to hold.
    pub(crate) fn take_at_most(&mut self, max_row: usize, observation: &Observation) {
        let chans = observation.freq_setups.iter().map(|s| s.freq_hz_f.len());
        let values = chans.max().unwrap_or(1) * observation.corrs.len();
        self.max_row = max_row.clamp(1, (MAX_VALUES / values.max(1)).max(1));
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

    /// Appends what a row says besides its visibilities.
    pub(crate) fn push(&mut self, head: &RowHead) {
        self.uvw_m_r.push(head.uvw_m);
        self.time_mjd_r.push(head.time_mjd);
        self.interval_s_r.push(head.interval_s);
        self.ant1_r.push(head.ants[0]);
        self.ant2_r.push(head.ants[1]);
        self.field_r.push(head.field);
        self.freq_setup_r.push(head.freq_setup);
    }

    /// What a row says besides its visibilities.
    pub(crate) fn head(&self, row: usize) -> RowHead {
        RowHead {
            uvw_m: self.uvw_m_r[row],
            time_mjd: self.time_mjd_r[row],
            interval_s: self.interval_s_r[row],
            ants: [self.ant1_r[row], self.ant2_r[row]],
            field: self.field_r[row],
            freq_setup: self.freq_setup_r[row],
        }
    }

    /// Values in one row: channels times correlations.
    pub fn values_per_row(&self) -> usize {
        self.n_chan * self.n_corr
    }

    /// Whether a writer can take the rows: the shape must be that of `observation`, and only what
    /// that has may be named. `n_before` rows have been written before; errors are in words.
    pub(crate) fn check(&self, observation: &Observation, n_before: u64) -> Result<(), String> {
        let setup = observation.freq_setups.first();
        let n_chan = setup.map_or(0, |setup| setup.freq_hz_f.len());
        let n_corr = observation.corrs.len();
        if (self.n_chan, self.n_corr) != (n_chan, n_corr) {
            return Err(format!(
                "a chunk has {} channels and {} correlations, the observation {n_chan} and {n_corr}",
                self.n_chan, self.n_corr
            ));
        }
        self.check_lengths()?;
        self.check_indices(observation, n_before)?;
        let sound = |row: &usize| {
            self.time_mjd_r[*row].abs() < MAX_MJD
                && self.uvw_m_r[*row].iter().all(|x| x.abs() < MAX_UVW_M)
        };
        match (0..self.n_row).find(|row| !sound(row)) {
            Some(row) => Err(format!(
                "row {}: MJD {} or (u, v, w) {:?} m cannot be",
                n_before + row as u64 + 1,
                self.time_mjd_r[row],
                self.uvw_m_r[row]
            )),
            None => Ok(()),
        }
    }

    fn check_lengths(&self) -> Result<(), String> {
        let n_row = self.n_row;
        let n_value = n_row * self.values_per_row();
        let lens = [
            (self.uvw_m_r.len(), n_row),
            (self.time_mjd_r.len(), n_row),
            (self.interval_s_r.len(), n_row),
            (self.ant1_r.len(), n_row),
            (self.ant2_r.len(), n_row),
            (self.field_r.len(), n_row),
            (self.freq_setup_r.len(), n_row),
            (self.vis_jy_rfp.len(), n_value),
            (self.weight_rfp.len(), n_value),
            (self.flag_rfp.len(), n_value),
        ];
        if lens.iter().any(|(found, wanted)| found != wanted) {
            return Err(format!(
                "a chunk of {n_row} rows has arrays of other lengths"
            ));
        }
        Ok(())
    }

    fn check_indices(&self, observation: &Observation, n_before: u64) -> Result<(), String> {
        let indices = [
            ("antenna", &self.ant1_r, observation.antennas.len()),
            ("antenna", &self.ant2_r, observation.antennas.len()),
            ("field", &self.field_r, observation.fields.len()),
            (
                "frequency set-up",
                &self.freq_setup_r,
                observation.freq_setups.len(),
            ),
        ];
        for (what, values, len) in indices {
            if let Some(row) = values.iter().position(|&index| index as usize >= len) {
                let at = n_before + row as u64 + 1;
                return Err(format!("row {at}: {what} {} of {len}", values[row]));
            }
        }
        Ok(())
    }

    /// Appends the rows `from..to` of another chunk of the same shape.
    pub(crate) fn append(&mut self, other: &Self, from: usize, to: usize) {
        let per_row = other.values_per_row();
        let values = from * per_row..to * per_row;
        self.n_row += to - from;
        self.uvw_m_r.extend(&other.uvw_m_r[from..to]);
        self.time_mjd_r.extend(&other.time_mjd_r[from..to]);
        self.interval_s_r.extend(&other.interval_s_r[from..to]);
        self.ant1_r.extend(&other.ant1_r[from..to]);
        self.ant2_r.extend(&other.ant2_r[from..to]);
        self.field_r.extend(&other.field_r[from..to]);
        self.freq_setup_r.extend(&other.freq_setup_r[from..to]);
        self.vis_jy_rfp.extend(&other.vis_jy_rfp[values.clone()]);
        self.weight_rfp.extend(&other.weight_rfp[values.clone()]);
        self.flag_rfp.extend(&other.flag_rfp[values]);
    }
}

/// Visibility, weight and flag as a chunk keeps them, and whether it was flagged for not being
/// finite; `weight` is negative where the sample is flagged. A value that is not finite is replaced by zero, so that zero weight times it is zero.
pub(crate) fn settle(re: f32, im: f32, weight: f32) -> (Complex<f32>, f32, bool, bool) {
    let finite_vis = re.is_finite() && im.is_finite();
    let finite = finite_vis && weight.is_finite();
    let good = finite && weight > 0.0;
    let vis = if finite_vis {
        Complex::new(re, im)
    } else {
        Complex::default()
    };
    let kept = if good { weight } else { 0.0 };
    (
        vis,
        kept,
        !good,
        !finite && (weight > 0.0 || weight.is_nan()),
    )
}
