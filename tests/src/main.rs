//! The `coaxle` tool, as the tests start it.

use std::process::ExitCode;

fn main() -> ExitCode {
    coaxle_host::cli::tune_transport();
    coaxle::cli::main()
}
