//! The payload: groups of numbers into rows of visibilities.
//!
//! # Source
//! FITS Standard 4.0, section 6; memo, section 3.1 (weights of zero or less mark bad data).

use num_complex::Complex;

use super::axes::Axes;
use crate::chunk::settle;
use crate::fits::header::Header;
use crate::{ReadError, VisChunk};

/// Type of the numbers, by BITPIX.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Element {
    U8,
    I16,
    I32,
    F32,
    F64,
}

impl Element {
    fn of_bitpix(bitpix: i64) -> Option<Self> {
        Some(match bitpix {
            8 => Self::U8,
            16 => Self::I16,
            32 => Self::I32,
            -32 => Self::F32,
            -64 => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::I16 => 2,
            Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Element `at` of big-endian numbers.
    fn get(self, bytes: &[u8], at: usize) -> f64 {
        fn part<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
            bytes.as_chunks::<N>().0[at]
        }
        match self {
            Self::U8 => f64::from(bytes[at]),
            Self::I16 => f64::from(i16::from_be_bytes(part(bytes, at))),
            Self::I32 => f64::from(i32::from_be_bytes(part(bytes, at))),
            Self::F32 => f64::from(f32::from_be_bytes(part(bytes, at))),
            Self::F64 => f64::from_be_bytes(part(bytes, at)),
        }
    }
}

/// How a group is laid out.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    element: Element,
    n_param: usize,
    /// Bytes in a group.
    pub(super) group_bytes: usize,
    axes: Axes,
    scale: f64,
    zero: f64,
    /// Raw value of what is undefined (integers).
    blank: Option<f64>,
    /// Real, imaginary part and weight of one correlation after the other as 32-bit floats.
    plain: bool,
}

impl Layout {
    /// Reads BITPIX, BSCALE, BZERO and BLANK.
    pub(super) fn read(header: &Header, axes: &Axes, n_param: usize) -> Result<Self, ReadError> {
        let bitpix = header.integer("BITPIX")?.unwrap_or(0);
        let element = Element::of_bitpix(bitpix).ok_or_else(|| {
            let what = format!("groups of {bitpix} bits are not read");
            header.place.unsupported("BITPIX", what)
        })?;
        let blank = match element {
            Element::F32 | Element::F64 => None,
            _ => header.integer("BLANK")?.map(|blank| blank as f64),
        };
        let scale = header.real("BSCALE")?.unwrap_or(1.0);
        let zero = header.real("BZERO")?.unwrap_or(0.0);
        let plain = element == Element::F32 && (scale, zero) == (1.0, 0.0) && is_plain(axes);
        Ok(Self {
            element,
            n_param,
            group_bytes: (n_param + axes.n_value) * element.bytes(),
            axes: axes.clone(),
            scale,
            zero,
            blank,
            plain,
        })
    }

    /// Bytes of a group's parameters.
    pub(super) fn parameter_bytes(&self) -> usize {
        self.n_param * self.element.bytes()
    }

    /// Raw parameter `at` of a group.
    pub(super) fn parameter(&self, group: &[u8], at: usize) -> f64 {
        self.element.get(group, at)
    }

    /// Appends the visibilities of a group; returns how many were not finite though not flagged.
    pub(super) fn append_data(&self, group: &[u8], chunk: &mut VisChunk) -> u64 {
        if self.plain {
            let n_value = chunk.values_per_row();
            let data = &group[self.n_param * size_of::<f32>()..];
            let cells = &data.as_chunks().0[..n_value];
            if append_finite(cells, chunk) {
                return 0;
            }
            return append_settled(cells.iter().map(numbers), chunk);
        }
        append_settled(self.places().map(|at| self.sample(group, at)), chunk)
    }

    /// Where the samples start, in the order of a chunk: IF, channel, correlation.
    fn places(&self) -> impl Iterator<Item = usize> + '_ {
        let Axes {
            n_if, freq, stokes, ..
        } = &self.axes;
        (0..n_if.len).flat_map(move |i| {
            (0..freq.len).flat_map(move |f| {
                (0..stokes.len).map(move |p| {
                    self.n_param + i * n_if.stride + f * freq.stride + p * stokes.stride
                })
            })
        })
    }

    /// Real part, imaginary part and weight (1 where the file has none).
    fn sample(&self, group: &[u8], at: usize) -> [f32; 3] {
        let complex = &self.axes.complex;
        [0, 1, 2].map(|i| {
            if i == complex.len {
                return 1.0;
            }
            let raw = self.element.get(group, at + i * complex.stride);
            if self.blank == Some(raw) {
                f32::NAN
            } else {
                (self.zero + self.scale * raw) as f32
            }
        })
    }
}

/// Real part, imaginary part and weight.
fn numbers(cell: &[u8; 12]) -> [f32; 3] {
    let parts = cell.as_chunks::<4>().0;
    [0, 1, 2].map(|i| f32::from_be_bytes(parts[i]))
}

/// Appends samples, if all are finite: what [`settle`] comes to then, in loops that the compiler makes
/// many at a time of. Returns whether they were.
fn append_finite(cells: &[[u8; 12]], chunk: &mut VisChunk) -> bool {
    let all_finite = cells.iter().fold(true, |all, cell| {
        let [re, im, weight] = numbers(cell);
        all & re.is_finite() & im.is_finite() & weight.is_finite()
    });
    if all_finite {
        let samples = || cells.iter().map(numbers);
        (chunk.vis_jy_rfp).extend(samples().map(|[re, im, _]| Complex::new(re, im)));
        (chunk.weight_rfp).extend(samples().map(|[_, _, w]| if w > 0.0 { w } else { 0.0 }));
        (chunk.flag_rfp).extend(samples().map(|[_, _, w]| w <= 0.0));
    }
    all_finite
}

