//! A file of raw arrivals, with a file of time exchanges beside it.

use std::path::{Path, PathBuf};

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Domain, Instant};
use coaxle_node::arrival::{ArrivalRow, ExchangeRow};
use coaxle_node::{Arrival, Arrived};

use crate::Trace;

/// Input of a receiver about the followed clock, as CSV: a line per message in one file, a line per time
/// exchange in another.
pub struct ArrivalsTrace {
    messages: Trace,
    exchanges: Trace,
}

impl ArrivalsTrace {
    /// Creates the file `messages` and the one at [`exchanges_beside`] it, or empties them.
    ///
    /// # Errors
    /// The file that cannot be written.
    pub fn create(messages: &Path) -> anyhow::Result<Self> {
        Ok(Self {
            messages: Trace::create(messages)?,
            exchanges: Trace::create(&exchanges_beside(messages))?,
        })
    }

    /// Adds the input of the cycle `tick`, which ideally began at `at` of the world's reference clock.
    pub fn write<D: Domain>(&mut self, at: Instant<D>, tick: &Tick, arrival: &Arrival) {
        let at_ns = at.as_nanos();
        let Arrival {
            far,
            at: arrived,
            what,
        } = *arrival;
        match &what {
            Arrived::Message(header) => {
                let row = ArrivalRow::new(at_ns, tick, arrived, header, far);
                self.messages.write(at, [row]);
            }
            Arrived::Exchange(response) => {
                let row = ExchangeRow::new(at_ns, tick, arrived, response, far);
                self.exchanges.write(at, [row]);
            }
        }
    }

    /// Writes out the rest.
    ///
    /// # Errors
    /// Not all rows could be written.
    pub fn finish(&mut self) -> anyhow::Result<()> {
        self.messages.finish()?;
        self.exchanges.finish()
    }
}

/// Endings of file names by their content.
const ARRIVALS: &str = "-arrivals";
const EXCHANGES: &str = "-exchanges";

/// Returns the path of the arrivals that belong to a trace: `saw.csv`, `saw-arrivals.csv`.
#[must_use]
pub fn arrivals_beside(trace: &Path) -> PathBuf {
    renamed(trace, |stem| format!("{stem}{ARRIVALS}"))
}

/// Returns the path of the time exchanges that belong to a file of arrivals: `saw-arrivals.csv` or
/// `saw.csv`, `saw-exchanges.csv`.
#[must_use]
pub fn exchanges_beside(arrivals: &Path) -> PathBuf {
    renamed(arrivals, |stem| {
        // Both names come from one trace: `saw-arrivals-exchanges.csv` would be nobody's guess.
        let stem = stem.strip_suffix(ARRIVALS).unwrap_or(stem);
        format!("{stem}{EXCHANGES}")
    })
}

/// Returns the path with another name, but with its extension.
fn renamed(path: &Path, rename: impl Fn(&str) -> String) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let renamed = path.with_file_name(rename(&stem));
    match path.extension() {
        // Not `with_extension`: the stem may have dots of its own.
        Some(extension) => {
            let mut name = renamed.into_os_string();
            name.push(".");
            name.push(extension);
            name.into()
        }
        None => renamed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use coaxle_clock::delay::TimeResponse;
    use coaxle_clock::{CycleIndex, CycleTime, Span};
    use coaxle_node::FrameHeader;

    #[test]
    fn files_lie_beside_each_other() {
        for (trace, arrivals, exchanges) in [
            ("a/saw.csv", "a/saw-arrivals.csv", "a/saw-exchanges.csv"),
            ("saw.1.csv", "saw.1-arrivals.csv", "saw.1-exchanges.csv"),
            ("saw", "saw-arrivals", "saw-exchanges"),
        ] {
            assert_eq!(arrivals_beside(Path::new(trace)), Path::new(arrivals));
            assert_eq!(exchanges_beside(Path::new(arrivals)), Path::new(exchanges));
            assert_eq!(exchanges_beside(Path::new(trace)), Path::new(exchanges));
        }
    }

    fn header(count: u64, send_stamp: Option<Span>) -> FrameHeader {
        FrameHeader {
            sender: 1,
            epoch: u64::MAX,
            index: CycleIndex::of_count(count),
            count,
            cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
            present_after: None,
            send_stamp,
        }
    }

    #[test]
    fn what_is_written_can_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saw-arrivals.csv");
        let tick = Tick {
            count: 7,
            ideal_start: Instant::from_nanos(14_000_000),
            elapsed: 1,
        };
        let arrived = Instant::from_nanos(13_999_999);
        let response = TimeResponse {
            run: 3,
            number: 4,
            requested: Instant::from_nanos(-5),
            epoch: 6,
            received: Span::from_nanos(8),
            responded: Span::from_nanos(9),
        };
        let (late, silent) = (header(5, Some(Span::from_nanos(-3))), header(6, None));
        let mut trace = ArrivalsTrace::create(&path).unwrap();
        let at: Instant<Machine> = Instant::from_nanos(1_014_000_000);
        for (far, what) in [
            (0, Arrived::Message(late)),
            (1, Arrived::Exchange(response)),
            (1, Arrived::Message(silent)),
        ] {
            let arrival = Arrival {
                far,
                at: arrived,
                what,
            };
            trace.write(at, &tick, &arrival);
        }
        trace.finish().unwrap();

        let mut messages = csv::Reader::from_path(&path).unwrap();
        let messages: Vec<ArrivalRow> = messages.deserialize().map(Result::unwrap).collect();
        let expected = [(late, 0), (silent, 1)]
            .map(|(h, far)| ArrivalRow::new(at.as_nanos(), &tick, arrived, &h, far));
        assert_eq!(messages, expected);
        assert_eq!(messages[0].send_stamp_ns, Some(-3));
        assert_eq!(messages[1].send_stamp_ns, None);
        let mut exchanges = csv::Reader::from_path(exchanges_beside(&path)).unwrap();
        let exchanges: Vec<ExchangeRow> = exchanges.deserialize().map(Result::unwrap).collect();
        let expected = ExchangeRow::new(at.as_nanos(), &tick, arrived, &response, 1);
        assert_eq!(exchanges, [expected]);
        let stamps = (
            expected.t1_ns,
            expected.t2_ns,
            expected.t3_ns,
            expected.t4_ns,
        );
        assert_eq!(stamps, (-5, 8, 9, 13_999_999));
    }
}
