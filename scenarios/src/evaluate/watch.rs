//! A receiver's slaves and far axes, watched for what must hold in every cycle.

use coaxle_axis::AxisStatus;
use coaxle_clock::Instant;
use coaxle_curve::profile::Limits;
use coaxle_receiver::signals::{FarAxisSignals, SlaveSignals};
use coaxle_receiver::{ReceiverConfig, SignalRow, SlaveConfig, StateName};
use coaxle_saw::SyncMask;
use coaxle_sim::{
    FarTimeCheck, FarTimeFault, LARGEST_RATE_ERROR, SetValueBound, SetValueCheck, Shares,
};
use coaxle_slave::{Command, OnMasterLoss, SlaveError, SlaveParameters};

use crate::event::{Event, Happening};
use crate::invariants::{Broken, Invariant, InvariantViolation, Watched};
use crate::topology::followed_of;
use coaxle_node::CommandOrder;

/// Watches a receiver.
#[derive(Debug)]
pub(super) struct ReceiverWatch {
    receiver: String,
    /// Its newest cycle.
    last: Option<u64>,
    slaves: Vec<SlaveWatch>,
    axes: Vec<AxisWatch>,
}

/// A cycle, when it ideally began, and how many it is after the one before: none if it is the first of a run.
#[derive(Clone, Copy, Debug)]
struct WatchedCycle {
    number: u64,
    t_s: f64,
    since: Option<u32>,
}

impl ReceiverWatch {
    /// `events` are those of the whole scenario: of commands it counts what they may lead to.
    pub(super) fn new(config: &ReceiverConfig, events: &[Event]) -> Self {
        let cycle_time = config.cycle_time_us.0.as_secs_f64();
        let slave = |slave: &SlaveConfig| {
            let stops_instantly = commands_to(slave, config, events).any(may_stop_instantly);
            SlaveWatch::new(slave, stops_instantly, cycle_time)
        };
        let axis = |((far, _, _), name)| AxisWatch {
            name,
            nodes: config.numbers_of(far),
            check: FarTimeCheck::new(cycle_time),
            line: None,
            found: Found::default(),
        };
        let names = config.far_axis_names();
        Self {
            receiver: config.name.to_string(),
            last: None,
            slaves: config.slaves.iter().map(slave).collect(),
            axes: config.far_axes().zip(names).map(axis).collect(),
        }
    }

    /// The next cycle, which ideally began so many s after the start of the run.
    pub(super) fn push(&mut self, t_s: f64, signals: &SignalRow) {
        let number = signals.node.cycle;
        let since = self.last.replace(number).and_then(|last| {
            let passed = number.checked_sub(last)?;
            u32::try_from(passed).ok().filter(|passed| *passed > 0)
        });
        let cycle = WatchedCycle { number, t_s, since };
        for (watch, slave) in self.slaves.iter_mut().zip(&signals.slaves) {
            watch.push(&cycle, slave);
        }
        for (watch, axis) in self.axes.iter_mut().zip(&signals.axes) {
            watch.push(&cycle, signals, axis);
        }
    }

    /// What the set positions of the n-th slave had at most of its limits; none if there is no such slave.
    pub(super) fn shares(&self, slave: usize) -> Option<Shares> {
        let check = self.slaves.get(slave)?.check.as_ref()?;
        Some(check.largest())
    }

    /// What did not hold.
    pub(super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> + '_ {
        let slaves = self.slaves.iter().map(|slave| (&slave.name, &slave.found));
        let axes = self.axes.iter().map(|axis| (&axis.name, &axis.found));
        slaves.chain(axes).flat_map(|(axis, found)| {
            let of = || Watched {
                receiver: self.receiver.clone(),
                axis: axis.clone(),
            };
            found.0.iter().map(move |found| found.violation(of()))
        })
    }
}

/// Watches a slave.
#[derive(Debug)]
struct SlaveWatch {
    name: String,
    check: Option<SetValueCheck>,
    /// A lost master stops it whatever the jerk.
    stops_quickly: bool,
    /// A master that runs back may stop it within a cycle.
    stops_instantly: bool,
    before: SlaveSignals,
    found: Found,
}

