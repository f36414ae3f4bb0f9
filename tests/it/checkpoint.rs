//! Runs that are killed and go on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

use tempfile::TempDir;

use crate::support::{errors, program, simulate, vis2cat_ok};

/// A galaxy that is found in less than a second.
const SKY: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1005,30.0005,300,2,0.2,0.1
";
/// Two that are sampled together in the end.
const PAIR: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1018,30.0005,300,2,0.2,0.1
53.0982,30.0002,250,1.5,-0.1,0.2
";
const SEARCH: &str = "--fov 24arcsec --tile-size 12arcsec --n-live 50 --flux 50uJy:1mJy";
const OUTPUTS: [&str; 2] = ["out.fits", "out.posterior.fits"];
const CHECKPOINT: &str = "out.checkpoint";

/// A field, what an uninterrupted run makes of it, and its whole checkpoint.
struct Field {
    folder: TempDir,
    data: PathBuf,
    wanted: Vec<Vec<u8>>,
    checkpoint: Vec<u8>,
}

fn field() -> &'static Field {
    static FIELD: OnceLock<Field> = OnceLock::new();
    FIELD.get_or_init(|| Field::new(SKY))
}

impl Field {
    fn new(sky: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let data = simulate(folder.path(), sky);
        let plain = folder.path().join("plain");
        fs::create_dir(&plain).unwrap();
        vis2cat_ok(search(&data, &plain, "").get_args());
        let wanted = outputs(&plain);
        // A second name keeps what the run removes in the end.
        let kept = folder.path().join("kept");
        fs::create_dir(&kept).unwrap();
        let mut run = start(&search(&data, &kept, "--checkpoint"));
        while !kept.join(CHECKPOINT).exists() {
            assert!(run.try_wait().unwrap().is_none(), "it ended at once");
        }
        let other_name = kept.join("kept");
        fs::hard_link(kept.join(CHECKPOINT), &other_name).unwrap();
        assert!(run.wait().unwrap().success());
        assert_eq!(outputs(&kept), wanted, "a checkpoint changes nothing");
        assert!(!kept.join(CHECKPOINT).exists());
        let checkpoint = fs::read(other_name).unwrap();
        Field {
            folder,
            data,
            wanted,
            checkpoint,
        }
    }

    /// An empty folder for a run.
    fn room(&self) -> TempDir {
        tempfile::tempdir_in(self.folder.path()).unwrap()
    }

    /// The run goes on with `checkpoint`, and must end like the uninterrupted one.
    fn goes_on(&self, checkpoint: &[u8], more: &str) -> String {
        let room = self.room();
        fs::write(room.path().join(CHECKPOINT), checkpoint).unwrap();
        let done = search(&self.data, room.path(), more).output().unwrap();
        assert!(done.status.success(), "{}", errors(&done));
        assert!(outputs(room.path()) == self.wanted, "other bytes: {more}");
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), OUTPUTS.len());
        errors(&done)
    }

    /// The run does not go on with `checkpoint`, which is left as it is.
    fn refuses(&self, checkpoint: &[u8], more: &str, wanted: &str) {
        let room = self.room();
        let path = room.path().join(CHECKPOINT);
        fs::write(&path, checkpoint).unwrap();
        let done = search(&self.data, room.path(), more).output().unwrap();
        let text = errors(&done);
        assert_eq!(done.status.code(), Some(3), "{text}");
        assert!(text.contains(wanted) && text.contains(CHECKPOINT), "{text}");
        assert!(fs::read(&path).unwrap() == checkpoint);
        assert_eq!(fs::read_dir(room.path()).unwrap().count(), 1);
    }

    /// Bytes of the head.
    fn head(&self) -> usize {
        let n: [u8; 4] = self.checkpoint[12..16].try_into().unwrap();
        16 + u32::from_le_bytes(n) as usize + 8
    }
}

fn search(data: &Path, folder: &Path, more: &str) -> Command {
    let mut run = program();
    run.arg(data).arg(folder.join("out.fits"));
    run.args(SEARCH.split_whitespace().chain(more.split_whitespace()));
    run
}

fn start(run: &Command) -> Child {
    let mut again = program();
    again.args(run.get_args()).stdout(Stdio::null());
    again.spawn().unwrap()
}

fn outputs(folder: &Path) -> Vec<Vec<u8>> {
    let read = |name| fs::read(folder.join(name)).unwrap();
    OUTPUTS.map(read).to_vec()
}

fn size(path: &Path) -> u64 {
    path.metadata().map_or(0, |m| m.len())
}

/// Kills `run` as soon as its checkpoint holds `n` bytes; false if it has ended before.
fn kill_at(run: &Command, path: &Path, n: u64) -> bool {
    let mut run = start(run);
    loop {
        if size(path) >= n {
            // SIGKILL: nothing can be done about it.
            run.kill().unwrap();
            return !run.wait().unwrap().success();
        }
        if let Some(status) = run.try_wait().unwrap() {
            assert!(status.success());
            return false;
        }
    }
}

