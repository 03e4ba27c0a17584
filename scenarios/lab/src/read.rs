//! A scenario file, read and checked.

use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::path::Path;

use coaxle_node::CommandOrder;
use coaxle_node::config::{ConfigError, Unit, did_you_mean, from_table};
use coaxle_node::faults::{WrongTerm, check_link};
use coaxle_node::fields_of;
use coaxle_node::keys::NodeName;
use coaxle_receiver::{Drives, ReceiverConfig, SlaveConfig};
use coaxle_sender::config::ShownAxes;
use serde_json::{Map, Value};

use crate::event::{Action, Event, EventKind};
use crate::expect::{Expectation, receiver_of};
use crate::group;
use crate::invariants::Exception;
use crate::layout::ScenarioLayout;
use crate::scenario::Scenario;
use crate::summary::{ReceiverSummary, RouterSummary, SlaveSummary};
use crate::topology::{ReceiverAxis, Root, Topology};

/// Reads and checks a scenario. `file` is its name in errors.
///
/// # Errors
/// [`ConfigError`] names the file, the field, what was received and what is expected.
pub fn scenario(file: &str, table: toml::Table) -> Result<Scenario, ConfigError> {
    let mut table = table;
    let origins = group::expand(file, &mut table)?;
    written_out(file, table).map_err(|error| origins.in_file(error))
}

/// Reads and checks a scenario without groups.
fn written_out(file: &str, table: toml::Table) -> Result<Scenario, ConfigError> {
    let mut scenario: Scenario = from_table(file, table)?;
    // Before the topology, whose cost grows with the square of the nodes.
    let count = scenario.check_count();
    count.map_err(|(field, reason)| ConfigError::field(file, field, reason))?;
    // Files are named relative to the scenario, wherever the tool is run.
    if let Some(folder) = Path::new(file).parent() {
        for sender in &mut scenario.senders {
            sender.relative_to(folder);
        }
        for receiver in &mut scenario.receivers {
            receiver.relative_to(folder);
        }
        scenario.network.relative_to(folder);
        scenario.timing_network.relative_to(folder);
        let links = scenario.routers.iter_mut();
        let links = links.filter_map(|router| router.link.as_mut());
        links.for_each(|link| link.relative_to(folder));
    }
    let topology = Topology::of(&scenario).map_err(|wrong| wrong.in_file(file))?;
    ScenarioLayout::of(&scenario, &topology).map_err(|wrong| wrong.in_file(file))?;
    tell_units(&mut scenario, &topology);
    show_followed_axes(&mut scenario, &topology, file)?;
    check_events(&scenario, &topology, file)?;
    check_expectations(&scenario, &topology, file)?;
    check_exceptions(&scenario, file)?;
    // Last, as nodes are built for it: the errors before are cheaper and name single fields.
    check_nodes(&scenario, file)?;
    Ok(scenario)
}

/// Sets the units of far axes that a receiver's config does not have.
fn tell_units(scenario: &mut Scenario, topology: &Topology) {
    // A receiver may follow one that comes later in the file: each pass resolves one step more.
    for _ in 0..scenario.receivers.len() {
        for view in topology.views() {
            let ReceiverAxis::Far { axis, .. } = view.of else {
                continue;
            };
            let unit = unit_of_source(scenario, view.receiver, axis, &view.root);
            // A unit that is not known yet must not replace one of an earlier pass.
            if unit != Unit::default() {
                scenario.receivers[view.receiver].far_axis_is_in(axis, unit);
            }
        }
    }
}

fn unit_of_source(scenario: &Scenario, receiver: usize, axis: usize, root: &Root) -> Unit {
    let far = scenario.receivers[receiver].far_axes().nth(axis);
    let id = far.map(|(_, _, axis)| axis.id);
    let source = root.source;
    let unit = match source.checked_sub(scenario.senders.len()) {
        None => {
            let mut axes = scenario.senders[source].axes.iter();
            axes.find(|axis| Some(axis.id.get()) == id)
                .map(|axis| axis.unit.clone())
        }
        Some(followed) => {
            let followed = &scenario.receivers[followed];
            let slave = id.and_then(|id| followed.slave_with_id(id));
            slave.map(|slave| followed.slave_unit(slave))
        }
    };
    unit.unwrap_or_default()
}

