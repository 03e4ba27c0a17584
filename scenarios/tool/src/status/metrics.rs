//! The status as metrics, in the text format that Prometheus scrapes.
//!
//! Numbers are values of `coaxle_<what>_<signal>`, in seconds and ratios (`base_units.rs`); of words there is
//! `coaxle_<what>_<signal>{…, is="synced"} 1`. Unknown values are left out. Help and unit come from the declarations of the signals.

use std::collections::BTreeMap;
use std::fmt::Write;

use coaxle_host::client::SeenNode;
use coaxle_node::signal::{Group, Kind, Signal, Signals};
use coaxle_receiver::signals as receiver;
use coaxle_sender::signals as sender;
use serde_json::Value;

use super::base_units::MetricName;
use super::reading;
use super::reading::StatusFields;

/// A metric: its help, its type, and a line for each sample.
struct Metric {
    help: String,
    is_counter: bool,
    samples: Vec<String>,
}

/// The metrics of all nodes.
pub(super) fn of(seen: &[SeenNode]) -> String {
    let mut metrics = Metrics::default();
    for node in seen {
        // Of every node, even without a status: an alarm on `coaxle_up` must not depend on one.
        let up = f64::from(u8::from(node.is_alive));
        let labels = label("node", node.name.as_str());
        let is_up = MetricName::of("up", false);
        metrics.add(
            "coaxle_up",
            &is_up,
            "1 while the node is there.",
            &labels,
            up,
        );
        if let Some(status) = reading(node) {
            metrics.add_node(&labels, &status);
        }
    }
    metrics.text()
}

#[derive(Default)]
struct Metrics(BTreeMap<String, Metric>);

/// Parts of a status: name, metric, label.
const PARTS: [(&str, &str, &str); 4] = [
    ("far", "far", "far"),
    ("axes", "axis", "axis"),
    ("virtual_axes", "virtual_axis", "axis"),
    ("slaves", "slave", "slave"),
];

impl Metrics {
    fn add_node(&mut self, labels: &str, status: &StatusFields<'_>) {
        self.add_all("node", labels, status);
        for (part, metric, labelled) in PARTS {
            for (name, fields) in status.parts(part) {
                let unit = fields.text("unit").filter(|unit| !unit.is_empty());
                let unit =
                    unit.map_or_else(String::new, |unit| format!(",{}", label("unit", unit)));
                let labels = format!("{labels},{}{unit}", label(labelled, name));
                // A far axis names its node; a sender's axis does not.
                let metric = match fields.text("node") {
                    // Different signals under one name would mix two kinds of values in one metric.
                    Some(_) if part == "axes" => "far_axis",
                    _ => metric,
                };
                self.add_all(metric, &labels, &fields);
            }
        }
        for (name, source) in status.parts("sources") {
            let labels = format!("{labels},{}", label("far", name));
            self.add_all("source", &labels, &source);
        }
    }

    fn add_all(&mut self, of: &str, labels: &str, fields: &StatusFields<'_>) {
        let declared = declared(of);
        for (name, value) in fields.fields() {
            let signal = declared.iter().find(|signal| signal.name == name);
            let counts = signal.map_or(value.is_u64(), |signal| signal.kind == Kind::Count);
            let named = MetricName::of(name, counts);
            let metric = format!("coaxle_{of}_{}", named.name);
            let help = help(signal, &named);
            match value {
                Value::Number(number) => {
                    let number = number.as_f64().unwrap_or(f64::NAN);
                    self.add(&metric, &named, &help, labels, number * named.scale);
                }
                // Prometheus has numbers only.
                Value::Bool(is) => {
                    self.add(&metric, &named, &help, labels, f64::from(u8::from(*is)));
                }
                // Names and numbers of runs would be a new series each time.
                Value::String(_) if ["node", "unit", "epoch", "label"].contains(&name) => {}
                Value::String(text) => {
                    let labels = format!("{labels},{}", label("is", text));
                    self.add(&metric, &named, &help, &labels, 1.0);
                }
                // The code alone, which has few values: each text would be a series of its own.
                Value::Object(fault) => {
                    if let Some(code) = fault.get("code").and_then(Value::as_str) {
                        let labels = format!("{labels},{}", label("is", code));
                        self.add(&metric, &named, &help, &labels, 1.0);
                    }
                }
                // Left out instead of NaN: a gap in a chart is the truth about an unknown value.
                Value::Null | Value::Array(_) => {}
            }
        }
    }

    fn add(&mut self, name: &str, named: &MetricName, help: &str, labels: &str, value: f64) {
        let metric = self.0.entry(name.to_owned()).or_insert_with(|| Metric {
            help: help.to_owned(),
            is_counter: named.is_counter,
            samples: Vec::new(),
        });
        metric.samples.push(format!("{name}{{{labels}}} {value}"));
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (name, metric) in &self.0 {
            let Metric {
                help,
                is_counter,
                samples,
            } = metric;
            // Writing to a string cannot fail.
            let _ = writeln!(text, "# HELP {name} {}", help.replace('\\', "\\\\"));
            let kind = if *is_counter { "counter" } else { "gauge" };
            let _ = writeln!(text, "# TYPE {name} {kind}");
            // Grouped by metric, as the format demands; hence the map.
            for sample in samples {
                let _ = writeln!(text, "{sample}");
            }
        }
        text.trim_end().to_owned()
    }
}

fn label(name: &str, value: &str) -> String {
    // Backslashes first: otherwise those of the quotes would be doubled.
    let value = value.replace('\\', "\\\\").replace('"', "\\\"");
    format!("{name}=\"{}\"", value.replace('\n', "\\n"))
}

