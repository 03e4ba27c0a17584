//! Invariants for any commands and any motion of the master.

use proptest::prelude::*;
use std::vec;

use super::*;
use coaxle_axis::AxisStatus;
use coaxle_axis::drive::DriveState;
use coaxle_gear::FlyingGearParameters;
use coaxle_saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode, SyncStrategy};

/// Event before a cycle.
#[derive(Clone, Debug)]
pub(super) enum Event {
    Command(Command),
    /// A gear with the ratio of the present velocities.
    GearHere,
    /// A flying saw to the velocity of a gear.
    VeloHere(GearInVelo),
    /// A flying saw to positions this far ahead: of the master, and per that of the slave.
    PosHere(GearInPos, f64, f64),
    /// A flying gear that begins a little ahead of the master: ratio, the slave's distances in and out.
    FlyingHere(f64, f64, f64),
    /// The master is lost for some cycles.
    Lost(u32),
    /// The master jumps: a beat, or a restart of its sender.
    Jump(f64),
    /// The master heads for a velocity at an acceleration.
    Head(f64, f64),
    /// A set value of the master is no number.
    Garbage,
}

/// A number spread evenly over decades.
pub(super) fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|exponent| libm::pow(10.0, exponent))
}

fn parameters() -> impl Strategy<Value = SlaveParameters> {
    (
        (decades(1.0, 3.5), decades(2.0, 4.5), decades(2.0, 4.5)),
        decades(2.0, 7.0),
        any::<bool>(),
    )
        .prop_map(
            |((velocity, acceleration, deceleration), jerk, quick)| SlaveParameters {
                velocity,
                acceleration,
                deceleration: Some(deceleration),
                jerk,
                on_master_loss: if quick {
                    OnMasterLoss::QuickStop
                } else {
                    OnMasterLoss::Stop
                },
                ..LIMITED
            },
        )
}

fn dynamics(parameters: &SlaveParameters) -> impl Strategy<Value = Dynamics> + use<> {
    let at_most =
        |most: f64| proptest::option::of((0.01..1.0).prop_map(move |x: f64| x * x * most));
    (
        at_most(parameters.acceleration),
        at_most(parameters.deceleration.unwrap_or(0.0)),
        at_most(parameters.jerk),
    )
        .prop_map(|(acceleration, deceleration, jerk)| Dynamics {
            acceleration,
            deceleration,
            jerk,
        })
}

pub(super) fn commands(parameters: &SlaveParameters) -> impl Strategy<Value = Command> + use<> {
    let most = parameters.velocity;
    let velocity = || proptest::option::of(most / 1_000.0..most);
    let dynamics = || dynamics(parameters);
    prop_oneof![
        1 => any::<bool>().prop_map(Command::Power),
        3 => Just(Command::Power(true)),
        3 => Just(Command::Reset {}),
        3 => (-100.0..1_000.0, velocity(), dynamics()).prop_map(|(position, velocity, dynamics)| {
            Command::MoveAbsolute { position, velocity, dynamics }
        }),
        2 => (-500.0..500.0, velocity(), dynamics()).prop_map(|(distance, velocity, dynamics)| {
            Command::MoveRelative { distance, velocity, dynamics }
        }),
        3 => (-most..most, dynamics()).prop_map(|(velocity, dynamics)| {
            Command::MoveVelocity { velocity, dynamics }
        }),
        1 => dynamics().prop_map(|dynamics| Command::Halt { dynamics }),
        1 => dynamics().prop_map(|dynamics| Command::Stop { dynamics }),
        4 => (-3.0..3.0).prop_map(|ratio| Command::GearIn(GearIn::of(ratio))),
        2 => Just(Command::GearOut {}),
        1 => (-100.0..1_000.0).prop_map(|position| Command::Home { position }),
    ]
}

/// Few checks, as usual in practice, or any.
fn sync_mode(time_based: bool) -> impl Strategy<Value = SyncMode> {
    let few = (any::<u32>(), any::<u32>()).prop_map(|(a, b)| a & b & 0x0073_0000);
    prop_oneof![4 => few, 1 => any::<u32>()]
        .prop_map(SyncMask::from_bits_truncate)
        .prop_map(move |mask| {
            if time_based {
                SyncMode::time_based(mask)
            } else {
                SyncMode::position_based(mask)
            }
        })
}

fn sync_limits(parameters: &SlaveParameters) -> impl Strategy<Value = SyncLimits> + use<> {
    let about = |most: f64| proptest::option::of((0.05..1.2).prop_map(move |x: f64| x * most));
    (
        about(parameters.velocity),
        about(parameters.acceleration),
        about(parameters.deceleration.unwrap_or(0.0)),
        about(parameters.jerk),
    )
        .prop_map(|(velocity, acceleration, deceleration, jerk)| SyncLimits {
            velocity,
            acceleration,
            deceleration,
            jerk,
            ..SyncLimits::default()
        })
}

