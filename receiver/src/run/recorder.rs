//! Destinations of a receiver's cycles: trace, log and status.

use coaxle_clock::Instant;
use coaxle_host::files::{InputRecord, Rows};
use coaxle_host::network::transport::Publisher;
use coaxle_host::node::{ArrivalRecord, Record, Recorder};
use coaxle_node::audit::AuditRecord;
use coaxle_os::{ArrivalsTrace, Machine};
use serde_json::{Map, Value, json};

use super::journal::{Journal, Level};
use super::status;
use crate::config::ReceiverConfig;
use crate::snapshot::ReceiverSnapshot;

/// Keeps the newest cycle for the status, and writes the requested files.
pub(super) struct ReceiverRecorder {
    config: ReceiverConfig,
    rows: Rows,
    arrivals: Option<ArrivalsTrace>,
    journal: Journal,
    newest: Option<ReceiverSnapshot>,
    /// Start of the newest cycle.
    newest_at: Instant<Machine>,
    /// Time and text of the last fault.
    last_fault: Option<(Instant<Machine>, String)>,
}

impl ReceiverRecorder {
    /// Creates the recorder, with a trace of the arrivals from the followed nodes if requested.
    pub(super) fn new(
        config: &ReceiverConfig,
        rows: Rows,
        arrivals: Option<ArrivalsTrace>,
    ) -> Self {
        Self {
            config: config.clone(),
            rows,
            arrivals,
            journal: Journal::new(config),
            newest: None,
            newest_at: Instant::EPOCH,
            last_fault: None,
        }
    }
}

impl Recorder<ReceiverSnapshot> for ReceiverRecorder {
    fn begin(&mut self, epoch: u64, rows: Box<dyn Publisher>) {
        self.rows.begin(epoch, rows);
    }

    fn reported(&mut self, at: Instant<Machine>, status: &str) {
        self.rows.reported(at, status);
    }

    fn audited(&mut self, at: Instant<Machine>, record: &AuditRecord) {
        self.rows.audited(at, record);
    }

    fn record(&mut self, record: &Record<ReceiverSnapshot>) {
        let snapshot = &record.snapshot;
        self.rows
            .row(record.ideal_start, record.woke, &snapshot.signals);
        for note in self.journal.take(record.ideal_start, snapshot) {
            note.log(&self.config.name);
            // Kept after it has passed, for an operator who asks later.
            if note.level != Level::Info {
                self.last_fault = Some((record.ideal_start, note.text.clone()));
            }
            self.rows
                .log(record.ideal_start, note.level.into(), note.text);
        }
        self.newest_at = record.ideal_start;
        match &mut self.newest {
            // Into the memory of the last one, in each cycle.
            Some(newest) => newest.clone_from(snapshot),
            None => self.newest = Some(snapshot.clone()),
        }
    }

    fn wants_inputs(&self) -> bool {
        self.rows.want_inputs()
    }

    fn told(&mut self, record: &InputRecord) {
        self.rows.told(record);
    }

