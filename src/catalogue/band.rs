//! The UCD word for the part of the spectrum that was observed.

/// Lower edges [Hz] of the bands of UCD1+ (IVOA, "The UCD1+ controlled vocabulary" 1.5), with names.
const BANDS: [(f64, &str); 14] = [
    (0.0, "em.radio.20MHz"),
    (20e6, "em.radio.20-100MHz"),
    (100e6, "em.radio.100-200MHz"),
    (200e6, "em.radio.200-400MHz"),
    (400e6, "em.radio.400-750MHz"),
    (750e6, "em.radio.750-1500MHz"),
    (1500e6, "em.radio.1500-3000MHz"),
    (3e9, "em.radio.3-6GHz"),
    (6e9, "em.radio.6-12GHz"),
    (12e9, "em.radio.12-30GHz"),
    (30e9, "em.mm.30-50GHz"),
    (50e9, "em.mm.50-100GHz"),
    (100e9, "em.mm.100-200GHz"),
    (200e9, "em.mm.200-400GHz"),
];

/// Upper edge of the last band [Hz].
const HIGHEST_HZ: f64 = 400e9;

/// The band that holds `freq_hz`; all of radio where that is unknown.
pub(super) fn ucd_band(freq_hz: Option<f64>) -> &'static str {
    match freq_hz {
        Some(freq) if freq > 0.0 && freq < HIGHEST_HZ => (BANDS.iter().rev())
            .find(|(edge, _)| freq >= *edge)
            .map_or("em.radio", |(_, name)| name),
        _ => "em.radio",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frequency_falls_into_its_band() {
        for (freq, band) in [
            (1.4e9, "em.radio.750-1500MHz"),
            (1.5e9, "em.radio.1500-3000MHz"),
            (5e6, "em.radio.20MHz"),
            (345e9, "em.mm.200-400GHz"),
            (1e15, "em.radio"),
            (f64::NAN, "em.radio"),
        ] {
            assert_eq!(ucd_band(Some(freq)), band);
        }
        assert_eq!(ucd_band(None), "em.radio");
    }
}
