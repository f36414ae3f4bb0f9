//! Where the time of a run went, in a file of its own: the outputs of a run do not depend on the clock.

use std::path::Path;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use vis2cat_formats::{PendingFile, ReadError, WriteError};

use crate::detect::Observer;

/// Wall time of one kind of stage, all times that it came.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Stage.
    pub stage: String,
    /// How often it came.
    pub times: u64,
    /// Wall time [s].
    pub wall_s: f64,
}

/// Passes on what it sees, and notes how long each stage takes.
pub struct Stopwatch<'a> {
    inner: &'a mut dyn Observer,
    /// The one that goes on stands last.
    stages: Vec<StageTime>,
    since: Instant,
}

impl<'a> Stopwatch<'a> {
    /// Starts now.
    pub fn new(inner: &'a mut dyn Observer) -> Self {
        Self {
            inner,
            stages: Vec::new(),
            since: Instant::now(),
        }
    }

    /// The stages until now, in the order in which they came last.
    pub fn stages(mut self) -> Vec<StageTime> {
        self.stop();
        self.stages
    }

    /// Time since the last stage began belongs to that.
    fn stop(&mut self) {
        if let Some(stage) = self.stages.last_mut() {
            stage.wall_s += self.since.elapsed().as_secs_f64();
        }
        self.since = Instant::now();
    }
}

impl Observer for Stopwatch<'_> {
    fn stage(&mut self, name: &str, n_step: u64) {
        self.stop();
        let known = self.stages.iter().position(|known| known.stage == name);
        let mut stage = match known {
            Some(i) => self.stages.remove(i),
            None => StageTime {
                stage: name.to_owned(),
                times: 0,
                wall_s: 0.0,
            },
        };
        stage.times += 1;
        self.stages.push(stage);
        self.inner.stage(name, n_step);
    }

    fn advance(&mut self, n_done: u64, n_eval: u64) {
        self.inner.advance(n_done, n_eval);
    }
}

/// Writes `stages` as CSV.
///
/// # Errors
/// The file exists and `overwrite` is false, or it cannot be written.
pub fn write(path: &Path, overwrite: bool, stages: &[StageTime]) -> Result<(), WriteError> {
    let unwritten = |what: String| WriteError::Parameter {
        path: path.to_owned(),
        what,
    };
    let mut text = csv::Writer::from_writer(Vec::new());
    for stage in stages {
        let written = text.serialize(stage);
        written.map_err(|error| unwritten(error.to_string()))?;
    }
    let text = text.into_inner();
    let text = text.map_err(|error| unwritten(error.to_string()))?;
    let mut file = PendingFile::create(path, overwrite)?;
    file.append(&text)?;
    file.commit()
}

/// Reads what [`write`] wrote.
///
/// # Errors
/// The file cannot be read or is something else; the error names the line.
pub fn read(path: &Path) -> Result<Vec<StageTime>, ReadError> {
    let text = std::fs::read(path).map_err(|source| ReadError::Io {
        path: path.to_owned(),
        source,
    })?;
    let rows = csv::Reader::from_reader(&text[..]).into_deserialize();
    rows.collect::<Result<_, csv::Error>>()
        .map_err(|error| ReadError::Malformed {
            path: path.to_owned(),
            place: "the table of times".into(),
            what: format!("{error}; give a file that --timings wrote"),
        })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::detect::NoObserver;

    #[test]
    fn stages_add_up_and_come_back_from_the_file() {
        let mut nobody = NoObserver;
        let mut watch = Stopwatch::new(&mut nobody);
        for stage in ["reading", "searching", "sampling", "searching"] {
            watch.stage(stage, 1);
            std::thread::sleep(Duration::from_millis(2));
            watch.advance(1, 1);
        }
        let stages = watch.stages();
        let named = |name| stages.iter().find(|s| s.stage == name).unwrap();
        assert_eq!(
            (
                stages.len(),
                named("searching").times,
                named("sampling").times
            ),
            (3, 2, 1)
        );
        assert!(named("searching").wall_s >= 4e-3 && named("reading").wall_s >= 2e-3);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("times.csv");
        write(&path, false, &stages).unwrap();
        assert_eq!(read(&path).unwrap(), stages);
        assert!(write(&path, false, &stages).is_err());
        std::fs::write(&path, "stage,times,wall_s\nreading,once,1\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("times.csv"));
    }
}
