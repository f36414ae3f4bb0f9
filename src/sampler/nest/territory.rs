//! Which part of the unit cube belongs to which mode.
//!
//! When a mode splits, every place in the cube goes to the child with the nearest ellipsoid, in
//! the mode dimensions and in units of that ellipsoid. So the modes tile the prior: two of them can never
//! claim the same point, their volumes and evidences add up whether or not a split was wise, and a
//! point that died before the split has one child that it belongs to.

use crate::sampler::bound::Ellipsoid;

/// The tree of splits.
#[derive(Debug, Clone, Default)]
pub(in crate::sampler) struct Territory {
    mode_dims: Vec<usize>,
    /// Of the mode dimensions, which are circles.
    is_wrapped: Vec<bool>,
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Default)]
struct Node {
    parent: Option<usize>,
    /// Of a node that has split: child and one of its ellipsoids in the mode dimensions.
    sites: Vec<(usize, Ellipsoid)>,
}

impl Territory {
    /// One node, which owns the whole cube.
    pub(super) fn new(mode_dims: &[usize], wrapped: &[usize]) -> Self {
        Self {
            mode_dims: mode_dims.to_vec(),
            is_wrapped: mode_dims.iter().map(|d| wrapped.contains(d)).collect(),
            nodes: vec![Node::default()],
        }
    }

    /// Divides `parent` among new children, given the ellipsoids of each; returns the first child.
    pub(super) fn split(&mut self, parent: usize, children: Vec<Vec<Ellipsoid>>) -> usize {
        let first = self.nodes.len();
        for (i, ellipsoids) in children.into_iter().enumerate() {
            self.nodes.push(Node {
                parent: Some(parent),
                sites: Vec::new(),
            });
            let sites = ellipsoids.into_iter().map(|e| (first + i, e));
            self.nodes[parent].sites.extend(sites);
        }
        first
    }

    /// Whether `u` belongs to `node`.
    pub(in crate::sampler) fn owns(&self, node: usize, u: &[f64]) -> bool {
        let Some(mut parent) = self.nodes[node].parent else {
            return true;
        };
        let shadow = self.shadow(u);
        let mut child = node;
        loop {
            if self.child(parent, &shadow) != child {
                return false;
            }
            match self.nodes[parent].parent {
                Some(next) => (child, parent) = (parent, next),
                None => return true,
            }
        }
    }

    /// The undivided node that `u` belongs to.
    pub(super) fn leaf(&self, u: &[f64]) -> usize {
        let shadow = self.shadow(u);
        let mut node = 0;
        while !self.nodes[node].sites.is_empty() {
            node = self.child(node, &shadow);
        }
        node
    }

    fn shadow(&self, u: &[f64]) -> Vec<f64> {
        self.mode_dims.iter().map(|&i| u[i]).collect()
    }

    /// Distance to a site, the short way round where dimensions are circles.
    fn distance2(&self, site: &Ellipsoid, shadow: &[f64]) -> f64 {
        if !self.is_wrapped.contains(&true) {
            return site.distance2(shadow);
        }
        let nearest = shadow.iter().zip(site.centre()).zip(&self.is_wrapped);
        let nearest = nearest.map(
            |((&x, c), is_wrapped)| {
                if *is_wrapped { x - (x - c).round() } else { x }
            },
        );
        site.distance2(&nearest.collect::<Vec<_>>())
    }

    /// The child of a divided node that a point belongs to.
    fn child(&self, node: usize, shadow: &[f64]) -> usize {
        let mut nearest = (f64::INFINITY, node);
        for (child, site) in &self.nodes[node].sites {
            let distance2 = self.distance2(site, shadow);
            if distance2 < nearest.0 {
                nearest = (distance2, *child);
            }
        }
        nearest.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn a_place_belongs_to_exactly_one_leaf_and_all_its_ancestors() {
        let ball =
            |x: f64, r: f64| Ellipsoid::new(&[x], &(DMatrix::identity(1, 1) * r * r)).unwrap();
        let mut territory = Territory::new(&[1], &[]);
        let left = territory.split(0, vec![vec![ball(0.2, 0.1)], vec![ball(0.8, 0.1)]]);
        let inner = territory.split(left, vec![vec![ball(0.15, 0.01)], vec![ball(0.25, 0.01)]]);
        for (y, leaf) in [(0.1, inner), (0.3, inner + 1), (0.6, left + 1)] {
            let u = [0.9, y];
            assert_eq!(territory.leaf(&u), leaf);
            assert!(territory.owns(leaf, &u) && territory.owns(0, &u));
        }
        assert!(!territory.owns(left, &[0.0, 0.7]));
        assert!(!territory.owns(inner, &[0.0, 0.7]));
    }

    #[test]
    fn places_are_claimed_the_short_way_round_a_circle() {
        let ball = |x: f64| Ellipsoid::new(&[x], &(DMatrix::identity(1, 1) * 0.01)).unwrap();
        let mut territory = Territory::new(&[0], &[0]);
        let first = territory.split(0, vec![vec![ball(0.95)], vec![ball(0.4)]]);
        assert_eq!(territory.leaf(&[0.1]), first);
        assert_eq!(territory.leaf(&[0.3]), first + 1);
    }
}
