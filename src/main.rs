//! Parses the command line, runs, and turns the outcome into an exit code.

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::Parser;
use vis2cat::cli::Cli;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let common = cli.common();
    let level = match (common.quiet, common.verbose) {
        (true, _) => "error",
        (_, 0) => "warn",
        (_, 1) => "info",
        _ => "debug",
    };
    tracing_subscriber::fmt()
        .with_max_level(level.parse().unwrap_or(tracing::Level::WARN))
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .init();
    if let Some(n) = common.threads {
        // Fails only if the pool exists already, which it cannot yet.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build_global();
    }
    let done = match cli.execute_guarded() {
        Ok(Some(code)) => Ok(code),
        Ok(None) => cli.execute().map(|()| ExitCode::SUCCESS),
        Err(error) => Err(error),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            complain(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

/// Prints an error and what caused it.
#[allow(clippy::print_stderr)]
fn complain(error: &dyn std::error::Error) {
    eprintln!("error: {error}");
    let mut cause = error.source();
    while let Some(error) = cause {
        eprintln!("  caused by: {error}");
        cause = error.source();
    }
}
