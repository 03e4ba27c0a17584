//! The audit in a recording.

use std::io::Write;
use std::path::Path;

use coaxle_node::audit::AuditRecord;
use coaxle_os::exit::Exit;
use coaxle_recording::{DamageList, Item, Reader};
use coaxle_report::inspect;

use super::AuditArgs;
use super::shown::RecordLines;
use crate::recorded;

/// Prints the records of a recording, and where it is damaged.
///
/// # Errors
/// Names the file that cannot be read.
pub(super) fn print(args: &AuditArgs, file: &Path) -> anyhow::Result<Exit> {
    let reader = Reader::new(recorded::open(file)?);
    let mut lines = RecordLines::default();
    let (mut damage, mut unread) = (DamageList::default(), 0_u64);
    inspect::print(|out| {
        for item in reader {
            match item {
                Ok(Item::Audit { json, .. }) => match AuditRecord::from_json(json.as_bytes()) {
                    Ok(record) => lines.write(args, &record, out)?,
                    Err(_) => unread += 1,
                },
                Ok(_) => {}
                Err(found) => damage.note(found),
            }
        }
        // For people only: programs expect records on all lines.
        if !args.json {
            write_rest(&lines, unread, out)?;
            recorded::damage(&damage).try_for_each(|line| writeln!(out, "{line}"))?;
        }
        Ok(true)
    })?;
    Ok(Exit::Done)
}

fn write_rest(lines: &RecordLines, unread: u64, out: &mut dyn Write) -> std::io::Result<()> {
    if lines.written == 0 {
        writeln!(out, "no such record is in it")?;
    }
    if unread > 0 {
        writeln!(out, "{unread} records are of another version, or damaged")?;
    }
    Ok(())
}
