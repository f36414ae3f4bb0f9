//! Days and their fractions.

/// Julian date of the modified Julian date 0.
pub(crate) const MJD_ZERO_JD: f64 = 2_400_000.5;
/// Modified Julian date of 1970-01-01.
const UNIX_EPOCH_MJD: i64 = 40_587;

/// Turns of the Earth in a solar day [deg], sidereal.
///
/// # Source
/// IERS Conventions (2010), section 5.5.3: 360 · 1.002 737 909 350 795.
pub(crate) const DEG_PER_DAY: f64 = 360.985_647_366_286_2;

/// A sum that loses nothing to the order or the size of its terms.
///
/// The parts of a DATE are 2.4 million days, a day and a microsecond, in any order.
///
/// # Source
/// Neumaier, Z. Angew. Math. Mech. 54, 39 (1974).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CarefulSum {
    sum: f64,
    lost: f64,
}

impl CarefulSum {
    /// Adds a term.
    pub(crate) fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - sum) + term
        } else {
            (term - sum) + self.sum
        };
        self.sum = sum;
    }

    /// The sum.
    pub(crate) fn total(self) -> f64 {
        self.sum + self.lost
    }
}

/// A calendar day as written in DATE-OBS and RDATE.
///
/// `YYYY-MM-DD`, with or without a time, or `DD/MM/YY` of the twentieth century (FITS Standard,
/// section 4.4.2.1). `None` where the text is cut or no day: real files have `'2006-06-'`.
pub(crate) fn parse_day(text: &str) -> Option<String> {
    let day = text.split('T').next()?.trim();
    let parts: Vec<&str> = day.split(['-', '/']).collect();
    let &[first, month, last] = parts.as_slice() else {
        return None;
    };
    let number = |text: &str| text.parse::<u32>().ok();
    let (year, month, day) = if day.contains('-') {
        (number(first)?, number(month)?, number(last)?)
    } else {
        (1900 + number(last)?, number(month)?, number(first)?)
    };
    let valid =
        (1900..3000).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    valid.then(|| format!("{year:04}-{month:02}-{day:02}"))
}

/// The calendar day `YYYY-MM-DD` of a modified Julian date.
///
/// # Source
/// Hinnant, "chrono-Compatible Low-Level Date Algorithms" (`civil_from_days`).
pub(crate) fn day_of_mjd(mjd: f64) -> String {
    let z = mjd.floor() as i64 - UNIX_EPOCH_MJD + 719_468;
    let era = z.div_euclid(146_097);
    let doe = z.rem_euclid(146_097);
    let yoe = (doe - doe / 1460 + doe / 36_524 - doe / 146_096) / 365;
    let doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
    let mp = (5 * doy + 2) / 153;
    let day = doy - (153 * mp + 2) / 5 + 1;
    let month = if mp < 10 { mp + 3 } else { mp - 9 };
    let year = yoe + era * 400 + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

/// The modified Julian date of `YYYY-MM-DD`; `None` where the text is something else.
///
/// # Source
/// As [`day_of_mjd`] (`days_from_civil`).
pub(crate) fn mjd_of_day(day: &str) -> Option<f64> {
    let mut parts = day.splitn(3, '-').map(|part| part.parse::<i64>().ok());
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let yoe = year.rem_euclid(400);
    let doy = (153 * (if month > 2 { month - 3 } else { month + 9 }) + 2) / 5 + day - 1;
    let doe = yoe * 365 + yoe / 4 - yoe / 100 + doy;
    Some((era * 146_097 + doe - 719_468 + UNIX_EPOCH_MJD) as f64)
}

/// Greenwich mean sidereal time at 0 h of a day [deg].
///
/// # Source
/// IAU 1982: Aoki et al., Astron. Astrophys. 105, 359, eq. 14.
pub(crate) fn gmst0_deg(mjd: f64) -> f64 {
    let t = (mjd.floor() - 51_544.5) / 36_525.0;
    let seconds = 24_110.548_41 + t * (8_640_184.812_866 + t * (0.093_104 - t * 6.2e-6));
    (seconds / 240.0).rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_keeps_the_microseconds() {
        let terms = [2.453_901_5e6, 0.25, 1e-12, -MJD_ZERO_JD];
        let mut there = CarefulSum::default();
        let mut back = CarefulSum::default();
        for i in 0..terms.len() {
            there.add(terms[i]);
            back.add(terms[terms.len() - 1 - i]);
        }
        assert_eq!(there.total(), 53_901.25 + 1e-12);
        assert_eq!(there.total(), back.total());
    }

    #[test]
    fn days_go_there_and_back() {
        assert_eq!(day_of_mjd(53_901.9), "2006-06-15");
        assert_eq!(mjd_of_day("2006-06-15"), Some(53_901.0));
        for mjd in (-50_000..100_000).step_by(97) {
            assert_eq!(
                mjd_of_day(&day_of_mjd(f64::from(mjd))),
                Some(f64::from(mjd))
            );
        }
        assert_eq!(mjd_of_day("2006-06-"), None);
    }

    #[test]
    fn cut_dates_are_no_dates() {
        assert_eq!(
            parse_day("2015-12-11T10:59:06.002").as_deref(),
            Some("2015-12-11")
        );
        assert_eq!(parse_day("15/06/98").as_deref(), Some("1998-06-15"));
        for text in ["2006-06-", "", "yesterday", "2006-13-01", "2006-06-15-1"] {
            assert_eq!(parse_day(text), None);
        }
    }

    #[test]
    fn sidereal_time_agrees_with_a_real_antenna_table() {
        // GSTIA0 of a VLBA file of 2006-06-15, written by AIPS: apparent, hence the tolerance.
        assert!((gmst0_deg(53_901.0) - 263.138_638_6).abs() < 0.01);
    }
}
