//! The nodes of a run as a picture: who shows its master when, with the delays that the receivers measured.

use coaxle_clock::Span;
use coaxle_lab::read;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::summary::{ReceiverSummary, Summary};
use coaxle_receiver::config::FarChannel;
use coaxle_topology::{AxisOrigin, FarReference, MeasuredWay, PlantAnalysis, PlantNode};

use super::Report;
use crate::print;

const ABOUT: &str = "Each box is a node with its axes, each line an axis that is followed: its delay and what 99.9 % of the cycles needed, as measured \
     in the last minute of the run. A drive shows its master later by the sum of the lags along its way and the hold-back of its node.";

/// Returns the picture, for a run with an axis that is shown later, or with a chain of nodes.
pub(super) fn element(report: &Report<'_>) -> String {
    let table = report.scenario_toml.parse().ok();
    let scenario = table.and_then(|table| read::scenario(&report.summary.scenario, table).ok());
    let Some(scenario) = scenario.filter(is_of_interest) else {
        return String::new();
    };
    let svg = print::svg_of_plant(&PlantAnalysis::of(&nodes(&scenario, report.summary)));
    format!(
        "<h2>Who shows its master when</h2>\n<p class=\"hint\">{ABOUT}</p>\n<div class=\"wide\">\n{svg}</div>\n"
    )
}

fn is_of_interest(scenario: &Scenario) -> bool {
    let is_presented = (scenario.senders.iter()).any(|it| it.axes.present_after().is_some());
    is_presented
        || scenario.receivers.iter().any(|receiver| {
            let mut far = receiver.far.iter();
            let mut virtual_axes = receiver.virtual_axes.iter();
            far.any(|far| far.channel != FarChannel::Axes)
                || virtual_axes.any(|axis| axis.present_after_ms.is_some())
        })
}

fn nodes(scenario: &Scenario, summary: &Summary) -> Vec<PlantNode> {
    let senders = scenario.senders.iter();
    let senders = senders.map(|sender| sender.plant_node(sender.name.as_str()));
    let receivers = scenario.receivers.iter().map(|receiver| {
        let mut node = receiver.plant_node(receiver.name.as_str());
        for axis in &mut node.axes {
            if let AxisOrigin::Far(far) = &mut axis.origin
                && let Some(measured) = of_axis(summary, receiver.name.as_str(), far)
            {
                node.hold_back = Some(Span::from_micros_f64(measured.last.node.hold_back_us));
                measure(far, measured);
            }
        }
        node
    });
    senders.chain(receivers).collect()
}

/// Figures of the receiver `name` by an axis that it follows.
fn of_axis<'s>(
    summary: &'s Summary,
    name: &str,
    far: &FarReference,
) -> Option<&'s ReceiverSummary> {
    let source = far.sources.first()?;
    let master = format!("{}/{}", source.node.channel_key(source.channel), source.id);
    let is_of = |part: &str| part == name || part.starts_with(&format!("{name}/"));
    let mut receivers = summary.receivers.iter();
    let found = receivers.find(|(part, figures)| is_of(part) && figures.master == master);
    found.map(|(_, figures)| figures)
}

fn measure(far: &mut FarReference, measured: &ReceiverSummary) {
    let signals = &measured.last.far;
    let time = |micros: Option<f64>| micros.map(Span::from_micros_f64);
    far.measure(&MeasuredWay {
        delay: time(signals.delay_us),
        needed: time(signals.needed_present_after_us),
        present_after: time(signals.present_after_us),
        lag: time(signals.presentation_lag_us),
    });
}
