//! Comparison of every receiver cycle with the master's true motion.

mod coupling;
mod cuts;
mod drift;
mod followed_delay;
mod followed_motion;
mod frame_age;
mod judge;
mod lag;
mod moments;
mod own_time;
mod settling;
mod shown_later;
mod skipped;
mod slave;
mod unnoticed;
mod watch;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::ChangeMicros;
use coaxle_node::config::LinkConfig;
use coaxle_receiver::signals::VirtualAxisSignals;
use coaxle_receiver::{ReceiverConfig, SignalRow};
use coaxle_sender::signals::{AxisSignals, SenderSignals};
use coaxle_sim::{Oracle, TruthSample};
use coaxle_source::config::SourceConfig;

use crate::event::{Action, Event, EventKind};
use crate::invariants::InvariantViolation;
use crate::row::{Reference, RowSink};
use crate::scenario::Scenario;
use crate::summary::{ReceiverSummary, World};
use crate::topology::{Root, Topology};
use judge::{Clocks, MotionSource, ReceiverJudge};
use skipped::SkippedCycles;
use watch::CoupledStopWatch;
pub use watch::ReceiverWatch;

/// True state of a sender's axis at the ideal start of a cycle, by its signals.
pub fn truth_of(at_ns: i64, node: &SenderSignals, axis: &AxisSignals) -> TruthSample<Reference> {
    TruthSample {
        at: Instant::from_nanos(at_ns),
        epoch: node.run,
        count: node.cycle,
        axis: Kinematics {
            position: axis.position,
            velocity: axis.velocity,
            acceleration: axis.acceleration,
        },
        present_after: Span::from_micros_f64(node.present_after_us.unwrap_or_default()),
    }
}

/// Time for which a master's past is kept for late receivers.
const MEMORY: Span = Span::from_secs(5);

/// The evaluation of a run.
#[derive(Debug)]
pub struct Evaluation {
    senders: usize,
    start: Instant<Reference>,
    masters: Vec<TrackedMaster>,
    /// A judge for each far or virtual axis of each receiver.
    judges: Vec<ReceiverJudge>,
    /// Indices of each receiver's judges.
    of_receiver: Vec<std::ops::Range<usize>>,
    /// The ids of the virtual axes of each receiver.
    virtual_axes: Vec<Box<[u32]>>,
    /// A watch for each receiver.
    watches: Vec<ReceiverWatch>,
    coupled_stops: CoupledStopWatch,
    skipped: SkippedCycles,
}

/// Result of an evaluation.
#[derive(Debug)]
pub struct Evaluated {
    /// Summaries of each receiver, by each of its far or virtual axes.
    pub receivers: Vec<(String, ReceiverSummary)>,
    /// Violations of invariants.
    pub violations: Vec<InvariantViolation>,
}

/// A sender's axis that is followed, a receiver's virtual axis, or a receiver that is followed: of a receiver only its
/// clock counts, as its motion is its sender's.
#[derive(Debug)]
struct TrackedMaster {
    node: usize,
    axis: u32,
    oracle: Oracle<Reference>,
}

/// The number of a master, among those known so far.
fn master_of(
    masters: &mut Vec<TrackedMaster>,
    node: usize,
    axis: u32,
    cycle_time: CycleTime,
) -> usize {
    let known = |master: &TrackedMaster| master.node == node && master.axis == axis;
    masters.iter().position(known).unwrap_or_else(|| {
        masters.push(TrackedMaster {
            node,
            axis,
            oracle: Oracle::new(cycle_time, MEMORY),
        });
        masters.len() - 1
    })
}

/// Stands for the clock of a receiver: the ids of its virtual axes begin at 1.
const CLOCK_ONLY: u32 = 0;

