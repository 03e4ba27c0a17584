//! Destinations of a sender's cycles: trace and status.

use coaxle_clock::Instant;
use coaxle_host::files::Rows;
use coaxle_host::network::transport::Publisher;
use coaxle_host::node::{Record, Recorder};
use coaxle_node::audit::AuditRecord;
use coaxle_node::fields_of;
use coaxle_node::signal::{Group, Instance};
use coaxle_os::Machine;
use serde_json::{Map, Value, json};

use crate::config::SenderConfig;
use crate::signals::AxisSignals;
use crate::snapshot::SenderSnapshot;

/// Keeps the newest cycle for the status, and writes the requested files.
pub(super) struct SenderRecorder {
    config: SenderConfig,
    rows: Rows,
    newest: Option<SenderSnapshot>,
}

impl SenderRecorder {
    pub(super) fn new(config: &SenderConfig, rows: Rows) -> Self {
        Self {
            config: config.clone(),
            rows,
            newest: None,
        }
    }
}

impl Recorder<SenderSnapshot> for SenderRecorder {
    fn begin(&mut self, epoch: u64, rows: Box<dyn Publisher>) {
        self.rows.begin(epoch, rows);
    }

    fn reported(&mut self, at: Instant<Machine>, status: &str) {
        self.rows.reported(at, status);
    }

    fn audited(&mut self, at: Instant<Machine>, record: &AuditRecord) {
        self.rows.audited(at, record);
    }

    fn record(&mut self, record: &Record<SenderSnapshot>) {
        let snapshot = &record.snapshot;
        self.rows
            .row(record.ideal_start, record.woke, &snapshot.signals);
        match &mut self.newest {
            // Copied in place: a thousand snapshots a second would otherwise allocate as often.
            Some(newest) => newest.clone_from(snapshot),
            None => self.newest = Some(snapshot.clone()),
        }
    }

    fn status(&self) -> Map<String, Value> {
        let mut status = match &self.newest {
            Some(snapshot) => status_of(&self.config, snapshot),
            // Before the first cycle only the host's part of the status is known.
            None => Map::new(),
        };
        self.rows.add_to(&mut status);
        status
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.rows.finish()
    }
}

/// A sender's part of the status: its signals, nested by subject. `docs/WIRE.md` describes it.
fn status_of(config: &SenderConfig, snapshot: &SenderSnapshot) -> Map<String, Value> {
    let mut status = fields_of(&snapshot.signals.node);
    // The host reports it as text.
    status.remove("run");
    let cycle_time = config.cycle_time_us.0.span().as_micros_f64();
    status.insert("cycle_time_us".to_owned(), json!(cycle_time));
    let instances = config.instances();
    let axes = instances.iter().filter(|of| of.group == Group::Axis);
    let axis = |(instance, (id, signals)): (&Instance, (u32, &AxisSignals))| {
        let mut axis = fields_of(signals);
        axis.insert("id".to_owned(), json!(id));
        axis.insert("unit".to_owned(), json!(instance.unit));
        (instance.name.clone(), Value::Object(axis))
    };
    if snapshot.signals.node.followers_failed > 0 {
        status.insert("health".to_owned(), json!("follower-failed"));
    }
    status.insert("followers".to_owned(), followers_of(config, snapshot));
    // Both come from the shown axes of one config, in one order.
    let axes = axes.zip(snapshot.axes()).map(axis);
    status.insert("axes".to_owned(), Value::Object(axes.collect()));
    status
}

/// Followers of each axis, by its id and their names: `{ "1": { "saw": "in-sync" } }`.
fn followers_of(config: &SenderConfig, snapshot: &SenderSnapshot) -> Value {
    let mut conditions = snapshot.followers.iter();
    let mut axes = Map::new();
    for axis in config.axes.iter() {
        let Some(followers) = &axis.followers else {
            continue;
        };
        let of_axis = followers.nodes.iter().zip(conditions.by_ref());
        let of_axis = of_axis.map(|(node, condition)| (node.to_string(), json!(condition)));
        axes.insert(axis.id.to_string(), Value::Object(of_axis.collect()));
    }
    Value::Object(axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sender;
    use coaxle_node::Node;
    use coaxle_node::config::parse;

    const DOCUMENT: &str = include_str!("../../../docs/WIRE.md");

    /// The host's fields in the status of a node that follows no other.
    const HOST_FIELDS: [&str; 15] = [
        "node",
        "namesakes",
        "role",
        "health",
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
    ];

    fn config() -> SenderConfig {
        let axis = |id| {
            format!(
                "[[axis]]\nid = {id}\nname = 'x'\nunit = 'mm'\nprogram = {{ start-velocity = {id}.0, \
                 limits = {{ velocity = 9, acceleration = 9, jerk = 9 }} }}\n"
            )
        };
        let text = format!("name = 's'\ncycle-time-us = 2000\n{}{}", axis(7), axis(9));
        parse("s", &text).unwrap()
    }

    /// Rows with these command line arguments.
    fn rows(line: &[&str]) -> Rows {
        #[derive(clap::Parser)]
        struct Cli {
            #[command(flatten)]
            node: coaxle_host::cli::NodeArgs,
        }
        let line = ["node", "s.toml"].iter().chain(line);
        let cli = <Cli as clap::Parser>::parse_from(line);
        super::super::rows(&cli.node, &config()).unwrap()
    }

    fn record() -> Record<SenderSnapshot> {
        let mut sender = Sender::new(&config(), Instant::EPOCH, 1).unwrap();
        let _ = sender.cycle(Instant::EPOCH);
        Record {
            ideal_start: Instant::from_nanos(3_000),
            woke: Instant::from_nanos(3_400),
            snapshot: sender.snapshot().clone(),
        }
    }

    #[test]
    fn the_status_has_the_fields_that_the_document_describes() {
        let mut recorder = SenderRecorder::new(&config(), rows(&[]));
        assert_eq!(
            recorder.status(),
            Map::new(),
            "nothing to say before the first cycle"
        );
        recorder.record(&record());
        let mut status = recorder.status();
        let axis = |id, velocity| json!({ "id": id, "unit": "mm", "position": 0.0, "velocity": velocity, "acceleration": 0.0 });
        let axes = json!({ "x.7": axis(7, 7.0), "x.9": axis(9, 9.0) });
        assert_eq!(status["axes"], axes);
        assert_eq!(status["cycle_time_us"], 2000.0);
        for field in HOST_FIELDS {
            assert!(!status.contains_key(field), "{field} is the host's");
            status.insert(field.to_owned(), Value::Null);
        }
        let examples = DOCUMENT.split("```json\n").skip(1);
        let example = examples
            .filter_map(|rest| rest.split("```").next())
            .map(|json| serde_json::from_str::<Map<_, _>>(json).expect("valid JSON"))
            .find(|example| example.get("role").is_some_and(|role| role == "sender"))
            .expect("an example");
        let names = |fields: &Map<String, Value>| fields.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&example), names(&status));
    }

    #[test]
    fn a_trace_has_a_row_per_cycle_and_a_column_per_signal() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.csv");
        let rows = rows(&["--trace", path.to_str().unwrap()]);
        let mut recorder = SenderRecorder::new(&config(), rows);
        recorder.record(&record());
        recorder.record(&record());
        recorder.finish().unwrap();
        let mut reader = csv::Reader::from_path(&path).unwrap();
        let rows: Vec<std::collections::HashMap<String, Option<f64>>> =
            reader.deserialize().collect::<Result<_, _>>().unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(
            (rows[1]["at_ns"], rows[1]["x.9.velocity"]),
            (Some(3_000.0), Some(9.0))
        );
    }
}
