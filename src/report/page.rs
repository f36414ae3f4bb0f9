//! The page: what stands where.

mod posteriors;
mod run;
mod sources;
mod truth;
mod visibilities;

use std::fmt::Write as _;

use super::Contents;
use super::figures::Figures;
use super::format::{self, plural};
use super::svg::escaped;
use super::theme::page_css;

const PAGE_CSS: &str = include_str!("page/page.css");
const SCRIPT: &str = include_str!("page/page.js");

/// Nothing may come from anywhere else, and no form may lead anywhere.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      img-src data:; base-uri 'none'; form-action 'none'";

/// One section of the page.
struct Section {
    id: &'static str,
    title: &'static str,
    html: String,
}

/// The whole page.
pub(super) fn html(contents: &Contents, figures: &Figures) -> String {
    let sections = sections(contents, figures);
    let name = escaped(&contents.name);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
         <meta name=\"generator\" content=\"vis2cat {}\"/>\n\
         <link rel=\"icon\" href=\"data:,\"/>\n\
         <title>{name}: vis2cat report</title>\n<style>\n{}{PAGE_CSS}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#main\">Skip to the report</a>\n<header>\n<h1>{name}</h1>\n\
         <p class=\"lead\">{}</p>\n<nav aria-label=\"Sections\"><ul>\n",
        env!("CARGO_PKG_VERSION"),
        page_css(),
        lead(contents)
    );
    for Section { id, title, .. } in &sections {
        let _ = writeln!(html, "<li><a href=\"#{id}\">{title}</a></li>");
    }
    html.push_str("</ul></nav>\n</header>\n<main id=\"main\" tabindex=\"-1\">\n");
    for Section {
        id,
        title,
        html: own,
    } in &sections
    {
        let _ = write!(
            html,
            "<section id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{title}</h2>\n\
             {own}</section>\n"
        );
    }
    let _ = write!(
        html,
        "</main>\n<footer><p>Made by vis2cat {}.</p></footer>\n<script>\n{SCRIPT}</script>\n</body>\n\
         </html>\n",
        env!("CARGO_PKG_VERSION")
    );
    html
}

fn sections(contents: &Contents, figures: &Figures) -> Vec<Section> {
    let section = |id, title, html| Section { id, title, html };
    let mut sections = vec![
        section("overview", "Overview", overview(figures)),
        section("sources", "Sources", sources::html(contents)),
    ];
    if let Some(truth) = &contents.truth {
        let html = truth::html(truth, &figures.truth);
        sections.push(section("truth", "Beside the truth", html));
    }
    if let Some(check) = &contents.check {
        let html = visibilities::html(check, figures.visibilities.as_ref());
        sections.push(section("visibilities", "Visibilities", html));
    }
    sections.push(section(
        "posteriors",
        "Posteriors",
        posteriors::html(contents, figures),
    ));
    sections.push(section(
        "run",
        "Run",
        run::html(&contents.details, &contents.timings),
    ));
    sections
}

/// The field, and beside it what was measured.
fn overview(figures: &Figures) -> String {
    let Some(field) = &figures.field else {
        return "<p>There is no source and no field.</p>\n".to_owned();
    };
    let mut html = format!("<div class=\"overview\">\n{}<div>\n", field.inline(""));
    html.extend(figures.measurements.iter().map(|figure| figure.inline("")));
    html.push_str("</div>\n</div>\n");
    html
}

/// What it is about, in a line.
fn lead(contents: &Contents) -> String {
    let details = &contents.details;
    let n_source = contents.catalogue.rows.len();
    let mut parts = vec![plural(n_source, "source")];
    if let Some(modes) = &contents.catalogue.modes {
        parts.push(format!("{} modes", modes.len()));
    }
    if let Some(n) = details.number("data.n_sample") {
        parts.push(format!("{} visibilities", format::grouped(n)));
    }
    if let Some(hz) = details.number("data.mean_freq") {
        parts.push(format!("{:.4} GHz", hz / 1e9));
    }
    if let Some(beam) = details.number("data.beam") {
        parts.push(format!("beam {beam:.2}″ (σ)"));
    }
    let about = ["Telescope", "Field"].map(|what| {
        let entry = details.header.iter().find(|(name, _)| *name == what);
        entry.map(|(_, value)| value.clone())
    });
    let about: Vec<String> = about.into_iter().flatten().chain(parts).collect();
    escaped(&about.join(" · "))
}
