//! Every receiver cycle against what the master really did.

mod coupling;
mod cuts;
mod drift;
mod judge;
mod lag;
mod moments;
mod settling;
mod slave;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_receiver::SignalRow;
use coaxle_sender::signals::{AxisSignals, SenderSignals};
use coaxle_sim::{Oracle, TruthSample};

use crate::curves::Curves;
use crate::row::{Reference, RowSink};
use crate::scenario::Scenario;
use crate::summary::ReceiverSummary;
use crate::topology::Topology;
use judge::Judge;

/// Where an axis of a sender truly was at the ideal start of a cycle, by its signals.
pub(crate) fn truth_of(
    at_ns: i64,
    node: &SenderSignals,
    axis: &AxisSignals,
) -> TruthSample<Reference> {
    TruthSample {
        at: Instant::from_nanos(at_ns),
        epoch: node.run,
        count: node.cycle,
        axis: Kinematics {
            position: axis.position,
            velocity: axis.velocity,
            acceleration: axis.acceleration,
        },
    }
}

/// How long a master's past is kept for receivers that are late.
const MEMORY: Span = Span::from_secs(5);

/// The evaluation of a run.
#[derive(Debug)]
pub struct Evaluation {
    senders: usize,
    start: Instant<Reference>,
    masters: Vec<Master>,
    /// One for each far axis of each receiver.
    judges: Vec<Judge>,
    /// Which of them are the receiver's.
    of_receiver: Vec<std::ops::Range<usize>>,
}

/// A sender's axis that somebody follows, or a receiver that somebody follows: of that only its
/// clock counts, as its motion is its sender's.
#[derive(Debug)]
struct Master {
    node: usize,
    axis: u32,
    oracle: Oracle<Reference>,
}

/// The number of a master, among those known so far.
fn master_of(masters: &mut Vec<Master>, node: usize, axis: u32, cycle_time: CycleTime) -> usize {
    let known = |master: &Master| master.node == node && master.axis == axis;
    masters.iter().position(known).unwrap_or_else(|| {
        masters.push(Master {
            node,
            axis,
            oracle: Oracle::new(cycle_time, MEMORY),
        });
        masters.len() - 1
    })
}

/// Stands for the clock of a receiver: its slaves' ids begin at 1.
const CLOCK_ONLY: u32 = 0;

impl Evaluation {
    /// Nothing evaluated yet; the run starts at `start`.
    #[must_use]
    pub(crate) fn new(scenario: &Scenario, topology: &Topology, start: Instant<Reference>) -> Self {
        let mut masters = Vec::new();
        let mut judges = Vec::new();
        let senders = scenario.senders.len();
        for view in topology.views() {
            let config = &scenario.receivers[view.receiver];
            let root = view.root;
            let cycle_time = scenario.senders[root.sender].cycle_time_us.0;
            let motion = master_of(&mut masters, root.sender, root.axis, cycle_time);
            let clock = match root.source.checked_sub(senders) {
                None => motion,
                Some(before) => {
                    let cycle_time = scenario.receivers[before].cycle_time_us.0;
                    master_of(&mut masters, root.source, CLOCK_ONLY, cycle_time)
                }
            };
            judges.push(Judge::new(config, motion, clock, view));
        }
        let of = |n: usize| {
            let views = topology.views();
            let first = views.partition_point(|view| view.receiver < n);
            first..views.partition_point(|view| view.receiver <= n)
        };
        Self {
            senders,
            start,
            masters,
            judges,
            of_receiver: (0..scenario.receivers.len()).map(of).collect(),
        }
    }

    /// A cycle of a sender: where one of its axes truly was.
    pub(crate) fn master_was(&mut self, sender: usize, axis: u32, sample: TruthSample<Reference>) {
        let master = self
            .masters
            .iter_mut()
            .find(|master| master.node == sender && master.axis == axis);
        if let Some(master) = master {
            master.oracle.push(sample);
        }
    }

    /// A cycle of a receiver.
    pub(crate) fn receiver_did(
        &mut self,
        receiver: usize,
        at_ns: i64,
        woke_ns: i64,
        signals: &SignalRow,
        sink: &mut impl RowSink,
    ) {
        self.clock_was(receiver, at_ns, signals);
        for view in self.of_receiver[receiver].clone() {
            let judge = &mut self.judges[view];
            judge.take(at_ns, woke_ns, signals);
            // The motion up to this cycle may be known only after the master's next one.
            while let Some(record) = judge.waiting.pop_front() {
                let at = Instant::from_nanos(record.at_ns);
                if !judge.is_known(&self.masters, at) && judge.waiting.len() + 1 < LONGEST_WAIT {
                    judge.waiting.push_front(record);
                    break;
                }
                let row = judge.judge(record, &self.masters, self.start);
                sink.row(view, &row);
                judge.take_back(row.record);
            }
        }
    }

    /// A receiver is the clock of those who follow it.
    fn clock_was(&mut self, receiver: usize, at_ns: i64, signals: &SignalRow) {
        let sample = TruthSample {
            at: Instant::from_nanos(at_ns),
            epoch: 0,
            count: signals.node.cycle,
            axis: Kinematics::default(),
        };
        self.master_was(self.senders + receiver, CLOCK_ONLY, sample);
    }

    /// The run is over: what still waits for the master is judged without it.
    pub(crate) fn finish(
        mut self,
        sink: &mut impl RowSink,
    ) -> Vec<(String, ReceiverSummary, Curves)> {
        for (n, judge) in self.judges.iter_mut().enumerate() {
            while let Some(record) = judge.waiting.pop_front() {
                let row = judge.judge(record, &self.masters, self.start);
                sink.row(n, &row);
                judge.take_back(row.record);
            }
        }
        self.judges.into_iter().map(Judge::finish).collect()
    }
}

/// Rows that wait for a master that is silent: a second's worth.
const LONGEST_WAIT: usize = 1_000;