impl Evaluation {
    /// An empty evaluation of a run that starts at `start`.
    #[must_use]
    pub fn new(
        scenario: &Scenario,
        topology: &Topology,
        world: World,
        start: Instant<Reference>,
    ) -> Self {
        let mut masters = Vec::new();
        let mut judges = Vec::new();
        let senders = scenario.senders.len();
        let clock_jumps = clock_jumps(scenario);
        let cycle_time = |node: usize| match node.checked_sub(senders) {
            None => scenario.senders[node].cycle_time_us.0,
            Some(receiver) => scenario.receivers[receiver].cycle_time_us.0,
        };
        for view in topology.views() {
            let config = &scenario.receivers[view.receiver];
            let roots = std::iter::once(&view.root).chain(&view.standbys);
            let sources = roots.map(|root| {
                // A followed receiver moves as its sender does, but its set values are dated by its own clock.
                let motion = master_of(&mut masters, root.node, root.axis, cycle_time(root.node));
                let clock = if root.source == root.node {
                    motion
                } else {
                    let cycle_time = cycle_time(root.source);
                    master_of(&mut masters, root.source, CLOCK_ONLY, cycle_time)
                };
                MotionSource {
                    motion,
                    clock,
                    gear: root.gear,
                    later: shown_later::delay_of(scenario, view.receiver, root),
                    is_led: shown_later::is_led(scenario, root),
                    jerk: shown_later::jerk_of(scenario, root),
                    // Runs of a receiver are numbered by the receiver: they never match the epoch of its sender.
                    is_receiver: root.source >= senders,
                    is_shown: !comes_through_encoder(scenario, root)
                        && !is_forged(scenario, config),
                }
            });
            let sources = sources.collect();
            // Delays between processes are correlated, too.
            let says_its_error =
                world == World::Virtual && !has_correlated_delays(scenario, config);
            // Without clocks nothing judges the stated error.
            let clocks = says_its_error.then_some(Clocks {
                jumps: &clock_jumps,
                resolution_us: steady_resolution(scenario, config),
            });
            judges.push(ReceiverJudge::new(
                config,
                &scenario.events,
                sources,
                view,
                clocks,
            ));
        }
        let virtual_axes = |receiver: &ReceiverConfig| {
            let axes = receiver.virtual_axes.iter();
            axes.map(|axis| axis.id.get()).collect()
        };
        let of = |n: usize| {
            let views = topology.views();
            let first = views.partition_point(|view| view.receiver < n);
            // Views stand receiver after receiver, so that each has one range of them.
            first..views.partition_point(|view| view.receiver <= n)
        };
        Self {
            senders,
            start,
            masters,
            judges,
            of_receiver: (0..scenario.receivers.len()).map(of).collect(),
            virtual_axes: (scenario.receivers.iter()).map(virtual_axes).collect(),
            watches: (scenario.receivers.iter())
                .map(|receiver| ReceiverWatch::new(receiver, &scenario.events, world))
                .collect(),
            coupled_stops: CoupledStopWatch::new(scenario),
            skipped: SkippedCycles::new(scenario, topology),
        }
    }

    /// Takes a cycle of a sender: its signals.
    pub fn push_sender(&mut self, sender: usize, node: &SenderSignals) {
        (self.skipped).push_node(sender, node.run, node.cycle, node.overruns);
    }

    /// Takes a cycle of a sender: the true state of one of its axes.
    pub fn push_master(&mut self, sender: usize, axis: u32, sample: TruthSample<Reference>) {
        let since = (sample.at - self.start).as_secs_f64();
        let cycle = (sample.epoch, sample.count);
        (self.coupled_stops).push_master((sender, axis), cycle, since, sample.axis.velocity);
        push(&mut self.masters, sender, axis, sample);
    }

    /// Takes a cycle of a receiver.
    pub fn push_receiver(
        &mut self,
        receiver: usize,
        at_ns: i64,
        woke_ns: i64,
        signals: &SignalRow,
        sink: &mut impl RowSink,
    ) {
        // Before its judges: a virtual axis is judged by the motion that this very cycle adds.
        self.push_clock(receiver, at_ns, signals);
        let (skipped, node) = (&mut self.skipped, &signals.node);
        skipped.push_node(self.senders + receiver, node.run, node.cycle, node.overruns);
        skipped.push_receiver(receiver, &signals.far);
        let since = (Instant::from_nanos(at_ns) - self.start).as_secs_f64();
        self.watches[receiver].push(since, signals);
        (self.coupled_stops).push_slaves(receiver, since, &signals.slaves);
        for view in self.of_receiver[receiver].clone() {
            let judge = &mut self.judges[view];
            judge.take(at_ns, woke_ns, signals);
            // The motion up to this cycle may be known only after the master's next one.
            while let Some(record) = judge.waiting.pop_front() {
                let at = Instant::from_nanos(record.at_ns);
                // A dead master is known no further: without the bound all rows to the end would wait for it.
                if !judge.is_known(&self.masters, record.place, at)
                    && Instant::from_nanos(at_ns) - at < LONGEST_WAIT
                {
                    judge.waiting.push_front(record);
                    break;
                }
                let row = judge.judge(record, &self.masters, self.start);
                sink.row(view, &row);
                // Boxes go round: a run of hours allocates as many as wait at a time.
                judge.take_back(row.record);
            }
        }
    }

    /// Takes a receiver as the clock of its followers, which moves its virtual axes.
    fn push_clock(&mut self, receiver: usize, at_ns: i64, signals: &SignalRow) {
        let sample = |axis| TruthSample {
            at: Instant::from_nanos(at_ns),
            epoch: signals.node.run,
            count: signals.node.cycle,
            axis,
            // Its virtual axes are shown later by a figure.
            present_after: Span::ZERO,
        };
        let (masters, node) = (&mut self.masters, self.senders + receiver);
        push(masters, node, CLOCK_ONLY, sample(Kinematics::default()));
        for (id, axis) in self.virtual_axes[receiver]
            .iter()
            .zip(&signals.virtual_axes)
        {
            push(masters, node, *id, sample(truly(axis)));
        }
    }

