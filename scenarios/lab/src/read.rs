//! A scenario file, read and checked.

use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::path::Path;

use coaxle_node::CommandOrder;
use coaxle_node::config::{ConfigError, Unit, Wrong, did_you_mean, from_table};
use coaxle_node::faults::check_link;
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
use crate::topology::{ReceiverAxis, Root, Topology, unknown_node};

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
    completed(scenario).map_err(|wrong| wrong.in_file(file))
}

/// Checks a scenario, and completes it with units and with the axes that its evaluation needs.
fn completed(mut scenario: Scenario) -> Result<Scenario, Wrong> {
    // Before the topology, whose cost grows with the square of the nodes.
    scenario.check_count()?;
    let topology = Topology::of(&scenario)?;
    ScenarioLayout::of(&scenario, &topology)?;
    tell_units(&mut scenario, &topology);
    show_followed_axes(&mut scenario, &topology)?;
    check_events(&scenario, &topology)?;
    check_expectations(&scenario, &topology)?;
    check_exceptions(&scenario)?;
    // Last, as nodes are built for it: the errors before are cheaper and name single fields.
    check_nodes(&scenario)?;
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
fn show_followed_axes(scenario: &mut Scenario, topology: &Topology) -> Result<(), Wrong> {
    for (n, sender) in scenario.senders.iter_mut().enumerate() {
        let axes = (topology.views().iter())
            .flat_map(|view| std::iter::once(&view.root).chain(&view.standbys))
            // Standbys are shown, too: after a take-over they are the truth.
            .filter(|root| root.node == n)
            .filter_map(|root| NonZeroU32::new(root.axis))
            .collect::<BTreeSet<_>>();
        sender.show_axes = ShownAxes::new(axes.into_iter().collect())
            .map_err(|wrong| wrong.within(format_args!("sender[{n}]: axes with receivers")))?;
    }
    Ok(())
}

fn check_events(scenario: &Scenario, topology: &Topology) -> Result<(), Wrong> {
    for (n, event) in scenario.events.iter().enumerate() {
        check_event(scenario, topology, event)
            .map_err(|wrong| wrong.within(format_args!("event[{n}]")))?;
    }
    Ok(())
}

fn check_event(scenario: &Scenario, topology: &Topology, event: &Event) -> Result<(), Wrong> {
    check_event_of_router(scenario, event)?;
    if scenario.router(&event.node).is_some() {
        return Ok(());
    }
    if topology.node(&event.node).is_none() {
        let nodes = topology.names().iter().map(NodeName::as_str);
        return Err(unknown_node(&event.node, nodes));
    }
    check_addressee(scenario, event)
}

/// Checks that a router goes away and comes back, and does nothing else.
fn check_event_of_router(scenario: &Scenario, event: &Event) -> Result<(), Wrong> {
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
    let received = format!("{received} for a router");
    Err(Wrong::of(field, received, "action restart or freeze"))
}

/// Checks that the addressee of a command exists.
fn check_addressee(scenario: &Scenario, event: &Event) -> Result<(), Wrong> {
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
    let expected = format!("{what} {node}: {known}{meant}");
    Err(Wrong::of(field, format_args!("{received:?}"), expected))
}

fn names<'a>(names: impl Iterator<Item = &'a NodeName>) -> Vec<String> {
    names.map(ToString::to_string).collect()
}

fn check_expectations(scenario: &Scenario, topology: &Topology) -> Result<(), Wrong> {
    let judged: Vec<_> = topology.views().iter().map(|v| v.name.as_str()).collect();
    for (n, expectation) in scenario.expectations.iter().enumerate() {
        check_expectation(expectation, scenario, &judged)
            .map_err(|wrong| wrong.within(format_args!("expect[{n}]")))?;
    }
    Ok(())
}

