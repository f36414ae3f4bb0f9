//! How the catalogue was made: samplers, counts, options, origin.

use std::fmt::Write as _;

use super::super::details::Details;
use super::super::format::{decimals, short};
use super::super::svg::escaped;
use crate::catalogue::RunEntry;
use crate::timing::StageTime;

/// Stages of a run that samplers are diagnosed in.
const STAGES: [(&str, &str); 2] = [
    ("sampler.search.", "Searches of tiles"),
    ("sampler.posterior.", "Posteriors of sources"),
];

pub(super) fn html(details: &Details, timings: &[StageTime]) -> String {
    if details.run.is_empty() && details.header.is_empty() && timings.is_empty() {
        return "<p>The catalogue does not say how it was made: it has no table RUN.</p>\n"
            .to_owned();
    }
    let is_option = |entry: &&RunEntry| entry.key.starts_with("config.");
    let is_sampler = |entry: &&RunEntry| entry.key.starts_with("sampler.");
    let counts: Vec<&RunEntry> = details
        .run
        .iter()
        .filter(|e| !is_option(e) && !is_sampler(e))
        .collect();
    let options: Vec<&RunEntry> = details.run.iter().filter(is_option).collect();
    let mut html = origin(details);
    html.push_str(&times(timings));
    html.push_str(&samplers(details));
    html.push_str(&entries("Data, search and noise", &counts));
    html.push_str(&entries("Options", &options));
    html
}

fn origin(details: &Details) -> String {
    let mut html = String::from("<dl class=\"facts\">\n");
    for (name, value) in &details.header {
        let _ = write!(
            html,
            "<div><dt>{name}</dt><dd>{}</dd></div>",
            escaped(value)
        );
    }
    html.push_str("\n</dl>\n");
    html
}

/// Where the time went, the longest stage first.
fn times(timings: &[StageTime]) -> String {
    if timings.is_empty() {
        return String::new();
    }
    let mut timings: Vec<&StageTime> = timings.iter().collect();
    timings.sort_by(|a, b| b.wall_s.total_cmp(&a.wall_s));
    let all_s: f64 = timings.iter().map(|t| t.wall_s).sum();
    let mut html = format!(
        "<div class=\"scroll\"><table>\n<caption>Where the time went, {} s in all</caption>\n<thead><tr>\
         <th scope=\"col\">Stage</th><th scope=\"col\">Times</th><th scope=\"col\">Wall time [s]</th>\
         <th scope=\"col\">Part [%]</th></tr></thead>\n<tbody>\n",
        decimals(all_s, 1)
    );
    for StageTime {
        stage,
        times,
        wall_s,
    } in timings
    {
        let part = 100.0 * wall_s / all_s.max(f64::MIN_POSITIVE);
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">{}</th><td class=\"number\">{times}</td><td class=\"number\">{}</td>\
             <td class=\"number\">{}</td></tr>",
            escaped(stage),
            decimals(*wall_s, 2),
            decimals(part, 1)
        );
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

/// Diagnostics of the samplers, stages beside each other.
fn samplers(details: &Details) -> String {
    let mut names: Vec<(&str, &str)> = Vec::new();
    for entry in &details.run {
        let name = STAGES
            .iter()
            .find_map(|(stage, _)| entry.key.strip_prefix(stage));
        if let Some(name) = name
            && !names.iter().any(|(known, _)| *known == name)
        {
            names.push((name, &entry.comment));
        }
    }
    if names.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<div class=\"scroll\"><table>\n<caption>How well the samplers did</caption>\n<thead><tr>\
         <th scope=\"col\">Diagnostic</th>",
    );
    for (_, title) in STAGES {
        let _ = write!(html, "<th scope=\"col\">{title}</th>");
    }
    html.push_str("<th scope=\"col\">Meaning</th></tr></thead>\n<tbody>\n");
    for (name, comment) in names {
        let _ = write!(
            html,
            "<tr><th scope=\"row\"><code>{}</code></th>",
            escaped(name)
        );
        for (stage, _) in STAGES {
            let value = details
                .number(&format!("{stage}{name}"))
                .unwrap_or(f64::NAN);
            let _ = write!(html, "<td class=\"number\">{}</td>", short(value));
        }
        let _ = writeln!(html, "<td>{}</td></tr>", escaped(comment));
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

/// Entries of `RUN` as they stand there.
fn entries(title: &str, entries: &[&RunEntry]) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let mut html = format!(
        "<details><summary>{title}</summary>\n<div class=\"scroll\"><table>\n<thead><tr>\
         <th scope=\"col\">Key</th><th scope=\"col\">Value</th><th scope=\"col\">Meaning</th></tr></thead>\n\
         <tbody>\n"
    );
    for RunEntry {
        key,
        value,
        comment,
    } in entries
    {
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\"><code>{}</code></th><td class=\"value\">{}</td><td>{}</td></tr>",
            escaped(key),
            escaped(value),
            escaped(comment)
        );
    }
    html.push_str("</tbody>\n</table></div></details>\n");
    html
}