/// Shows every followed axis, which the evaluation needs.
fn show_followed_axes(
    scenario: &mut Scenario,
    topology: &Topology,
    file: &str,
) -> Result<(), ConfigError> {
    for (n, sender) in scenario.senders.iter_mut().enumerate() {
        let axes = (topology.views().iter())
            .flat_map(|view| std::iter::once(&view.root).chain(&view.standbys))
            // Standbys are shown, too: after a take-over they are the truth.
            .filter(|root| root.node == n)
            .filter_map(|root| NonZeroU32::new(root.axis))
            .collect::<BTreeSet<_>>();
        sender.show_axes = ShownAxes::new(axes.into_iter().collect()).map_err(|wrong| {
            ConfigError::field(file, format!("sender[{n}]: axes with receivers"), wrong)
        })?;
    }
    Ok(())
}

fn check_events(scenario: &Scenario, topology: &Topology, file: &str) -> Result<(), ConfigError> {
    for (n, event) in scenario.events.iter().enumerate() {
        check_event_of_router(scenario, event).map_err(|(field, reason)| {
            ConfigError::field(file, format!("event[{n}].{field}"), reason)
        })?;
        if scenario.router(&event.node).is_some() {
            continue;
        }
        if topology.node(&event.node).is_none() {
            let nodes = topology.names().iter().map(NodeName::as_str);
            let reason = format!(
                "received {:?}, expected a node of this scenario{}",
                event.node.as_str(),
                did_you_mean(event.node.as_str(), nodes)
            );
            return Err(ConfigError::field(file, format!("event[{n}].node"), reason));
        }
        check_addressee(scenario, event).map_err(|(field, reason)| {
            ConfigError::field(file, format!("event[{n}].{field}"), reason)
        })?;
    }
    Ok(())
}

/// Checks that a router goes away and comes back, and does nothing else.
fn check_event_of_router(scenario: &Scenario, event: &Event) -> Result<(), (&'static str, String)> {
    let (field, received) = match &event.what {
        _ if scenario.router(&event.node).is_none() => return Ok(()),
        EventKind::Away {
            action: Action::Restart | Action::Freeze,
            ..
        } => return Ok(()),
        EventKind::Away {
            action: Action::Twin,
            ..
        } => ("action", "twin"),
        EventKind::Away {
            action: Action::Stop,
            ..
        } => ("action", "stop"),
        EventKind::Command(_) => ("command", "a command"),
    };
    let reason = format!("received {received} for a router, expected action restart or freeze");
    Err((field, reason))
}

/// Checks that the addressee of a command exists.
fn check_addressee(scenario: &Scenario, event: &Event) -> Result<(), (&'static str, String)> {
    let EventKind::Command(commanded) = &event.what else {
        return Ok(());
    };
    let receivers = scenario.receivers.iter();
    let told = receivers.filter(|receiver| receiver.name == event.node);
    let slaves = |config: &ReceiverConfig| names(config.slaves.iter().map(|slave| &slave.name));
    let far = |config: &ReceiverConfig| names(config.far.iter().map(|far| &far.node));
    let (field, what, known): (_, _, Vec<_>) = match commanded.order {
        CommandOrder::Slave(_) | CommandOrder::Plate(_) => {
            ("slave", "a slave of", told.flat_map(slaves).collect())
        }
        CommandOrder::Far(_) => ("far", "a node followed by", told.flat_map(far).collect()),
    };
    let received = commanded.order.addressee();
    if known.iter().any(|name| name == received) {
        return Ok(());
    }
    let meant = did_you_mean(received, known.iter().map(String::as_str));
    let (node, known) = (&event.node, known.join(", "));
    let reason = format!("received {received:?}, expected {what} {node}: {known}{meant}");
    Err((field, reason))
}

fn names<'a>(names: impl Iterator<Item = &'a NodeName>) -> Vec<String> {
    names.map(ToString::to_string).collect()
}

