//! The field: sources with the errors of their positions, modes that were dropped, what is true.

use super::super::Contents;
use super::super::axis::{Axis, range, round_step};
use super::super::figure::Figure;
use super::super::format::{decimals, number};
use super::super::panel::{Panel, Sample, cross, legend, plus};
use super::super::svg::Svg;
use crate::catalogue::FoundRow;
use crate::coords::RaDec;
use crate::detect::Status;
use crate::units::{ARCSEC, MICROJY};

const SIZE: [f64; 2] = [640.0, 640.0];
const CORNER: [f64; 2] = [66.0, 34.0];
const SIDE: f64 = 556.0;
/// Semi-axis that the ellipse of a typical error is given at most [px], less where there are many sources:
/// then it is this part of their distance.
const ELLIPSE_PX: f64 = 20.0;
const ELLIPSE_PART: f64 = 0.2;
/// Points of an ellipse.
const N_POINT: usize = 28;

pub(super) fn draw(contents: &Contents) -> Option<Figure> {
    if contents.catalogue.rows.is_empty() && contents.catalogue.field.is_none() {
        return None;
    }
    let map = Map::new(contents);
    let mut svg = Svg::default();
    map.panel.frame(&mut svg);
    let n_dropped = map.dropped(&mut svg);
    let factor = map.sources(&mut svg);
    map.truth(&mut svg);
    let mut entries = vec![(Sample::Dot, "dot", "source".to_owned())];
    if let Some(factor) = factor {
        entries.push((
            Sample::Dot,
            "halo",
            format!("1σ of its position, × {factor}"),
        ));
    }
    if n_dropped > 0 {
        entries.push((Sample::Cross, "dropped", "mode that was dropped".to_owned()));
    }
    if contents.truth.is_some() {
        entries.push((Sample::Plus, "truth", "true source".to_owned()));
    }
    let entries: Vec<(Sample, &str, &str)> = entries
        .iter()
        .map(|(s, c, t)| (*s, *c, t.as_str()))
        .collect();
    legend(&mut svg, [68.0, 16.0], &entries);
    Some(Figure::new(
        "field",
        "The field",
        &map.about(n_dropped, factor),
        SIZE,
        svg,
    ))
}

struct Map<'a> {
    contents: &'a Contents,
    panel: Panel,
    /// Unit of the axes [rad].
    unit_rad: f64,
}

impl<'a> Map<'a> {
    fn new(contents: &'a Contents) -> Self {
        let ([l_low, l_high], [m_low, m_high]) = square(contents);
        let (unit_rad, unit) = if l_high - l_low > 240.0 * ARCSEC {
            (60.0 * ARCSEC, "arcmin")
        } else {
            (ARCSEC, "arcsec")
        };
        let axis = |what: &str, ends: [f64; 2]| {
            Axis::linear(&format!("{what} [{unit}]"), ends.map(|end| end / unit_rad))
        };
        let panel = Panel {
            x: axis("Offset towards east", [l_low, l_high]).reversed(),
            y: axis("Offset towards north", [m_low, m_high]),
            corner: CORNER,
            size: [SIDE, SIDE],
        };
        Self {
            contents,
            panel,
            unit_rad,
        }
    }

    /// The place of a position; none outside the panel.
    fn at(&self, position: RaDec) -> Option<[f64; 2]> {
        let lm = self.contents.offset(position);
        let (x, y) = (lm.l / self.unit_rad, lm.m / self.unit_rad);
        let inside = self.panel.x.holds(x) && self.panel.y.holds(y);
        inside.then(|| self.panel.at(x, y))
    }

    fn px_per_rad(&self) -> f64 {
        let [low, high] = self.panel.x.ends();
        SIDE / ((high - low) * self.unit_rad)
    }

    /// Draws modes that are no sources; how many there are.
    fn dropped(&self, svg: &mut Svg) -> usize {
        let modes = self.contents.catalogue.modes.iter().flatten();
        let dropped = modes.filter(|mode| mode.status != Status::Kept);
        let mut n = 0;
        for mode in dropped {
            let Some(at) = self.at(mode.position) else {
                continue;
            };
            let why = mode.status.as_str();
            let title = format!("{why}, SNR {}", decimals(mode.snr_peak, 1));
            svg.titled(&title, |svg| cross(svg, "dropped", at));
            n += 1;
        }
        n
    }

    fn truth(&self, svg: &mut Svg) {
        let sources = self.contents.truth.iter().flat_map(|t| &t.list.sources);
        for source in sources {
            if let Some(at) = self.at(source.position) {
                let title = format!("true source of {:.1} µJy", source.flux_jy / MICROJY);
                svg.titled(&title, |svg| plus(svg, "truth", at));
            }
        }
    }

