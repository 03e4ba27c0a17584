//! Changes in the status of a node, as events.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use crate::part::{PartKind, StatusText};

/// Event of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Occurrence {
    /// Path of its object: `saw`, `saw/slaves/carriage`.
    pub path: String,
    /// Severity of OPC UA, from 1 to 1000.
    pub severity: u16,
    /// The event in words.
    pub message: String,
}

/// Severities: part 5 of OPC UA has five bands.
const HIGH: u16 = 900;
const MEDIUM: u16 = 500;
const LOW: u16 = 100;

/// Healths in which the node does what it is configured for.
const WELL: [&str; 2] = ["ok", "on-standby"];

/// Difference from which two ages are those of two faults.
// Ages are taken from two clocks four times a second.
const SAME_FAULT_S: f64 = 1.0;

/// State of a node as its status has it, and the changes of it.
#[derive(Clone, Debug, Default)]
pub struct StatusWatch {
    is_alive: Option<bool>,
    health: Option<String>,
    /// Faults that are present, by the path of the object and the field.
    faults: BTreeMap<(String, &'static str), String>,
    /// Text of the last fault, and its time since the start of the node, s.
    last_fault: Option<(String, f64)>,
    is_known: bool,
}

impl StatusWatch {
    /// Takes the state of a node. Returns the events since the last call.
    pub fn take(
        &mut self,
        node: &str,
        is_alive: bool,
        status: Option<&Map<String, Value>>,
    ) -> Vec<Occurrence> {
        let mut events = Vec::new();
        let mut add = |path: &str, severity, message: String| {
            events.push(Occurrence {
                path: path.to_owned(),
                severity,
                message,
            });
        };
        if self
            .is_alive
            .replace(is_alive)
            .is_some_and(|was| was != is_alive)
        {
            match is_alive {
                true => add(node, LOW, format!("{node} is there again")),
                false => add(node, HIGH, format!("{node} is gone")),
            }
        }
        let Some(status) = status else {
            return events;
        };
        self.take_health(node, status, &mut add);
        self.take_faults(node, status, &mut add);
        self.take_last_fault(node, status, &mut add);
        self.is_known = true;
        events
    }

    fn take_health(
        &mut self,
        node: &str,
        status: &Map<String, Value>,
        add: &mut impl FnMut(&str, u16, String),
    ) {
        let Some(health) = status.get("health").and_then(Value::as_str) else {
            return;
        };
        let before = self.health.replace(health.to_owned());
        let is_well = WELL.contains(&health);
        let severity = if is_well { LOW } else { HIGH };
        match before {
            Some(before) if before != health => {
                add(
                    node,
                    severity,
                    format!("health of {node}: {before} → {health}"),
                );
            }
            // A client that connects later reads the variable; at the start good news are none.
            None if !is_well => add(node, severity, format!("health of {node}: {health}")),
            _ => {}
        }
    }

    fn take_faults(
        &mut self,
        node: &str,
        status: &Map<String, Value>,
        add: &mut impl FnMut(&str, u16, String),
    ) {
        let present = present_faults(node, status);
        for (of, text) in &present {
            if self.faults.get(of) != Some(text) {
                add(&of.0, HIGH, format!("{} of {}: {text}", of.1, of.0));
            }
        }
        for (of, text) in &self.faults {
            if !present.contains_key(of) {
                add(&of.0, LOW, format!("{} of {} is over: {text}", of.1, of.0));
            }
        }
        self.faults = present;
    }

    fn take_last_fault(
        &mut self,
        node: &str,
        status: &Map<String, Value>,
        add: &mut impl FnMut(&str, u16, String),
    ) {
        let number = |of: &Map<String, Value>, name: &str| of.get(name).and_then(Value::as_f64);
        let fault = status.get("last_fault").and_then(Value::as_object);
        let now = fault.and_then(|fault| {
            let text = fault.get("text")?.as_str()?.to_owned();
            let at = number(status, "uptime_s")? - number(fault, "age_s")?;
            Some((text, at))
        });
        let is_new = match (&now, &self.last_fault) {
            (Some((text, at)), Some((before, was_at))) => {
                text != before || (at - was_at).abs() > SAME_FAULT_S
            }
            (Some(_), None) => true,
            (None, _) => false,
        };
        // One from before the server was there is history, which it has none of.
        if let Some((text, _)) = now.as_ref().filter(|_| is_new && self.is_known) {
            add(node, MEDIUM, format!("fault of {node}: {text}"));
        }
        self.last_fault = now.or_else(|| self.last_fault.take());
    }
}

/// Value of a variable from the status of its node. `part` is the object's part of it.
#[must_use]
pub fn status_text(text: StatusText, part: Option<&Map<String, Value>>) -> Option<String> {
    let part = part?;
    match text {
        StatusText::Alive => None,
        StatusText::Health => part.get("health")?.as_str().map(str::to_owned),
        StatusText::Fault(field) => fault_text(part.get(field)?),
    }
}

/// The part of a status that an object shows.
#[must_use]
pub fn status_part<'s>(
    status: &'s Map<String, Value>,
    kind: PartKind,
    name: &str,
) -> Option<&'s Map<String, Value>> {
    match kind {
        PartKind::Node => Some(status),
        kind => status.get(kind.folder())?.get(name)?.as_object(),
    }
}