    /// Ends the run: cycles that still wait for the master are judged without it.
    pub fn finish(mut self, sink: &mut impl RowSink) -> Evaluated {
        for (n, judge) in self.judges.iter_mut().enumerate() {
            while let Some(record) = judge.waiting.pop_front() {
                let row = judge.judge(record, &self.masters, self.start);
                sink.row(n, &row);
                judge.take_back(row.record);
            }
        }
        self.watches.iter_mut().for_each(ReceiverWatch::end);
        let watches = &self.watches;
        let mut violations: Vec<_> = watches.iter().flat_map(ReceiverWatch::violations).collect();
        violations.extend(self.coupled_stops.violations());
        violations.extend(self.judges.iter().flat_map(ReceiverJudge::violations));
        let judged = self.judges.into_iter();
        Evaluated {
            receivers: judged
                .map(|judge| judge.finish(watches, &self.skipped))
                .collect(),
            violations,
        }
    }
}

/// True if delays are correlated over seconds: a small change of the drift, and its effect on the error, cannot be
/// distinguished from them for as long (docs/OBSERVER-METHOD.md).
fn has_correlated_delays(scenario: &Scenario, receiver: &ReceiverConfig) -> bool {
    links_to(scenario, receiver).any(|link| link.correlated.is_some())
}

/// Resolution of a receiver's arrival times, µs; none where delays change for good on the way.
fn steady_resolution(scenario: &Scenario, receiver: &ReceiverConfig) -> Option<f64> {
    let resolution = links_to(scenario, receiver).try_fold(0.0, |most, link| {
        // A delay that changes for good shifts the constant error of a time without a measured delay.
        let changes = !link.delay_steps.is_empty() || !link.delay_terms_us.is_empty();
        // Faults that end take the mean of their delays with them.
        let is_steady = !changes && link.faults_until_s.is_none();
        is_steady.then(|| f64::max(most, link.resolution_us.span().as_micros_f64()))
    });
    // Queues of routers grow and shrink, and with them the delay.
    resolution.filter(|_| scenario.routers.is_empty())
}

/// True if messages are forged on the way to a receiver: their content is no truth.
fn is_forged(scenario: &Scenario, receiver: &ReceiverConfig) -> bool {
    links_to(scenario, receiver).any(|link| !link.forgeries.is_empty())
}

/// The faults of all links by which messages of axes reach a receiver.
fn links_to<'a>(
    scenario: &'a Scenario,
    receiver: &'a ReceiverConfig,
) -> impl Iterator<Item = &'a LinkConfig> {
    // Faults of requests are left out: they delay no frame.
    let own = receiver.far.iter().map(|far| &far.faults);
    own.chain([&scenario.network])
}

/// True if the axis at the root is a sender's that is seen through an encoder.
fn comes_through_encoder(scenario: &Scenario, root: &Root) -> bool {
    let sender = scenario.senders.get(root.node);
    let mut axes = sender.into_iter().flat_map(|sender| sender.axes.iter());
    let axis = axes.find(|axis| axis.id.get() == root.axis);
    axis.is_some_and(|axis| matches!(axis.source, SourceConfig::Encoder(_)))
}

/// Times at which clocks of nodes jump, or receivers restart, which others may follow, s after the start of the run.
fn clock_jumps(scenario: &Scenario) -> Vec<f64> {
    let senders = scenario.senders.iter().map(|sender| &sender.clock);
    let receivers = (scenario.receivers.iter()).map(|receiver| &receiver.clock);
    let steps = senders.chain(receivers).flat_map(|clock| &clock.steps);
    // A step of the drift alone moves no reading.
    let jumps = steps.filter(|step| step.phase_us != ChangeMicros::default());
    let jumps = jumps.map(|step| step.at_s.span().as_secs_f64());
    let is_receiver =
        |event: &&Event| (scenario.receivers.iter()).any(|one| one.name == event.node);
    let of_receivers = scenario.events.iter().filter(is_receiver);
    let restarts = of_receivers.filter_map(|event| match event.what {
        EventKind::Away {
            action: Action::Restart,
            for_s,
            // Both when it dies and when it is back: either begins another time for its followers.
        } => Some([event.at_s.into(), f64::from(event.at_s) + f64::from(for_s)]),
        EventKind::Away { .. } | EventKind::Command(_) => None,
    });
    jumps.chain(restarts.flatten()).collect()
}

/// Takes the next cycle of a master, if it is followed.
fn push(masters: &mut [TrackedMaster], node: usize, axis: u32, sample: TruthSample<Reference>) {
    let is_it = |master: &&mut TrackedMaster| master.node == node && master.axis == axis;
    // Axes that nobody follows have no oracle.
    if let Some(master) = masters.iter_mut().find(is_it) {
        master.oracle.push(sample);
    }
}

fn truly(axis: &VirtualAxisSignals) -> Kinematics {
    Kinematics {
        position: axis.true_position,
        velocity: axis.true_velocity,
        acceleration: axis.true_acceleration,
    }
}

/// Longest wait of a row for a silent master. The slowest cycle lasts 0.1 s: a master that lives is known ten times within.
const LONGEST_WAIT: Span = Span::from_secs(1);
