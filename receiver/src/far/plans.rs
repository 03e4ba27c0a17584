//! Plans of a far node: their pieces wait for the cycle they belong to, and are joined to the motion of each axis.

use std::collections::VecDeque;

use coaxle_axis::motion_plan::{MOST_PIECES, MotionPiece, PlanFault};
use coaxle_clock::{Instant, Local};
use coaxle_node::config::LinkConfig;
use coaxle_node::plan::MAX_PLANS;
use coaxle_node::{FrameHeader, PlannedPiece};
use coaxle_remote::{PlannedAhead, PlannedMotion, ReceivedPlan};

use super::frames::TakenFrame;
use crate::config::{FarAxisConfig, FarConfig};
use crate::signals::{FarAxisSignals, FarNodeSignals};

/// Messages of plans that can wait …
// A sender publishes one in a cycle at most, and not in each cycle.
const WAITING: usize = 2;
/// … and plans of each axis where injected faults hold them back: those of some seconds.
const WAITING_OF_FAULTS: usize = 64;

/// Plans of a node's axes.
#[derive(Debug)]
pub(super) struct Plans {
    waiting: VecDeque<(Instant<Local>, PlannedPiece)>,
    assembly: PlanAssembly,
    /// Run of the plans.
    run: Option<u64>,
    axes: Box<[PlannedAxis]>,
    received: u64,
    refused: u64,
    fault: Option<PlanFault>,
}

/// Plans of an axis.
#[derive(Debug, Default)]
struct PlannedAxis {
    motion: PlannedMotion,
    contradictions: u64,
    /// False for an axis whose set values are not those of the frames.
    is_usable: bool,
}

/// A plan whose pieces arrive one after the other.
#[derive(Debug)]
struct PlanAssembly {
    pieces: [MotionPiece; MOST_PIECES],
    /// The piece that completes it or leads to the next one.
    next: Option<PieceId>,
}

/// Run, cycle and axis of a plan, and the number of a piece.
type PieceId = (u64, u64, u16, u8);

impl PlanAssembly {
    /// Takes a piece; returns the plan that it completes.
    fn take(&mut self, piece: &PlannedPiece) -> Result<Option<ReceivedPlan<'_>>, PlanFault> {
        let id = |number| (piece.epoch, piece.count, piece.axis, number);
        let is_last = piece.number + 1 >= piece.of;
        let is_next = piece.number == 0 || self.next == Some(id(piece.number));
        self.next = (is_next && !is_last).then(|| id(piece.number + 1));
        let number = usize::from(piece.number);
        if let Some(place) = self.pieces.get_mut(number) {
            *place = piece.piece;
        }
        match (is_next, is_last, self.pieces.get(..=number)) {
            // A piece that is lost on its way into the node leaves a plan with a hole: counted once.
            (false, true, _) => Err(PlanFault::Incomplete),
            (true, true, Some(pieces)) => Ok(Some(ReceivedPlan {
                count: piece.count,
                pieces,
                promised_until: piece.promised_until,
            })),
            _ => Ok(None),
        }
    }
}

impl Plans {
    /// Creates the plans of a node's axes; none if there is no use for them.
    pub(super) fn new(config: &FarConfig) -> Option<Self> {
        let axis = |axis: &FarAxisConfig| PlannedAxis {
            is_usable: axis.uses_plans(),
            ..PlannedAxis::default()
        };
        let axes: Box<[_]> = config.axes.iter().map(axis).collect();
        let waiting = match config.faults == LinkConfig::default() {
            true => WAITING * axes.len().min(MAX_PLANS),
            false => WAITING_OF_FAULTS * axes.len(),
        };
        config.uses_plans().then(|| Self {
            // Sized once, because nothing between two cycles allocates.
            waiting: VecDeque::with_capacity(waiting * MOST_PIECES),
            assembly: PlanAssembly {
                pieces: [MotionPiece::default(); MOST_PIECES],
                next: None,
            },
            run: None,
            axes,
            received: 0,
            refused: 0,
            fault: None,
        })
    }

