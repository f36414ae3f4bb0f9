//! The numbers of an evaluation as tables for people.

use std::fmt::Write as _;

use crate::catalogue::aligned;
use crate::evaluate::{
    Binned, Coverage, Curve, CurvePoint, Evaluation, FalseRow, Fraction, IntervalKind, Mean,
    MissedSource, ParameterReport, ReliabilityBin,
};

/// Cuts on the signal-to-noise ratio that are shown.
const CUTS: [f64; 17] = [
    3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 200.0,
];

/// Missed sources and false rows that are listed.
const MAX_LISTED: usize = 20;

/// All tables, one below the other, without a newline at the end.
pub(super) fn text(evaluation: &Evaluation) -> String {
    let mut text = counts(evaluation);
    let mut section = |title: &str, table: String| {
        if !table.is_empty() {
            let _ = write!(text, "\n{title}\n{}", indented(&table));
        }
    };
    section(
        "estimate - truth (pull: divided by the error)",
        parameters(&evaluation.parameters),
    );
    for binned in &evaluation.bins {
        section(
            &format!("by {}", with_unit(binned.name, binned.unit)),
            bins(binned),
        );
    }
    let title = format!("cuts on the {}", modes(evaluation));
    section(&title, curves(&evaluation.curves));
    let by_snr = (evaluation.curves.iter()).filter(|curve| curve.score.starts_with("SNR"));
    for curve in by_snr {
        let title = format!("keeping what has at least this {}", curve.score);
        section(&title, cuts(curve));
    }
    section(
        "P_source against the fraction that is true",
        reliability(&evaluation.reliability),
    );
    section("missed", missed(&evaluation.missed));
    section("false", false_rows(&evaluation.false_rows));
    text.truncate(text.trim_end().len());
    text
}

fn counts(e: &Evaluation) -> String {
    let lines = [
        ["completeness".to_owned(), fraction(&e.completeness)],
        ["  of SNR >= 5".to_owned(), fraction(&e.completeness_snr_5)],
        ["purity".to_owned(), fraction(&e.purity)],
        [
            "false".to_owned(),
            format!("{} per deg^2", number(e.false_per_deg2, 2)),
        ],
    ];
    let mut text = indented(&aligned(&lines));
    if e.n_truth_outside > 0 {
        let n = e.n_truth_outside;
        let _ = writeln!(text, "  {n} true sources outside the field do not count");
    }
    text
}

fn modes(e: &Evaluation) -> String {
    let Evaluation {
        n_mode,
        n_mode_left_out,
        modes_table,
        ..
    } = e;
    if *modes_table == "CATALOGUE" {
        format!("{n_mode} rows of CATALOGUE")
    } else {
        format!(
            "{n_mode} modes of {modes_table} ({n_mode_left_out} more are no source at any cut, or \
             seen twice)"
        )
    }
}

fn parameters(parameters: &[ParameterReport]) -> String {
    let titles = [
        "", "bias", "pull", "rms", "largest", "> 5", "in 68%", "in 95%",
    ];
    let cells = |p: &ParameterReport| {
        [
            with_unit(p.name, p.unit),
            mean(&p.bias, 4),
            number(p.pull_mean, 2),
            number(p.pull_rms, 2),
            number(p.pull_largest, 2),
            p.n_beyond_5_sigma.to_string(),
            coverage(&p.coverage[0]),
            coverage(&p.coverage[1]),
        ]
    };
    table(titles, parameters.iter().map(cells))
}

fn bins(binned: &Binned) -> String {
    let titles = ["", "completeness", "purity", "flux / true"];
    let cells = |bin: &crate::evaluate::Bin| {
        let range = if bin.high.is_finite() {
            format!("{} to {}", round(bin.low), round(bin.high))
        } else {
            format!("from {}", round(bin.low))
        };
        [
            range,
            fraction(&bin.completeness),
            fraction(&bin.purity),
            mean(&bin.flux_ratio, 3),
        ]
    };
    table(titles, binned.bins.iter().map(cells))
}

fn curves(curves: &[Curve]) -> String {
    let titles = [
        "",
        "true",
        "false",
        "ROC area",
        "best cut",
        "TPR - FPR",
        "no false from",
        "completeness",
        "of SNR >= 5",
    ];
    let cells = |curve: &Curve| {
        let cut = |p: Option<CurvePoint>| number(p.map_or(f64::NAN, |p| p.cut), 2);
        let index = |p: Option<CurvePoint>| {
            p.map_or(f64::NAN, |p| p.true_positive_rate - p.false_positive_rate)
        };
        let clean = curve.lowest_without_false;
        [
            with_unit(curve.score, curve.unit),
            curve.n_true.to_string(),
            curve.n_false.to_string(),
            number(curve.area, 4),
            cut(curve.best),
            number(index(curve.best), 3),
            cut(clean),
            clean.map_or("-".to_owned(), |p| fraction(&p.completeness)),
            clean.map_or("-".to_owned(), |p| fraction(&p.completeness_snr_5)),
        ]
    };
    table(titles, curves.iter().map(cells))
}

