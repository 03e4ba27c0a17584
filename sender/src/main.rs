//! The sender node as a program.

use std::process::ExitCode;

use clap::Parser;
use coaxle_host::cli::{LogArgs, exit_code, run_program};
use coaxle_os::exit::EXIT_CODES;
use coaxle_sender::run::{Args, run};

/// Sender node: publishes axes once per cycle of its own clock
#[derive(Parser)]
#[command(version, after_help = EXIT_CODES)]
struct Cli {
    #[command(flatten)]
    args: Args,
    #[command(flatten)]
    log: LogArgs,
}

fn main() -> ExitCode {
    // Before anything else: the runtimes of the transport read their settings once.
    run_program(|| {
        let cli = Cli::parse();
        let logging = cli.log.init();
        exit_code(run(&cli.args), logging)
    })
}
