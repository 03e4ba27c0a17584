//! Content of a recording, and its files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;

/// Arrivals and time exchanges of one run of a sender, on one time scale: nanoseconds since the ideal
/// start of the first recorded cycle, whose count is 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ArrivalRecording {
    pub(crate) messages: Vec<RecordedMessage>,
    pub(crate) exchanges: Vec<RecordedExchange>,
    /// Messages with numbers that the file cannot hold: more than 2.1 s late.
    pub(crate) left_out: u64,
}

/// A message. The ideal start of its cycle is `count` times the cycle time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RecordedMessage {
    /// The sender's cycle, counted from the first recorded one.
    // 24 days at 1 kHz.
    pub(crate) count: i32,
    /// Departure after the ideal start of its cycle, ns; 0 where the sender does not state it.
    pub(crate) send_stamp_ns: i32,
    /// Arrival minus that, ns.
    // An i32 of ns ends at 2.147 s: later messages are left out and counted.
    pub(crate) delay_ns: i32,
}

/// The four stamps of a time request and its response, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct RecordedExchange {
    pub(crate) t1_ns: i64,
    pub(crate) t2_ns: i64,
    pub(crate) t3_ns: i64,
    pub(crate) t4_ns: i64,
}

/// The files of a recording called `DIR/NAME`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RecordingFiles {
    /// `NAME.i32`: a row per message, see [`RecordedMessage::row`].
    pub(crate) messages: PathBuf,
    /// `NAME-exchanges.csv`.
    pub(crate) exchanges: PathBuf,
    /// `NAME.json`: origin and content of the recording.
    pub(crate) summary: PathBuf,
}

impl RecordingFiles {
    pub(crate) fn of(name: &Path) -> Self {
        let ending = |ending: &str| {
            let mut path = name.as_os_str().to_owned();
            // Appended: `with_extension` would cut a name with a dot in it.
            path.push(ending);
            PathBuf::from(path)
        };
        Self {
            messages: ending(".i32"),
            exchanges: ending("-exchanges.csv"),
            summary: ending(".json"),
        }
    }
}

impl RecordedMessage {
    /// Four little-endian 32-bit integers: count, send stamp, delay, and the delay by the kernel's
    /// receive stamp, which Zenoh does not show: 0.
    fn row(&self) -> [u8; 16] {
        let mut row = [0; 16];
        for (place, number) in [self.count, self.send_stamp_ns, self.delay_ns]
            .into_iter()
            .enumerate()
        {
            row[4 * place..4 * place + 4].copy_from_slice(&number.to_le_bytes());
        }
        row
    }
}

impl ArrivalRecording {
    /// Writes messages and exchanges.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub(crate) fn write(&self, files: &RecordingFiles) -> anyhow::Result<()> {
        self.write_messages(&files.messages)
            .with_context(|| format!("cannot write {}", files.messages.display()))?;
        self.write_exchanges(&files.exchanges)
            .with_context(|| format!("cannot write {}", files.exchanges.display()))
    }

    fn write_messages(&self, path: &Path) -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        for message in &self.messages {
            file.write_all(&message.row())?;
        }
        file.flush()
    }

    fn write_exchanges(&self, path: &Path) -> csv::Result<()> {
        let mut csv = csv::WriterBuilder::new()
            .has_headers(false)
            .from_path(path)?;
        // Written even if there are none: a file without a head line could not be read.
        csv.write_record(["t1_ns", "t2_ns", "t3_ns", "t4_ns"])?;
        for exchange in &self.exchanges {
            csv.serialize(exchange)?;
        }
        Ok(csv.flush()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads the rows as the estimators' examples do.
    fn rows(path: &Path) -> Vec<[i32; 4]> {
        let bytes = std::fs::read(path).unwrap();
        let (words, rest) = bytes.as_chunks::<4>();
        assert!(rest.is_empty());
        let numbers: Vec<i32> = words.iter().map(|word| i32::from_le_bytes(*word)).collect();
        let (rows, rest) = numbers.as_chunks::<4>();
        assert!(rest.is_empty());
        rows.to_vec()
    }

    #[test]
    fn what_is_written_can_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let files = RecordingFiles::of(&folder.path().join("udp.idle"));
        assert!(files.messages.ends_with("udp.idle.i32"));
        let recording = ArrivalRecording {
            messages: vec![
                RecordedMessage {
                    count: 0,
                    send_stamp_ns: -20,
                    delay_ns: 13_000,
                },
                RecordedMessage {
                    count: 70_000,
                    send_stamp_ns: 55_555,
                    delay_ns: i32::MAX,
                },
            ],
            exchanges: vec![RecordedExchange {
                t1_ns: -5,
                t2_ns: 6,
                t3_ns: 7,
                t4_ns: 1 << 40,
            }],
            left_out: 0,
        };
        recording.write(&files).unwrap();
        assert_eq!(
            rows(&files.messages),
            [[0, -20, 13_000, 0], [70_000, 55_555, i32::MAX, 0]]
        );
        let text = std::fs::read_to_string(&files.exchanges).unwrap();
        assert_eq!(text, "t1_ns,t2_ns,t3_ns,t4_ns\n-5,6,7,1099511627776\n");
        let mut csv = csv::Reader::from_path(&files.exchanges).unwrap();
        let read: Vec<RecordedExchange> = csv.deserialize().map(Result::unwrap).collect();
        assert_eq!(read, recording.exchanges);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let files = RecordingFiles::of(Path::new("no/such/folder/idle"));
        let error = ArrivalRecording::default().write(&files).unwrap_err();
        assert!(format!("{error:#}").contains("no/such/folder/idle.i32"));
    }
}
