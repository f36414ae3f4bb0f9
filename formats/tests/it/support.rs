//! Observations, chunks and whole reads for the tests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use num_complex::Complex;
use vis2cat_formats::{
    Antenna, Corr, EarthOrientation, Field, Frame, FreqSetup, Observation, ReadError, TimeScale,
    VisChunk, VisReader, VisWriter, create, open,
};

/// The repository's `fixtures/NAME`.
pub(crate) fn fixtures(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fixtures")
        .join(name)
}

/// A file or directory of visibilities.
#[derive(Debug)]
pub(crate) struct Fixture {
    /// What is to be opened.
    pub(crate) path: PathBuf,
    /// The same name in the folder of fixtures, where what is known of it stands.
    pub(crate) beside: PathBuf,
    /// Where an archive was unpacked.
    _unpacked: Option<tempfile::TempDir>,
}

/// The visibilities of a folder, whatever their format, sorted. Directories are kept in archives.
pub(crate) fn visibility_files(folder: &Path) -> Vec<Fixture> {
    let mut paths = files(folder, "uvfits");
    paths.extend(files(folder, "uvh5"));
    let plain = paths.into_iter().map(|path| Fixture {
        beside: path.clone(),
        path,
        _unpacked: None,
    });
    let archives = files(folder, "gz").into_iter().map(|path| unpack(&path));
    plain.chain(archives).collect()
}

/// `NAME.ms` of an archive `NAME.ms.tar.gz`.
pub(crate) fn unpack(archive: &Path) -> Fixture {
    let folder = tempfile::tempdir().unwrap();
    let packed = flate2::read::GzDecoder::new(std::fs::File::open(archive).unwrap());
    tar::Archive::new(packed).unpack(folder.path()).unwrap();
    let beside = archive.with_extension("").with_extension("");
    Fixture {
        path: folder.path().join(beside.file_name().unwrap()),
        beside,
        _unpacked: Some(folder),
    }
}

/// Names of everything in a folder, hidden files too.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

/// Files of a folder with an extension, sorted.
pub(crate) fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == extension));
    paths.sort();
    paths
}

/// The bytes of all files, by their names.
pub(crate) fn files_below(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for name in names(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            let inner = files_below(&path).into_iter();
            files.extend(inner.map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            files.insert(name, std::fs::read(&path).unwrap());
        }
    }
    files
}

/// The shape of an observation.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    pub(crate) n_antenna: usize,
    pub(crate) n_if: usize,
    pub(crate) n_chan_per_if: usize,
    pub(crate) corrs: Vec<Corr>,
    pub(crate) n_field: usize,
    pub(crate) n_setup: usize,
    pub(crate) n_row: usize,
    pub(crate) seed: u64,
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            n_antenna: 5,
            n_if: 1,
            n_chan_per_if: 3,
            corrs: vec![Corr::Xx, Corr::Yy],
            n_field: 1,
            n_setup: 1,
            n_row: 10,
            seed: 1,
        }
    }
}

/// An observation with every member set.
pub(crate) fn observation(shape: &Shape) -> Observation {
    let antenna = |i: usize| Antenna {
        number: i as u32 + 1,
        name: format!("m{i:03}"),
        itrf_m: [
            5.1e6 + 0.1 * i as f64,
            2e6 - 77.7 * i as f64,
            -3.2e6 / (i + 1) as f64,
        ],
        diameter_m: Some(13.5),
    };
    let field = |i: usize| Field {
        name: format!("F{i}"),
        ra_rad: 0.1 + i as f64,
        dec_rad: -0.5 - 0.01 * i as f64,
        frame: Frame::Fk5(2000.0),
        drifts: false,
    };
    let setup = |s: usize| {
        let mut setup = FreqSetup {
            n_if: shape.n_if,
            ..FreqSetup::default()
        };
        for i in 0..shape.n_if {
            for f in 0..shape.n_chan_per_if {
                let step_hz = if i % 2 == 0 { 2.5e5 } else { -1.25e5 };
                setup
                    .freq_hz_f
                    .push(1.4e9 + 1e8 * s as f64 + 1e7 * i as f64 + f as f64 * step_hz);
                setup.chan_width_hz_f.push(step_hz);
            }
        }
        setup
    };
    Observation {
        telescope: "MEERKAT".into(),
        instrument: "SKARAB".into(),
        observer: "O'Neil".into(),
        date_obs: "2023-02-25".into(),
        array_position_m: [0.0; 3],
        antennas: (0..shape.n_antenna).map(antenna).collect(),
        fields: (0..shape.n_field).map(field).collect(),
        freq_setups: (0..shape.n_setup).map(setup).collect(),
        corrs: shape.corrs.clone(),
        n_row: shape.n_row as u64,
        time_scale: TimeScale::Utc,
        earth: EarthOrientation {
            ut1_utc_s: Some(-0.0123),
            polar_motion_arcsec: Some([0.1, 0.25]),
            gst0_deg: Some(154.25),
        },
        history: vec!["AIPS WTSCAL = 1.0".into(), "made for a test".into()],
        warnings: Vec::new(),
        uvh5: None,
        ms: None,
    }
}

