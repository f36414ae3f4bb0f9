//! The values of the rows: the model, the noise, the weights.

use num_complex::Complex;
use rayon::prelude::*;
use vis2cat_formats::{Frame, VisChunk};

use super::SimulateConfig;
use super::noise::NoiseSource;
use super::predict::{Component, Look};
use crate::coords::IcrsCentre;
use crate::rime::{Instrument, Source, pole_of};

/// Rows that one task works on; fixed, so that sums do not depend on the number of threads.
const ROWS_PER_TASK: usize = 64;

/// What makes the values of a row from its (u, v, w) and noise level.
#[derive(Debug, Clone)]
pub(super) struct RowModel {
    components: Vec<Component>,
    look: Look,
    n_corr: usize,
    noise: Option<NoiseSource>,
}

/// Consecutive rows, worked on by one thread.
struct Rows<'a> {
    /// Number of the first in the observation.
    first_row: u64,
    uvw_m_r: &'a [[f64; 3]],
    sigma_jy_r: &'a [f64],
    vis_jy_rfp: &'a mut [Complex<f32>],
    weight_rfp: &'a mut [f32],
}

impl RowModel {
    pub(super) fn new(config: &SimulateConfig, start_mjd: f64, sources: &[Source]) -> Self {
        let freq_hz_f = config.freq_hz_f();
        let band_hz = [freq_hz_f[0], freq_hz_f[config.n_chan - 1]];
        let pole = pole_of(2000.0 + (start_mjd - 51544.5) / 365.25);
        let pole = IcrsCentre::new(config.centre, Frame::Icrs).from_icrs(pole);
        let look = Look {
            freq_hz_f,
            width_hz: config.chan_width_hz(),
            interval_s: config.interval_s,
            instrument: Instrument::new(&config.instrument, band_hz, pole),
        };
        let component = |source| Component::new(source, config.profile, &look);
        Self {
            components: sources.iter().map(component).collect(),
            look: look.clone(),
            n_corr: config.corrs.len(),
            noise: config.noise.then(|| NoiseSource::new(config.seed)),
        }
    }

    /// Channels times correlations.
    pub(super) fn values_per_row(&self) -> usize {
        self.look.freq_hz_f.len() * self.n_corr
    }

    /// Visibilities and weights of the rows of `chunk`, the first of which is row `first_row` of the
    /// observation; `sigma_jy_r` is the noise of each. Adds Σ w F² of each source to `sum_wf2_s`.
    pub(super) fn fill(
        &self,
        first_row: u64,
        sigma_jy_r: &[f64],
        chunk: &mut VisChunk,
        sum_wf2_s: &mut [f64],
    ) {
        let values_per_task = ROWS_PER_TASK * self.values_per_row();
        let sums: Vec<Vec<f64>> = chunk
            .vis_jy_rfp
            .par_chunks_mut(values_per_task)
            .zip(chunk.weight_rfp.par_chunks_mut(values_per_task))
            .zip(chunk.uvw_m_r.par_chunks(ROWS_PER_TASK))
            .zip(sigma_jy_r.par_chunks(ROWS_PER_TASK))
            .enumerate()
            .map(
                |(task, (((vis_jy_rfp, weight_rfp), uvw_m_r), sigma_jy_r))| {
                    self.fill_task(Rows {
                        first_row: first_row + (task * ROWS_PER_TASK) as u64,
                        uvw_m_r,
                        sigma_jy_r,
                        vis_jy_rfp,
                        weight_rfp,
                    })
                },
            )
            .collect();
        for sum_s in sums {
            for (total, sum) in sum_wf2_s.iter_mut().zip(sum_s) {
                *total += sum;
            }
        }
    }

    /// Fills `rows` and returns Σ w F² of each component over them.
    fn fill_task(&self, rows: Rows) -> Vec<f64> {
        let Rows {
            first_row,
            uvw_m_r,
            sigma_jy_r,
            vis_jy_rfp,
            weight_rfp,
        } = rows;
        let per_row = self.values_per_row();
        let mut sum_wf2_s = vec![0.0; self.components.len()];
        let mut model_jy_f = vec![Complex::default(); self.look.freq_hz_f.len()];
        let values = vis_jy_rfp
            .chunks_mut(per_row)
            .zip(weight_rfp.chunks_mut(per_row));
        let inputs = uvw_m_r.iter().zip(sigma_jy_r);
        for ((row, (vis_jy_fp, weight_fp)), (&uvw_m, &sigma_jy)) in
            (first_row..).zip(values).zip(inputs)
        {
            let weight = sigma_jy.powi(-2);
            model_jy_f.fill(Complex::default());
            for (component, sum_wf2) in self.components.iter().zip(&mut sum_wf2_s) {
                let sum_f2 = component.add_to(uvw_m, &self.look, &mut model_jy_f);
                *sum_wf2 += weight * self.n_corr as f64 * sum_f2;
            }
            for (vis_jy_p, model_jy) in vis_jy_fp.chunks_mut(self.n_corr).zip(&model_jy_f) {
                vis_jy_p.fill(Complex::new(model_jy.re as f32, model_jy.im as f32));
            }
            if let Some(noise) = &self.noise {
                noise.add_to(row, sigma_jy, vis_jy_fp);
            }
            weight_fp.fill(weight as f32);
        }
        sum_wf2_s
    }
}