fn gear_in_velo(parameters: &SlaveParameters) -> impl Strategy<Value = Event> + use<> {
    let mode = any::<bool>().prop_flat_map(sync_mode);
    (-3.0..3.0, mode, sync_limits(parameters)).prop_map(|(ratio, sync_mode, limits)| {
        Event::VeloHere(GearInVelo {
            ratio: Ratio::of(ratio),
            sync_mode,
            limits,
        })
    })
}

pub(super) fn gear_in_pos(parameters: &SlaveParameters) -> impl Strategy<Value = Event> + use<> {
    let ahead = (1.0..200.0, 0.1..1.5);
    let start = proptest::option::of(1.0..200.0);
    let strategy = proptest::option::of(prop::sample::select(SyncStrategy::ALL.as_slice()));
    (
        -3.0..3.0,
        sync_mode(false),
        sync_limits(parameters),
        ahead,
        (start, strategy),
    )
        .prop_map(
            |(ratio, sync_mode, limits, (master, share), (master_start_distance, strategy))| {
                let command = GearInPos {
                    ratio: Ratio::of(ratio),
                    master_sync_position: 0.0,
                    slave_sync_position: 0.0,
                    master_start_distance,
                    strategy,
                    sync_mode,
                    limits,
                };
                Event::PosHere(command, master, share)
            },
        )
}

fn events(parameters: &SlaveParameters) -> impl Strategy<Value = (Event, u32)> + use<> {
    let event = prop_oneof![
        8 => commands(parameters).prop_map(Event::Command),
        4 => Just(Event::GearHere),
        3 => (-3.0..3.0, -100.0..100.0, -200.0..200.0)
            .prop_map(|(ratio, way_in, way_out)| Event::FlyingHere(ratio, way_in, way_out)),
        4 => gear_in_velo(parameters),
        6 => gear_in_pos(parameters),
        1 => (1_u32..5).prop_map(Event::Lost),
        1 => (-5.0..5.0).prop_map(Event::Jump),
        3 => (-300.0..300.0, 10.0..3_000.0).prop_map(|(v, a)| Event::Head(v, a)),
        1 => Just(Event::Garbage),
    ];
    (event, 0_u32..150)
}

/// A master with a drifting clock.
pub(super) struct Conveyor {
    state: Kinematics,
    target: f64,
    push: f64,
    drift: f64,
}

impl Conveyor {
    pub(super) fn at_rest() -> Self {
        Self {
            state: Kinematics::at_rest(0.0),
            target: 0.0,
            push: 1_000.0,
            drift: 1.0,
        }
    }

    pub(super) const fn state(&self) -> Kinematics {
        self.state
    }

    pub(super) const fn head_for(&mut self, velocity: f64, push: f64) {
        (self.target, self.push) = (velocity, push);
    }

    pub(super) fn jump(&mut self, by: f64) {
        self.state.position += by;
    }

    pub(super) fn step(&mut self, dt: f64) {
        let dt = dt * self.drift;
        let missing = self.target - self.state.velocity;
        let change = missing.clamp(-self.push * dt, self.push * dt);
        self.state.acceleration = change / dt;
        self.state.position += (self.state.velocity + change / 2.0) * dt;
        self.state.velocity += change;
    }
}

/// Engaged over `way_in` in the master's direction, soon released over `way_out`.
pub(super) fn flying_gear(
    slave: &Kinematics,
    master: &Kinematics,
    ratio: f64,
    way_in: f64,
    way_out: f64,
) -> FlyingGearParameters {
    let way_in = way_in.abs() * (master.velocity * ratio).signum();
    let ahead = 2.0 * way_in / ratio + master.velocity * 0.02;
    let sync = slave.position + way_in;
    FlyingGearParameters {
        ratio,
        master_sync_position: master.position + ahead,
        slave_sync_position: sync,
        slave_desync_position: sync + way_in,
        slave_stop_position: sync + way_in + way_out,
        default_slave_negative: way_in < 0.0,
    }
}

