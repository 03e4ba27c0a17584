//! What becomes of a sender's cycles: trace and status.

use coaxle_clock::CycleTime;
use coaxle_host::{Record, Recorder, Trace, fields_of};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::node::SenderSnapshot;
use crate::record::SenderRecord;

/// Keeps the newest cycle for the status, and all of them if there is a trace.
pub(super) struct SenderRecorder {
    cycle_time: CycleTime,
    trace: Option<Trace>,
    newest: Option<SenderSnapshot>,
}

/// What a sender adds to its status: `docs/WIRE.md` describes each field.
#[derive(Serialize)]
struct Status {
    cycle: u64,
    cycle_time_us: f64,
    overruns: u64,
    index: u16,
    count: u64,
    time_requests: TimeRequestsStatus,
    axes: Vec<AxisStatus>,
}

#[derive(Serialize)]
struct TimeRequestsStatus {
    answered: u64,
    dropped: u64,
    refused: u64,
}

#[derive(Serialize)]
struct AxisStatus {
    id: u32,
    position: f64,
    velocity: f64,
}

impl SenderRecorder {
    pub(super) const fn new(cycle_time: CycleTime, trace: Option<Trace>) -> Self {
        Self {
            cycle_time,
            trace,
            newest: None,
        }
    }
}

impl Recorder<SenderSnapshot> for SenderRecorder {
    fn record(&mut self, record: &Record<SenderSnapshot>) {
        let snapshot = &record.snapshot;
        if let Some(trace) = &mut self.trace {
            let (at, woke) = (record.ideal_start.as_nanos(), record.woke.as_nanos());
            trace.write(record.ideal_start, SenderRecord::rows(at, woke, snapshot));
        }
        match &mut self.newest {
            Some(newest) => newest.clone_from(snapshot),
            None => self.newest = Some(snapshot.clone()),
        }
    }

    fn status(&self) -> Map<String, Value> {
        match &self.newest {
            Some(snapshot) => fields_of(&Status::of(self.cycle_time, snapshot)),
            None => Map::new(),
        }
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.trace.as_mut().map_or(Ok(()), Trace::finish)
    }
}

impl Status {
    fn of(cycle_time: CycleTime, snapshot: &SenderSnapshot) -> Self {
        let axis = |axis: &crate::AxisKinematics| AxisStatus {
            id: axis.id,
            position: axis.position,
            velocity: axis.velocity,
        };
        Self {
            cycle: snapshot.count,
            cycle_time_us: cycle_time.span().as_micros_f64(),
            overruns: snapshot.overruns,
            index: snapshot.index.0,
            count: snapshot.count,
            time_requests: TimeRequestsStatus {
                answered: snapshot.time_requests.taken.answered,
                dropped: snapshot.time_requests.taken.dropped,
                refused: snapshot.time_requests.refused,
            },
            axes: snapshot.axes.iter().map(axis).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AxisKinematics, Sender};
    use coaxle_clock::{Instant, Span};
    use coaxle_node::Node;
    use coaxle_node::config::parse;
    use serde_json::json;

    const DOCUMENT: &str = include_str!("../../../docs/WIRE.md");

    /// What the host adds to the status of a node that follows nobody.
    const HOST_FIELDS: [&str; 12] = [
        "node",
        "role",
        "health",
        "epoch",
        "uptime_s",
        "cycles",
        "telemetry_dropped",
        "exchange_refused",
        "published",
        "publish_dropped",
        "publish_failed",
        "followed",
    ];

    fn cycle_time() -> CycleTime {
        CycleTime::new(Span::from_millis(2)).unwrap()
    }

    fn record() -> Record<SenderSnapshot> {
        let text = "name = 's'\ncycle-time-us = 2000\n[[axis]]\nid = 7\nname = 'x'\nprogram = { \
                    start-velocity = 5.0, limits = { velocity = 9, acceleration = 9, jerk = 9 } }";
        let config = parse("s", text).unwrap();
        let mut sender = Sender::new(&config, Instant::EPOCH, 1).unwrap();
        let _ = sender.cycle(Instant::EPOCH);
        Record {
            ideal_start: Instant::from_nanos(3_000),
            woke: Instant::from_nanos(3_400),
            snapshot: sender.snapshot().clone(),
        }
    }

    #[test]
    fn the_status_has_the_fields_that_the_document_describes() {
        let mut recorder = SenderRecorder::new(cycle_time(), None);
        assert_eq!(
            recorder.status(),
            Map::new(),
            "nothing to say before the first cycle"
        );
        recorder.record(&record());
        let mut status = recorder.status();
        assert_eq!(
            status["axes"],
            json!([{ "id": 7, "position": 0.0, "velocity": 5.0 }])
        );
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
    fn a_trace_has_a_row_per_shown_axis_and_cycle() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.csv");
        let mut recorder = SenderRecorder::new(cycle_time(), Some(Trace::create(&path).unwrap()));
        let mut record = record();
        let other = AxisKinematics {
            id: 9,
            position: 1.5,
            velocity: 2.5,
            acceleration: 3.5,
        };
        record.snapshot.axes = [record.snapshot.axes[0], other].into();
        recorder.record(&record);
        recorder.record(&record);
        recorder.finish().unwrap();
        let rows: Vec<SenderRecord> = csv::Reader::from_path(&path)
            .unwrap()
            .deserialize()
            .collect::<Result<_, _>>()
            .unwrap();
        assert_eq!(
            rows.iter().map(|row| row.axis).collect::<Vec<_>>(),
            [7, 9, 7, 9]
        );
        assert_eq!((rows[1].at_ns, rows[1].acceleration), (3_000, 3.5));
    }
}