/// Checks that an expectation can be judged, among the names that have figures.
fn check_expectation(
    expectation: &Expectation,
    scenario: &Scenario,
    judged: &[&str],
) -> Result<(), Wrong> {
    if let Some(router) = &expectation.router {
        return check_expectation_of_router(router, expectation, scenario);
    }
    // In the order of `nodes`: the receiver, then the one it is compared with.
    for (name, field) in expectation.nodes().zip(["receiver", "at-most-share.of"]) {
        if !judged.contains(&name) {
            return Err(unknown(field, name, judged));
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
                    let expected = format!("a slave of {node}: {}{meant}", known.join(", "));
                    return Err(Wrong::of("slave", format_args!("{name:?}"), expected));
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
) -> Result<(), Wrong> {
    let known = scenario.routers.iter();
    let known: Vec<_> = known.map(|router| router.name.as_str()).collect();
    if !known.contains(&router) {
        return Err(unknown("router", router, &known));
    }
    let is_of_a_receiver = !expectation.receiver.is_empty() || expectation.slave.is_some();
    if is_of_a_receiver || expectation.at_most_share.is_some() {
        let received = "receiver, slave or at-most-share besides";
        return Err(Wrong::of("router", received, "router alone"));
    }
    check_bound(expectation, &fields_of(&RouterSummary::default()))
}

/// Checks that the field exists, and that the expectation has a bound.
fn check_bound(expectation: &Expectation, fields: &Map<String, Value>) -> Result<(), Wrong> {
    if !fields.contains_key(&expectation.field) {
        let known: Vec<_> = fields.keys().map(String::as_str).collect();
        return Err(unknown("field", &expectation.field, &known));
    }
    if expectation.has_bound() {
        Ok(())
    } else {
        let expected = "at least one of at-most, at-least, equals, at-most-share";
        Err(Wrong::of("field", "no bound of it", expected))
    }
}

/// The error about an unknown name, with the known ones.
fn unknown(field: &str, received: &str, known: &[impl AsRef<str>]) -> Wrong {
    let known: Vec<_> = known.iter().map(AsRef::as_ref).collect();
    let meant = did_you_mean(received, known.iter().copied());
    let expected = format!("one of: {}{meant}", known.join(", "));
    Wrong::of(field, format_args!("{received:?}"), expected)
}

fn check_exceptions(scenario: &Scenario) -> Result<(), Wrong> {
    for (n, exception) in scenario.exceptions.iter().enumerate() {
        check_exception(exception, scenario)
            .map_err(|wrong| wrong.within(format_args!("exception[{n}]")))?;
    }
    Ok(())
}

/// Checks that the part of an exception exists.
fn check_exception(exception: &Exception, scenario: &Scenario) -> Result<(), Wrong> {
    let Exception {
        receiver, of, from, ..
    } = exception;
    let receivers = &scenario.receivers;
    let Some(config) = receivers
        .iter()
        .find(|known| known.name.as_str() == receiver)
    else {
        let known = names(receivers.iter().map(|known| &known.name));
        return Err(unknown("receiver", receiver, &known));
    };
    let mut known = names(config.slaves.iter().map(|slave| &slave.name));
    known.extend(config.far_axis_names());
    known.extend(names(config.received_nodes().iter().map(|node| node.node)));
    known.push(receiver.clone());
    if !known.contains(of) {
        return Err(unknown("of", of, &known));
    }
    if from.is_empty() {
        return Err(Wrong::of("from", "none", "at least one of the invariants"));
    }
    Ok(())
}

/// Checks that every node is able to start: its parameters are checked where they are used.
fn check_nodes(scenario: &Scenario) -> Result<(), Wrong> {
    let start = coaxle_clock::Instant::EPOCH;
    check_link(&scenario.network).map_err(|wrong| wrong.within("network"))?;
    check_link(&scenario.timing_network).map_err(|wrong| wrong.within("timing-network"))?;
    for (n, sender) in scenario.senders.iter().enumerate() {
        let built = || coaxle_sender::Sender::new(sender, start, 0).map(drop);
        let checked = sender.check_files().and_then(|()| built());
        checked.map_err(|wrong| wrong.within(format_args!("sender[{n}]")))?;
    }
    for (n, config) in scenario.receivers.iter().enumerate() {
        let drives = Drives::simulated();
        let built = || coaxle_receiver::Receiver::with_drives(config, drives, start, 0).map(drop);
        let checked = config.check_files().and_then(|()| built());
        checked.map_err(|wrong| wrong.within(format_args!("receiver[{n}]")))?;
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