/// Numbers between 0 and 1, the same for the same seed.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        // Constants: Knuth, The Art of Computer Programming 2, section 3.3.4, table 1 (MMIX).
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> u32 {
        (self.next() * n as f64) as u32
    }
}

/// Rows of random numbers for `observation`.
pub(crate) fn chunk(shape: &Shape) -> VisChunk {
    let mut random = Numbers(shape.seed);
    let mut chunk = VisChunk::new(shape.n_row);
    chunk.clear(shape.n_if * shape.n_chan_per_if, shape.corrs.len());
    for row in 0..shape.n_row {
        chunk
            .uvw_m_r
            .push([0; 3].map(|_| (random.next() - 0.5) * 1e4));
        chunk
            .time_mjd_r
            .push(60_000.9 + row as f64 * 7.77 / 86_400.0);
        chunk.interval_s_r.push(7.75);
        chunk.ant1_r.push(random.below(shape.n_antenna));
        chunk.ant2_r.push(random.below(shape.n_antenna));
        chunk.field_r.push(random.below(shape.n_field));
        chunk.freq_setup_r.push(random.below(shape.n_setup));
        for _ in 0..chunk.values_per_row() {
            let (re, im) = (random.next() - 0.5, random.next() - 0.5);
            let flag = random.next() < 0.2;
            chunk.vis_jy_rfp.push(Complex::new(re as f32, im as f32));
            chunk.weight_rfp.push(if flag {
                0.0
            } else {
                0.1 + random.next() as f32
            });
            chunk.flag_rfp.push(flag);
        }
    }
    chunk.n_row = shape.n_row;
    chunk
}

/// A writer of the format that the path's extension names.
pub(crate) fn writer(path: &Path, observation: &Observation) -> Box<dyn VisWriter> {
    create(path, observation, false).unwrap()
}

/// Writes one chunk.
pub(crate) fn write(path: &Path, observation: &Observation, chunk: &VisChunk) {
    let mut writer = writer(path, observation);
    writer.write_chunk(chunk).unwrap();
    writer.finish().unwrap();
}

/// Whether a warning says that coordinates and antenna positions disagree, as random ones do.
pub(crate) fn is_about_direction(warning: &str) -> bool {
    ["UU, VV, WW", "uvw_array", "UVW"]
        .iter()
        .any(|coordinates| warning.starts_with(coordinates))
}

/// Reads a file from front to back, `max_row` rows at a time, into one chunk.
pub(crate) fn read(path: &Path, max_row: usize) -> Result<(Observation, VisChunk), ReadError> {
    let mut reader = open(path)?;
    let all = read_rows(reader.as_mut(), max_row)?;
    Ok((reader.observation().clone(), all))
}

/// The rows that are left in a reader, in one chunk.
pub(crate) fn read_rows(reader: &mut dyn VisReader, max_row: usize) -> Result<VisChunk, ReadError> {
    let mut all = VisChunk::default();
    let mut chunk = VisChunk::new(max_row);
    while reader.read_chunk(&mut chunk)? > 0 {
        (all.n_chan, all.n_corr) = (chunk.n_chan, chunk.n_corr);
        all.n_row += chunk.n_row;
        all.uvw_m_r.extend(&chunk.uvw_m_r);
        all.time_mjd_r.extend(&chunk.time_mjd_r);
        all.interval_s_r.extend(&chunk.interval_s_r);
        all.ant1_r.extend(&chunk.ant1_r);
        all.ant2_r.extend(&chunk.ant2_r);
        all.field_r.extend(&chunk.field_r);
        all.freq_setup_r.extend(&chunk.freq_setup_r);
        all.vis_jy_rfp.extend(&chunk.vis_jy_rfp);
        all.weight_rfp.extend(&chunk.weight_rfp);
        all.flag_rfp.extend(&chunk.flag_rfp);
    }
    all.max_row = all.n_row;
    Ok(all)
}
