//! A receiver's files of arrivals and exchanges, of one run of the sender.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Take};
use std::path::Path;

use anyhow::Context;
use coaxle_node::arrival::{ArrivalRow, ExchangeRow};
use coaxle_node::text_file::{self, ShortLines};
use coaxle_os::exchanges_beside;
use coaxle_os::exit::{Mistake, wrong_file};
use serde::de::DeserializeOwned;

/// The longest run of the sender in a file of arrivals, with the exchanges beside it. There is at
/// least one message.
#[derive(Clone, Debug)]
pub(crate) struct Raw {
    pub(crate) messages: Vec<ArrivalRow>,
    pub(crate) exchanges: Vec<ExchangeRow>,
    /// Runs of the sender that were left out, as they are shorter.
    pub(crate) other_runs: usize,
}

/// Kind of file expected, for errors.
const KIND: &str = "a file that a receiver wrote with --arrivals, or beside its --trace";

impl Raw {
    /// Reads the file `arrivals` and the exchanges beside it, if there are any.
    ///
    /// # Errors
    /// Names the file and what is wrong with it.
    pub(crate) fn read(arrivals: &Path) -> anyhow::Result<Self> {
        let mut messages: Vec<ArrivalRow> = read_rows(arrivals)
            .map_err(|wrong| Mistake::in_file(format!("{wrong:#}; expected {KIND}")))?;
        // A recording is of one clock: that of the receiver's first far node.
        messages.retain(|row| row.far == 1);
        let path = exchanges_beside(arrivals);
        let exchanges = if path.exists() {
            read_rows(&path)?
        } else {
            Vec::new()
        };
        let Some((epoch, runs)) = longest_run(&messages) else {
            return wrong_file(format!(
                "{}: received no messages, expected some: did the receiver hear its master?",
                arrivals.display()
            ));
        };
        let mut raw = Self {
            messages,
            exchanges,
            other_runs: runs - 1,
        };
        raw.messages.retain(|row| row.epoch == epoch);
        raw.exchanges
            .retain(|row| row.far == 1 && row.epoch == epoch);
        Ok(raw)
    }

    /// Drops messages that arrived later than `nanos` after the first message.
    pub(crate) fn keep_first(&mut self, nanos: i64) {
        let end = self.messages[0].arrival_ns.saturating_add(nanos);
        self.messages.retain(|row| row.arrival_ns <= end);
        // t4 is the receiver's clock, as the arrivals are.
        self.exchanges.retain(|row| row.t4_ns <= end);
    }

    /// The message that was sent first: where it was overtaken it is not the first that arrived.
    pub(crate) fn sent_first(&self) -> &ArrivalRow {
        // All messages are of one run by now, so their counts compare.
        let by_count = self.messages.iter().min_by_key(|row| row.count);
        by_count.unwrap_or(&self.messages[0])
    }
}

/// The run with the most messages, and how many runs there are.
fn longest_run(messages: &[ArrivalRow]) -> Option<(u64, usize)> {
    let mut runs = BTreeMap::<u64, usize>::new();
    for row in messages {
        *runs.entry(row.epoch).or_default() += 1;
    }
    // Counts begin again with each run, so one recording cannot hold two.
    let longest = runs.iter().max_by_key(|(_, messages)| **messages)?;
    Some((*longest.0, runs.len()))
}

/// Every whole row of a file with a head line.
fn read_rows<T: DeserializeOwned>(path: &Path) -> anyhow::Result<Vec<T>> {
    rows(path)?.collect()
}

/// Reads such rows one after the other: recordings of hours are long.
pub(crate) fn rows<T: DeserializeOwned>(
    path: &Path,
) -> anyhow::Result<impl Iterator<Item = anyhow::Result<T>>> {
    let named = || format!("cannot read {}", path.display());
    let file = text_file::open(path, MOST_BYTES)?;
    let lines = whole_lines(file).with_context(named)?;
    let mut csv = csv::Reader::from_reader(ShortLines::new(lines));
    // The iterator below takes a header that cannot be read for the end of the file.
    csv.headers().with_context(named)?;
    let rows = csv.into_deserialize();
    Ok(rows.map(move |row| row.with_context(named)))
}

/// Most bytes of a file: half a day in cycles of a millisecond.
// 43.2 million lines of less than 100 bytes.
const MOST_BYTES: u64 = 4 << 30;
/// More than the longest line.
const TAIL: u64 = 4096;

/// A file up to its last line break: a killed node may leave half a line.
fn whole_lines(mut file: File) -> io::Result<Take<File>> {
    let length = file.metadata()?.len();
    // Only the end is read: a line break lies within the last line's length of it.
    let before = length.saturating_sub(TAIL);
    file.seek(SeekFrom::Start(before))?;
    let mut tail = Vec::new();
    (&file).take(TAIL).read_to_end(&mut tail)?;
    let lines = tail.iter().rposition(|byte| *byte == b'\n');
    file.rewind()?;
    Ok(file.take(lines.map_or(0, |end| before + end as u64 + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str =
        "at_ns,cycle,cycle_start_ns,epoch,count,cycle_time_ns,arrival_ns,send_stamp_ns\n";

    fn written(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saw-arrivals.csv");
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn the_longest_run_is_kept_and_half_a_line_is_not() {
        let text = format!(
            "{HEAD}9,1,1,5,70,1000000,100,\n9,1,1,6,0,1000000,300,-4\n9,1,1,6,1,1000000,400,7\n9,1,1,6,2,10"
        );
        let (_folder, path) = written(&text);
        let mut raw = Raw::read(&path).unwrap();
        assert_eq!(raw.other_runs, 1);
        let stamps: Vec<_> = raw.messages.iter().map(|row| row.send_stamp_ns).collect();
        assert_eq!(stamps, [Some(-4), Some(7)]);
        raw.keep_first(99);
        assert_eq!(raw.messages.len(), 1);
    }

    #[test]
    fn long_files_end_with_their_last_whole_line() {
        for half in ["", "9,1,1", "9,1,1,5,1000,1000000,40"] {
            let line = |k: i64| format!("9,1,1,5,{k},1000000,{},-4\n", 300 + k);
            let text: String = (0..1_000).map(line).collect();
            let (_folder, path) = written(&format!("{HEAD}{text}{half}"));
            assert_eq!(Raw::read(&path).unwrap().messages.len(), 1_000);
        }
    }

    #[test]
    fn files_of_another_kind_are_named() {
        for (text, expected) in [
            ("", "received no messages"),
            (HEAD, "received no messages"),
            ("a,b\n1,2\n", "missing field `at_ns`"),
        ] {
            let (_folder, path) = written(text);
            let error = format!("{:#}", Raw::read(&path).unwrap_err());
            assert!(error.contains("saw-arrivals.csv"), "{error}");
            assert!(error.contains(expected), "{error}");
        }
    }
}
