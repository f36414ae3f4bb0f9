//! What another cut would have kept: completeness, purity and the ROC curve.

use serde::Serialize;

use super::Fraction;
use super::candidates::{Candidate, Candidates};

/// Cuts on one score of the modes.
///
/// A true mode is one that is a true source, at whatever cut; a false mode is any other. The rates of
/// the ROC curve are relative to the modes, completeness to the true sources in the field, with or
/// without a mode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Column that is cut.
    pub score: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The table with that column.
    pub table: &'static str,
    /// True modes.
    pub n_true: usize,
    /// False modes.
    pub n_false: usize,
    /// Area under the ROC curve: the probability that a true mode scores higher than a false one, of
    /// equal ones one half (Mann & Whitney 1947). NaN without true or without false modes.
    pub area: f64,
    /// The cut with the largest difference of true and false positive rate, of several the highest.
    pub best: Option<CurvePoint>,
    /// The lowest cut that keeps no false mode.
    pub lowest_without_false: Option<CurvePoint>,
    /// All cuts that matter, each the score of a mode, from high to low.
    pub points: Vec<CurvePoint>,
}

/// What is kept of the modes with at least a certain score.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurvePoint {
    /// The lowest score that is kept.
    pub cut: f64,
    /// True modes that are kept.
    pub n_true: usize,
    /// False modes that are kept.
    pub n_false: usize,
    /// True modes that are kept, of all true modes; NaN if there are none.
    pub true_positive_rate: f64,
    /// False modes that are kept, of all false modes; NaN if there are none.
    pub false_positive_rate: f64,
    /// True sources in the searched field whose mode is kept, of all of them.
    pub completeness: Fraction,
    /// The same of those with a signal-to-noise ratio of at least
    /// [`POPULATION_SNR`](super::POPULATION_SNR).
    pub completeness_snr_5: Fraction,
    /// True modes of those that are kept.
    pub purity: Fraction,
}

impl Curve {
    /// What a cut at any value keeps.
    pub fn at(&self, cut: f64) -> Option<CurvePoint> {
        let kept = self.points.iter().rfind(|point| point.cut >= cut);
        let none = self.points.first().map(|first| CurvePoint {
            n_true: 0,
            n_false: 0,
            true_positive_rate: 0.0 * first.true_positive_rate,
            false_positive_rate: 0.0 * first.false_positive_rate,
            completeness: Fraction::new(0, first.completeness.of),
            completeness_snr_5: Fraction::new(0, first.completeness_snr_5.of),
            purity: Fraction::new(0, 0),
            ..*first
        });
        kept.copied()
            .or(none)
            .map(|point| CurvePoint { cut, ..point })
    }
}

/// One column of the candidates: name, unit, value.
type Score = (&'static str, &'static str, fn(&Candidate) -> f64);

/// A curve for every score that at least one candidate has.
pub(super) fn report(candidates: &Candidates) -> Vec<Curve> {
    let scores: [Score; 3] = [
        (candidates.snr_column, "", |c| c.snr),
        ("Total_flux", "uJy", |c| c.flux_ujy),
        ("Log_Z", "", |c| c.log_z),
    ];
    let curves = scores.into_iter().map(|score| curve(candidates, score));
    curves.flatten().collect()
}

fn curve(candidates: &Candidates, (score, unit, get): Score) -> Option<Curve> {
    let mut scored: Vec<(f64, Option<usize>)> = (candidates.list.iter())
        .map(|candidate| (get(candidate), candidate.truth))
        .filter(|(value, _)| !value.is_nan())
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    if scored.is_empty() {
        return None;
    }
    let points = points(candidates, &scored);
    let last = points.last();
    let (n_true, n_false) = last.map_or((0, 0), |last| (last.n_true, last.n_false));
    Some(Curve {
        score,
        unit,
        table: candidates.table,
        n_true,
        n_false,
        area: area(&points),
        best: best(&points),
        lowest_without_false: points.iter().rfind(|point| point.n_false == 0).copied(),
        points,
    })
}

/// What is kept at every score in turn; `scored` begins with the highest.
fn points(candidates: &Candidates, scored: &[(f64, Option<usize>)]) -> Vec<CurvePoint> {
    let n_field = candidates.in_field.iter().filter(|is| **is).count();
    let n_population = candidates.in_population.iter().filter(|is| **is).count();
    let all_true = scored.iter().filter(|(_, truth)| truth.is_some()).count();
    let all_false = scored.len() - all_true;
    let (mut n_true, mut n_false, mut field, mut population) = (0, 0, 0, 0);
    let mut points = Vec::new();
    for equal in scored.chunk_by(|a, b| a.0 == b.0) {
        for (_, truth) in equal {
            n_true += usize::from(truth.is_some());
            n_false += usize::from(truth.is_none());
            field += usize::from(truth.is_some_and(|i| candidates.in_field[i]));
            population += usize::from(truth.is_some_and(|i| candidates.in_population[i]));
        }
        points.push(CurvePoint {
            cut: equal[0].0,
            n_true,
            n_false,
            true_positive_rate: n_true as f64 / all_true as f64,
            false_positive_rate: n_false as f64 / all_false as f64,
            completeness: Fraction::new(field, n_field),
            completeness_snr_5: Fraction::new(population, n_population),
            purity: Fraction::new(n_true, n_true + n_false),
        });
    }
    points
}

