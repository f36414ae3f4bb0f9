//! Every kernel against the plain f64 sum, and against itself in other company.

use super::*;
use crate::coords::Lm;
use crate::likelihood::plain_xy;
use crate::likelihood::samples::{MEERKAT, PROFILES, noise, seen, sources};
use crate::rime::shape::Profile;
use crate::rime::{Source, predict};

fn available() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.is_available())
}

fn xy(isa: Isa, block: &VisBlock, sources: &[Source], profile: Profile) -> Vec<Xy> {
    let terms: Vec<_> = sources
        .iter()
        .map(|s| SourceTerm::new(s, profile))
        .collect();
    let mut out = vec![Xy::default(); terms.len()];
    accumulate(isa, block, &terms, &mut out);
    out
}

/// Error of ln L relative to the largest of its own size, the expected ln L of a true source,
/// SNR²/2 = S²Y/2, and its scatter under noise, SNR = S sqrt(Y).
///
/// Under noise S X is a random walk that passes through zero, so that ln L has no relative error
/// of its own there; what the posterior feels is the error against these scales.
fn relative_error(got: Xy, plain: Xy, flux_jy: f64) -> f64 {
    let (log_l, snr) = (plain.log_l(flux_jy), plain.snr(flux_jy));
    let scale = log_l.abs().max(snr).max(0.5 * snr * snr);
    (got.log_l(flux_jy) - log_l).abs() / scale
}

/// Largest relative error of ln L of `sources` over `block`.
fn worst_error(isa: Isa, block: &VisBlock, sources: &[Source], profile: Profile) -> f64 {
    let errors = xy(isa, block, sources, profile)
        .into_iter()
        .zip(sources)
        .map(|(got, s)| relative_error(got, plain_xy(block, s, profile), s.flux_jy));
    errors.fold(0.0, f64::max)
}

#[test]
fn log_l_of_noise_is_within_1e_5_over_the_prior() {
    let block = noise(20_000, 1);
    let sources = sources(200, 2);
    for profile in PROFILES {
        for isa in available() {
            let worst = worst_error(isa, &block, &sources, profile);
            assert!(worst < 1e-5, "{isa:?} {profile:?}: {worst:e}");
        }
    }
}

#[test]
fn log_l_of_a_bright_source_is_within_1e_5() {
    let mut block = noise(20_000, 3);
    let truth = Source {
        flux_jy: 0.02,
        ..sources(1, 4)[0]
    };
    for k in 0..block.len() {
        let weight = block.weight[k];
        let vis = predict(
            &truth,
            Profile::Exponential,
            block.u[k],
            block.v[k],
            block.w[k],
        );
        block.weighted_re[k] += weight * vis.re as f32;
        block.weighted_im[k] += weight * vis.im as f32;
    }
    for isa in available() {
        let worst = worst_error(isa, &block, &[truth], Profile::Exponential);
        assert!(worst < 1e-6, "{isa:?}: {worst:e}");
    }
}

#[test]
fn kernels_agree_with_each_other() {
    let block = noise(5_000, 5);
    let sources = sources(50, 6);
    for profile in PROFILES {
        let reference = xy(Isa::Portable, &block, &sources, profile);
        for isa in available() {
            for (a, b) in xy(isa, &block, &sources, profile).iter().zip(&reference) {
                assert!(
                    (a.x - b.x).abs() <= 5e-6 * b.y.sqrt(),
                    "{isa:?} {profile:?}"
                );
                assert!((a.y - b.y).abs() <= 2e-6 * b.y, "{isa:?} {profile:?}");
            }
        }
    }
}

#[test]
fn every_length_of_tail_is_summed() {
    for len in (0..=70).chain([511, 512, 513, 1024, 1039]) {
        let block = noise(len, len as u64);
        let sources = sources(3, 7);
        for isa in available() {
            for (got, s) in xy(isa, &block, &sources, Profile::Exponential)
                .iter()
                .zip(&sources)
            {
                let plain = plain_xy(&block, s, Profile::Exponential);
                assert!(
                    (got.x - plain.x).abs() <= 1e-5 * plain.y.sqrt(),
                    "{isa:?} {len}"
                );
                assert!((got.y - plain.y).abs() <= 1e-6 * plain.y, "{isa:?} {len}");
            }
        }
    }
}

#[test]
fn an_empty_block_adds_nothing() {
    for isa in available() {
        let sums = xy(
            isa,
            &VisBlock::default(),
            &sources(2, 8),
            Profile::Exponential,
        );
        assert_eq!(sums, [Xy::default(); 2]);
    }
}

#[test]
fn no_sources_give_no_sums() {
    for isa in available() {
        assert!(xy(isa, &noise(20, 9), &[], Profile::Point).is_empty());
    }
}

