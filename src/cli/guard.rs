//! A process that looks after another one, which reads what may end it.
//!
//! casacore trusts much of what stands in a Measurement Set: one that is damaged can end the process that
//! reads it. So a process that is to read one starts the same program again, waits, and says what is wrong
//! if that was ended by a signal.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus};

use vis2cat_formats::{ReadError, is_measurement_set};

use crate::run::RunError;

/// Set in the process that reads.
const GUARDED: &str = "VIS2CAT_GUARDED";

/// The exit code of the process that read the `inputs`; none if this process is to go on by itself, as there
/// is nothing to guard against, or as it is the one that is looked after.
///
/// # Errors
/// It was ended by a signal that a damaged input sends.
pub(super) fn run_guarded(inputs: &[&Path]) -> Result<Option<ExitCode>, RunError> {
    let Some(set) = inputs.iter().find(|input| is_measurement_set(input)) else {
        return Ok(None);
    };
    if std::env::var_os(GUARDED).is_some() {
        end_with_parent();
        return Ok(None);
    }
    let child = std::env::current_exe().and_then(|program| {
        let mut command = Command::new(program);
        let arguments = std::env::args_os().skip(1);
        command.args(arguments).env(GUARDED, "1").status()
    });
    // Where no process can be started, this one reads.
    let Ok(status) = child else {
        return Ok(None);
    };
    outcome(status, set).map(Some)
}

#[cfg(unix)]
fn outcome(status: ExitStatus, set: &Path) -> Result<ExitCode, RunError> {
    use std::os::unix::process::ExitStatusExt as _;

    // What reading beyond, dividing by zero and giving up send: SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV.
    const CRASHES: [i32; 5] = [4, 6, 7, 8, 11];
    match status.signal() {
        Some(signal) if CRASHES.contains(&signal) => Err(RunError::Read(ReadError::Malformed {
            path: PathBuf::from(set),
            place: "Measurement Set".into(),
            what: format!(
                "ended the process that read it with signal {signal}: most likely it is damaged where casacore does \
                 not notice; copy it again"
            ),
        })),
        Some(signal) => Ok(ExitCode::from(128u8.saturating_add(signal as u8))),
        None => Ok(code(status)),
    }
}

#[cfg(not(unix))]
fn outcome(status: ExitStatus, _set: &Path) -> Result<ExitCode, RunError> {
    Ok(code(status))
}

fn code(status: ExitStatus) -> ExitCode {
    ExitCode::from(u8::try_from(status.code().unwrap_or(1)).unwrap_or(1))
}

/// Whoever kills the process that looks on means this one.
fn end_with_parent() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL));
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::process::ExitStatusExt as _;

    use super::*;

    fn of_wait_status(raw: i32) -> Result<String, RunError> {
        let code = outcome(ExitStatus::from_raw(raw), Path::new("a.ms"))?;
        Ok(format!("{code:?}"))
    }

    #[test]
    fn a_crash_is_the_fault_of_the_input_and_everything_else_is_passed_on() {
        for crash in [6, 11] {
            let error = of_wait_status(crash).unwrap_err();
            assert_eq!(error.exit_code(), 3);
            assert!(error.to_string().contains("a.ms"), "{error}");
            assert!(
                error.to_string().contains(&format!("signal {crash}")),
                "{error}"
            );
        }
        let plain = |code: u8| format!("{:?}", ExitCode::from(code));
        assert_eq!(of_wait_status(4 << 8).unwrap(), plain(4));
        assert_eq!(of_wait_status(0).unwrap(), plain(0));
        // Killed, as by a scheduler: the code that a shell gives it.
        assert_eq!(of_wait_status(9).unwrap(), plain(137));
    }
}
