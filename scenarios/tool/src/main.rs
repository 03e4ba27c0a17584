//! The `coaxle` tool: runs scenarios, and nodes.

use std::process::ExitCode;

fn main() -> ExitCode {
    coaxle_host::cli::run_program(coaxle::cli::main)
}
