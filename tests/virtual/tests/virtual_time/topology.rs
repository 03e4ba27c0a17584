//! Delays that `coaxle topology` computes from configs, beside those that receivers measure.

use coaxle_lab::catalog;
use coaxle_node::config::{LinkConfig, parse};
use coaxle_topology::{AxisOrigin, PlantAnalysis, PlantNode, ShownAs, WaySource};

use crate::common;

const CHAIN: &str = "presented-chain";
const RECEIVERS: [&str; 3] = ["first", "second", "third"];

/// The nodes of a scenario, all of whose ways are this link.
fn plant(overrides: &[&str], link: &LinkConfig) -> PlantAnalysis {
    let overrides: Vec<_> = overrides.iter().map(|&set| set.to_owned()).collect();
    let source = catalog::find(CHAIN).expect("a scenario of the catalogue");
    let scenario = source.read(&overrides).expect("the scenario is right");
    let senders = scenario
        .senders
        .iter()
        .map(|node| node.plant_node("a sender"));
    let receivers = scenario
        .receivers
        .iter()
        .map(|node| node.plant_node("a receiver"));
    let mut nodes: Vec<PlantNode> = senders.chain(receivers).collect();
    for axis in nodes.iter_mut().flat_map(|node| &mut node.axes) {
        if let AxisOrigin::Far(far) = &mut axis.origin {
            far.way = WaySource::Link(Box::new(link.clone()));
        }
    }
    PlantAnalysis::of(&nodes)
}

/// What the three receivers of a run say at its end that they need, ms.
fn measured(overrides: &[&str]) -> [f64; 3] {
    let source = catalog::find(CHAIN).expect("a scenario of the catalogue");
    let out = tempfile::tempdir().expect("a scratch folder");
    let _ = common::run_into(&source, overrides, Some(7), out.path());
    let mut trace = csv::Reader::from_path(out.path().join("trace.csv")).expect("a trace");
    let header = trace.headers().expect("a header").clone();
    let column = |name: &str| {
        let mut names = header.iter();
        let place = names.position(|known| known == name);
        place.unwrap_or_else(|| panic!("{name}: {header:?}"))
    };
    // A row for each receiver and cycle.
    let (receiver, needed) = (column("receiver"), column("far.needed_present_after_us"));
    let mut last = [None; 3];
    for row in trace.records() {
        let row = row.expect("a row");
        let place = RECEIVERS.iter().position(|name| *name == &row[receiver]);
        if let (Some(place), Ok(value)) = (place, row[needed].parse::<f64>()) {
            last[place] = Some(value);
        }
    }
    last.map(|needed| needed.expect("known in the end") / 1e3)
}

#[test]
fn a_chain_needs_what_its_configs_say() {
    for network in [
        "latency-us = 20000\njitter = { exponential-us = 20 }\nloss = 0.05",
        "latency-us = 5000\njitter = { uniform-us = 4000 }",
        "latency-us = 800",
    ] {
        let set = format!("network={{ {} }}", network.replace('\n', ", "));
        let overrides = [set.as_str(), "duration-s=25", "expect=[]"];
        let link = parse("network", network).expect("a link");
        let plant = plant(&overrides, &link);
        let stages = &plant.routes.last().expect("a route").stages;
        for (stage, measured) in stages.iter().zip(measured(&overrides)) {
            let needed = stage.needed_ms.expect("a known link");
            println!(
                "{network}: {} needs {needed} ms, measures {measured} ms",
                stage.node
            );
            // A bin of the statistics, 6.25 %, and half a cycle of 1 ms: the ends of a minute differ.
            let off = (needed - measured).abs();
            assert!(off <= 0.07 * measured + 0.5, "{stage:?} {measured}");
        }
    }
}

#[test]
fn the_proposal_of_a_chain_interpolates_all_of_it_and_less_does_not() {
    let network = "latency-us = 20000\njitter = { exponential-us = 20 }\nloss = 0.05";
    let link = parse("network", network).expect("a link");
    let lags = ["first", "second"].map(|node| format!("receiver.{node}.lag-ms='auto'"));
    let lags = [lags[0].as_str(), &lags[1]];
    let proposed = plant(&lags, &link).proposals[0].present_after_ms;
    let proposed = proposed.expect("known ways");
    let error = |present_after: f64| {
        let axis = format!("sender.line.axis.conveyor.present-after-ms={present_after}");
        let overrides = [&lags[..], &[&axis, "duration-s=30", "expect=[]"]].concat();
        let present: Vec<_> = plant(&overrides, &link).routes;
        let is_good = present
            .iter()
            .all(|route| route.shown == ShownAs::Interpolated);
        let summary = common::run(CHAIN, &overrides);
        let third = common::figures(&summary, "third");
        (is_good, third.shown_position_error_max.expect("judged"))
    };
    // The last node has 15 % of the whole less than a third of it.
    let (good, short) = (error(proposed), error((proposed * 0.85).floor()));
    println!("{proposed} ms: {good:?} mm; 15 % less: {short:?} mm");
    assert!(good.0 && !short.0);
    // As with the 200 ms of the scenario: 3 µm, clocks included.
    assert!(
        good.1 < 0.003 && short.1 > 10.0 * good.1,
        "{good:?} {short:?}"
    );
}
