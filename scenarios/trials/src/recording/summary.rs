//! Summary of a recording, for people and for programs.

use std::fmt::Write;

use serde::Serialize;

use super::format::{ArrivalRecording, RecordedMessage};

/// Origin and content of a recording: `NAME.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct RecordingSummary {
    pub(crate) origin: RecordingOrigin,
    /// The sender's nominal cycle time, µs: the ideal start of count k is k times this.
    pub(crate) cycle_time_us: f64,
    /// From the first message to the last, s.
    pub(crate) seconds: f64,
    pub(crate) messages: usize,
    /// Counts that are missing: skipped by the sender, lost on the way, or not recorded.
    pub(crate) missing: i64,
    /// Messages more than 2.1 s late, which the format cannot hold.
    pub(crate) left_out: u64,
    pub(crate) exchanges: usize,
    /// Arrival minus send, µs.
    pub(crate) delay_us: DelayQuantiles,
    /// Lateness of departures, µs.
    pub(crate) send_stamp_us: DelayQuantiles,
}

/// Origin of the recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "from")]
pub(crate) enum RecordingOrigin {
    /// Processes on this machine. Both read one clock: delays are true.
    Processes {
        transport: &'static str,
        busy: u16,
        real_time: bool,
    },
    /// A file of arrivals, of two unknown clocks: delays are deviations from a fitted line of this
    /// drift.
    Fitted { file: String, drift_ppm: f64 },
}

/// Quantiles of delays or send stamps, µs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct DelayQuantiles {
    least: f64,
    p10: f64,
    median: f64,
    p90: f64,
    p99: f64,
    most: f64,
}

impl RecordingSummary {
    /// Summary of a recording with at least one message.
    pub(crate) fn of(
        recording: &ArrivalRecording,
        origin: RecordingOrigin,
        cycle_time_ns: i64,
    ) -> Self {
        let messages = &recording.messages;
        let counts = || messages.iter().map(|message| i64::from(message.count));
        let range = counts().max().unwrap_or(0) - counts().min().unwrap_or(0);
        Self {
            origin,
            // Divided, as a factor of 1e-3 would add meaningless digits.
            cycle_time_us: cycle_time_ns as f64 / 1e3,
            seconds: range as f64 * cycle_time_ns as f64 / 1e9,
            messages: messages.len(),
            // Duplicates may make more messages than counts.
            missing: (range + 1 - messages.len() as i64).max(0),
            left_out: recording.left_out,
            exchanges: recording.exchanges.len(),
            delay_us: DelayQuantiles::of(messages, |message| message.delay_ns),
            send_stamp_us: DelayQuantiles::of(messages, |message| message.send_stamp_ns),
        }
    }

    /// Returns the summary as text for people.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{} messages in {:.1} s, {} missing, {} time exchanges",
            self.messages, self.seconds, self.missing, self.exchanges
        );
        if self.left_out > 0 {
            let _ = writeln!(text, "{} left out: more than 2.1 s late", self.left_out);
        }
        if let RecordingOrigin::Fitted { drift_ppm, .. } = self.origin {
            let _ = writeln!(
                text,
                "delays are what deviates from the fitted line: {drift_ppm:.3} ppm, least delay 0"
            );
        }
        let _ = writeln!(
            text,
            "{:12}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}",
            "µs", "least", "10 %", "median", "90 %", "99 %", "most"
        );
        for (name, q) in [("delay", self.delay_us), ("sent late", self.send_stamp_us)] {
            let _ = write!(text, "{name:12}");
            for value in [q.least, q.p10, q.median, q.p90, q.p99, q.most] {
                let _ = write!(text, "{value:10.1}");
            }
            let _ = writeln!(text);
        }
        text
    }
}

impl DelayQuantiles {
    fn of(messages: &[RecordedMessage], nanos: impl Fn(&RecordedMessage) -> i32) -> Self {
        let mut sorted: Vec<i32> = messages.iter().map(nanos).collect();
        sorted.sort_unstable();
        // An empty list has all quantiles 0, by `get` below.
        let last = sorted.len().saturating_sub(1) as f64;
        let at = |share: f64| {
            let place = (share * last).round() as usize;
            sorted.get(place).map_or(0.0, |ns| f64::from(*ns) / 1e3)
        };
        Self {
            least: at(0.0),
            p10: at(0.1),
            median: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            most: at(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_counts_what_is_there_and_what_is_missing() {
        let message = |count: i32| RecordedMessage {
            count,
            send_stamp_ns: 1_000 * count,
            delay_ns: 50_000 - 1_000 * count,
        };
        let counts = (0..=50).filter(|count| count % 10 != 3);
        let recording = ArrivalRecording {
            messages: counts.map(message).collect(),
            exchanges: Vec::new(),
            left_out: 2,
        };
        let origin = RecordingOrigin::Fitted {
            file: "saw-arrivals.csv".to_owned(),
            drift_ppm: 12.5,
        };
        let summary = RecordingSummary::of(&recording, origin, 2_000_000);
        // 51 counts without 3, 13, 23, 33 and 43.
        assert_eq!((summary.messages, summary.missing), (46, 5));
        // 50 cycles of 2 ms.
        assert!((summary.seconds - 0.1).abs() < 1e-12);
        assert!((summary.cycle_time_us - 2_000.0).abs() < 1e-9);
        assert!((summary.delay_us.least, summary.delay_us.most) == (0.0, 50.0));
        // The missing counts shift the median by a message.
        assert!((summary.send_stamp_us.median - 25.0).abs() < 1.5);
        let text = summary.text();
        for part in [
            "46 messages",
            "5 missing",
            "2 left out",
            "12.500 ppm",
            "median",
        ] {
            assert!(text.contains(part), "{text}");
        }
        let json = serde_json::to_value(&summary).unwrap();
        assert_eq!(json["origin"]["from"], "fitted");
        assert_eq!(json["delay_us"]["most"], 50.0);
    }
}
