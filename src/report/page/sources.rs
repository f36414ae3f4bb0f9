//! The table of sources: every column can be sorted by, every row leads to its posterior.

use std::fmt::Write as _;

use super::super::Contents;
use super::super::svg::escaped;
use super::format::{decimals, with_error};
use crate::catalogue::{Estimate, Flags};
use crate::units::{ARCSEC, DEG, MICROJY};

/// Title of a column, its unit, and what it is in words.
const COLUMNS: [(&str, &str, &str); 12] = [
    ("No.", "", "Source_id"),
    ("Name", "", "Source_name"),
    ("RA", "deg", "right ascension, ICRS"),
    ("DEC", "deg", "declination, ICRS"),
    (
        "σ",
        "arcsec",
        "error of the position, the larger of both axes",
    ),
    ("Flux", "µJy", "total flux density"),
    ("Scale", "arcsec", "scale-length, harmonic mean of the axes"),
    ("e₁", "", "ellipticity along east"),
    ("e₂", "", "ellipticity along the diagonal"),
    ("SNR", "", "signal-to-noise ratio in the visibilities"),
    ("P", "", "probability of a source, P_source"),
    ("Flags", "", "bits, see the posterior of the source"),
];

/// A cell: what is read, and the number that it is sorted by.
type Cell = (String, Option<f64>);

pub(super) fn html(contents: &Contents) -> String {
    let rows = &contents.catalogue.rows;
    if rows.is_empty() {
        return "<p>No source was found.</p>\n".to_owned();
    }
    let mut html = String::from(
        "<p class=\"hint\">Means and standard deviations of the posterior. A title sorts the table; a name \
         leads to the posterior of the source.</p>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" \
         aria-label=\"Table of sources\">\n<table class=\"sortable\" id=\"source-table\">\n<thead><tr>\n",
    );
    for (title, unit, about) in COLUMNS {
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!("<span class=\"unit\">[{unit}]</span>")
        };
        let _ = writeln!(
            html,
            "<th scope=\"col\"><button type=\"button\" title=\"{about}\">{title}{unit}</button></th>"
        );
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in 0..rows.len() {
        html.push_str(&line(contents, row));
    }
    html.push_str("</tbody>\n</table>\n</div>\n");
    html
}

fn line(contents: &Contents, row: usize) -> String {
    let anchor = contents.anchor(row);
    let mut html = String::from("<tr>");
    for (i, (text, value)) in cells(contents, row).into_iter().enumerate() {
        let text = escaped(&text);
        let value = value.filter(|v| v.is_finite());
        let key = value.map_or(String::new(), |v| format!(" data-value=\"{v}\""));
        let _ = match i {
            1 => write!(
                html,
                "<th scope=\"row\"><a href=\"#{anchor}\">{text}</a></th>"
            ),
            _ => write!(html, "<td class=\"number\"{key}>{text}</td>"),
        };
    }
    html.push_str("</tr>\n");
    html
}

fn cells(contents: &Contents, row: usize) -> [Cell; COLUMNS.len()] {
    let found = &contents.catalogue.rows[row];
    let number = contents.number_of(row);
    let plain = |value: f64, n: usize| (decimals(value, n), Some(value));
    let estimate =
        |e: Estimate, unit: f64| (with_error(e.mean / unit, e.err / unit), Some(e.mean / unit));
    let sigma = found.e_ra_rad.max(found.e_dec_rad) / ARCSEC;
    let flags = contents.row_details(row).flags;
    [
        (number.to_string(), Some(number as f64)),
        (contents.title(row), None),
        plain(found.position.ra_rad / DEG, 5),
        plain(found.position.dec_rad / DEG, 5),
        plain(sigma, 3),
        estimate(found.flux_jy, MICROJY),
        estimate(found.scale_rad, ARCSEC),
        estimate(found.e1, 1.0),
        estimate(found.e2, 1.0),
        plain(found.snr, 1),
        plain(found.p_source, 3),
        plain(flags, 0),
    ]
}

/// What the bits of `Flags` say.
pub(super) fn meanings(flags: f64) -> Vec<&'static str> {
    let flags = if flags.is_finite() {
        Flags(flags as i32)
    } else {
        Flags::default()
    };
    let set = Flags::MEANING
        .iter()
        .filter(|(bit, _)| flags.contains(*bit));
    set.map(|(_, meaning)| *meaning).collect()
}