    /// Stores a piece that arrived at `at`.
    pub(super) fn store(&mut self, at: Instant<Local>, piece: &PlannedPiece) {
        if self.waiting.len() == self.waiting.capacity() {
            // A plan without its first piece is incomplete, and counted when its others are taken in.
            self.waiting.pop_front();
        }
        self.waiting.push_back((at, *piece));
    }

    /// Counts a plan that cannot be used.
    pub(super) const fn refuse(&mut self, fault: PlanFault) {
        self.refused = self.refused.saturating_add(1);
        self.fault = Some(fault);
    }

    /// Takes the pieces that had arrived when a cycle ideally began, of the run of the newest frame.
    pub(super) fn take(&mut self, cycle_start: Instant<Local>, header: Option<&FrameHeader>) {
        let run = header.map(|header| header.epoch);
        if run != self.run {
            self.run = run;
            self.clear();
        }
        // A single turn of the queue: what is not due yet goes back behind the rest, in its order.
        for _ in 0..self.waiting.len() {
            let Some((at, piece)) = self.waiting.pop_front() else {
                break;
            };
            if at > cycle_start {
                self.waiting.push_back((at, piece));
            } else if let Err(fault) = self.take_piece(&piece) {
                self.refuse(fault);
            }
        }
    }

    fn take_piece(&mut self, piece: &PlannedPiece) -> Result<(), PlanFault> {
        let Some(plan) = self.assembly.take(piece)? else {
            return Ok(());
        };
        let Some(run) = self.run else {
            // No frame has come yet: whether the plan is that of the run that will be followed is not known.
            return Ok(());
        };
        if piece.epoch != run {
            return Err(PlanFault::OtherRun);
        }
        self.received = self.received.saturating_add(1);
        let axis = self.axes.get_mut(usize::from(piece.axis));
        let Some(axis) = axis.filter(|axis| axis.is_usable) else {
            return Ok(());
        };
        let outcome = axis.motion.take(&plan);
        if outcome == Err(PlanFault::PromiseBroken) {
            axis.contradictions = axis.contradictions.saturating_add(1);
        }
        outcome
    }

    /// Compares the plans with the samples of a frame.
    pub(super) fn check(&mut self, frame: &TakenFrame<'_>, header: &FrameHeader) {
        let instant = header.cycle_time.span() * frame.count as i64;
        for (axis, sample) in self.axes.iter_mut().zip(frame.samples) {
            let Some(sample) = sample else {
                continue;
            };
            if axis.motion.check(instant, &sample.set).is_err() {
                axis.contradictions = axis.contradictions.saturating_add(1);
                self.fault = Some(PlanFault::Contradicted);
            }
        }
    }

    /// Forgets all plans: the next ones are unrelated to them.
    fn clear(&mut self) {
        for axis in &mut self.axes {
            axis.motion.clear();
        }
    }

    /// The planned motion of an axis, `count` cycles after the begin of the run.
    pub(super) fn of(
        &self,
        axis: usize,
        count: u64,
        header: &FrameHeader,
    ) -> Option<PlannedAhead<'_>> {
        let motion = &self.axes.get(axis)?.motion;
        // Known, or of no use.
        motion.known_until()?;
        Some(PlannedAhead {
            motion,
            newest: header.cycle_time.span() * count as i64,
        })
    }

    /// The motion that its node has promised for an axis.
    pub(super) fn motion(&self, axis: usize) -> Option<&PlannedMotion> {
        self.axes.get(axis).map(|axis| &axis.motion)
    }

    /// Writes the signals of the node.
    pub(super) fn show(&self, signals: &mut FarNodeSignals) {
        signals.plans_received = self.received;
        signals.plans_refused = self.refused;
        signals.plan_fault = self.fault;
    }

    /// Writes those of an axis.
    pub(super) fn show_axis(&self, axis: usize, signals: &mut FarAxisSignals) {
        if let Some(axis) = self.axes.get(axis) {
            signals.plan_contradictions = axis.contradictions;
        }
    }
}