/// Area under the ROC curve, by trapezia from (0, 0).
fn area(points: &[CurvePoint]) -> f64 {
    let rates = |p: &CurvePoint| (p.false_positive_rate, p.true_positive_rate);
    let mut last = (0.0, 0.0);
    let mut area = 0.0;
    for (x, y) in points.iter().map(rates) {
        area += (x - last.0) * 0.5 * (y + last.1);
        last = (x, y);
    }
    area
}

/// Youden's index (1950, Cancer 3, 32) at its largest.
fn best(points: &[CurvePoint]) -> Option<CurvePoint> {
    let all = points.last().filter(|p| p.n_true > 0 && p.n_false > 0)?;
    // The difference of the rates times both numbers of modes: without rounding.
    let index =
        |p: &CurvePoint| (p.n_true * all.n_false) as i128 - (p.n_false * all.n_true) as i128;
    // The first of equal ones has the highest cut.
    (points.iter().copied()).reduce(|best, p| if index(&p) > index(&best) { p } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(snr: f64, truth: Option<usize>) -> Candidate {
        Candidate {
            snr,
            flux_ujy: f64::NAN,
            log_z: f64::NAN,
            p_source: f64::NAN,
            truth,
        }
    }

    /// Six true sources, the last without a mode, the first two outside the field.
    fn curves(list: Vec<Candidate>) -> Vec<Curve> {
        let candidates = Candidates {
            table: "MODES",
            snr_column: "SNR_peak",
            list,
            n_left_out: 0,
            in_field: vec![false, false, true, true, true, true],
            in_population: vec![false, false, true, false, false, false],
        };
        report(&candidates)
    }

    /// Scores T 9, T 8, F 7, T 6, (T and F) 5, F 4: of the 4 x 3 pairs of a true and a false mode
    /// 3 + 3 + 2 are in order, and the last true one beats one false and ties with another: 9.5 / 12.
    #[test]
    fn a_curve_by_hand() {
        let list = vec![
            candidate(9.0, Some(2)),
            candidate(5.0, None),
            candidate(8.0, Some(0)),
            candidate(7.0, None),
            candidate(4.0, None),
            candidate(6.0, Some(3)),
            candidate(f64::NAN, Some(4)),
            candidate(5.0, Some(1)),
        ];
        let curves = curves(list);
        assert_eq!(curves.len(), 1);
        let curve = &curves[0];
        assert_eq!((curve.n_true, curve.n_false), (4, 3));
        assert!((curve.area - 9.5 / 12.0).abs() < 1e-15);
        let cuts: Vec<f64> = curve.points.iter().map(|p| p.cut).collect();
        assert_eq!(cuts, [9.0, 8.0, 7.0, 6.0, 5.0, 4.0]);
        // TPR - FPR: 1/4, 1/2, 1/2 - 1/3, 3/4 - 1/3, 1 - 2/3, 0.
        assert_eq!(curve.best.unwrap().cut, 8.0);
        let clean = curve.lowest_without_false.unwrap();
        assert_eq!((clean.cut, clean.n_true, clean.completeness.n), (8.0, 2, 1));
        assert_eq!(clean.completeness.of, 4);
        assert_eq!(
            (clean.completeness_snr_5.n, clean.completeness_snr_5.of),
            (1, 1)
        );
        assert_eq!(
            curve.at(5.5),
            curve.at(6.0).map(|p| CurvePoint { cut: 5.5, ..p })
        );
        let none = curve.at(10.0).unwrap();
        assert_eq!((none.n_true + none.n_false, none.completeness.of), (0, 4));
        let at_6 = curve.points[3];
        assert_eq!((at_6.purity.n, at_6.purity.of), (3, 4));
        assert!((at_6.false_positive_rate - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn without_false_modes_there_is_no_area_and_every_cut_is_clean() {
        let curves = curves(vec![candidate(5.0, Some(2)), candidate(9.0, Some(3))]);
        let curve = &curves[0];
        assert!(curve.area.is_nan() && curve.best.is_none());
        assert_eq!(curve.lowest_without_false.unwrap().cut, 5.0);
    }

    #[test]
    fn if_the_strongest_mode_is_false_no_cut_is_clean() {
        let curves = curves(vec![candidate(5.0, Some(2)), candidate(9.0, None)]);
        assert!(curves[0].lowest_without_false.is_none());
        assert!(curves[0].area == 0.0);
    }
}