fn check_expectations(
    scenario: &Scenario,
    topology: &Topology,
    file: &str,
) -> Result<(), ConfigError> {
    let judged: Vec<_> = topology.views().iter().map(|v| v.name.as_str()).collect();
    for (n, expectation) in scenario.expectations.iter().enumerate() {
        check_expectation(expectation, scenario, &judged).map_err(|(field, reason)| {
            ConfigError::field(file, format!("expect[{n}].{field}"), reason)
        })?;
    }
    Ok(())
}

/// Checks that an expectation can be judged, among the names that have figures. Returns the wrong field and
/// the reason.
fn check_expectation(
    expectation: &Expectation,
    scenario: &Scenario,
    judged: &[&str],
) -> Result<(), (&'static str, String)> {
    if let Some(router) = &expectation.router {
        return check_expectation_of_router(router, expectation, scenario);
    }
    // In the order of `nodes`: the receiver, then the one it is compared with.
    for (name, field) in expectation.nodes().zip(["receiver", "at-most-share.of"]) {
        if !judged.contains(&name) {
            return Err((field, unknown(name, judged)));
        }
    }
    let fields = match &expectation.slave {
        None => fields_of(&ReceiverSummary::default()),
        Some(name) => {
            let of_slave = |slave: &SlaveConfig| slave.name.as_str() == name;
            for node in expectation.nodes() {
                let node = receiver_of(node);
                let receiver = scenario.receivers.iter().find(|r| r.name.as_str() == node);
                if !receiver.is_some_and(|r| r.slaves.iter().any(of_slave)) {
                    let slaves = receiver.iter().flat_map(|r| &r.slaves);
                    let known: Vec<_> = slaves.map(|slave| slave.name.as_str()).collect();
                    let meant = did_you_mean(name, known.iter().copied());
                    let known = known.join(", ");
                    let reason =
                        format!("received {name:?}, expected a slave of {node}: {known}{meant}");
                    return Err(("slave", reason));
                }
            }
            fields_of(&SlaveSummary::default())
        }
    };
    check_bound(expectation, &fields)
}

fn check_expectation_of_router(
    router: &str,
    expectation: &Expectation,
    scenario: &Scenario,
) -> Result<(), (&'static str, String)> {
    let known = scenario.routers.iter();
    let known: Vec<_> = known.map(|router| router.name.as_str()).collect();
    if !known.contains(&router) {
        return Err(("router", unknown(router, &known)));
    }
    let is_of_a_receiver = !expectation.receiver.is_empty() || expectation.slave.is_some();
    if is_of_a_receiver || expectation.at_most_share.is_some() {
        let reason = "received receiver, slave or at-most-share besides, expected router alone";
        return Err(("router", reason.to_owned()));
    }
    check_bound(expectation, &fields_of(&RouterSummary::default()))
}

/// Checks that the field exists, and that the expectation has a bound.
fn check_bound(
    expectation: &Expectation,
    fields: &Map<String, Value>,
) -> Result<(), (&'static str, String)> {
    if !fields.contains_key(&expectation.field) {
        let known: Vec<_> = fields.keys().map(String::as_str).collect();
        return Err(("field", unknown(&expectation.field, &known)));
    }
    if expectation.has_bound() {
        Ok(())
    } else {
        let reason = "expected at least one of at-most, at-least, equals, at-most-share";
        Err(("field", reason.to_owned()))
    }
}

/// The error about an unknown name, with the known ones.
fn unknown(received: &str, known: &[&str]) -> String {
    let meant = did_you_mean(received, known.iter().copied());
    let known = known.join(", ");
    format!("received {received:?}, expected one of: {known}{meant}")
}

fn check_exceptions(scenario: &Scenario, file: &str) -> Result<(), ConfigError> {
    for (n, exception) in scenario.exceptions.iter().enumerate() {
        check_exception(exception, scenario).map_err(|(field, reason)| {
            ConfigError::field(file, format!("exception[{n}].{field}"), reason)
        })?;
    }
    Ok(())
}

