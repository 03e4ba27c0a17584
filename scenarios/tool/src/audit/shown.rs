//! Records as lines.

use std::io::{self, Write};

use coaxle_node::audit::AuditRecord;
use time::OffsetDateTime;

use super::AuditArgs;

/// Writes records, and notes the gaps between them.
#[derive(Default)]
pub(super) struct RecordLines {
    /// Node, run and number of the last one.
    last: Option<(String, String, u64)>,
    /// Number of records written.
    pub(super) written: u64,
}

impl RecordLines {
    /// Writes a record, if it is asked for.
    pub(super) fn write(
        &mut self,
        args: &AuditArgs,
        record: &AuditRecord,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        if let Some(gap) = self.gap(record).filter(|_| !args.json) {
            writeln!(out, "{gap}")?;
        }
        if args.refused && !is_refusal(record) {
            return Ok(());
        }
        self.written += 1;
        match args.json {
            true => writeln!(out, "{}", record.to_json()),
            false => writeln!(out, "{} {} {record}", time_of(record.at_us), record.node),
        }
    }

    /// A line about records that are missing before this one.
    fn gap(&mut self, record: &AuditRecord) -> Option<String> {
        let AuditRecord {
            node, run, number, ..
        } = record;
        let now = (node.to_string(), run.clone(), *number);
        let before = self.last.replace(now)?;
        let is_same_run = before.0 == node.as_str() && before.1 == *run;
        let missing = number.saturating_sub(before.2).saturating_sub(1);
        (is_same_run && missing > 0)
            .then(|| format!("… {missing} records of {node} are missing here"))
    }
}

fn is_refusal(record: &AuditRecord) -> bool {
    use coaxle_node::audit::AuditOutcome::{Accepted, Ended, NotTaken, Refused};
    match record.entry.outcome {
        Accepted => false,
        Refused | NotTaken | Ended => true,
    }
}

/// A time in UTC, as RFC 3339 has it.
fn time_of(at_us: i64) -> String {
    let nanos = i128::from(at_us) * 1_000;
    let Ok(at) = OffsetDateTime::from_unix_timestamp_nanos(nanos) else {
        // Beyond the calendar: from a damaged file.
        return format!("{at_us} us");
    };
    format!(
        "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z",
        at.year(),
        u8::from(at.month()),
        at.day(),
        at.hour(),
        at.minute(),
        at.second(),
        at.microsecond()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use coaxle_node::audit::{AUDIT_VERSION, AuditDoor, AuditEntry, AuditOutcome};
    use coaxle_node::keys::NodeName;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        audit: AuditArgs,
    }

    fn record(number: u64, outcome: AuditOutcome) -> AuditRecord {
        let entry = AuditEntry::new(AuditDoor::Order, Some("anna"), "MC_Power", outcome);
        AuditRecord {
            version: AUDIT_VERSION,
            node: NodeName::new("saw").unwrap(),
            run: "5".to_owned(),
            number,
            at_us: 1_795_766_400_000_001,
            entry: entry.on("carriage"),
            count: 1,
        }
    }

    fn lines(options: &[&str]) -> String {
        let args = Cli::try_parse_from([&["x", "a.mcap"][..], options].concat()).unwrap();
        let mut out = Vec::new();
        let mut lines = RecordLines::default();
        for record in [
            record(1, AuditOutcome::Accepted),
            record(2, AuditOutcome::Refused),
            record(5, AuditOutcome::NotTaken),
        ] {
            lines.write(&args.audit, &record, &mut out).unwrap();
        }
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn records_are_lines_with_their_time_and_gaps_show() {
        let order = "order of \"anna\": MC_Power to \"carriage\"";
        let time = "2026-11-27T08:00:00.000001Z saw";
        assert_eq!(
            lines(&[]),
            format!(
                "{time} 1: {order}: accepted\n{time} 2: {order}: refused\n\
                 … 2 records of saw are missing here\n{time} 5: {order}: not taken\n"
            )
        );
        assert_eq!(lines(&["--refused"]).lines().count(), 3);
        let json = lines(&["--json", "--refused"]);
        assert_eq!(json.lines().count(), 2);
        assert!(
            json.lines()
                .all(|line| AuditRecord::from_json(line.as_bytes()).is_ok())
        );
    }

    #[test]
    fn a_file_or_a_node_is_named() {
        for bad in [
            &["x"][..],
            &["x", "a.mcap", "--node", "saw"],
            &["x", "a.mcap", "--follow"],
        ] {
            assert!(Cli::try_parse_from(bad).is_err(), "{bad:?}");
        }
        assert!(Cli::try_parse_from(["x", "--node", "saw", "-f"]).is_ok());
    }
}