/// Meaning and unit of a signal; for other fields, where to look.
fn help(signal: Option<&Signal>, named: &MetricName) -> String {
    let unit = signal.map(|signal| named.unit.unwrap_or(signal.unit));
    match signal.zip(unit) {
        Some((signal, "")) => signal.meaning().to_owned(),
        Some((signal, unit)) => format!("{} ({unit})", signal.meaning()),
        None => "See docs/WIRE.md, Status.".to_owned(),
    }
}

fn declared(of: &str) -> Vec<Signal> {
    fn all<S: Signals>(group: Group) -> impl Iterator<Item = Signal> {
        // A wrong pair would give the help of other signals.
        debug_assert_eq!(S::GROUP, group);
        S::SIGNALS.iter().copied()
    }
    match of {
        "node" => all::<receiver::NodeSignals>(Group::Node)
            .chain(all::<sender::SenderSignals>(Group::Node))
            .collect(),
        "far" => all::<receiver::FarNodeSignals>(Group::FarNode).collect(),
        "far_axis" => all::<receiver::FarAxisSignals>(Group::FarAxis).collect(),
        "axis" => all::<sender::AxisSignals>(Group::Axis).collect(),
        "virtual_axis" => all::<receiver::VirtualAxisSignals>(Group::VirtualAxis).collect(),
        "slave" => all::<receiver::SlaveSignals>(Group::Slave).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::samples::{RECEIVER, SENDER, object};
    use coaxle_clock::Instant;
    use coaxle_node::keys::NodeName;

    fn metrics() -> String {
        let node = |name: &str, json: &str| SeenNode {
            name: NodeName::new(name).unwrap(),
            is_alive: true,
            status: Some((Instant::EPOCH, object(json))),
        };
        of(&[node("conveyor", SENDER), node("saw", RECEIVER)])
    }

    #[test]
    fn numbers_flags_words_and_faults_are_metrics() {
        let text = metrics();
        for expected in [
            "coaxle_up{node=\"saw\"} 1",
            "coaxle_node_cycles_total{node=\"conveyor\"} 25245",
            "coaxle_node_error{node=\"saw\",is=\"0x4B52\"} 1",
            "coaxle_far_drift_ratio{node=\"saw\",far=\"conveyor\"} 0.0005001",
            "coaxle_far_synced{node=\"saw\",far=\"conveyor\"} 1",
            "coaxle_far_observer_state{node=\"saw\",far=\"conveyor\",is=\"synced\"} 1",
            "coaxle_source_frame_age_seconds{node=\"saw\",far=\"conveyor\"} 0.00041",
            "coaxle_axis_velocity{node=\"conveyor\",axis=\"conveyor\",unit=\"mm\"} 500",
            "coaxle_far_axis_corrected_position{node=\"saw\",axis=\"conveyor.3\",unit=\"mm\"} 12597.89375",
            "coaxle_slave_program_step{node=\"saw\",slave=\"slave\",unit=\"mm\"} 2",
            "# HELP coaxle_far_drift_ratio Estimated drift of its clock against the own one (`fDrift`).",
        ] {
            assert!(
                text.lines().any(|line| line == expected),
                "{expected}\n{text}"
            );
        }
    }

    #[test]
    fn each_metric_has_one_head_and_lines_as_the_format_has_them() {
        let text = metrics();
        let mut heads = Vec::new();
        for line in text.lines() {
            if let Some(head) = line.strip_prefix("# TYPE ") {
                heads.push(head.to_owned());
            } else if !line.starts_with('#') {
                let (name, rest) = line.split_once('{').unwrap();
                let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
                assert!(name.chars().all(is_plain), "{line}");
                let (_, value) = rest.rsplit_once("} ").unwrap();
                assert!(value.parse::<f64>().is_ok(), "{line}");
            }
        }
        let all = heads.len();
        heads.dedup();
        assert_eq!(heads.len(), all);
    }

    #[test]
    fn counts_and_other_numbers_have_their_types() {
        let text = metrics();
        for head in [
            "# TYPE coaxle_up gauge",
            "# TYPE coaxle_far_lost_total counter",
            "# TYPE coaxle_far_delay_seconds gauge",
            "# TYPE coaxle_slave_program_step gauge",
            "# TYPE coaxle_far_observer_state gauge",
        ] {
            assert!(text.lines().any(|line| line == head), "{head}\n{text}");
        }
    }

    #[test]
    fn dashboard_and_alerts_ask_for_metrics_that_there_are() {
        let of_host = ["up", "node_cycles_total", "source_frame_age_seconds"];
        let of_host = of_host.map(str::to_owned);
        let declared = ["node", "far", "slave"].into_iter().flat_map(|of| {
            let names = declared(of).into_iter().map(move |signal| {
                let counts = signal.kind == Kind::Count;
                format!("{of}_{}", MetricName::of(signal.name, counts).name)
            });
            names.collect::<Vec<_>>()
        });
        let known: Vec<_> = declared.chain(of_host).collect();
        for asking in [
            include_str!("../../../../docs/grafana-dashboard.json"),
            include_str!("../../../../docs/prometheus-alerts.yml"),
        ] {
            let is_of_a_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let names = asking.split(|c| !is_of_a_name(c));
            let names = names.filter_map(|name| name.strip_prefix("coaxle_"));
            let names: Vec<_> = names.collect();
            assert!(names.len() > 5, "{names:?}");
            for name in names {
                assert!(known.iter().any(|known| known == name), "{name}");
            }
        }
    }

    #[test]
    fn names_cannot_end_a_label() {
        assert_eq!(label("axis", "a\"b\\c\nd"), r#"axis="a\"b\\c\nd""#);
    }
}