impl SlaveWatch {
    fn new(config: &SlaveConfig, stops_instantly: bool, cycle_time: f64) -> Self {
        let limits = config.limits();
        Self {
            name: config.name.to_string(),
            check: check_of(&limits, cycle_time),
            stops_quickly: limits.on_master_loss == OnMasterLoss::QuickStop,
            stops_instantly,
            before: SlaveSignals::default(),
            found: Found::default(),
        }
    }

    fn push(&mut self, cycle: &WatchedCycle, slave: &SlaveSignals) {
        let shown = [slave.position, slave.velocity, slave.acceleration];
        let shown = shown.into_iter().flatten().chain([slave.drive_position]);
        for value in shown.filter(|value| !value.is_finite()) {
            self.found.add(cycle, Invariant::Finite, value, f64::MAX);
        }
        let before = std::mem::replace(&mut self.before, *slave);
        let stops_now = self.stops_instantly && is_instant_stop(&before, slave);
        let (Some(check), Some(position)) = (&mut self.check, slave.position) else {
            return;
        };
        let is_set_anew = slave.set_anew != before.set_anew || slave.state == AxisStatus::Disabled;
        if is_set_anew || stops_now || cycle.since.is_none() {
            check.restart();
        }
        if self.stops_quickly && is_quick_stop(slave) {
            check.free_jerk();
        }
        let found = &mut self.found;
        check.push(position, cycle.since.unwrap_or(1), |excess| {
            found.add(cycle, excess.bound.into(), excess.value, excess.limit);
        });
    }
}

fn check_of(parameters: &SlaveParameters, cycle_time: f64) -> Option<SetValueCheck> {
    let SlaveParameters {
        velocity,
        acceleration,
        deceleration,
        jerk,
        ..
    } = *parameters;
    let deceleration = deceleration.unwrap_or(acceleration);
    let limits = Limits::new(velocity, acceleration, deceleration, jerk).ok()?;
    let min = parameters.min_position.unwrap_or(f64::NEG_INFINITY);
    let max = parameters.max_position.unwrap_or(f64::INFINITY);
    Some(SetValueCheck::new(&limits, [min, max], cycle_time))
}

/// The stop of a slave whose master is lost, with its full deceleration from the next cycle on.
fn is_quick_stop(slave: &SlaveSignals) -> bool {
    slave.state == AxisStatus::ErrorStop && slave.error == SlaveError::MasterLost.code()
}

/// The stop of a flying saw whose master runs back past the coupling position: it stands from one cycle to the
/// next.
fn is_instant_stop(before: &SlaveSignals, now: &SlaveSignals) -> bool {
    before.state == AxisStatus::SynchronizedMotion
        && matches!(
            now.state,
            AxisStatus::Standstill | AxisStatus::DiscreteMotion
        )
        && now.velocity == Some(0.0)
}

/// Every command that a slave may get: by its program, or by an event.
fn commands_to<'a>(
    slave: &'a SlaveConfig,
    receiver: &'a ReceiverConfig,
    events: &'a [Event],
) -> impl Iterator<Item = &'a Command> {
    let of_program = slave.steps.iter().filter_map(|step| step.command.as_ref());
    let of_events = events.iter().filter_map(move |event| match &event.what {
        Happening::Command(commanded) if event.node == receiver.name => match &commanded.order {
            CommandOrder::Slave(order) if order.slave.as_str() == slave.name.as_str() => {
                Some(&order.command)
            }
            CommandOrder::Slave(_) | CommandOrder::Far(_) => None,
        },
        _ => None,
    });
    of_program.chain(of_events)
}

fn may_stop_instantly(command: &Command) -> bool {
    let mode = match command {
        Command::GearInPos(command) => command.sync_mode,
        Command::GearInVelo(command) => command.sync_mode,
        _ => return false,
    };
    mode.mask.contains(SyncMask::INSTANT_STOP_ON_ROLLBACK)
}