/// One run that is killed at 20 random places, by turns with one thread and with two.
#[test]
fn a_run_that_is_killed_twenty_times_ends_with_the_same_bytes() {
    let field = field();
    let room = field.room();
    let path = room.path().join(CHECKPOINT);
    let whole = field.checkpoint.len() as f64;
    let mut n_killed = 0;
    for i in 0..20 {
        // The golden ratio, modulo one: anywhere in the i-th twentieth.
        let place = (f64::from(i) + (f64::from(i) * 0.618_034).fract()) / 20.0;
        let threads = format!("--resume --threads {}", 1 + i % 2);
        let run = search(&field.data, room.path(), &threads);
        n_killed += u32::from(kill_at(&run, &path, 1 + (0.99 * place * whole) as u64));
        if outputs_exist(room.path()) {
            break;
        }
    }
    assert!(n_killed >= 18, "it was killed only {n_killed} times");
    let more = if outputs_exist(room.path()) {
        "--resume --overwrite"
    } else {
        "--resume"
    };
    vis2cat_ok(search(&field.data, room.path(), more).get_args());
    assert!(outputs(room.path()) == field.wanted);
}

fn outputs_exist(folder: &Path) -> bool {
    OUTPUTS.iter().any(|name| folder.join(name).exists())
}

#[test]
fn a_checkpoint_that_is_cut_anywhere_is_gone_on_with() {
    let field = field();
    let (head, len) = (field.head(), field.checkpoint.len());
    for (i, cut) in [head, head + 5, len / 3, len / 2 + 3, len - 1, len]
        .iter()
        .enumerate()
    {
        let more = format!("--resume --threads {}", 1 + i % 2);
        field.goes_on(&field.checkpoint[..*cut], &more);
    }
}

/// The last questions are about groups: joint draws, and a last look at all of them.
#[test]
fn sources_that_are_sampled_together_are_gone_on_with() {
    let field = Field::new(PAIR);
    let groups = vis2cat_formats::fits::read_table(
        &field.folder.path().join("plain").join(OUTPUTS[0]),
        Some("CATALOGUE"),
    );
    assert_eq!(groups.unwrap().numbers("Group_id").unwrap(), [1.0, 1.0]);
    let len = field.checkpoint.len();
    field.goes_on(&field.checkpoint[..len - 200_000], "--resume");
}

#[test]
fn what_is_damaged_is_worked_out_again() {
    let field = field();
    let mut bytes = field.checkpoint.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let text = field.goes_on(&bytes, "--resume");
    assert!(text.contains("is damaged at byte"), "{text}");
}

#[test]
fn a_checkpoint_of_another_run_is_refused_with_what_differs() {
    let field = field();
    let bytes = &field.checkpoint;
    field.refuses(
        bytes,
        "--resume --seed 2",
        "'seed = 1' there, 'seed = 2' here",
    );
    field.refuses(
        b"SIMPLE  = T, and so on, for a while",
        "--resume",
        "no checkpoint",
    );
    field.refuses(b"", "--resume", "no checkpoint");
    field.refuses(&bytes[..field.head() - 3], "--resume", "damaged");
    for (place, wanted) in [(9, "another format"), (13, "damaged"), (40, "damaged")] {
        let mut bytes = bytes.clone();
        bytes[place] ^= 1;
        field.refuses(&bytes, "--resume", wanted);
    }
    let other = field.room();
    let data = simulate(other.path(), &SKY.replace("300", "310"));
    let path = other.path().join(CHECKPOINT);
    fs::write(&path, bytes).unwrap();
    let done = search(&data, other.path(), "--resume").output().unwrap();
    assert!(
        errors(&done).contains("the input has changed"),
        "{}",
        errors(&done)
    );
}

#[test]
fn a_checkpoint_is_not_replaced_unless_told_and_not_shared() {
    let field = field();
    let room = field.room();
    let path = room.path().join(CHECKPOINT);
    fs::write(&path, &field.checkpoint).unwrap();
    let done = search(&field.data, room.path(), "--checkpoint")
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(4));
    assert!(errors(&done).contains("--resume"), "{}", errors(&done));
    let file = fs::File::open(&path).unwrap();
    file.lock().unwrap();
    let done = search(&field.data, room.path(), "--resume")
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(3));
    assert!(errors(&done).contains("in use"), "{}", errors(&done));
    drop(file);
    let more = "--checkpoint --overwrite";
    vis2cat_ok(search(&field.data, room.path(), more).get_args());
    assert!(outputs(room.path()) == field.wanted && !path.exists());
}

/// A limit on the size of files stands for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_is_4_and_what_was_written_is_good() {
    let field = field();
    let room = field.room();
    let run = search(&field.data, room.path(), "--checkpoint");
    let blocks = field.checkpoint.len() / 512 / 2;
    let limited = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let done = Command::new("sh")
        .args(["-c", &limited])
        .arg(run.get_program())
        .args(run.get_args())
        .output()
        .unwrap();
    let text = errors(&done);
    assert_eq!(done.status.code(), Some(4), "{text}");
    assert!(
        text.contains("make room") && text.contains(CHECKPOINT),
        "{text}"
    );
    assert!(!outputs_exist(room.path()));
    let left = fs::read(room.path().join(CHECKPOINT)).unwrap();
    assert!(left.len() > field.checkpoint.len() / 3);
    field.goes_on(&left, "--resume");
}
