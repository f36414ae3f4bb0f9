//! Numbers as people read them.

/// A number with a true minus sign.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.trim_start_matches(['0', '.']).is_empty() => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

/// `123.5 ± 1.2`: both with the decimals that show two digits of the error.
pub(super) fn with_error(mean: f64, err: f64) -> String {
    if !mean.is_finite() {
        return "–".to_owned();
    }
    if !(err > 0.0 && err.is_finite()) {
        return short(mean);
    }
    let decimals = error_decimals(err);
    format!("{} ± {}", number(mean, decimals), number(err, decimals))
}

/// Decimals that show two digits of an error above 0.
pub(super) fn error_decimals(err: f64) -> usize {
    (1.0 - err.log10().floor()).clamp(0.0, 6.0) as usize
}

/// A number with so many decimals, or a dash.
pub(super) fn decimals(value: f64, decimals: usize) -> String {
    if value.is_finite() {
        number(value, decimals)
    } else {
        "–".to_owned()
    }
}

/// A number of four digits or so, or a dash.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "–".to_owned()
    } else if value == value.trunc() && size < 1e15 {
        grouped(value)
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        number(value, decimals)
    } else {
        format!("{value:.3e}").replace('-', "\u{2212}")
    }
}

/// A whole number with narrow gaps between groups of three digits.
pub(super) fn grouped(value: f64) -> String {
    let digits = number(value, 0);
    let (sign, digits) = match digits.strip_prefix('\u{2212}') {
        Some(rest) => ("\u{2212}", rest),
        None => ("", digits.as_str()),
    };
    let n = digits.len();
    let mut text = sign.to_owned();
    for (i, digit) in digits.chars().enumerate() {
        if n > 4 && i > 0 && (n - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// `1 source`, `2 sources`.
pub(super) fn plural(n: usize, what: &str) -> String {
    format!(
        "{} {what}{}",
        grouped(n as f64),
        if n == 1 { "" } else { "s" }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_by_hand() {
        assert_eq!(with_error(123.456, 1.234), "123.5 ± 1.2");
        assert_eq!(with_error(-0.5, f64::NAN), "−0.5000");
        assert_eq!(with_error(f64::NAN, 1.0), "–");
        assert_eq!(grouped(9_266_880.0), "9\u{202f}266\u{202f}880");
        assert_eq!(
            [short(0.000_65), short(23419.0), short(5.720_99)],
            ["6.500e−4", "23\u{202f}419", "5.721"]
        );
        assert_eq!(plural(1, "source"), "1 source");
    }
}
