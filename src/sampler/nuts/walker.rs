//! One chain of nuts-rs in a thread of its own.

use nalgebra::DVector;
use nuts_rs::{
    Chain as _, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError,
    Settings as _,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Draws that the step and the scales are found with.
const N_TUNE: usize = 200;
/// A trajectory has at most 2 to the power of this many steps: where that is too short, others are too.
const MOST_DOUBLINGS: u64 = 6;

/// What a chain says.
enum Message {
    /// It waits for ln p here, and its slope.
    Place(DVector<f64>),
    /// It has made a draw.
    Draw(DVector<f64>),
}

/// A chain in a thread of its own, which ends when nobody answers any more.
#[derive(Debug)]
pub(super) struct Walker {
    messages: Receiver<Message>,
    answers: Sender<(f64, Vec<f64>)>,
    /// Its draws, those of tuning first.
    all_draws: Vec<DVector<f64>>,
}

impl Walker {
    /// The chain `number` of several, from `start` on.
    pub(super) fn start(start: DVector<f64>, seed: u64, number: usize) -> Self {
        let (say, messages) = channel();
        let (answers, heard) = channel();
        std::thread::spawn(move || {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(number as u64 + 1);
            let settings = DiagNutsSettings {
                num_tune: N_TUNE as u64,
                maxdepth: MOST_DOUBLINGS,
                ..DiagNutsSettings::default()
            };
            let density = Density {
                n_dim: start.len(),
                say: say.clone(),
                heard,
            };
            let Ok(mut chain) = settings.new_chain(0, CpuMath::new(density), &mut rng) else {
                return;
            };
            let mut is_well = chain.set_position(start.as_slice()).is_ok();
            while is_well {
                is_well = chain.draw().is_ok_and(|(draw, _)| {
                    let draw = DVector::from_column_slice(&draw);
                    say.send(Message::Draw(draw)).is_ok()
                });
            }
        });
        Self {
            messages,
            answers,
            all_draws: Vec::new(),
        }
    }

    /// Takes its draws until it wants a slope; none if it has ended.
    pub(super) fn next_place(&mut self) -> Option<DVector<f64>> {
        loop {
            match self.messages.recv().ok()? {
                Message::Place(place) => return Some(place),
                Message::Draw(draw) => self.all_draws.push(draw),
            }
        }
    }

    /// ln p at its place, and the slope.
    pub(super) fn answer(&self, log_p: f64, slope: Vec<f64>) {
        // A chain that has ended is found out when it is asked to go on.
        let _ = self.answers.send((log_p, slope));
    }

    /// Draws after those of tuning.
    pub(super) fn n_draw(&self) -> usize {
        self.all_draws.len().saturating_sub(N_TUNE)
    }

    /// The first `count` of these.
    pub(super) fn draws(&self, count: usize) -> impl Iterator<Item = &DVector<f64>> {
        self.all_draws.iter().skip(N_TUNE).take(count)
    }
}

/// ln p as a chain sees it.
#[derive(Debug)]
struct Density {
    n_dim: usize,
    say: Sender<Message>,
    heard: Receiver<(f64, Vec<f64>)>,
}

#[derive(Debug, thiserror::Error)]
enum NoDensity {
    #[error("ln p is not finite")]
    NotFinite,
    #[error("nobody answers")]
    Alone,
}

impl LogpError for NoDensity {
    fn is_recoverable(&self) -> bool {
        matches!(self, Self::NotFinite)
    }
}

impl HasDims for Density {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.n_dim as u64)])
    }
}

impl CpuLogpFunc for Density {
    type LogpError = NoDensity;
    type ExpandedVector = Vec<f64>;
    type FlowParameters = ();

    fn dim(&self) -> usize {
        self.n_dim
    }

    fn logp(&mut self, place: &[f64], slope: &mut [f64]) -> Result<f64, NoDensity> {
        let question = Message::Place(DVector::from_column_slice(place));
        self.say.send(question).map_err(|_| NoDensity::Alone)?;
        let (log_p, answer) = self.heard.recv().map_err(|_| NoDensity::Alone)?;
        slope.copy_from_slice(&answer);
        if log_p.is_finite() && slope.iter().all(|slope| slope.is_finite()) {
            Ok(log_p)
        } else {
            Err(NoDensity::NotFinite)
        }
    }

    fn expand_vector<R: Rng + ?Sized>(
        &mut self,
        _rng: &mut R,
        place: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(place.to_vec())
    }
}