fn fault_text(fault: &Value) -> Option<String> {
    let fault = fault.as_object()?;
    let text = fault
        .get("text")
        .and_then(Value::as_str)
        .unwrap_or_default();
    match fault.get("code").and_then(Value::as_str) {
        // Texts of refusals begin with their code already.
        Some(code) if !text.contains(code) => Some(format!("{code}: {text}")),
        _ => Some(text.to_owned()),
    }
}

fn present_faults(
    node: &str,
    status: &Map<String, Value>,
) -> BTreeMap<(String, &'static str), String> {
    let mut present = BTreeMap::new();
    let mut add = |path: &str, kind: PartKind, of: &Map<String, Value>| {
        // The last fault of a node may be over: it is an event of its own.
        for field in kind.faults().filter(|field| *field != "last_fault") {
            if let Some(text) = of.get(field).and_then(fault_text) {
                present.insert((path.to_owned(), field), text);
            }
        }
    };
    add(node, PartKind::Node, status);
    for kind in [PartKind::FarNode, PartKind::VirtualAxis, PartKind::Slave] {
        let parts = status.get(kind.folder()).and_then(Value::as_object);
        for (name, part) in parts.into_iter().flatten() {
            if let Some(part) = part.as_object() {
                add(&format!("{node}/{}/{name}", kind.folder()), kind, part);
            }
        }
    }
    present
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn take(watch: &mut StatusWatch, status: &Value) -> Vec<(String, String)> {
        let events = watch.take("saw", true, status.as_object());
        events
            .into_iter()
            .map(|event| (event.path, event.message))
            .collect()
    }

    fn event(path: &str, message: &str) -> (String, String) {
        (path.to_owned(), message.to_owned())
    }

    #[test]
    fn changes_of_health_and_faults_are_events_and_what_stays_is_none() {
        let mut watch = StatusWatch::default();
        let well = json!({ "health": "ok", "uptime_s": 10.0, "slaves": { "carriage": { "error": null } } });
        assert_eq!(take(&mut watch, &well), []);
        let failed = json!({
            "health": "slave-failed", "uptime_s": 11.0,
            "slaves": { "carriage": { "error": { "code": "0x4550", "text": "following error" } } },
        });
        let expected = [
            event("saw", "health of saw: ok → slave-failed"),
            event(
                "saw/slaves/carriage",
                "error of saw/slaves/carriage: 0x4550: following error",
            ),
        ];
        assert_eq!(take(&mut watch, &failed), expected);
        assert_eq!(take(&mut watch, &failed), []);
        assert_eq!(take(&mut watch, &well).len(), 2);
    }

    #[test]
    fn a_last_fault_is_an_event_once_and_one_of_before_is_none() {
        let mut watch = StatusWatch::default();
        let lost = |uptime: f64, age: f64| json!({ "uptime_s": uptime, "last_fault": { "age_s": age, "text": "3 frames were lost" } });
        assert_eq!(take(&mut watch, &lost(100.0, 50.0)), []);
        assert_eq!(take(&mut watch, &lost(101.0, 51.01)), []);
        let again = [event("saw", "fault of saw: 3 frames were lost")];
        assert_eq!(take(&mut watch, &lost(103.0, 0.5)), again);
        assert_eq!(take(&mut watch, &lost(103.5, 1.0)), []);
    }

    #[test]
    fn a_node_that_goes_and_comes_is_two_events() {
        let mut watch = StatusWatch::default();
        assert_eq!(watch.take("saw", true, None), []);
        assert_eq!(watch.take("saw", false, None)[0].message, "saw is gone");
        assert_eq!(watch.take("saw", true, None)[0].severity, LOW);
    }
}
