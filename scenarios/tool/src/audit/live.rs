//! The audit of a running node.

use std::time::Duration;

use coaxle_host::client::AuditReader;
use coaxle_node::audit::{AuditExcerpt, AuditQuery};
use coaxle_node::keys::NodeName;
use coaxle_os::exit::Exit;
use coaxle_report::inspect;

use super::AuditArgs;
use super::shown::RecordLines;

/// Interval of `--follow`. A query for what is new cannot miss a record, as a publication could.
const AGAIN: Duration = Duration::from_millis(500);

/// Prints the newest records of a node, and with `--follow` those that it makes from then on.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, or a node that does not answer.
pub(super) fn print(args: &AuditArgs, node: &NodeName) -> anyhow::Result<Exit> {
    let reader = AuditReader::open(&args.network.transport()?)?;
    let shown = show(args, node, &reader);
    reader.close();
    shown.map(|()| Exit::Done)
}

fn show(args: &AuditArgs, node: &NodeName, reader: &AuditReader) -> anyhow::Result<()> {
    let mut lines = RecordLines::default();
    let mut known = reader.ask(node, &AuditQuery::newest(args.newest))?;
    while write(args, &mut lines, &known)? && args.follow {
        std::thread::park_timeout(AGAIN);
        known = match next(reader, node, &known) {
            Ok(next) => next,
            // A node that restarts is not there for a moment: nothing new is shown meanwhile.
            Err(error) => {
                tracing::warn!("{error:#}");
                AuditExcerpt {
                    records: Vec::new(),
                    ..known
                }
            }
        };
    }
    Ok(())
}

/// Asks for the records after the known ones.
fn next(
    reader: &AuditReader,
    node: &NodeName,
    known: &AuditExcerpt,
) -> anyhow::Result<AuditExcerpt> {
    // A reply has a greatest length: it may end before the newest record.
    let last = known
        .records
        .last()
        .map_or(known.newest, |last| last.number);
    let next = reader.ask(node, &AuditQuery::after(last))?;
    match next.run == known.run {
        true => Ok(next),
        // The node was restarted: its numbers begin again.
        false => reader.ask(node, &AuditQuery::after(0)),
    }
}

/// Writes records; false if the output is closed.
fn write(
    args: &AuditArgs,
    lines: &mut RecordLines,
    excerpt: &AuditExcerpt,
) -> anyhow::Result<bool> {
    let mut is_read = false;
    inspect::print(|out| {
        for record in &excerpt.records {
            lines.write(args, record, out)?;
        }
        out.flush()?;
        // Not reached if the pipe is closed: then following ends.
        is_read = true;
        Ok(true)
    })?;
    Ok(is_read)
}
