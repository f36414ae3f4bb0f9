//! Many nested samplers side by side over one data set: every pass over the data serves the
//! batches of all of them.

use rayon::prelude::*;

use super::mode::ModeSample;
use super::{DetectError, Observer};
use crate::dataset::{Dataset, View, ViewRequest};
use crate::likelihood::Xy;
use crate::prior::{Region, SourcePrior, Window};
use crate::rime::Source;
use crate::sampler::{Evidence, Health, NestedRun, Sampler, SamplerError};
use crate::units::ARCSEC;

/// Regions explored at a time: enough points for a pass, few enough dead points to hold.
const IN_FLIGHT: usize = 64;
/// A sample of less weight than this, of a total of one, is not worth keeping.
pub(super) const NO_WEIGHT: f64 = 1e-9;

/// What a sampler is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// To find the modes of a region.
    Search,
    /// To draw the posterior of a source, which is one piece.
    Posterior,
    /// The same, after a sampler for [`Task::Posterior`] made no headway: whatever shape it has.
    AnyPosterior,
}

/// What a new sampler needs to know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplerSettings {
    /// Dimensions of the unit cube.
    pub n_dim: usize,
    /// Live points.
    pub n_live: usize,
    /// What it is for.
    pub task: Task,
    /// Seed of its random stream.
    pub seed: u64,
}

/// Makes the samplers.
pub type SamplerFactory<'a> =
    dyn Fn(SamplerSettings) -> Result<Box<dyn Sampler>, SamplerError> + Sync + 'a;

/// A region to explore.
#[derive(Debug, Clone)]
pub(super) struct Target {
    /// Where.
    pub(super) region: Region,
    /// Which part of the prior.
    pub(super) window: Window,
    /// The removed sources that are put back for it.
    pub(super) restored: Vec<Source>,
    /// Must it be all visibilities?
    pub(super) is_exact: bool,
    /// Its sampler.
    pub(super) sampler: SamplerSettings,
}

/// A finished region.
pub(super) struct Explored {
    /// Position in the list of targets.
    pub(super) index: usize,
    pub(super) region: Region,
    pub(super) window: Window,
    pub(super) run: NestedRun,
    pub(super) evidence: Evidence,
    pub(super) health: Health,
    /// The sampler was stopped before it had the whole evidence.
    pub(super) is_unfinished: bool,
}

struct Active {
    index: usize,
    target: Target,
    view: View,
    sampler: Box<dyn Sampler>,
    is_unfinished: bool,
}

/// Explores all targets and hands each to `done` as it finishes.
pub(super) fn explore(
    dataset: &mut Dataset,
    prior: &SourcePrior,
    factory: &SamplerFactory<'_>,
    targets: Vec<Target>,
    observer: &mut dyn Observer,
    done: &mut dyn FnMut(Explored),
) -> Result<(), DetectError> {
    let mut queue = targets.into_iter().enumerate();
    let mut active: Vec<Active> = Vec::new();
    let (n_eval_before, mut n_done) = (dataset.n_eval(), 0);
    loop {
        // Where a view takes a pass over the data, they are made many at a time.
        if active.is_empty() || !dataset.views_take_a_pass() {
            let room = IN_FLIGHT - active.len();
            let next: Vec<_> = queue.by_ref().take(room).collect();
            active.extend(start(factory, next)?);
        }
        if active.is_empty() {
            return Ok(());
        }
        let points = ask_all(&mut active, prior, factory)?;
        let log_l = evaluate(dataset, &active, &points)?;
        tell_all(&mut active, &log_l)?;
        let (going_on, finished): (Vec<_>, Vec<_>) = active
            .into_iter()
            .zip(points)
            .partition(|(_, points)| !points.is_empty());
        active = going_on.into_iter().map(|(region, _)| region).collect();
        n_done += finished.len() as u64;
        let finished = finished.into_par_iter();
        let explored: Vec<Explored> = finished.map(|(region, _)| region.finish()).collect();
        explored.into_iter().for_each(&mut *done);
        observer.advance(n_done, dataset.n_eval() - n_eval_before);
    }
}

/// Makes the views and the samplers of targets.
fn start(
    factory: &SamplerFactory<'_>,
    targets: Vec<(usize, Target)>,
) -> Result<Vec<Active>, DetectError> {
    let active = |(index, target): (usize, Target)| {
        let view = View::new(ViewRequest {
            region: target.region,
            restored: target.restored.clone(),
            is_exact: target.is_exact,
        });
        let sampler = factory(target.sampler).map_err(|e| in_region(&target.region, e))?;
        Ok(Active {
            index,
            target,
            view,
            sampler,
            is_unfinished: false,
        })
    };
    targets.into_iter().map(active).collect()
}

/// The points that each region wants evaluated; none = finished.
fn ask_all(
    active: &mut [Active],
    prior: &SourcePrior,
    factory: &SamplerFactory<'_>,
) -> Result<Vec<Vec<Source>>, DetectError> {
    active
        .par_iter_mut()
        .map(|a| {
            let Target { region, window, .. } = a.target;
            let u = a.ask(factory).map_err(|e| in_region(&region, e))?;
            Ok(u.chunks_exact(prior.n_dim())
                .map(|u| prior.source(&region, &window.place(u)))
                .collect())
        })
        .collect()
}

