//! How the catalogue was made: samplers, counts, options, origin.

use std::fmt::Write as _;

use super::super::details::Details;
use super::super::format::short;
use super::super::svg::escaped;
use crate::catalogue::RunEntry;

/// Stages of a run that samplers are diagnosed in.
const STAGES: [(&str, &str); 2] = [
    ("sampler.search.", "Searches of tiles"),
    ("sampler.posterior.", "Posteriors of sources"),
];

pub(super) fn html(details: &Details) -> String {
    if details.run.is_empty() && details.header.is_empty() {
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
