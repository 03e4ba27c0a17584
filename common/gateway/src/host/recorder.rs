//! Records of a gateway's cycles: trace, recording, status, and a log line for each change.

use coaxle_clock::Instant;
use coaxle_host::files::Rows;
use coaxle_host::network::transport::Publisher;
use coaxle_host::node::{Record, Recorder};
use coaxle_node::audit::AuditRecord;
use coaxle_node::fields_of;
use coaxle_os::Machine;
use serde_json::{Map, Value, json};

use crate::GatewaySnapshot;
use crate::config::{GatewayConfig, PlcAxisConfig};
use crate::signals::{GatewaySignals, PlcAxisSignals};

/// Role of a gateway in status and recordings.
pub(super) const ROLE: &str = "gateway";

/// Keeps the newest cycle for the status, and writes the requested files.
pub(super) struct GatewayRecorder {
    config: GatewayConfig,
    rows: Rows,
    newest: Option<GatewaySnapshot>,
    logged: LoggedState,
}

/// State as last logged.
#[derive(Clone, Copy, Default)]
struct LoggedState {
    is_synced: bool,
    runs: u64,
}

impl GatewayRecorder {
    pub(super) fn new(config: &GatewayConfig, rows: Rows) -> Self {
        Self {
            config: config.clone(),
            rows,
            newest: None,
            logged: LoggedState::default(),
        }
    }

    /// Logs changes since the last cycle.
    fn log_changes(&mut self, signals: &GatewaySignals) {
        let node = &self.config.name;
        if signals.plc_runs > self.logged.runs {
            // The first run is the start, not a change.
            if self.logged.runs > 0 {
                let index = signals.plc_index;
                tracing::warn!(%node, "the PLC goes on with index {index}: another run of it");
            }
            self.logged.runs = signals.plc_runs;
            // Another run is logged as synced again.
            self.logged.is_synced = false;
        }
        if signals.plc_synced != self.logged.is_synced {
            self.logged.is_synced = signals.plc_synced;
            match signals.plc_drift_ppm {
                Some(drift) => tracing::info!(
                    %node,
                    "the clock of the PLC is known, drift {drift:+.1} ppm: its axes are published"
                ),
                None => tracing::warn!(%node, "the clock of the PLC is not known any more"),
            }
        }
    }
}

impl Recorder<GatewaySnapshot> for GatewayRecorder {
    fn begin(&mut self, epoch: u64, rows: Box<dyn Publisher>) {
        self.rows.begin(epoch, rows);
    }

    fn reported(&mut self, at: Instant<Machine>, status: &str) {
        self.rows.reported(at, status);
    }

    fn audited(&mut self, at: Instant<Machine>, record: &AuditRecord) {
        self.rows.audited(at, record);
    }

    fn record(&mut self, record: &Record<GatewaySnapshot>) {
        let snapshot = &record.snapshot;
        self.rows
            .row(record.ideal_start, record.woke, &snapshot.signals);
        self.log_changes(&snapshot.signals.node);
        // In place: a snapshot of many axes is not allocated in each cycle.
        match &mut self.newest {
            Some(newest) => newest.clone_from(snapshot),
            None => self.newest = Some(snapshot.clone()),
        }
    }

    fn status(&self) -> Map<String, Value> {
        let mut status = match &self.newest {
            Some(snapshot) => status_of(&self.config, snapshot),
            None => Map::new(),
        };
        self.rows.add_to(&mut status);
        status
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.rows.finish()
    }
}

/// A gateway's part of its status: its signals and its health.
fn status_of(config: &GatewayConfig, snapshot: &GatewaySnapshot) -> Map<String, Value> {
    let node = &snapshot.signals.node;
    let mut status = fields_of(node);
    // The host adds it, as text.
    status.remove("run");
    status.insert("health".to_owned(), json!(health(config, node)));
    let cycle_time = config.cycle_time_us.0.span().as_micros_f64();
    status.insert("cycle_time_us".to_owned(), json!(cycle_time));
    let axes = config.axes.iter().zip(&snapshot.signals.axes);
    let axis = |(of, signals): (&PlcAxisConfig, &PlcAxisSignals)| {
        let mut axis = fields_of(signals);
        axis.insert("id".to_owned(), json!(of.id.get()));
        axis.insert("unit".to_owned(), json!(of.unit));
        (of.name.to_string(), Value::Object(axis))
    };
    status.insert("axes".to_owned(), Value::Object(axes.map(axis).collect()));
    status
}

/// Health of the gateway: the first condition that needs attention.
fn health(config: &GatewayConfig, node: &GatewaySignals) -> &'static str {
    // The connection first: without it the other figures are old.
    if !node.plc_is_up {
        "plc-away"
    } else if node.plc_is_stopped {
        "plc-stopped"
    } else if config.axes.is_empty() {
        "ok"
    } else if node.plc_runs == 0 {
        // Connected, and no index has come yet.
        "plc-silent"
    } else if !node.plc_synced {
        "starting-up"
    } else {
        "ok"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn config() -> GatewayConfig {
        let text = "name = 'press'\ncycle-time-us = 2000\n[pipe]\n\
                    [[axis]]\nid = 7\nname = 'belt'\nunit = 'mm'";
        parse("g", text).unwrap()
    }

    #[test]
    fn the_status_has_the_signals_of_the_node_and_of_each_axis() {
        let config = config();
        let mut snapshot = GatewaySnapshot::new(&config);
        snapshot.signals.axes[0].position = 1.5;
        let status = status_of(&config, &snapshot);
        let axis = json!({ "id": 7, "unit": "mm", "position": 1.5, "velocity": 0.0,
                           "acceleration": 0.0, "error_code": 0 });
        assert_eq!(status["axes"], json!({ "belt": axis }));
        assert_eq!(status["cycle_time_us"], 2000.0);
        assert_eq!(status["plc_drift_ppm"], Value::Null);
        assert!(!status.contains_key("run"));
    }

    #[test]
    fn its_health_is_the_first_thing_that_is_missing() {
        let config = config();
        let mut node = GatewaySignals::default();
        assert_eq!(health(&config, &node), "plc-away");
        node.plc_is_up = true;
        assert_eq!(health(&config, &node), "plc-silent");
        node.plc_runs = 1;
        assert_eq!(health(&config, &node), "starting-up");
        node.plc_synced = true;
        assert_eq!(health(&config, &node), "ok");
        node.plc_is_stopped = true;
        assert_eq!(health(&config, &node), "plc-stopped");
    }
}