    /// Draws the sources; the factor on their errors, where these are known.
    fn sources(&self, svg: &mut Svg) -> Option<f64> {
        let rows = &self.contents.catalogue.rows;
        let brightest = rows.iter().map(|r| r.flux_jy.mean).fold(0.0, f64::max);
        let factor = self.error_factor();
        for (i, row) in rows.iter().enumerate() {
            let Some(at) = self.at(row.position) else {
                continue;
            };
            let part = (row.flux_jy.mean / brightest).clamp(0.0, 1.0);
            let title = format!(
                "{}: {} µJy, SNR {}",
                self.contents.title(i),
                decimals(row.flux_jy.mean / MICROJY, 1),
                decimals(row.snr, 1)
            );
            svg.linked(&self.contents.anchor(i), &title, |svg| {
                if let Some(factor) = factor {
                    svg.path("halo", &self.ellipse(i, row, at, factor));
                }
                svg.circle("dot", at, 1.6 + 3.4 * part.sqrt());
            });
        }
        factor
    }

    /// A round factor that makes typical errors large, but no larger than [`ELLIPSE_PX`] or so that they hide each other.
    fn error_factor(&self) -> Option<f64> {
        let rows = self.contents.catalogue.rows.iter();
        let mut sigmas: Vec<f64> = rows
            .map(|row| row.e_ra_rad.max(row.e_dec_rad))
            .filter(|sigma| *sigma > 0.0)
            .collect();
        sigmas.sort_by(f64::total_cmp);
        let typical_px = sigmas.get(sigmas.len() / 2)? * self.px_per_rad();
        let apart_px = SIDE / (sigmas.len() as f64).sqrt();
        let wanted_px = ELLIPSE_PX.min(ELLIPSE_PART * apart_px);
        Some((1.0 / round_step(typical_px / wanted_px)).round().max(1.0))
    }

    /// The path of `factor` standard deviations about the place `at`.
    fn ellipse(&self, i: usize, row: &FoundRow, [x, y]: [f64; 2], factor: f64) -> String {
        let corr = self.contents.row_details(i).corr_ra_dec;
        let corr = if corr.is_finite() {
            corr.clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let scale = factor * self.px_per_rad();
        let (east, north) = (scale * row.e_ra_rad, scale * row.e_dec_rad);
        if !(east.is_finite() && north.is_finite()) {
            return String::new();
        }
        let point = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / N_POINT as f64).sin_cos();
            // East is to the left, north is up.
            let up = north * (corr * cos + (1.0 - corr * corr).sqrt() * sin);
            // What lies outside the panel is moved to its edge.
            [
                (x - east * cos).clamp(CORNER[0], CORNER[0] + SIDE),
                (y - up).clamp(CORNER[1], CORNER[1] + SIDE),
            ]
        };
        let points: Vec<[f64; 2]> = (0..N_POINT).map(point).collect();
        super::super::svg::polyline(&points) + "Z"
    }

    fn about(&self, n_dropped: usize, factor: Option<f64>) -> String {
        let centre = self.contents.centre();
        let errors = factor.map_or(String::new(), |factor| {
            format!(" Ellipses are the standard deviations of positions, enlarged {factor} times.")
        });
        let dropped = match n_dropped {
            0 => String::new(),
            1 => " A cross marks a mode that was dropped.".to_owned(),
            n => format!(" Crosses mark the {n} modes that were dropped."),
        };
        let n = self.contents.catalogue.rows.len();
        format!(
            "{n} source{} about RA {}°, DEC {}° (ICRS); larger dots are brighter, and lead to \
             the source.{errors}{dropped}",
            if n == 1 { "" } else { "s" },
            number(centre.ra_rad.to_degrees(), 5),
            number(centre.dec_rad.to_degrees(), 5)
        )
    }
}

/// The searched field, or a square that holds all sources: ends in l and in m [rad].
fn square(contents: &Contents) -> ([f64; 2], [f64; 2]) {
    if let Some(field) = contents.catalogue.field {
        return ([field.low.l, field.high.l], [field.low.m, field.high.m]);
    }
    let offsets = contents
        .catalogue
        .rows
        .iter()
        .map(|r| contents.offset(r.position));
    let offsets: Vec<_> = offsets.collect();
    let along =
        |pick: fn(&crate::coords::Lm) -> f64| range(offsets.iter().map(pick)).unwrap_or([0.0, 0.0]);
    let (l, m) = (along(|lm| lm.l), along(|lm| lm.m));
    let half = 0.55 * (l[1] - l[0]).max(m[1] - m[0]).max(10.0 * ARCSEC);
    let about = |[low, high]: [f64; 2]| [0.5 * (low + high) - half, 0.5 * (low + high) + half];
    (about(l), about(m))
}
