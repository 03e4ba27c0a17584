//! The `coaxle` tool, as the tests start it.

use std::process::ExitCode;

fn main() -> ExitCode {
    coaxle_host::cli::run_program(coaxle::cli::main)
}
