//! The program as a user runs it, and a small field with known sources that several tests share.

use std::ffi::OsStr;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use vis2cat::catalogue::CataloguePaths;
use vis2cat_formats::fits::{Table, read_table};

/// Three galaxies without any symmetry about the phase centre at RA 53.1, Dec +30 deg.
const SKY: &str = "\
RA[deg],DEC[deg],Total_flux[uJy],Scale_length[arcsec],E1,E2
53.1105,30.0095,300,2.0,0.2,0.1
53.0930,29.9960,200,1.5,-0.1,0.2
53.1070,29.9890,150,1.2,0.0,-0.2
";

/// What they are looked for with.
pub(crate) const SEARCH: [&str; 4] = ["--fov", "2arcmin", "--flux", "50uJy:1mJy"];

/// The program, with its arguments to come.
pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_vis2cat"))
}

/// Runs the program to its end.
pub(crate) fn vis2cat<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Output {
    program().args(args).output().unwrap()
}

/// Runs the program, which must succeed; returns what it printed.
pub(crate) fn vis2cat_ok<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> String {
    let done = vis2cat(args);
    assert!(done.status.success(), "{}", errors(&done));
    String::from_utf8(done.stdout).unwrap()
}

/// Standard error as text.
pub(crate) fn errors(done: &Output) -> String {
    String::from_utf8_lossy(&done.stderr).into_owned()
}

/// A file of the repository.
pub(crate) fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Simulates 27 dishes over six hours with the sources of `sky`, about RA 53.1, Dec +30 deg.
pub(crate) fn simulate(folder: &Path, sky: &str) -> PathBuf {
    let list = folder.join("sky.csv");
    std::fs::write(&list, sky).unwrap();
    let (data, truth) = (folder.join("field.uvfits"), folder.join("truth.fits"));
    let command = format!(
        "simulate {} --array vla-b --dec 30deg --hours 6 --tint 10min --overwrite \
         --catalogue {} --truth {}",
        data.display(),
        list.display(),
        truth.display()
    );
    vis2cat_ok(command.split_whitespace());
    data
}

/// A simulated field and what was found in it.
pub(crate) struct Run {
    pub(crate) data: PathBuf,
    pub(crate) truth: PathBuf,
    pub(crate) paths: CataloguePaths,
}

impl Run {
    /// A table of the catalogue.
    pub(crate) fn table(&self, name: &str) -> Table {
        read_table(&self.paths.catalogue, Some(name)).unwrap()
    }
}

/// The field, simulated and searched once for all tests, by two threads.
pub(crate) fn searched() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("searched");
        std::fs::create_dir_all(&folder).unwrap();
        let data = simulate(&folder, SKY);
        let more = ["--threads", "2", "--overwrite"];
        let paths = search(&data, &folder.join("out.fits"), &more);
        let truth = folder.join("truth.fits");
        Run { data, truth, paths }
    })
}

/// Searches a file of [`SEARCH`]'s kind.
pub(crate) fn search(data: &Path, out: &Path, more: &[&str]) -> CataloguePaths {
    let files = [data.as_os_str(), out.as_os_str()];
    let flags = SEARCH.iter().chain(more).map(OsStr::new);
    vis2cat_ok(files.into_iter().chain(flags));
    CataloguePaths::new(out)
}

/// A Python that has `module`, or none, which is said.
pub(crate) fn python_with(module: &str) -> Option<String> {
    let python = std::env::var("VIS2CAT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let import = format!("import {module}");
    let found = Command::new(&python).args(["-c", &import]).output();
    if found.is_ok_and(|done| done.status.success()) {
        return Some(python);
    }
    skipped(&format!("{python} has no {module}"));
    None
}

/// Whether a command can be found.
pub(crate) fn has_command(name: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).any(|folder| folder.join(name).is_file());
    if !found {
        skipped(&format!("there is no {name}"));
    }
    found
}

/// Says that a check is left out; where all tools should be there (`scripts/test.sh`), fails.
pub(crate) fn skipped(why: &str) {
    assert!(
        !oracles_are_required(),
        "{why}, and VIS2CAT_ORACLES=required"
    );
    // Straight to the terminal: the test harness hides what passing tests print.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {why}");
}

/// Whether a missing tool is a failure.
pub(crate) fn oracles_are_required() -> bool {
    std::env::var("VIS2CAT_ORACLES").is_ok_and(|value| value == "required")
}
