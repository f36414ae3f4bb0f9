//! One place for each source: its numbers in full, and its corner plot.

use std::fmt::Write as _;

use super::super::Contents;
use super::super::figures::Figures;
use super::super::format::{decimals, plural, short, with_error};
use super::super::svg::escaped;
use super::sources::meanings;
use crate::units::{ARCSEC, MICROJY};

pub(super) fn html(contents: &Contents, figures: &Figures) -> String {
    let n = contents.catalogue.rows.len();
    let mut html = String::new();
    if contents.catalogue.samples.is_none() && n > 0 {
        html.push_str(
            "<p>No posterior samples lie beside the catalogue, so that there are no corner plots.</p>\n",
        );
    } else if figures.corners.len() < n {
        let _ = writeln!(
            html,
            "<p>Corner plots of the {} with the highest signal-to-noise ratio; <code>--corners</code> \
             draws more.</p>",
            plural(figures.corners.len(), "source")
        );
    }
    html.push_str("<div class=\"posteriors\">\n");
    for row in 0..n {
        html.push_str(&source(contents, figures, row));
    }
    html.push_str("</div>\n");
    html
}

fn source(contents: &Contents, figures: &Figures, row: usize) -> String {
    let (anchor, title) = (contents.anchor(row), escaped(&contents.title(row)));
    let mut html = format!("<article id=\"{anchor}\" tabindex=\"-1\">\n<h3>{title}</h3>\n<dl>\n");
    for (name, value) in facts(contents, row) {
        let _ = write!(
            html,
            "<div><dt>{name}</dt><dd>{}</dd></div>",
            escaped(&value)
        );
    }
    html.push_str("\n</dl>\n");
    for meaning in meanings(contents.row_details(row).flags) {
        let _ = writeln!(html, "<p class=\"warning\">{}</p>", escaped(meaning));
    }
    let corner = figures.corners.iter().find(|(of, _)| *of == row);
    if let Some((_, figure)) = corner {
        html.push_str(&figure.inline(""));
    }
    html.push_str("<p class=\"back\"><a href=\"#sources\">Back to the table</a></p>\n</article>\n");
    html
}

/// What is told of a source: name and value.
fn facts(contents: &Contents, row: usize) -> Vec<(&'static str, String)> {
    let (found, details) = (&contents.catalogue.rows[row], contents.row_details(row));
    let mut facts = vec![
        (
            "Flux density",
            format!(
                "{} µJy",
                with_error(found.flux_jy.mean / MICROJY, found.flux_jy.err / MICROJY)
            ),
        ),
        (
            "Spectral index",
            with_error(found.spectral_index.mean, found.spectral_index.err),
        ),
        ("SNR, at the peak", decimals(found.snr_peak, 1)),
        ("ln Z", with_error(details.log_z, details.e_log_z)),
        ("P_source", decimals(found.p_source, 4)),
        ("Effective samples", decimals(details.n_eff, 0)),
    ];
    let n_member = (0..contents.catalogue.rows.len())
        .filter(|&other| contents.row_details(other).group_id == details.group_id)
        .count();
    if n_member > 1 {
        facts.push((
            "Sampled together",
            format!("{n_member} sources (group {})", details.group_id),
        ));
    }
    if let Some(matched) = contents.match_of(row) {
        facts.push((
            "True flux density",
            format!("{} µJy", short(matched.true_flux_ujy)),
        ));
        facts.push((
            "From its true place",
            format!("{} arcsec", short(matched.separation_arcsec)),
        ));
    } else if contents.truth.is_some() {
        facts.push(("True source", "none".to_owned()));
    }
    if found.e_ra_rad.is_finite() {
        let errors = [found.e_ra_rad, found.e_dec_rad].map(|e| decimals(e / ARCSEC, 3));
        facts.push((
            "Errors east, north",
            format!("{}″, {}″", errors[0], errors[1]),
        ));
    }
    facts.retain(|(_, value)| !value.starts_with('–'));
    facts
}
