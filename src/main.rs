//! The program `hopes`: points in at one end, the skeleton's changes out at the other.
//!
//! In: arguments.
//! Out: an exit code: 0 done (also for a closed pipe and after a first signal), 1 failed, 2 wrong usage, 3 input
//! refused under `--strict`. Stdout carries data, stderr carries logs.
//! Must not know: geometry; what a subcommand does.

mod cli;
mod client;
mod daemon;
mod formats;
mod view;

use std::process::ExitCode;

use cli::Failure;

fn main() -> ExitCode {
    let outcome = match cli::parse() {
        Ok(cli) => {
            log_to_stderr(cli.log_level());
            cli.run()
        }
        Err(answer) if !answer.use_stderr() => {
            log_to_stderr(tracing::Level::INFO);
            cli::show_answer(&answer)
        }
        Err(usage) => usage.exit(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(reason)) => {
            tracing::error!("{reason}");
            ExitCode::from(2)
        }
        Err(Failure::Refused(reason)) => {
            tracing::error!("{reason}");
            ExitCode::from(3)
        }
        Err(Failure::Failed(error)) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(Failure::Failed(error)) => {
            tracing::error!("{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn log_to_stderr(level: tracing::Level) {
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::IsTerminal::is_terminal(&std::io::stderr()))
        .with_target(false)
        // Stderr may be closed: that is no reason to stop, and not to panic.
        .log_internal_errors(false)
        .without_time()
        .init();
}

/// A program that reads our output may stop when it has seen enough.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause.downcast_ref::<std::io::Error>().is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
    })
}
