//! The table of sources: every column can be sorted by, every row leads to its posterior.

use super::super::Contents;
use super::super::format::{decimals, with_error};
use super::super::svg::escaped;
use crate::catalogue::{Estimate, Flags};
use crate::units::{ARCSEC, DEG, MICROJY};

/// Title of a column, its unit, and what it is in words.
const COLUMNS: [(&str, &str, &str); 13] = [
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
    (
        "β",
        "",
        "spectral index: flux density goes as frequency to this power",
    ),
    ("SNR", "", "signal-to-noise ratio in the visibilities"),
    ("P", "", "probability of a source, P_source"),
    ("Flags", "", "bits, see the posterior of the source"),
];

/// A cell: what is read, and the number that it is sorted by.
type Cell = (String, Option<f64>);

/// The column that a row is called by.
const NAME: usize = 1;

pub(super) fn html(contents: &Contents) -> String {
    let n = contents.catalogue.rows.len();
    if n == 0 {
        return "<p>No source was found.</p>\n".to_owned();
    }
    let rows: Vec<_> = (0..n).map(|row| cells(contents, row)).collect();
    let is_known = |&column: &usize| {
        let known = |(_, value): &Cell| value.is_some_and(f64::is_finite);
        column == NAME || rows.iter().any(|row| known(&row[column]))
    };
    let columns: Vec<usize> = (0..COLUMNS.len()).filter(is_known).collect();
    let mut html = String::from(
        "<p class=\"hint\">Means and standard deviations of the posterior. A title sorts the table; a name \
         leads to the posterior of the source.</p>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" \
         aria-label=\"Table of sources\">\n<table class=\"sortable\">\n<thead><tr>\n",
    );
    html.extend(columns.iter().map(|&column| title(column)));
    html.push_str("</tr></thead>\n<tbody>\n");
    for (row, cells) in rows.iter().enumerate() {
        html.push_str("<tr>");
        let anchor = contents.anchor(row);
        html.extend(
            columns
                .iter()
                .map(|&column| cell(column, &cells[column], &anchor)),
        );
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table>\n</div>\n");
    html
}

/// The title of a column: a button that sorts by it.
fn title(column: usize) -> String {
    let (title, unit, about) = COLUMNS[column];
    let unit = match unit {
        "" => String::new(),
        unit => format!("<span class=\"unit\">[{unit}]</span>"),
    };
    format!(
        "<th scope=\"col\"><button type=\"button\" title=\"{about}\">{title}{unit}</button></th>\n"
    )
}

fn cell(column: usize, (text, value): &Cell, anchor: &str) -> String {
    let text = escaped(text);
    if column == NAME {
        return format!("<th scope=\"row\"><a href=\"#{anchor}\">{text}</a></th>");
    }
    let value = value.filter(|value| value.is_finite());
    let key = value.map_or(String::new(), |value| format!(" data-value=\"{value}\""));
    format!("<td class=\"number\"{key}>{text}</td>")
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
        estimate(found.spectral_index, 1.0),
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
