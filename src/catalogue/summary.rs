//! The sources as a table for people.

use super::row::{Estimate, SourceRow};
use crate::coords::RaDec;
use crate::units::{ARCSEC, DEG, MICROJY};

/// Titles of the columns; the first is aligned left, the others right.
const TITLES: [&str; 9] = [
    "name", "RA", "DEC", "E_RA \"", "E_DEC \"", "flux uJy", "size \"", "SNR", "log Z",
];

/// One line a source, columns aligned, under a line of titles: name, position with errors [arcsec],
/// flux density [uJy] and scale-length [arcsec] with errors, SNR, log evidence.
pub fn summary_table(sources: &[SourceRow]) -> String {
    let mut lines = vec![TITLES.map(str::to_owned)];
    lines.extend(sources.iter().map(cells));
    aligned(&lines)
}

/// Lines of cells with their columns aligned: the first to the left, the others to the right.
pub(crate) fn aligned<const N: usize>(lines: &[[String; N]]) -> String {
    let width = |column: usize| lines.iter().map(|l| l[column].chars().count()).max();
    let widths: Vec<usize> = (0..N).map(|c| width(c).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let padded = line.iter().zip(&widths).enumerate();
        let cells: Vec<String> = padded
            .map(|(column, (cell, &width))| match column {
                0 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            })
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

fn cells(source: &SourceRow) -> [String; TITLES.len()] {
    let p = &source.posterior;
    let error_arcsec = p.e_ra_rad.max(p.e_dec_rad) / ARCSEC;
    let [ra, dec] = sexagesimal(p.position, digits(error_arcsec));
    [
        source.name.clone(),
        ra,
        dec,
        format!("{:.*}", digits(error_arcsec), p.e_ra_rad / ARCSEC),
        format!("{:.*}", digits(error_arcsec), p.e_dec_rad / ARCSEC),
        with_error(p.flux_jy, MICROJY),
        with_error(p.scale_rad, ARCSEC),
        format!("{:.1}", source.snr),
        format!("{:.1}", source.log_z.mean),
    ]
}

/// Decimals that show two digits of an error.
fn digits(err: f64) -> usize {
    if err > 0.0 && err.is_finite() {
        (1.0 - err.log10().floor()).clamp(0.0, 6.0) as usize
    } else {
        2
    }
}

fn with_error(value: Estimate, unit: f64) -> String {
    let digits = digits(value.err / unit);
    format!(
        "{:.digits$} ± {:.digits$}",
        value.mean / unit,
        value.err / unit
    )
}

/// Right ascension with one decimal more than `decimals` of an arcsecond, and declination, rounded.
fn sexagesimal(position: RaDec, decimals: usize) -> [String; 2] {
    if !position.ra_rad.is_finite() || !position.dec_rad.is_finite() {
        return ["nan".to_owned(), "nan".to_owned()];
    }
    let ra = position.ra_rad.rem_euclid(std::f64::consts::TAU) / DEG / 15.0;
    let sign = if position.dec_rad < 0.0 { '-' } else { '+' };
    let dec = position.dec_rad.abs() / DEG;
    [
        base60(ra, decimals + 1, Some(24)),
        format!("{sign}{}", base60(dec, decimals, None)),
    ]
}

/// `hh:mm:ss.s` of a number of hours or degrees, rounded as a whole so that no 60 appears.
fn base60(whole: f64, decimals: usize, modulus: Option<u64>) -> String {
    let scale = 10_u64.pow(decimals as u32);
    let ticks = (whole * 3600.0 * scale as f64).round() as u64;
    let ticks = modulus.map_or(ticks, |m| ticks % (m * 3600 * scale));
    let (seconds, fraction) = (ticks / scale, ticks % scale);
    let (h, m, s) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match decimals {
        0 => format!("{h:02}:{m:02}:{s:02}"),
        _ => format!("{h:02}:{m:02}:{s:02}.{fraction:0decimals$}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_carries_over_and_around() {
        assert_eq!(base60(23.999_999_999, 2, Some(24)), "00:00:00.00");
        assert_eq!(base60(29.999_999_999, 1, None), "30:00:00.0");
        assert_eq!(base60(12.5, 0, None), "12:30:00");
        let [ra, dec] = sexagesimal(
            RaDec {
                ra_rad: 15.0 * DEG,
                dec_rad: -0.5 / 3600.0 * DEG,
            },
            1,
        );
        assert_eq!((ra.as_str(), dec.as_str()), ("01:00:00.00", "-00:00:00.5"));
    }

    #[test]
    fn an_error_shows_two_digits() {
        let flux = Estimate {
            mean: 123.456e-6,
            err: 1.234e-6,
        };
        assert_eq!(with_error(flux, MICROJY), "123.5 ± 1.2");
        assert_eq!(with_error(Estimate::MISSING, MICROJY), "NaN ± NaN");
    }

    #[test]
    fn no_sources_leave_the_titles() {
        assert_eq!(summary_table(&[]).lines().count(), 1);
    }
}
