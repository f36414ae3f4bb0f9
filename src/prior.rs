//! Priors: the unit cube to source parameters.