/// Watches a far axis.
#[derive(Debug)]
struct AxisWatch {
    name: String,
    /// Its node, and the standbys of that, by their numbers.
    nodes: Vec<usize>,
    check: FarTimeCheck,
    /// The mode that made its set values, how often its clock was started anew by an order, and which node it is
    /// read from.
    line: Option<(StateName, u32, usize)>,
    found: Found,
}

impl AxisWatch {
    fn push(&mut self, cycle: &WatchedCycle, signals: &SignalRow, axis: &FarAxisSignals) {
        let node = self.nodes[followed_of(&self.nodes, signals)];
        let far = &signals.far[node];
        let shown = [axis.corrected_position, axis.corrected_velocity];
        for value in shown
            .into_iter()
            .flatten()
            .filter(|value| !value.is_finite())
        {
            self.found.add(cycle, Invariant::Finite, value, f64::MAX);
        }
        // From one mode to another, or from one node, it is another time: set values are led over to it.
        let line = axis
            .state
            .map(|state| (state, far.re_initialisations, node));
        let is_another = std::mem::replace(&mut self.line, line) != line;
        let shown = axis.far_time_ns.filter(|_| is_corrected(axis));
        let (Some(run), Some(time)) = (far.epoch, shown) else {
            self.check.restart();
            return;
        };
        if is_another || cycle.since.is_none() {
            self.check.restart();
        }
        let time = Instant::from_nanos(time);
        let fault = self.check.push(run, time, cycle.since.unwrap_or(1));
        let (invariant, value, limit) = match fault {
            None => return,
            // TS5066 has no bound: a new correction is blended in over 90 cycles, however large it is.
            Some(FarTimeFault::Rate(_)) if axis.state != Some(StateName::Observer) => return,
            Some(FarTimeFault::NotLater(by)) => (Invariant::FarTime, by, 0.0),
            Some(FarTimeFault::Rate(rate)) => (Invariant::FarRate, rate.abs(), LARGEST_RATE_ERROR),
        };
        self.found.add(cycle, invariant, value, limit);
    }
}

/// Whether its set values stand for a time that was calculated: in bypass they are as they came.
fn is_corrected(axis: &FarAxisSignals) -> bool {
    matches!(
        axis.state,
        Some(StateName::Sync | StateName::Time | StateName::Observer)
    )
}

/// What was found of one slave or far axis: an entry for each invariant.
#[derive(Debug, Default)]
struct Found(Vec<OfInvariant>);

#[derive(Debug)]
struct OfInvariant {
    invariant: Invariant,
    first: Broken,
    worst: Broken,
    limit: f64,
    cycles: u64,
}

impl Found {
    fn add(&mut self, cycle: &WatchedCycle, invariant: Invariant, value: f64, limit: f64) {
        let this = Broken {
            cycle: cycle.number,
            t_s: cycle.t_s,
            value,
        };
        match self.0.iter_mut().find(|known| known.invariant == invariant) {
            Some(known) => {
                known.cycles += 1;
                if (value - limit).abs() > (known.worst.value - known.limit).abs() {
                    known.worst = this;
                }
            }
            None => self.0.push(OfInvariant {
                invariant,
                first: this,
                worst: this,
                limit,
                cycles: 1,
            }),
        }
    }
}

impl OfInvariant {
    fn violation(&self, of: Watched) -> InvariantViolation {
        InvariantViolation {
            of,
            invariant: self.invariant,
            first: self.first,
            worst: self.worst,
            limit: self.limit,
            cycles: self.cycles,
        }
    }
}

impl From<SetValueBound> for Invariant {
    fn from(bound: SetValueBound) -> Self {
        match bound {
            SetValueBound::Finite => Self::Finite,
            SetValueBound::Velocity => Self::Velocity,
            SetValueBound::Acceleration => Self::Acceleration,
            SetValueBound::Jerk => Self::Jerk,
            SetValueBound::SoftwareLimit => Self::SoftwareLimit,
        }
    }
}
