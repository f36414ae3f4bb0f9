//! UTC as text and as modified Julian date.

use sofars::cal::{cal2jd, jd2cal};
use sofars::consts::{DAYSEC, DJM0};

use super::SimulateError;

/// The modified Julian date [day] of `text`, UTC: `YYYY-MM-DD` or `YYYY-MM-DDThh:mm[:ss[.sss]][Z]`.
///
/// # Errors
/// The text has another form or no such day or time exists.
///
/// # Not valid when
/// The time lies within a leap second (the last was on 2016-12-31).
pub fn parse_utc(text: &str) -> Result<f64, SimulateError> {
    parse(text.trim()).ok_or_else(|| {
        SimulateError::parameter(format!(
            "expected a UTC time like 2020-01-01T12:00:00, found \"{text}\""
        ))
    })
}

fn parse(text: &str) -> Option<f64> {
    let text = text.strip_suffix('Z').unwrap_or(text);
    let (date, time) = text.split_once(['T', ' ']).unwrap_or((text, "0:0"));
    let mut date = date.splitn(3, '-');
    let mut date_part = || date.next()?.parse::<i32>().ok();
    let (_, day_mjd) = cal2jd(date_part()?, date_part()?, date_part()?).ok()?;
    let mut time = time.splitn(3, ':');
    let hour: u32 = time.next()?.parse().ok()?;
    let minute: u32 = time.next()?.parse().ok()?;
    let second: f64 = time.next().unwrap_or("0").parse().ok()?;
    if hour > 23 || minute > 59 || !(0.0..60.0).contains(&second) {
        return None;
    }
    Some(day_mjd + (f64::from(hour * 3600 + minute * 60) + second) / DAYSEC)
}

/// `mjd` [day, UTC] as `YYYY-MM-DDThh:mm:ss`, rounded to the second.
pub fn format_utc(mjd: f64) -> String {
    let second = (mjd * DAYSEC).round();
    let day_mjd = (second / DAYSEC).floor();
    let in_day = (second - day_mjd * DAYSEC) as u32;
    match jd2cal(DJM0, day_mjd) {
        Ok((year, month, day, _)) => format!(
            "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}",
            in_day / 3600,
            in_day / 60 % 60,
            in_day % 60
        ),
        Err(_) => format!("MJD {mjd}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_come_back_as_they_went_in() {
        for (text, mjd) in [
            ("1858-11-17T00:00:00", 0.0),
            ("2000-01-01T12:00:00", 51544.5),
            ("2020-01-01T00:00:00", 58849.0),
            ("2024-02-29T23:59:59", 60369.0 + 86399.0 / 86400.0),
        ] {
            assert!((parse_utc(text).unwrap() - mjd).abs() < 1e-10, "{text}");
            assert_eq!(format_utc(mjd), text);
        }
        assert_eq!(parse_utc("2020-01-01").unwrap(), 58849.0);
        assert_eq!(parse_utc("2020-01-01 06:00Z").unwrap(), 58849.25);
    }

    #[test]
    fn no_such_time_is_an_error() {
        for text in [
            "",
            "2020",
            "2020-13-01",
            "2021-02-29",
            "2020-01-01T24:00",
            "2020-01-01T12",
            "yesterday",
        ] {
            assert!(parse_utc(text).is_err(), "{text}");
        }
    }
}
