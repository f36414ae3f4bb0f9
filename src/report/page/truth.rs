//! The catalogue beside the truth.

use std::fmt::Write as _;

use super::super::Figure;
use super::super::contents::Truth;
use super::super::format::{decimals, plural, short};
use super::super::svg::escaped;
use crate::evaluate::Fraction;

pub(super) fn html(truth: &Truth, figures: &[Figure]) -> String {
    let e = &truth.evaluation;
    let mut html = format!(
        "<p>Matched with <b>{}</b>: {} in the searched field, {} outside. A source is true if a true one \
         lies within {} standard deviations of its position, or within {} arcsec.</p>\n<dl class=\"facts\">\n",
        escaped(&truth.name),
        plural(e.n_truth, "true source"),
        e.n_truth_outside,
        short(e.match_n_sigma),
        short(e.match_floor_arcsec)
    );
    let mut fact = |name: &str, value: String| {
        let _ = write!(html, "<div><dt>{name}</dt><dd>{value}</dd></div>");
    };
    fact("Completeness", fraction(e.completeness));
    fact("of SNR ≥ 5", fraction(e.completeness_snr_5));
    fact("Purity", fraction(e.purity));
    if e.false_per_deg2.is_finite() {
        fact("False for each deg²", short(e.false_per_deg2));
    }
    html.push_str("\n</dl>\n<div class=\"figures\">\n");
    html.extend(figures.iter().map(|figure| figure.inline("")));
    html.push_str("</div>\n");
    let has_roc = figures.iter().any(|figure| figure.name == "roc");
    if !has_roc {
        html.push_str(
            "<p>There is no ROC curve: it takes true and false modes, and one kind is missing.</p>\n",
        );
    }
    html.push_str(&missed(truth));
    html.push_str(&false_rows(truth));
    html
}

fn fraction(f: Fraction) -> String {
    if f.of == 0 {
        return "–".to_owned();
    }
    format!("{} ({} of {})", decimals(f.value, 3), f.n, f.of)
}

fn missed(truth: &Truth) -> String {
    let missed = &truth.evaluation.missed;
    let rows = missed.iter().map(|s| {
        let row = s.truth_row.to_string();
        [
            row,
            decimals(s.ra_deg, 6),
            decimals(s.dec_deg, 6),
            decimals(s.flux_ujy, 1),
            decimals(s.snr, 1),
        ]
    });
    let titles = [
        "Row of the truth",
        "RA [deg]",
        "DEC [deg]",
        "Flux [µJy]",
        "SNR",
    ];
    table("True sources that were missed", titles, rows.collect())
}

fn false_rows(truth: &Truth) -> String {
    let rows = truth.evaluation.false_rows.iter().map(|s| {
        let name = if s.name.is_empty() {
            format!("row {}", s.row)
        } else {
            s.name.clone()
        };
        [
            name,
            decimals(s.ra_deg, 6),
            decimals(s.dec_deg, 6),
            decimals(s.flux_ujy, 1),
            decimals(s.snr, 1),
        ]
    });
    let titles = ["Source", "RA [deg]", "DEC [deg]", "Flux [µJy]", "SNR"];
    table("Sources that are not true", titles, rows.collect())
}

/// A table with its caption; nothing without rows.
fn table(caption: &str, titles: [&str; 5], rows: Vec<[String; 5]>) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut html =
        format!("<div class=\"scroll\"><table>\n<caption>{caption}</caption>\n<thead><tr>");
    for title in titles {
        let _ = write!(html, "<th scope=\"col\">{title}</th>");
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        let [first, rest @ ..] = row;
        let _ = write!(html, "<tr><th scope=\"row\">{}</th>", escaped(&first));
        for cell in rest {
            let _ = write!(html, "<td class=\"number\">{cell}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}
