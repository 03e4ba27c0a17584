//! A receiver's part of the status: its signals, nested by subject, and faults in words.
//! `docs/WIRE.md` describes it.

use coaxle_node::circles::AxisAddress;
use coaxle_node::fields_of;
use coaxle_node::signal::{Group, Instance};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::fault::Fault;
use crate::config::ReceiverConfig;
use crate::health::HealthName;
use crate::snapshot::{ReceiverSnapshot, SignalRow};

/// The status of a receiver that has not run a cycle yet, and so has not evaluated its masters.
pub(super) fn before_the_first_cycle() -> Map<String, Value> {
    let health = HealthName::WaitingForMaster.name();
    Map::from_iter([("health".to_owned(), health.into())])
}

/// The status after a cycle.
pub(super) fn of(config: &ReceiverConfig, snapshot: &ReceiverSnapshot) -> Map<String, Value> {
    let instances = config.instances();
    let SignalRow {
        node,
        far,
        axes,
        virtual_axes,
        slaves,
    } = &snapshot.signals;
    let mut status = fields_of(node);
    let cycle_time = config.cycle_time_us.0.span().as_micros_f64();
    status.insert("cycle_time_us".to_owned(), json!(cycle_time));
    status.insert("error".to_owned(), json!(Fault::of(snapshot)));
    // By the order of the config, which instances and signals share.
    let mut far = named(&instances, Group::FarNode, far);
    for ((n, (_, status)), heard) in far.iter_mut().enumerate().zip(config.received_nodes()) {
        let of = (heard.place > 0).then(|| &config.far[heard.far].node);
        put(status, "standby_of", json!(of));
        put(status, "error", json!(Fault::of_far(snapshot, n)));
        put(status, "warning", json!(Fault::of_warning(snapshot, n)));
    }
    let mut axes = named(&instances, Group::FarAxis, axes);
    let published = config.published_far_axes();
    for (n, ((_, far, axis), (_, status))) in config.far_axes().zip(axes.iter_mut()).enumerate() {
        put(status, "node", json!(far.node));
        put(status, "id", json!(axis.id));
        let place = published.iter().position(|axis| *axis == n);
        put(status, "published_id", json!(place.map(|place| place + 1)));
        put(status, "follows", addresses(&config.addresses_of(n)));
    }
    let mut virtual_axes = named(&instances, Group::VirtualAxis, virtual_axes);
    for (n, (_, status)) in virtual_axes.iter_mut().enumerate() {
        put(status, "id", json!(config.virtual_axes[n].id));
        // Replaces the code of the signal, which a reader would have to look up.
        let code = snapshot.signals.virtual_axes[n].error;
        put(status, "error", json!(Fault::of_virtual_axis(code)));
    }
    let mut slaves = named(&instances, Group::Slave, slaves);
    for (n, (_, status)) in slaves.iter_mut().enumerate() {
        let faults = &snapshot.faults[n];
        put(status, "id", json!(config.slave_id(n)));
        put(
            status,
            "follows",
            addresses(&config.far_masters_of_slave(n)),
        );
        put(status, "error", json!(Fault::of_slave(faults)));
        put(status, "refusal", json!(Fault::of_refusal(faults)));
        put(status, "program_error", json!(Fault::of_program(faults)));
        let step = snapshot.signals.slaves[n].program_step.unwrap_or_default();
        let step = config.slaves[n]
            .steps
            // Steps count from 1. Without a step the 0 wraps to a place that no list has.
            .get(usize::from(step).wrapping_sub(1));
        put(
            status,
            "label",
            json!(step.and_then(|step| step.label.as_deref())),
        );
    }
    for (group, of) in [
        ("far", far),
        ("axes", axes),
        ("virtual_axes", virtual_axes),
        ("slaves", slaves),
    ] {
        status.insert(group.to_owned(), Value::Object(Map::from_iter(of)));
    }
    status
}

/// The signals of one group, by the names of its instances.
fn named(instances: &[Instance], group: Group, signals: &[impl Serialize]) -> Vec<(String, Value)> {
    let of_group = instances.iter().filter(|instance| instance.group == group);
    let status = |(instance, signals): (&Instance, _)| {
        let mut status = Value::Object(fields_of(signals));
        if matches!(group, Group::FarAxis | Group::VirtualAxis | Group::Slave) {
            put(&mut status, "unit", json!(instance.unit));
        }
        (instance.name.clone(), status)
    };
    of_group.zip(signals).map(status).collect()
}

/// Replaces a signal that is a code by its text.
fn put(status: &mut Value, field: &str, value: Value) {
    status[field] = value;
}

fn addresses(of: &[AxisAddress]) -> Value {
    of.iter()
        .map(|address| json!(address.to_string()))
        .collect()
}
