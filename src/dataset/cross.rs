//! Several sources together: what they have in common, and regions in which they are looked at.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::answers::Question;
use super::memo::Memo;
use super::views::{POINTS_PER_TASK, ask_views};
use super::{Dataset, DatasetError, View, ViewRequest};
use crate::likelihood::facet::{CrossBuilder, CrossFacet, FacetPlan};
use crate::likelihood::{PairTerm, Xy, accumulate_pairs, joint_log_l, pairs};
use crate::prior::Region;
use crate::rime::Source;

/// Regions about sources that are looked at together: made ready when evaluated for the first time.
pub struct JointView {
    /// One for each source, with all of them in the data.
    members: Vec<View>,
    /// The smallest region that holds all of theirs.
    united: Region,
    /// Some must be evaluated by all visibilities.
    is_exact: bool,
    /// None inside: what they have in common is summed over all samples.
    cross: OnceLock<Option<CrossFacet>>,
    /// Sums at unit flux density: those of the members, and of pairs. Points beside each other have most
    /// of their sources in common.
    known: RefCell<Known>,
}

#[derive(Debug, Default)]
struct Known {
    xy: Vec<Memo<UnitKey, Xy>>,
    cross: Memo<[UnitKey; 2], f64>,
}

/// Sources with the same one look the same at unit flux density.
type UnitKey = [u64; 6];

fn unit_key(source: &Source) -> UnitKey {
    let Source {
        lm,
        scale_rad,
        e,
        tilt,
        ..
    } = source;
    [lm.l, lm.m, *scale_rad, e.e1, e.e2, *tilt].map(f64::to_bits)
}

impl JointView {
    /// The regions of a group; the sources that any of them puts back must be the same.
    pub fn new(requests: Vec<ViewRequest>) -> Self {
        Self {
            united: united(&requests),
            is_exact: requests.iter().any(|request| request.is_exact),
            known: RefCell::new(Known {
                xy: requests.iter().map(|_| Memo::default()).collect(),
                cross: Memo::default(),
            }),
            members: requests.into_iter().map(View::new).collect(),
            cross: OnceLock::new(),
        }
    }

    /// The facet of a view that is ready, if it has one.
    fn cross(&self) -> Option<&CrossFacet> {
        self.cross.get()?.as_ref()
    }
}

