//! The visibilities beside the model, in numbers.

use std::fmt::Write as _;

use super::super::Figure;
use super::super::format::{decimals, grouped, with_error};
use super::super::svg::escaped;
use super::super::visibilities::Check;

pub(super) fn html(check: &Check, figure: Option<&Figure>) -> String {
    let inputs: Vec<String> = check
        .inputs
        .iter()
        .map(|i| format!("<b>{}</b>", escaped(i)))
        .collect();
    let mut html = format!(
        "<p>{}, {} Stokes I samples: χ² for each degree of freedom is {} with the model subtracted, and {} \
         without; noise alone gives 1 ± {}. {}</p>\n",
        inputs.join(", "),
        grouped(check.n_sample as f64),
        decimals(check.chi2, 4),
        decimals(check.chi2_of_data, 4),
        decimals(1.0 / (check.n_sample as f64).sqrt(), 4),
        origin(check)
    );
    html.extend(figure.map(|figure| figure.inline("")));
    html.push_str(&table(check));
    html
}

fn origin(check: &Check) -> String {
    let of_posterior = match check.n_draw {
        0 => "Without posterior samples, predictions are those of the estimates alone.".to_owned(),
        n => format!("Predictions are from {n} joint draws of all sources from the posterior."),
    };
    let of_input = match check.is_same_input {
        Some(true) => " These are the bytes that the catalogue was made of.",
        Some(false) => " <strong>These are not the bytes that the catalogue was made of.</strong>",
        None => "",
    };
    of_posterior + of_input
}

fn table(check: &Check) -> String {
    let mut html = String::from(
        "<details><summary>The same in numbers</summary>\n<div class=\"scroll\"><table>\n<thead><tr>\
         <th scope=\"col\">Baseline length [kλ]</th><th scope=\"col\">Samples</th>\
         <th scope=\"col\">Data [µJy]</th><th scope=\"col\">Prediction [µJy]</th>\
         <th scope=\"col\">Pull</th><th scope=\"col\">χ²/dof</th></tr></thead>\n<tbody>\n",
    );
    for bin in &check.bins {
        let [low, high] = bin.ends.map(|end| decimals(end / 1e3, 2));
        let [mean, deviation] = bin.predicted_ujy;
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">{low} to {high}</th><td class=\"number\">{}</td>\
             <td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>\
             <td class=\"number\">{}</td></tr>",
            grouped(bin.n_sample as f64),
            with_error(bin.data_ujy, bin.err_ujy),
            with_error(mean, deviation),
            decimals(bin.pull(), 2),
            with_error(bin.chi2, bin.chi2_err())
        );
    }
    html.push_str("</tbody>\n</table></div></details>\n");
    html
}
