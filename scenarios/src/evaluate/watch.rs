//! A receiver's slaves and far axes, watched for what must hold in every cycle.

use coaxle_axis::AxisStatus;
use coaxle_clock::Instant;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, SlaveSignals};
use coaxle_receiver::{ReceiverConfig, SignalRow, SlaveConfig, StateName};
use coaxle_saw::SyncMask;
use coaxle_sim::{
    ErrorStopCheck, FarTimeCheck, FarTimeFault, LARGEST_RATE_ERROR, SetValueBound, SetValueCheck,
    Shares, TooFar,
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
            used: None,
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
    stop: Option<ErrorStopCheck>,
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
        let profile = profile_limits(&limits);
        let check = |profile| SetValueCheck::new(&profile, software_limits(&limits), cycle_time);
        Self {
            name: config.name.to_string(),
            check: profile.map(check),
            stop: profile.map(|profile| ErrorStopCheck::new(profile, cycle_time)),
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
        self.watch_error_stop(cycle, &before, slave);
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

impl SlaveWatch {
    fn watch_error_stop(
        &mut self,
        cycle: &WatchedCycle,
        before: &SlaveSignals,
        slave: &SlaveSignals,
    ) {
        let is_next = cycle.since.is_some();
        let was_stopped = is_next && before.state == AxisStatus::ErrorStop;
        if was_stopped && !follows_error_stop(slave.state) {
            let velocity = slave.velocity.unwrap_or_default().abs();
            (self.found).add(cycle, Invariant::ErrorLatch, velocity, 0.0);
        }
        let Some(stop) = &mut self.stop else {
            return;
        };
        if slave.state != AxisStatus::ErrorStop || slave.set_anew != before.set_anew || !is_next {
            stop.restart();
        }
        let (AxisStatus::ErrorStop, Some(position)) = (slave.state, slave.position) else {
            return;
        };
        let set = Kinematics {
            position,
            velocity: slave.velocity.unwrap_or_default(),
            acceleration: slave.acceleration.unwrap_or_default(),
        };
        if let Some(TooFar { way, most }) = stop.push(&set) {
            self.found.add(cycle, Invariant::StoppingWay, way, most);
        }
    }
}

fn profile_limits(parameters: &SlaveParameters) -> Option<Limits> {
    let SlaveParameters {
        velocity,
        acceleration,
        deceleration,
        jerk,
        ..
    } = *parameters;
    let deceleration = deceleration.unwrap_or(acceleration);
    Limits::new(velocity, acceleration, deceleration, jerk).ok()
}

fn software_limits(parameters: &SlaveParameters) -> [f64; 2] {
    let min = parameters.min_position.unwrap_or(f64::NEG_INFINITY);
    [min, parameters.max_position.unwrap_or(f64::INFINITY)]
}

/// Whether a slave that was in error stop may be in this state next.
const fn follows_error_stop(state: AxisStatus) -> bool {
    matches!(
        state,
        AxisStatus::ErrorStop | AxisStatus::Standstill | AxisStatus::Disabled
    )
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
    /// The frame that was used last.
    used: Option<Used>,
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
        let used = Used::of(node, far);
        let before = std::mem::replace(&mut self.used, used);
        if let (Some(before), Some(used)) = (before, used)
            && before.run == used.run
            && cycle.since.is_some()
            && used.count < before.count
        {
            (self.found).add(
                cycle,
                Invariant::Count,
                used.count as f64,
                before.count as f64,
            );
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

/// A frame that was used.
#[derive(Clone, Copy, Debug)]
struct Used {
    /// The node, its epoch, and how many runs of it were followed: within an epoch the count may begin anew once, as
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

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;
    use coaxle_receiver::signals::NodeSignals;

    const CONFIG: &str = "name = 'saw'\ncycle-time-us = 1000\nmaster = { node = 'belt' }\n[[slave]]\nname = 'x'\n\
                          limits = { velocity = 500, acceleration = 1000, jerk = 1e5 }\n";

    /// The invariants that rows break, a cycle apart.
    fn broken(rows: impl IntoIterator<Item = SignalRow>) -> Vec<Invariant> {
        let config: ReceiverConfig = parse("saw.toml", CONFIG).expect("a config");
        let mut watch = ReceiverWatch::new(&config, &[]);
        for (cycle, mut row) in (1..).zip(rows) {
            row.node.cycle = cycle;
            watch.push(cycle as f64 * 1e-3, &row);
        }
        watch.violations().map(|found| found.invariant).collect()
    }

    fn row(slave: SlaveSignals, far: FarNodeSignals) -> SignalRow {
        SignalRow {
            node: NodeSignals::default(),
            far: [far].into(),
            axes: [FarAxisSignals::default()].into(),
            virtual_axes: [].into(),
            slaves: [slave].into(),
        }
    }

    fn in_state(state: AxisStatus, position: f64, velocity: f64) -> SignalRow {
        let slave = SlaveSignals {
            state,
            position: Some(position),
            velocity: Some(velocity),
            ..SlaveSignals::default()
        };
        row(slave, FarNodeSignals::default())
    }

    #[test]
    fn error_stop_is_left_for_rest_only() {
        use AxisStatus::{DiscreteMotion, ErrorStop, Standstill};
        let states =
            |states: &[AxisStatus]| broken(states.iter().map(|state| in_state(*state, 0.0, 0.0)));
        assert_eq!(
            states(&[DiscreteMotion, ErrorStop, ErrorStop, Standstill]),
            []
        );
        assert_eq!(
            states(&[ErrorStop, DiscreteMotion]),
            [Invariant::ErrorLatch]
        );
    }

    #[test]
    fn error_stop_comes_to_rest() {
        let on = (0..200).map(|k| in_state(AxisStatus::ErrorStop, 0.3 * f64::from(k), 300.0));
        assert_eq!(broken(on), [Invariant::StoppingWay]);
    }

    #[test]
    fn a_count_goes_back_with_another_run_only() {
        let used = |used: &[(u64, u64)]| {
            let row = |(epoch, count): &(u64, u64)| {
                let far = FarNodeSignals {
                    followed: true,
                    epoch: Some(*epoch),
                    count: Some(*count),
                    ..FarNodeSignals::default()
                };
                row(SlaveSignals::default(), far)
            };
            broken(used.iter().map(row))
        };
        assert_eq!(used(&[(1, 5), (1, 5), (1, 7), (2, 0), (2, 1)]), []);
        assert_eq!(used(&[(1, 5), (1, 4)]), [Invariant::Count]);
    }
}