impl Active {
    fn finish(self) -> Explored {
        let run = self.sampler.finish();
        let evidence = run.evidence();
        let health = run.health(evidence.log_z_err);
        tracing::debug!("region {}: {health}", self.index);
        if tracing::enabled!(tracing::Level::DEBUG) {
            for history in run.live_history() {
                tracing::debug!("region {}, {history}", self.index);
            }
        }
        Explored {
            index: self.index,
            region: self.target.region,
            window: self.target.window,
            run,
            evidence,
            health,
            is_unfinished: self.is_unfinished,
        }
    }

    /// The sampler's points; none = finished.
    ///
    /// A sampler that makes no headway is replaced if it draws a posterior, and else ends with what it
    /// has.
    fn ask(&mut self, factory: &SamplerFactory<'_>) -> Result<Vec<f64>, SamplerError> {
        loop {
            let settings = &mut self.target.sampler;
            match self.sampler.ask() {
                Ok(u) => return Ok(u.to_vec()),
                Err(SamplerError::Stalled { .. }) if settings.task == Task::Posterior => {
                    settings.task = Task::AnyPosterior;
                    self.sampler = factory(*settings)?;
                }
                Err(SamplerError::Stalled { .. }) => {
                    self.is_unfinished = true;
                    return Ok(Vec::new());
                }
                Err(error) => return Err(error),
            }
        }
    }
}

fn tell_all(active: &mut [Active], log_l: &[Vec<f64>]) -> Result<(), DetectError> {
    active
        .par_iter_mut()
        .zip(log_l)
        .filter(|(_, log_l)| !log_l.is_empty())
        .try_for_each(|(a, log_l)| {
            a.sampler
                .tell(log_l)
                .map_err(|e| in_region(&a.target.region, e))
        })
}

/// ln L of every point.
fn evaluate(
    dataset: &mut Dataset,
    active: &[Active],
    points: &[Vec<Source>],
) -> Result<Vec<Vec<f64>>, DetectError> {
    let jobs: Vec<(&View, &[Source])> = active
        .iter()
        .zip(points)
        .map(|(a, points)| (&a.view, points.as_slice()))
        .collect();
    let xy = dataset.evaluate_views(&jobs)?;
    let log_l = |(points, xy): (&Vec<Source>, &Vec<Xy>)| {
        let pairs = points.iter().zip(xy);
        pairs.map(|(p, xy)| xy.log_l(p.flux_jy)).collect()
    };
    Ok(points.iter().zip(&xy).map(log_l).collect())
}

pub(super) fn in_region(region: &Region, source: SamplerError) -> DetectError {
    let centre = region.from_unit(0.5, 0.5);
    DetectError::Sampler {
        l_arcsec: centre.l / ARCSEC,
        m_arcsec: centre.m / ARCSEC,
        source,
    }
}

impl Explored {
    /// Dead points, each with its ln weight, as samples of sources. Those whose weight is nothing
    /// are left out.
    pub(super) fn samples(
        &self,
        log_weights: impl Iterator<Item = (usize, f64)>,
        prior: &SourcePrior,
    ) -> Vec<ModeSample> {
        let sample = |(i, weight): (usize, f64)| ModeSample {
            source: prior.source(&self.region, &self.window.place(&self.run.dead[i].u)),
            log_l: self.run.dead[i].log_l,
            weight,
        };
        log_weights
            .map(|(i, log_w)| (i, log_w.exp()))
            .filter(|(_, weight)| *weight > NO_WEIGHT)
            .map(sample)
            .collect()
    }

    /// ln of the share that what was explored has of the prior over `field`.
    pub(super) fn log_share(&self, field: &Region) -> f64 {
        (self.region.area() / field.area()).ln() + self.window.log_volume()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Progress;

    /// Cannot go on, or brings one point for ever.
    struct Fake {
        is_stuck: bool,
        u: [f64; 6],
    }

    impl Sampler for Fake {
        fn ask(&mut self) -> Result<&[f64], SamplerError> {
            if self.is_stuck {
                return Err(SamplerError::Stalled {
                    n_eval: 1,
                    log_l: 0.0,
                    advice: String::new(),
                });
            }
            Ok(&self.u)
        }

        fn tell(&mut self, _log_l: &[f64]) -> Result<(), SamplerError> {
            Ok(())
        }

        fn progress(&self) -> Progress {
            Progress::default()
        }

        fn finish(self: Box<Self>) -> NestedRun {
            NestedRun::default()
        }
    }

    #[allow(clippy::unnecessary_wraps)] // as a factory is
    fn fake(settings: SamplerSettings) -> Result<Box<dyn Sampler>, SamplerError> {
        let is_stuck = settings.task != Task::AnyPosterior;
        let u = [0.5; 6];
        Ok(Box::new(Fake { is_stuck, u }))
    }

    #[test]
    fn another_sampler_takes_over_where_one_is_stuck_with_a_posterior() {
        let region = Region::square(crate::coords::Lm::default(), 1e-4);
        let start = |task| {
            let target = Target {
                region,
                window: Window::FULL,
                restored: Vec::new(),
                is_exact: false,
                sampler: SamplerSettings {
                    n_dim: 6,
                    n_live: 10,
                    task,
                    seed: 1,
                },
            };
            start(&fake, vec![(0, target)]).unwrap().remove(0)
        };
        let mut posterior = start(Task::Posterior);
        assert_eq!(posterior.ask(&fake).unwrap(), [0.5; 6]);
        assert_eq!(posterior.target.sampler.task, Task::AnyPosterior);
        assert!(!posterior.is_unfinished);
        // A search ends with what it has.
        let mut search = start(Task::Search);
        assert!(search.ask(&fake).unwrap().is_empty());
        assert!(search.is_unfinished);
    }
}