    fn arrived(&mut self, record: &ArrivalRecord) {
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.write(record.ideal_start, &record.tick, &record.arrival);
        }
    }

    fn status(&self) -> Map<String, Value> {
        let mut status = match &self.newest {
            Some(snapshot) => {
                let mut status = status::of(&self.config, snapshot);
                let fault = self.last_fault.as_ref().map(|(at, text)| {
                    let age_s = (self.newest_at - *at).as_secs_f64();
                    json!({ "age_s": age_s, "text": text })
                });
                status.insert("last_fault".to_owned(), json!(fault));
                status
            }
            None => status::before_the_first_cycle(),
        };
        self.rows.add_to(&mut status);
        status
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        // Both files are finished, whichever of them fails.
        let arrived = self.arrivals.as_mut().map_or(Ok(()), ArrivalsTrace::finish);
        self.rows.finish().and(arrived)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::Receiver;
    use coaxle_clock::{CycleIndex, CycleTime, Span};
    use coaxle_curve::profile::Kinematics;
    use coaxle_node::config::parse;
    use coaxle_node::signal::Group;
    use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node, Rejection};

    const DOCUMENT: &str = include_str!("../../../docs/WIRE.md");

    /// The host's fields, with a subscription and a publication.
    const HOST_FIELDS: [&str; 19] = [
        "node",
        "namesakes",
        "role",
        "epoch",
        "uptime_s",
        "cycles",
        "telemetry_dropped",
        "exchange_refused",
        "real_time",
        "published",
        "publish_dropped",
        "publish_failed",
        "followed",
        "seen_by",
        "sources",
        "received",
        "refused",
        "mailbox_dropped",
        "arrivals_dropped",
    ];

    fn config() -> ReceiverConfig {
        let text = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'conveyor', axis = 3 }\n\
                    [[virtual-axis]]\nid = 2\nname = 'shaft'\nunit = '°'\nprogram = { start-position = 7, \
                    limits = { velocity = 1, acceleration = 1, jerk = 1 } }";
        parse("r", text).unwrap()
    }

    /// Rows with these command line arguments.
    fn rows(line: &[&str]) -> Rows {
        #[derive(clap::Parser)]
        struct Cli {
            #[command(flatten)]
            node: coaxle_host::cli::NodeArgs,
        }
        let line = ["node", "r.toml"].iter().chain(line);
        let cli = <Cli as clap::Parser>::parse_from(line);
        super::super::rows(&cli.node, &config()).unwrap()
    }

    fn record(snapshot: ReceiverSnapshot) -> Record<ReceiverSnapshot> {
        Record {
            ideal_start: Instant::from_nanos(1_000),
            woke: Instant::from_nanos(1_700),
            snapshot,
        }
    }

    fn coupled() -> ReceiverSnapshot {
        let mut receiver = Receiver::new(&config(), Instant::EPOCH, 1).unwrap();
        let header = FrameHeader {
            sender: 1,
            epoch: 5,
            index: CycleIndex(9),
            count: 9,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            present_after: None,
            send_stamp: None,
        };
        let axis = AxisSample {
            set: Kinematics::at_rest(2.5),
            ..AxisSample::default()
        };
        let axes = &[Some(axis)];
        receiver.receive(Instant::EPOCH, 0, &Message::Frame(Frame { header, axes }));
        let refused = Message::Rejected(Rejection::Implausible);
        receiver.receive(Instant::EPOCH, 0, &refused);
        let _ = receiver.cycle(Instant::EPOCH);
        receiver.snapshot().clone()
    }

    #[test]
    fn the_status_has_the_fields_that_the_document_describes() {
        let mut recorder = ReceiverRecorder::new(&config(), rows(&[]), None);
        let before = recorder.status();
        assert_eq!(before["health"], "waiting-for-master");
        assert_eq!(
            before.len(),
            1,
            "nothing more to say before the first cycle"
        );
        recorder.record(&record(coupled()));
        let mut status = recorder.status();
        assert_eq!(status["health"], "starting-up");
        assert_eq!(status["far"]["conveyor"]["rejected_implausible"], 1);
        assert_eq!(status["axes"]["conveyor.3"]["received_position"], 2.5);
        assert_eq!(status["error"], Value::Null);
        for field in HOST_FIELDS {
            assert!(!status.contains_key(field), "{field} is the host's");
            status.insert(field.to_owned(), Value::Null);
        }
        let examples = DOCUMENT.split("```json\n").skip(1);
        let example = examples
            .filter_map(|rest| rest.split("```").next())
            .map(|json| serde_json::from_str::<Value>(json).expect("valid JSON"))
            .find(|example| example.get("role").is_some_and(|role| role == "receiver"))
            .expect("an example");
        // The example's signals are some of many: `docs/SIGNALS.md` has them all.
        let whole = shape(&Value::Object(status));
        for path in shape(&example) {
            let elsewhere = ["sources.", "real_time.", "last_fault."];
            let is_elsewhere = elsewhere.iter().any(|object| path.starts_with(object));
            assert!(is_elsewhere || whole.contains(&path), "{path}");
        }
    }

    /// Every path of an object.
    fn shape(value: &Value) -> Vec<String> {
        let mut paths = Vec::new();
        if let Value::Object(fields) = value {
            for (name, inner) in fields {
                paths.push(name.clone());
                paths.extend(shape(inner).iter().map(|path| format!("{name}.{path}")));
            }
        }
        paths
    }

    #[test]
    fn the_status_says_every_signal_of_everything() {
        let mut recorder = ReceiverRecorder::new(&config(), rows(&[]), None);
        recorder.record(&record(coupled()));
        let status = recorder.status();
        for instance in config().instances() {
            let of = match instance.group {
                Group::Node => &Value::Object(status.clone()),
                Group::FarNode => &status["far"][&instance.name],
                Group::FarAxis => &status["axes"][&instance.name],
                Group::VirtualAxis => &status["virtual_axes"][&instance.name],
                Group::Slave => &status["slaves"][&instance.name],
                Group::Axis | Group::Truth => unreachable!("no group of a receiver's"),
            };
            for signal in instance.signals {
                assert!(of.get(signal.name).is_some(), "{}", signal.name);
            }
        }
    }

    #[test]
    fn an_error_is_code_and_text_and_a_master_that_does_not_fit_is_one() {
        let mut recorder = ReceiverRecorder::new(&config(), rows(&[]), None);
        let mut snapshot = coupled();
        snapshot.health = crate::Health::CycleTimesDoNotFit;
        snapshot.far_health[0] = snapshot.health;
        snapshot.data_cycle_times[0] = CycleTime::new(Span::from_micros(1_500)).ok();
        recorder.record(&record(snapshot));
        for error in [
            &recorder.status()["error"],
            &recorder.status()["far"]["conveyor"]["error"],
        ] {
            assert_eq!(error["code"], "0x4b56");
            assert!(
                error["text"].as_str().unwrap().contains("1500 µs"),
                "{error}"
            );
        }
    }

    #[test]
    fn the_last_fault_is_told_with_its_age_until_there_is_another() {
        let mut recorder = ReceiverRecorder::new(&config(), rows(&[]), None);
        recorder.record(&record(coupled()));
        assert_eq!(recorder.status()["last_fault"], Value::Null);
        let mut failed = coupled();
        failed.health = crate::Health::CycleTimesDoNotFit;
        failed.far_health[0] = failed.health;
        for after in [1, 2, 3] {
            let mut record = record(failed.clone());
            record.ideal_start += Span::from_secs(after);
            recorder.record(&record);
        }
        let fault = &recorder.status()["last_fault"];
        assert_eq!(fault["age_s"], 2.0);
        assert!(
            fault["text"].as_str().unwrap().contains("cycle time"),
            "{fault}"
        );
    }

    #[test]
    fn a_trace_has_a_row_per_cycle_and_a_value_per_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.csv");
        let columns = config().columns();
        let rows = rows(&["--trace", path.to_str().unwrap()]);
        let mut recorder = ReceiverRecorder::new(&config(), rows, None);
        for _ in 0..3 {
            recorder.record(&record(coupled()));
        }
        recorder.finish().unwrap();
        let mut reader = csv::Reader::from_path(&path).unwrap();
        assert_eq!(reader.headers().unwrap(), columns);
        let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        let value = |column: &str| {
            let place = columns.iter().position(|name| name == column).unwrap();
            &rows[2][place]
        };
        for (column, expected) in [
            ("at_ns", "1000"),
            ("woke_ns", "1700"),
            ("health", "starting-up"),
            ("conveyor.count", "9"),
            ("conveyor.rejected_implausible", "1"),
            ("conveyor.3.received_position", "2.5"),
            ("conveyor.3.state", "time"),
            ("shaft.position", "7.0"),
            ("shaft.activity", "idle"),
            ("slave.state", "synchronized-motion"),
            ("slave.following_error", "0.0"),
        ] {
            assert_eq!(value(column), expected, "{column}");
        }
    }
}
