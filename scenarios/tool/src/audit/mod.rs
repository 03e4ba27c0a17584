//! `coaxle audit`: who was refused what by a node, and who did what there; of a recording, or of a running node.

mod live;
mod recorded;
mod shown;

use std::path::PathBuf;

use clap::Args;
use coaxle_host::cli::NetworkArgs;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::Exit;

/// Source and format of the records.
#[derive(Debug, Args)]
pub(crate) struct AuditArgs {
    /// A recording
    #[arg(
        value_name = "FILE",
        required_unless_present = "node",
        conflicts_with = "node"
    )]
    file: Option<PathBuf>,
    /// A running node; in a secure network with --secure and the folder of an operator
    #[arg(long, value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    node: Option<NodeName>,
    /// Go on with further records as they are made, until Ctrl-C
    #[arg(short, long, conflicts_with = "file")]
    follow: bool,
    /// Of a running node, the number of records to begin with: the newest ones; it keeps 1024
    #[arg(long, value_name = "N", default_value_t = 100)]
    newest: u64,
    /// Only what was refused or ended
    #[arg(long)]
    refused: bool,
    /// Records as the node publishes them: JSON, one on a line
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Prints the records.
///
/// # Errors
/// Names the file that cannot be read, or the node that does not answer.
pub(crate) fn audit(args: &AuditArgs) -> anyhow::Result<Exit> {
    match (&args.file, &args.node) {
        (Some(file), _) => recorded::print(args, file),
        (None, Some(node)) => live::print(args, node),
        // Refused by the command line.
        (None, None) => Ok(Exit::Failed),
    }
}
