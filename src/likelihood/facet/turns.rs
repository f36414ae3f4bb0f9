//! Phases.
#![allow(clippy::inline_always)] // compiled anew for each instruction set

use crate::likelihood::kernel::numbers::{SQRT2_COS_PI, SQRT2_SIN_PI};

/// Cosine and sine of `turns` turns, to 3e-7; `turns` within 2^50. Without calls and closures, so
/// that loops over it vectorise with the instructions of the caller.
#[inline(always)]
pub(super) fn cos_sin(turns: f64) -> [f32; 2] {
    // Adding it rounds to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let x = (turns - ((turns + ROUND) - ROUND)) as f32;
    let square = x * x;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for i in (0..SQRT2_SIN_PI.len()).rev() {
        sine = sine * square + SQRT2_SIN_PI[i];
    }
    for i in (0..SQRT2_COS_PI.len()).rev() {
        cosine = cosine * square + SQRT2_COS_PI[i];
    }
    sine *= x;
    [1.0 - sine * sine, sine * cosine]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn phases_are_good_to_single_precision_at_any_number_of_turns() {
        for whole in [0.0, 7.0, -12_345.0, 1e6] {
            for i in 0..=1000 {
                let turns = whole + i as f64 / 1000.0 - 0.5;
                let [cos, sin] = cos_sin(turns).map(f64::from);
                let (expected_sin, expected_cos) = (TAU * turns).sin_cos();
                assert!(
                    (cos - expected_cos).hypot(sin - expected_sin) < 5e-7,
                    "{turns}"
                );
            }
        }
    }
}