/// Appends samples of any kind; returns how many were not finite though not flagged.
fn append_settled(samples: impl Iterator<Item = [f32; 3]>, chunk: &mut VisChunk) -> u64 {
    let mut n_odd = 0;
    for [re, im, signed] in samples {
        let (vis, weight, flag, odd) = settle(re, im, signed);
        chunk.vis_jy_rfp.push(vis);
        chunk.weight_rfp.push(weight);
        chunk.flag_rfp.push(flag);
        n_odd += u64::from(odd);
    }
    n_odd
}

/// Whether the axes run COMPLEX (3), STOKES, FREQ, IF as nearly all writers have them.
fn is_plain(axes: &Axes) -> bool {
    let in_place = |len: usize, stride: usize, wanted: usize| len == 1 || stride == wanted;
    let per_chan = 3 * axes.stokes.len;
    axes.complex.len == 3
        && axes.complex.stride == 1
        && in_place(axes.stokes.len, axes.stokes.stride, 3)
        && in_place(axes.freq.len, axes.freq.stride, per_chan)
        && in_place(axes.n_if.len, axes.n_if.stride, per_chan * axes.freq.len)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uvfits::axes::Axis;

    #[test]
    fn numbers_of_every_type_are_big_endian() {
        assert_eq!(Element::U8.get(&[7, 200], 1), 200.0);
        assert_eq!(Element::I16.get(&[0, 0, 0xff, 0xfe], 1), -2.0);
        assert_eq!(Element::I32.get(&[0, 0, 1, 0], 0), 256.0);
        assert_eq!(Element::F32.get(&[0x3f, 0x80, 0, 0], 0), 1.0);
        assert_eq!(Element::F64.get(&[0xc0, 0, 0, 0, 0, 0, 0, 0], 0), -2.0);
    }

    #[test]
    fn bad_samples_are_flagged_and_only_odd_ones_counted() {
        let good = settle(1.0, -2.0, 3.0);
        assert_eq!(good, (Complex::new(1.0, -2.0), 3.0, false, false));
        let flagged = (Complex::new(1.0, 2.0), 0.0, true, false);
        assert_eq!(settle(1.0, 2.0, -3.0), flagged);
        assert_eq!(settle(1.0, 2.0, -0.0), flagged);
        assert_eq!(settle(1.0, 2.0, f32::NEG_INFINITY), flagged);
        assert_eq!(
            settle(1.0, 2.0, f32::NAN),
            (Complex::new(1.0, 2.0), 0.0, true, true)
        );
        assert_eq!(
            settle(1.0, 2.0, f32::INFINITY),
            (Complex::new(1.0, 2.0), 0.0, true, true)
        );
        assert_eq!(
            settle(f32::NAN, 2.0, 1.0),
            (Complex::default(), 0.0, true, true)
        );
        assert_eq!(
            settle(f32::NAN, 2.0, -1.0),
            (Complex::default(), 0.0, true, false)
        );
    }

    /// Axes given as (complex, stokes, freq, IF) lengths, laid out in the order of `order`.
    fn axes(lens: [usize; 4], order: [usize; 4]) -> Axes {
        let mut made = [Axis {
            number: 0,
            len: 1,
            stride: 0,
        }; 4];
        let mut stride = 1;
        for which in order {
            made[which] = Axis {
                number: which + 2,
                len: lens[which],
                stride,
            };
            stride *= lens[which];
        }
        let [complex, stokes, freq, n_if] = made;
        Axes {
            complex,
            stokes,
            freq,
            n_if,
            ra: made[0],
            dec: made[0],
            n_value: stride,
        }
    }

    #[test]
    fn axes_in_any_order_give_the_same_rows() {
        let lens = [3, 2, 2, 2];
        let sample = |complex: usize, p: usize, f: usize, i: usize| {
            (1 + complex + 3 * (p + 2 * (f + 2 * i))) as f32
        };
        let mut wanted: Option<VisChunk> = None;
        for order in [[0, 1, 2, 3], [0, 2, 1, 3], [3, 2, 1, 0], [1, 0, 3, 2]] {
            let axes = axes(lens, order);
            let mut group = vec![0u8; 4 * axes.n_value];
            for (c, p, f, i) in (0..24).map(|n| (n % 3, n / 3 % 2, n / 6 % 2, n / 12)) {
                let at = c * axes.complex.stride
                    + p * axes.stokes.stride
                    + f * axes.freq.stride
                    + i * axes.n_if.stride;
                group[4 * at..4 * at + 4].copy_from_slice(&sample(c, p, f, i).to_be_bytes());
            }
            let layout = Layout {
                element: Element::F32,
                n_param: 0,
                group_bytes: group.len(),
                plain: is_plain(&axes),
                axes,
                scale: 1.0,
                zero: 0.0,
                blank: None,
            };
            assert_eq!(layout.plain, order == [0, 1, 2, 3]);
            let mut chunk = VisChunk::new(1);
            chunk.clear(4, 2);
            assert_eq!(layout.append_data(&group, &mut chunk), 0);
            assert_eq!(chunk.vis_jy_rfp[0], Complex::new(1.0, 2.0));
            assert_eq!(wanted.get_or_insert_with(|| chunk.clone()), &chunk);
        }
    }
}