#[test]
fn samples_of_zero_weight_change_nothing() {
    let block = noise(100, 10);
    let mut padded = block.clone();
    padded.u.extend([1e5; 16]);
    padded.v.extend([-7e5; 16]);
    padded.w.extend([3.0; 16]);
    padded.weight.extend([0.0; 16]);
    padded.weighted_re.extend([0.0; 16]);
    padded.weighted_im.extend([0.0; 16]);
    let sources = sources(4, 11);
    for isa in available() {
        for profile in PROFILES {
            let (a, b) = (
                xy(isa, &block, &sources, profile),
                xy(isa, &padded, &sources, profile),
            );
            for (a, b) in a.iter().zip(&b) {
                assert!((a.x - b.x).abs() <= 1e-5 * a.y.sqrt());
                assert!((a.y - b.y).abs() <= 1e-6 * a.y);
            }
        }
    }
}

#[test]
fn phases_beyond_the_fixed_point_form_are_summed_in_f64() {
    let mut block = noise(600, 12);
    block.u.iter_mut().for_each(|u| *u *= 1e3);
    let source = Source {
        lm: Lm { l: 0.3, m: -0.2 },
        flux_jy: 1e-4,
        scale_rad: 1e-9,
        ..Source::default()
    };
    for isa in available() {
        for profile in PROFILES {
            let worst = worst_error(isa, &block, &[source], profile);
            assert!(worst < 1e-5, "{isa:?} {profile:?}: {worst:e}");
        }
    }
}

#[test]
fn half_a_turn_gives_minus_one() {
    let block = VisBlock {
        u: vec![1.0, 3.0, -1.0],
        v: vec![0.0; 3],
        w: vec![0.0; 3],
        weighted_re: vec![2.0; 3],
        weighted_im: vec![0.0; 3],
        weight: vec![2.0; 3],
        ..VisBlock::default()
    };
    let source = Source {
        lm: Lm { l: 0.5, m: 0.0 },
        ..Source::default()
    };
    for isa in available() {
        let sums = xy(isa, &block, &[source], Profile::Point)[0];
        assert!(
            (sums.x + 6.0).abs() < 3e-6 && (sums.y - 6.0).abs() < 1e-6,
            "{isa:?}"
        );
    }
}

#[test]
fn sums_do_not_depend_on_the_company_in_the_batch() {
    let block = noise(1_500, 13);
    let sources = sources(37, 14);
    for isa in available() {
        let together = xy(isa, &block, &sources, Profile::Exponential);
        for size in [1, 2, 3, 5, 36] {
            let apart: Vec<_> = sources
                .chunks(size)
                .flat_map(|sources| xy(isa, &block, sources, Profile::Exponential))
                .collect();
            assert_eq!(together, apart, "{isa:?}, batches of {size}");
        }
    }
}

#[test]
fn sums_are_added_to_what_is_there() {
    let block = noise(40, 15);
    let source = sources(1, 16)[0];
    let alone = xy(Isa::Portable, &block, &[source], Profile::Gaussian)[0];
    let mut out = [Xy { x: 5.0, y: 7.0 }];
    accumulate(
        Isa::Portable,
        &block,
        &[SourceTerm::new(&source, Profile::Gaussian)],
        &mut out,
    );
    assert_eq!(
        out,
        [Xy {
            x: 5.0 + alone.x,
            y: 7.0 + alone.y
        }]
    );
}

/// A bias of the cosine would add up over samples, N times, where noise adds up sqrt(N) times.
#[test]
fn the_cosine_has_no_mean() {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let count = 1 << 22;
    let block = VisBlock {
        u: (0..count).map(|k| (k as f64 * golden).fract()).collect(),
        v: vec![0.0; count],
        w: vec![0.0; count],
        weighted_re: vec![1.0; count],
        weighted_im: vec![0.0; count],
        weight: vec![1.0; count],
        ..VisBlock::default()
    };
    let source = Source {
        lm: Lm { l: 1.0, m: 0.0 },
        ..Source::default()
    };
    let plain = plain_xy(&block, &source, Profile::Point);
    for isa in available() {
        let mean = (xy(isa, &block, &[source], Profile::Point)[0].x - plain.x) / count as f64;
        assert!(mean.abs() < 1e-9, "{isa:?}: {mean:e}");
    }
}

#[test]
fn factors_of_the_instrument_are_in_x_and_y() {
    let mut plain = noise(5_000, 21);
    let sources = sources(60, 22);
    for profile in PROFILES {
        for isa in available() {
            let block = seen(plain.clone(), MEERKAT);
            let worst = worst_error(isa, &block, &sources, profile);
            assert!(worst < 1e-5, "{isa:?} {profile:?}: {worst:e}");
        }
    }
    // They make a difference: the data are not those of sources without them.
    let block = seen(plain.clone(), MEERKAT);
    plain.u.clone_from(&block.u);
    plain.v.clone_from(&block.v);
    plain.w.clone_from(&block.w);
    let [with, without] = [&block, &plain].map(|b| plain_xy(b, &sources[0], Profile::Point).y);
    assert!((with / without - 1.0).abs() > 0.05, "{with} {without}");
}