fn cuts(curve: &Curve) -> String {
    let titles = ["", "completeness", "of SNR >= 5", "purity", "TPR", "FPR"];
    let ends = (curve.points.last()).zip(curve.points.first());
    let (lowest, highest) = ends.map_or((0.0, 0.0), |(low, high)| (low.cut, high.cut));
    // From the last cut that keeps everything on.
    let first = CUTS.iter().rposition(|cut| *cut <= lowest).unwrap_or(0);
    let shown = CUTS[first..].iter().take_while(|cut| **cut <= highest);
    let cells = |p: CurvePoint| {
        [
            round(p.cut),
            fraction(&p.completeness),
            fraction(&p.completeness_snr_5),
            fraction(&p.purity),
            number(p.true_positive_rate, 3),
            number(p.false_positive_rate, 3),
        ]
    };
    table(titles, shown.filter_map(|cut| curve.at(*cut)).map(cells))
}

fn reliability(bins: &[ReliabilityBin]) -> String {
    let titles = ["", "mean P_source", "true"];
    let used = bins.iter().filter(|bin| bin.is_true.of > 0);
    let cells = |bin: &ReliabilityBin| {
        [
            format!("{} to {}", round(bin.low), round(bin.high)),
            number(bin.mean_p, 3),
            fraction(&bin.is_true),
        ]
    };
    table(titles, used.map(cells))
}

fn missed(missed: &[MissedSource]) -> String {
    let titles = ["truth row", "RA deg", "DEC deg", "flux uJy", "SNR"];
    let cells = |source: &MissedSource| {
        [
            source.truth_row.to_string(),
            number(source.ra_deg, 6),
            number(source.dec_deg, 6),
            number(source.flux_ujy, 1),
            number(source.snr, 1),
        ]
    };
    listed(
        table(titles, missed.iter().take(MAX_LISTED).map(cells)),
        missed.len(),
    )
}

fn false_rows(rows: &[FalseRow]) -> String {
    let titles = ["row", "name", "RA deg", "DEC deg", "flux uJy", "SNR"];
    let cells = |row: &FalseRow| {
        [
            row.row.to_string(),
            row.name.clone(),
            number(row.ra_deg, 6),
            number(row.dec_deg, 6),
            number(row.flux_ujy, 1),
            number(row.snr, 1),
        ]
    };
    listed(
        table(titles, rows.iter().take(MAX_LISTED).map(cells)),
        rows.len(),
    )
}

/// A table, and how many lines more there would be.
fn listed(mut table: String, n: usize) -> String {
    if n > MAX_LISTED {
        let _ = writeln!(table, "and {} more, which --json lists", n - MAX_LISTED);
    }
    table
}

/// Titles and lines, or nothing where there are no lines.
fn table<const N: usize>(titles: [&str; N], lines: impl Iterator<Item = [String; N]>) -> String {
    let mut all = vec![titles.map(str::to_owned)];
    all.extend(lines);
    if all.len() == 1 {
        return String::new();
    }
    aligned(&all)
}

fn indented(text: &str) -> String {
    text.lines().fold(String::new(), |indented, line| {
        indented + "  " + line + "\n"
    })
}

fn with_unit(name: &str, unit: &str) -> String {
    format!("{name} {unit}").trim_end().to_owned()
}

fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() {
        format!("{value:.decimals$}")
    } else {
        "-".to_owned()
    }
}

/// A round number without the rounding errors of its making.
fn round(value: f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}

fn fraction(f: &Fraction) -> String {
    if f.of == 0 {
        return "-".to_owned();
    }
    format!("{:.3} ({}/{})", f.value, f.n, f.of)
}

fn mean(mean: &Mean, decimals: usize) -> String {
    match mean.n {
        0 => "-".to_owned(),
        1 => number(mean.value, decimals),
        _ => format!("{:.decimals$} ± {:.decimals$}", mean.value, mean.err),
    }
}

/// A coverage, marked where it is not from the posterior.
fn coverage(coverage: &Coverage) -> String {
    let mark = match coverage.from {
        IntervalKind::Gaussian => " Gaussian",
        IntervalKind::Columns | IntervalKind::Samples => "",
    };
    format!("{}{mark}", fraction(&coverage.covered))
}