/// Checks that the part of an exception exists. Returns the wrong field and the reason.
fn check_exception(
    exception: &Exception,
    scenario: &Scenario,
) -> Result<(), (&'static str, String)> {
    let Exception {
        receiver, of, from, ..
    } = exception;
    let unknown = |received: &str, known: Vec<String>| {
        let known: Vec<_> = known.iter().map(String::as_str).collect();
        unknown(received, &known)
    };
    let receivers = &scenario.receivers;
    let Some(config) = receivers
        .iter()
        .find(|known| known.name.as_str() == receiver)
    else {
        let known = names(receivers.iter().map(|known| &known.name));
        return Err(("receiver", unknown(receiver, known)));
    };
    let mut known = names(config.slaves.iter().map(|slave| &slave.name));
    known.extend(config.far_axis_names());
    known.extend(names(config.received_nodes().iter().map(|node| node.node)));
    known.push(receiver.clone());
    if !known.contains(of) {
        return Err(("of", unknown(of, known)));
    }
    if from.is_empty() {
        let reason = "expected at least one of the invariants".to_owned();
        return Err(("from", reason));
    }
    Ok(())
}

/// Checks that every node is able to start: its parameters are checked where they are used.
fn check_nodes(scenario: &Scenario, file: &str) -> Result<(), ConfigError> {
    let start = coaxle_clock::Instant::EPOCH;
    let wrong_file = |wrong: WrongTerm| ConfigError::field(file, wrong.field(), wrong.reason());
    let network = check_link(&scenario.network);
    network.map_err(|wrong| wrong_file(wrong.within("network")))?;
    let network = check_link(&scenario.timing_network);
    network.map_err(|wrong| wrong_file(wrong.within("timing-network")))?;
    for (n, sender) in scenario.senders.iter().enumerate() {
        let files = sender.check_files();
        files.map_err(|wrong| wrong_file(wrong.within(&format!("sender[{n}]"))))?;
        coaxle_sender::Sender::new(sender, start, 0)
            .map_err(|wrong| ConfigError::field(file, format!("sender[{n}]"), wrong))?;
    }
    for (n, receiver) in scenario.receivers.iter().enumerate() {
        let files = receiver.check_files();
        files.map_err(|wrong| wrong_file(wrong.within(&format!("receiver[{n}]"))))?;
        coaxle_receiver::Receiver::with_drives(receiver, Drives::simulated(), start, 0)
            .map_err(|wrong| ConfigError::field(file, format!("receiver[{n}]"), wrong))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEHIND_A_ROUTER: &str = "title = 't'\nduration-s = 1\n[[router]]\nname = 'hall'\nnodes = ['*']\n\
        [[sender]]\nname = 'belt'\ncycle-time-us = 1000\n[[sender.axis]]\nid = 1\nname = 'belt'\n\
        [sender.axis.program]\nstart-velocity = 1.0\nlimits = { velocity = 2.0, acceleration = 1.0, jerk = 1.0 }\n\
        [[receiver]]\nname = 'saw'\ncycle-time-us = 1000\nmaster.node = 'belt'\n";

    fn read(rest: &str) -> Result<Scenario, String> {
        let text = format!("{BEHIND_A_ROUTER}{rest}");
        let table = text.parse().expect("TOML");
        scenario("t.toml", table).map_err(|error| error.to_string())
    }

    #[test]
    fn an_action_that_no_router_has_is_named_as_received() {
        for action in ["twin", "stop"] {
            let event =
                format!("[[event]]\nat-s = 0.5\nnode = 'hall'\naction = '{action}'\nfor-s = 0.1\n");
            let error = read(&event).unwrap_err();
            let expected =
                format!("received {action} for a router, expected action restart or freeze");
            assert!(error.contains(&expected), "{error}");
        }
    }

    #[test]
    fn an_exception_may_be_of_a_far_node_and_of_the_receiver_itself() {
        let exception = |of: &str| {
            read(&format!(
                "[[exception]]\nreceiver = 'saw'\nof = '{of}'\nfrom = ['messages']\nreason = 'it shows it'\n"
            ))
        };
        for of in ["belt", "belt.1", "saw"] {
            assert!(exception(of).is_ok(), "{of}: {:?}", exception(of));
        }
        let error = exception("nobody").unwrap_err();
        assert!(
            error.contains("exception[0].of: received \"nobody\""),
            "{error}"
        );
    }
}
