//! A scenario in the simulation: virtual time, as fast as it goes.

mod any_node;
mod populated;
mod stepped;

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Span};
use coaxle_node::{Arrival, CommandAnswer, CommandOutcome, Node};
use coaxle_sim::{CycleSeen, Observer, True, World};

use crate::evaluate::{Evaluation, truth_of};
use crate::event::{Event, EventKind};
use crate::finished::{Finished, Progress};
use crate::row::RowSink;
use crate::scenario::Scenario;
use crate::summary;
use crate::timeline::changes_of;
use crate::topology::Topology;
use crate::verdict::Verdict;
use any_node::AnyNode;
use populated::{apply, populate};

pub use populated::GivenMotion;
pub use stepped::{ReceiverSeen, SteppedScenario};

/// Runs a checked scenario in virtual time.
///
/// # Errors
/// A node that cannot be built, or that breaks its contract.
pub fn run(
    scenario: &Scenario,
    sink: &mut impl RowSink,
    progress: &mut dyn Progress,
) -> anyhow::Result<Finished> {
    let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
    let mut world = populate(scenario, &topology, None)?;
    let mut watcher = RunObserver {
        senders: scenario.senders.len(),
        receivers: scenario.receivers.len(),
        evaluation: Evaluation::new(scenario, &topology, summary::World::Virtual, Instant::EPOCH),
        sink,
        outcomes: vec![None; scenario.events.len()],
    };
    let end = Instant::EPOCH + Span::from_secs_f64(scenario.duration_s.get());
    let mut is_whole = true;
    for change in changes_of(scenario, &topology) {
        // Events behind the end happen at the end, where no cycle shows them any more.
        let at = (Instant::EPOCH + change.at).min(end);
        is_whole = run_in_steps(&mut world, at, &mut watcher, progress, end)?;
        if !is_whole {
            break;
        }
        apply(&mut world, scenario, &change);
    }
    let is_whole = is_whole && run_in_steps(&mut world, end, &mut watcher, progress, end)?;
    let interrupted_at = (!is_whole).then(|| world.now().since_epoch().as_secs_f64());
    let commands = judge_commands(scenario, &watcher.outcomes);
    let routers = world.router_traffic();
    let RunObserver {
        evaluation, sink, ..
    } = watcher;
    let finished = Finished::new(evaluation.finish(sink)).with_commands(commands);
    let finished = finished.with_routers(routers);
    Ok(finished.interrupted_at(interrupted_at))
}

fn judge_commands(scenario: &Scenario, outcomes: &[Option<CommandOutcome>]) -> Vec<Verdict> {
    let judge = |(event, outcome): (&Event, &Option<CommandOutcome>)| {
        let EventKind::Command(commanded) = &event.what else {
            return None;
        };
        let answer = outcome.map(|outcome| CommandAnswer::new(&commanded.order, &outcome));
        Some(commanded.judge(event, answer.as_ref()))
    };
    scenario
        .events
        .iter()
        .zip(outcomes)
        .filter_map(judge)
        .collect()
}

/// Runs up to `until`; false if interrupted before.
fn run_in_steps<S: RowSink>(
    world: &mut World<AnyNode>,
    until: Instant<True>,
    watcher: &mut RunObserver<'_, S>,
    progress: &mut dyn Progress,
    end: Instant<True>,
) -> anyhow::Result<bool> {
    while world.now() < until {
        // In steps, as a run of hours without events has to be shown, and may be ended.
        let next = (world.now() + PROGRESS_STEP).min(until);
        world.run_until(next, watcher)?;
        let done = next.since_epoch().as_secs_f64() / end.since_epoch().as_secs_f64();
        if !progress.at(done) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Virtual time between two updates of the progress.
const PROGRESS_STEP: Span = Span::from_secs(1);

struct RunObserver<'a, S> {
    senders: usize,
    receivers: usize,
    evaluation: Evaluation,
    sink: &'a mut S,
    /// Outcomes of the commands among the scenario's events.
    outcomes: Vec<Option<CommandOutcome>>,
}

impl<S> RunObserver<'_, S> {
    /// True for a duplicate node, which is not observed.
    const fn is_twin(&self, index: usize) -> bool {
        index >= self.senders + self.receivers
    }
}

impl<S: RowSink> Observer<AnyNode> for RunObserver<'_, S> {
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, AnyNode>) {
        if self.is_twin(seen.index) {
            return;
        }
        let at_ns = seen.ideal_start.as_nanos();
        match seen.node {
            AnyNode::Sender(sender) => {
                let snapshot = sender.snapshot();
                let node = &snapshot.signals.node;
                self.evaluation.push_sender(seen.index, node);
                for (id, axis) in snapshot.axes() {
                    let sample = truth_of(at_ns, node, axis);
                    self.evaluation.push_master(seen.index, id, sample);
                }
            }
            AnyNode::Receiver(receiver) => {
                let (number, woke_ns) = (seen.index - self.senders, seen.woke.as_nanos());
                let signals = &receiver.snapshot().signals;
                self.evaluation
                    .push_receiver(number, at_ns, woke_ns, signals, self.sink);
            }
        }
    }

    fn arrived(
        &mut self,
        index: usize,
        ideal_start: Instant<True>,
        tick: &Tick,
        arrival: &Arrival,
    ) {
        if self.is_twin(index) {
            return;
        }
        if let Some(receiver) = index.checked_sub(self.senders) {
            self.sink.arrived(receiver, ideal_start, tick, arrival);
        }
    }

    fn order_executed(&mut self, number: usize, outcome: &CommandOutcome) {
        // By the number of the event: orders under way at the end of the run have no outcome.
        self.outcomes[number] = Some(*outcome);
    }
}