impl Dataset {
    /// Y_ij [Jy⁻²] at unit flux density of every pair, in one pass over the data.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn cross(&mut self, pairs: &[[Source; 2]]) -> Result<Vec<f64>, DatasetError> {
        if pairs.is_empty() {
            return Ok(Vec::new());
        }
        self.n_eval += pairs.len() as u64;
        let ask = |question: &mut Question| question.sources(pairs.as_flattened());
        self.answer("pairs", ask, |dataset| dataset.sum_cross(pairs))
    }

    /// The sums themselves.
    fn sum_cross(&mut self, pairs: &[[Source; 2]]) -> Result<Vec<f64>, DatasetError> {
        let mut sums = vec![0.0; pairs.len()];
        if pairs.is_empty() {
            return Ok(sums);
        }
        let profile = self.profile;
        let terms: Vec<PairTerm> = pairs.iter().map(|p| PairTerm::new(p, profile)).collect();
        self.for_each_batch(|blocks| accumulate_pairs(blocks, &terms, &mut sums))?;
        Ok(sums)
    }

    /// Fills the facets for what the members of new `views` have in common.
    fn make_cross_ready(&mut self, views: &[&JointView]) -> Result<(), DatasetError> {
        let is_new = |view: &&&JointView| view.cross.get().is_none();
        let views: Vec<&JointView> = views.iter().filter(is_new).copied().collect();
        for (plan, which) in self.cross_plans(&views) {
            let centre = |&i: &usize| views[i].united.from_unit(0.5, 0.5);
            let centres: Vec<_> = which.iter().map(centre).collect();
            let mut builder = CrossBuilder::new(plan, &centres);
            self.for_few_blocks(|blocks| builder.add(blocks))?;
            for (i, facet) in which.into_iter().zip(builder.finish()) {
                views[i].cross.get_or_init(|| Some(facet));
            }
        }
        for view in views {
            view.cross.get_or_init(|| None);
        }
        Ok(())
    }

    /// Which groups are served by facets, with the plans of these, as many at a time as fit the
    /// memory budget.
    fn cross_plans(&self, views: &[&JointView]) -> Vec<(Arc<FacetPlan>, Vec<usize>)> {
        let mut by_size: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
        for (i, view) in views.iter().enumerate() {
            if !view.is_exact {
                let step = self.size_step(&view.united);
                by_size.entry(step).or_default().push(i);
            }
        }
        let mut plans = Vec::new();
        for (step, which) in by_size {
            let needs = CrossFacet::needs(self.facet_needs(step));
            let Some(plan) = self.plan(needs).map(Arc::new) else {
                continue;
            };
            let chunks = which.chunks(self.at_a_time(plan.build_bytes()));
            plans.extend(chunks.map(|which| (plan.clone(), which.to_vec())));
        }
        plans
    }

    /// ln L - ln L0 of the points of each view, a point being one source for each of its regions; the
    /// removed sources must be those of the time when the views were made.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn evaluate_joint_views(
        &mut self,
        jobs: &[(&JointView, &[Source])],
    ) -> Result<Vec<Vec<f64>>, DatasetError> {
        let count = |(view, points): &(&JointView, &[Source])| points.len() / view.members.len();
        for job @ (view, points) in jobs {
            let n_pair = pairs(view.members.len()).count();
            self.n_eval += (points.len() + count(job) * n_pair) as u64;
        }
        let ask = |question: &mut Question| {
            for (view, points) in jobs {
                let members = view.members.iter().map(|member| (member, &[][..]));
                ask_views(question, &members.collect::<Vec<_>>());
                question.sources(points);
            }
        };
        let log_l = self.answer("groups", ask, |data| {
            Ok(data.sum_joint_views(jobs)?.concat())
        })?;
        let mut log_l = log_l.into_iter();
        Ok(jobs
            .iter()
            .map(|job| log_l.by_ref().take(count(job)).collect())
            .collect())
    }

    /// The same, worked out.
    fn sum_joint_views(
        &mut self,
        jobs: &[(&JointView, &[Source])],
    ) -> Result<Vec<Vec<f64>>, DatasetError> {
        let mut xy = self.xy_of_views(jobs)?.into_iter();
        let cross = self.cross_of_views(jobs)?;
        let log_l = |((view, points), cross): (&(&JointView, &[Source]), Vec<f64>)| {
            let count = view.members.len();
            let xy: Vec<Vec<Xy>> = xy.by_ref().take(count).collect();
            let n_pair = pairs(count).count();
            let point = |(i, sources): (usize, &[Source])| {
                let xy: Vec<Xy> = xy.iter().map(|xy| xy[i]).collect();
                joint_log_l(sources, &xy, &cross[n_pair * i..n_pair * (i + 1)])
            };
            points.chunks_exact(count).enumerate().map(point).collect()
        };
        Ok(jobs.iter().zip(cross).map(log_l).collect())
    }

    /// X and Y of all points of every member of each view.
    fn xy_of_views(
        &mut self,
        jobs: &[(&JointView, &[Source])],
    ) -> Result<Vec<Vec<Xy>>, DatasetError> {
        let mut asked = Vec::new();
        for (view, points) in jobs {
            for (i, memo) in view.known.borrow_mut().xy.iter_mut().enumerate() {
                let of_member = points.iter().skip(i).step_by(view.members.len());
                asked.push(memo.ask(of_member.copied(), unit_key));
            }
        }
        let views = jobs.iter().flat_map(|(view, _)| &view.members);
        let wanted = asked.iter().map(|asked| asked.wanted.as_slice());
        let sums = self.sum_views(&views.zip(wanted).collect::<Vec<_>>())?;
        let mut answers = asked.iter().zip(&sums);
        let mut xy = Vec::with_capacity(asked.len());
        for (view, _) in jobs {
            let mut known = view.known.borrow_mut();
            for (memo, (asked, sums)) in known.xy.iter_mut().zip(answers.by_ref()) {
                xy.push(memo.complete(asked, sums));
            }
        }
        Ok(xy)
    }

    /// Y_ij of all pairs in all points of each view: by facets, and by one pass for all others.
    fn cross_of_views(
        &mut self,
        jobs: &[(&JointView, &[Source])],
    ) -> Result<Vec<Vec<f64>>, DatasetError> {
        let evaluated = jobs.iter().filter(|(_, points)| !points.is_empty());
        self.make_cross_ready(&evaluated.map(|(view, _)| *view).collect::<Vec<_>>())?;
        let ask = |(view, points): &(&JointView, &[Source])| {
            let count = view.members.len();
            let pairs_of = |p: &[Source]| pairs(count).map(|[i, j]| [p[i], p[j]]).collect();
            let points = points.chunks_exact(count);
            let all = points.flat_map(|p| -> Vec<[Source; 2]> { pairs_of(p) });
            let mut known = view.known.borrow_mut();
            known.cross.ask(all, |pair| pair.each_ref().map(unit_key))
        };
        let asked: Vec<_> = jobs.iter().map(ask).collect();
        let all = || jobs.iter().map(|(view, _)| *view).zip(&asked);
        let without: Vec<[Source; 2]> = all()
            .filter(|(view, _)| view.cross().is_none())
            .flat_map(|(_, asked)| asked.wanted.iter().copied())
            .collect();
        let mut summed = self.sum_cross(&without)?.into_iter();
        let by_facet = |facet: &CrossFacet, wanted: &[[Source; 2]]| -> Vec<f64> {
            let tasks = wanted.par_chunks(POINTS_PER_TASK);
            tasks
                .flat_map_iter(|pairs| facet.cross_batch(pairs))
                .collect()
        };
        let sums = all().map(|(view, asked)| {
            let sums: Vec<f64> = match view.cross() {
                Some(facet) => by_facet(facet, &asked.wanted),
                None => summed.by_ref().take(asked.wanted.len()).collect(),
            };
            view.known.borrow_mut().cross.complete(asked, &sums)
        });
        Ok(sums.collect())
    }
}

/// The smallest region that holds all of `requests`.
fn united(requests: &[ViewRequest]) -> Region {
    let regions = requests.iter().map(|request| request.region);
    let all = regions.reduce(|all, region| all.united(&region));
    all.unwrap_or_else(|| Region::square(crate::coords::Lm::default(), 0.0))
}
