//! The receiver node as a program.

use std::process::ExitCode;

use clap::Parser;
use coaxle_host::cli::{LogArgs, exit_code, run_program};
use coaxle_os::exit::EXIT_CODES;
use coaxle_receiver::run::{Args, run};

/// Receiver node: makes a far axis local and smooth, and drives a slave with it
#[derive(Parser)]
#[command(version, after_help = EXIT_CODES)]
struct Cli {
    #[command(flatten)]
    args: Args,
    #[command(flatten)]
    log: LogArgs,
}

fn main() -> ExitCode {
    run_program(|| {
        let cli = Cli::parse();
        let logging = cli.log.init();
        exit_code(run(&cli.args), logging)
    })
}