/// Checks one cycle: the set values are finite and within the software limits, and the positions
/// keep velocity, acceleration and jerk in their differences, for any stated velocity.
fn keep(axis: &AxisWithPlates, differences: &mut Differences, parameters: &SlaveParameters) {
    let now = axis.set();
    let finite = [now.position, now.velocity, now.acceleration];
    assert!(finite.into_iter().all(f64::is_finite), "{now:?}");
    let range =
        parameters.min_position.unwrap_or(f64::MIN)..=parameters.max_position.unwrap_or(f64::MAX);
    assert!(range.contains(&now.position), "{now:?}");
    // Without power the axis is at its drive's position.
    let unpowered = axis.actual().state != DriveState::Following;
    if unpowered || axis.status() == AxisStatus::Homing {
        differences.begin_anew();
    }
    // This reaction ignores the jerk limit.
    let quick = axis.status() == AxisStatus::ErrorStop
        && parameters.on_master_loss == OnMasterLoss::QuickStop;
    let jerk = if quick { 1e15 } else { parameters.jerk };
    differences.keep(
        axis,
        &SlaveParameters {
            jerk,
            ..*parameters
        },
    );
}

proptest! {
    #[test]
    fn the_set_values_keep_their_limits(
        (parameters, events) in parameters().prop_flat_map(|parameters| {
            let events = proptest::collection::vec(events(&parameters), 1..60);
            (Just(parameters), events)
        }),
        drift_ppm in -200.0..200.0,
        // A node may miss a cycle.
        cycles_at_once in 1_u32..3,
    ) {
        let mut axis = powered(&parameters);
        let mut master = Conveyor {
            drift: 1.0 + drift_ppm * 1e-6,
            ..Conveyor::at_rest()
        };
        let dt = CYCLE.0 * f64::from(cycles_at_once);
        let mut differences = Differences::every(&axis, dt);
        let mut stops_instantly = false;
        for (event, cycles) in events {
            let (mut lost, mut garbage) = (0, false);
            let failed = axis.status() == AxisStatus::ErrorStop;
            let before = axis.set();
            let mut saw = |axis: &mut AxisWithPlates, command: Command, mask: SyncMask| {
                if axis.command(&command).is_ok() {
                    stops_instantly = mask.contains(SyncMask::INSTANT_STOP_ON_ROLLBACK);
                }
            };
            match event {
                Event::Command(command) => {
                    let accepted = axis.command(&command).is_ok();
                    if matches!(command, Command::Home { .. } | Command::Power(_)) {
                        differences.begin_anew();
                    }
                    if failed && accepted {
                        let harmless = matches!(command, Command::Power(_) | Command::Reset {});
                        prop_assert!(harmless, "{:?}", command);
                    }
                    if failed && axis.status() != AxisStatus::ErrorStop {
                        prop_assert_eq!(command, Command::Reset {});
                        if parameters.on_master_loss == OnMasterLoss::QuickStop {
                            // The quick stop may have ended just now.
                            differences.begin_anew();
                        }
                    }
                }
                Event::GearHere => {
                    let ratio = before.velocity / master.state.velocity;
                    let _ = axis.command(&Command::GearIn(GearIn::of(ratio)));
                }
                Event::FlyingHere(ratio, way_in, way_out) => {
                    let gear = flying_gear(&before, &master.state, ratio, way_in, way_out);
                    let _ = axis.command(&Command::from(gear));
                }
                Event::VeloHere(command) => {
                    saw(&mut axis, Command::GearInVelo(command), command.sync_mode.mask);
                }
                Event::PosHere(command, way, share) => {
                    let way = way.copysign(master.state.velocity);
                    let slave = command.ratio.numerator * way * share;
                    let command = GearInPos {
                        master_sync_position: master.state.position + way,
                        slave_sync_position: before.position + slave,
                        ..command
                    };
                    saw(&mut axis, Command::from(command), command.sync_mode.mask);
                }
                Event::Lost(count) => lost = count,
                Event::Jump(by) => master.jump(by),
                Event::Head(velocity, push) => master.head_for(velocity, push),
                Event::Garbage => garbage = true,
            }
            if !matches!(axis.status(), AxisStatus::Homing | AxisStatus::Disabled) {
                prop_assert!((axis.set().position - before.position).abs() <= parameters.velocity * dt);
            }
            for _ in 0..=cycles {
                let failed = axis.status() == AxisStatus::ErrorStop;
                let was = axis.error().map(|error| error.code());
                master.step(dt);
                let seen = Kinematics {
                    velocity: if garbage { f64::NAN } else { master.state.velocity },
                    ..master.state
                };
                let coupled = axis.status() == AxisStatus::SynchronizedMotion;
                let heard = lost == 0;
                lost = lost.saturating_sub(1);
                let now = axis.update(heard.then_some(&seen), Seconds(dt));
                if stops_instantly && coupled && now == Kinematics::at_rest(now.position) {
                    differences.begin_anew();
                }
                keep(&axis, &mut differences, &parameters);
                if failed {
                    prop_assert_eq!(axis.status(), AxisStatus::ErrorStop);
                    prop_assert_eq!(axis.error().map(|error| error.code()), was);
                }
                prop_assert_eq!(axis.error().is_some(), axis.status() == AxisStatus::ErrorStop);
            }
        }
    }
}
