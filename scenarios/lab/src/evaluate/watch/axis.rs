//! A far axis: the time that its set values stand for, and their frames.

use coaxle_clock::Instant;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals};
use coaxle_receiver::{FilterState, SignalRow};
use coaxle_sim::{FarTimeCheck, FarTimeFault, LARGEST_RATE_ERROR};

use super::found::{Found, WatchedCycle};
use super::motion::MotionWatch;
use super::shown::LARGEST_SLEW;
use crate::invariants::Invariant;
use crate::topology::followed_of;

/// Resolution of lags, µs.
const RESOLUTION_US: f64 = 2e-3;

/// Watches a far axis.
#[derive(Debug)]
pub(super) struct AxisWatch {
    pub(super) name: String,
    /// Indices of its node and that node's standbys.
    nodes: Vec<usize>,
    check: FarTimeCheck,
    motion: MotionWatch,
    /// The newest cycle and its signals.
    last: Option<(WatchedCycle, FarAxisSignals)>,
    /// The mode that made its set values, the number of its clock's restarts by an order, and the node it is
    /// read from.
    line: Option<(FilterState, u32, usize)>,
    /// Lag of the axis behind its node's time, µs.
    lag_us: f64,
    /// Cycle time, µs.
    cycle_us: f64,
    /// The frame that was used last.
    used: Option<Used>,
    /// Index of the node it is read from, and number of take-overs before.
    owner: Option<(usize, u64)>,
    pub(super) found: Found,
}

impl AxisWatch {
    /// `nodes` are the indices of its node and that node's standbys; the receiver's cycle time is in s.
    pub(super) fn new(
        name: String,
        nodes: Vec<usize>,
        motion: MotionWatch,
        cycle_time: f64,
    ) -> Self {
        Self {
            name,
            nodes,
            check: FarTimeCheck::new(cycle_time),
            motion,
            last: None,
            line: None,
            lag_us: 0.0,
            cycle_us: 1e6 * cycle_time,
            used: None,
            owner: None,
            found: Found::default(),
        }
    }

    pub(super) fn push(
        &mut self,
        cycle: &WatchedCycle,
        signals: &SignalRow,
        axis: &FarAxisSignals,
    ) {
        let node = self.nodes[followed_of(&self.nodes, signals)];
        let far = &signals.far[node];
        let shown = [axis.corrected_position, axis.corrected_velocity];
        // Before anything is compared: NaN is neither above a bound nor below it, and would pass all others.
        for value in shown
            .into_iter()
            .flatten()
            .filter(|value| !value.is_finite())
        {
            self.found.add(cycle, Invariant::Finite, value, f64::MAX);
        }
        self.last = Some((*cycle, *axis));
        self.motion.push(cycle, (node, far), axis, &mut self.found);
        self.watch_owner(cycle, node, far.take_overs);
        let used = Used::of(node, far);
        let before = std::mem::replace(&mut self.used, used);
        if let (Some(before), Some(used)) = (before, used)
            && before.run == used.run
            && cycle.since.is_some()
            // Equal counts are a cycle without a new frame.
            && used.count < before.count
        {
            (self.found).add(
                cycle,
                Invariant::Count,
                used.count as f64,
                before.count as f64,
            );
        }
        // A change of mode or node changes the time: set values are blended over to it.
        let line = axis
            .state
            .map(|state| (state, far.re_initialisations, node));
        let is_another = std::mem::replace(&mut self.line, line) != line;
        let shown = axis.far_time_ns.filter(|_| is_corrected(axis));
        let (Some(run), Some(time)) = (far.epoch, shown) else {
            self.check.restart();
            return;
        };
        let lag = far.presentation_lag_us.unwrap_or_default();
        // The first lag is there at once, and so is a much shorter or longer one while all slaves stand, and the time shown with it (swarm
        // schedules 20067 and 20300).
        let changed = (lag - std::mem::replace(&mut self.lag_us, lag)).abs();
        let jumped = changed
            > LARGEST_SLEW * self.cycle_us * f64::from(cycle.since.unwrap_or(1)) + RESOLUTION_US;
        if is_another || jumped || cycle.since.is_none() {
            self.check.restart();
        }
        let time = Instant::from_nanos(time);
        // Skipped cycles count: far time passes during them, too.
        let fault = self.check.push(run, time, cycle.since.unwrap_or(1));
        let (invariant, value, limit) = match fault {
            None => return,
            // TS5066 has no bound: a new correction is blended in over 90 cycles, however large it is.
            Some(FarTimeFault::Rate(_)) if axis.state != Some(FilterState::Observer) => return,
            Some(FarTimeFault::NotLater(by)) => (Invariant::FarTime, by, 0.0),
            Some(FarTimeFault::Rate(rate)) => (Invariant::FarRate, rate.abs(), LARGEST_RATE_ERROR),
        };
        self.found.add(cycle, invariant, value, limit);
    }

    /// Ends the run.
    pub(super) fn end(&mut self) {
        if let Some((cycle, axis)) = &self.last {
            self.motion.end(cycle, axis, &mut self.found);
        }
    }

    fn watch_owner(&mut self, cycle: &WatchedCycle, node: usize, take_overs: u64) {
        let before = self.owner.replace((node, take_overs));
        let Some((owner, before)) = before.filter(|_| cycle.since.is_some()) else {
            return;
        };
        // A take-over may go to and fro between two rows of a process, so any larger number will do.
        if owner != node && take_overs <= before {
            let next = before + 1;
            (self.found).add(cycle, Invariant::Owner, take_overs as f64, next as f64);
        }
    }
}

/// A frame that was used.
#[derive(Clone, Copy, Debug)]
struct Used {
    /// The node, its epoch, and the number of runs followed: within an epoch the count may restart once, as
    /// another run.
    run: (usize, u64, u64),
    count: u64,
}

impl Used {
    fn of(node: usize, far: &FarNodeSignals) -> Option<Self> {
        let (epoch, count) = far.epoch.zip(far.count)?;
        let run = (node, epoch, far.restarts);
        Some(Self { run, count })
    }
}

/// True if its set values stand for a calculated time: in bypass they are as received.
fn is_corrected(axis: &FarAxisSignals) -> bool {
    matches!(
        axis.state,
        Some(FilterState::Sync | FilterState::Time | FilterState::Observer)
    )
}
