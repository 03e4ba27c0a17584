//! Random commands at random moments: the axis keeps its limits in its differences, for any hand-over.
//!
//! The guarantee: no position differs from the previous ones by more than velocity, acceleration
//! and jerk of the limits allow, as long as the motion is the axis's own or leads it to its master;
//! with a synchronous slave its master's own motion counts, by the ratio, so that the master keeps
//! them here too.

use proptest::prelude::*;

use super::cams::plate;
use super::invariants::flying_gear;
use super::*;
use coaxle_axis::AxisStatus;
use coaxle_cam::{Activation, ActivationMode, CamIn, JumpHandling, ScalingMode, Tables};
use coaxle_curve::profile::{Limits, Profile, to_velocity};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode, SyncStrategy};

/// Commands; positions are relative to the axes.
#[derive(Clone, Debug)]
enum Event {
    Command(Command),
    Pos {
        ratio: f64,
        way: f64,
        share: f64,
        start_distance: Option<f64>,
        mask: SyncMask,
        strategy: Option<SyncStrategy>,
    },
    /// A flying gear that begins a little ahead of the master: ratio, the slave's distances in and out.
    Flying(f64, f64, f64),
    /// A plate, over a ramp or without one, at once or with the next cycle.
    Cam(CamIn),
    /// The master heads for a velocity.
    Master(f64),
}

fn dynamics() -> impl Strategy<Value = Dynamics> {
    let at_most = |most: f64| proptest::option::of((0.1..1.0).prop_map(move |x: f64| x * x * most));
    (at_most(5_000.0), at_most(4_000.0), at_most(100_000.0)).prop_map(
        |(acceleration, deceleration, jerk)| Dynamics {
            acceleration,
            deceleration,
            jerk,
        },
    )
}

/// Ratios that keep the slave of a master within `MASTER` within its own limits.
fn ratio() -> impl Strategy<Value = f64> {
    prop_oneof![-1.5..-0.1, 0.1..1.5]
}

fn masks() -> impl Strategy<Value = SyncMask> {
    prop_oneof![
        Just(SyncMask::empty()),
        Just(SyncMask::PREFER_CONST_VELO),
        Just(SyncMask::OVERSHOOT_VELO),
        Just(SyncMask::MAX_DYNAMICS),
    ]
}

fn strategies() -> impl Strategy<Value = Option<SyncStrategy>> {
    proptest::option::of(prop::sample::select(SyncStrategy::ALL.as_slice()))
}

fn events() -> impl Strategy<Value = (Event, u32)> {
    let gear = (ratio(), dynamics()).prop_map(|(ratio, dynamics)| GearIn { ratio, dynamics });
    let to_velocity = (ratio(), masks(), any::<bool>()).prop_map(|(ratio, mask, time_based)| {
        Command::GearInVelo(GearInVelo {
            ratio: Ratio::of(ratio),
            sync_mode: if time_based {
                SyncMode::time_based(mask)
            } else {
                SyncMode::position_based(mask)
            },
            limits: SyncLimits::default(),
        })
    });
    let to_position = (
        (ratio(), 20.0..900.0, 0.2..1.5),
        proptest::option::of(20.0..400.0),
        (masks(), strategies()),
    )
        .prop_map(
            |((ratio, way, share), start_distance, (mask, strategy))| Event::Pos {
                ratio,
                way,
                share,
                start_distance,
                mask,
                strategy,
            },
        );
    let command = prop_oneof![
        2 => (-900.0..900.0, dynamics()).prop_map(|(distance, dynamics)| Command::MoveRelative {
            distance,
            velocity: None,
            dynamics,
        }),
        1 => (-900.0..900.0).prop_map(move_absolute),
        2 => (-900.0..900.0, dynamics())
            .prop_map(|(velocity, dynamics)| Command::MoveVelocity { velocity, dynamics }),
        2 => dynamics().prop_map(|dynamics| Command::Halt { dynamics }),
        1 => dynamics().prop_map(|dynamics| Command::Stop { dynamics }),
        1 => Just(Command::GearOut {}),
        4 => gear.prop_map(Command::GearIn),
        2 => (ratio(), dynamics(), any::<bool>()).prop_map(|(ratio, dynamics, position)| {
            let ratios = Ratios::new(&[ratio]).expect("a ratio");
            let sync_mode = match position {
                true => MultiMasterSync::PosSync2,
                false => MultiMasterSync::PosSync1,
            };
            Command::GearInMultiMaster(GearInMultiMaster { ratios, dynamics, sync_mode })
        }),
        4 => to_velocity,
    ];
    let cam = (
        1_u32..3,
        proptest::option::of(20.0..400.0),
        any::<bool>(),
        0.2..1.0,
    )
        .prop_map(|(table, ramp, at_once, slave_scaling)| CamIn {
            table,
            slave_scaling,
            slave_scaling_mode: ScalingMode::AutoOffset,
            activation: Activation::new(if at_once {
                ActivationMode::Instantaneous
            } else {
                ActivationMode::NextCycle
            }),
            jump: ramp.map_or(JumpHandling::Refuse, |master_length| JumpHandling::RampIn {
                master_length,
            }),
            ..CamIn::default()
        });
    let event = prop_oneof![
        2 => cam.prop_map(Event::Cam),
        2 => (ratio(), 5.0..200.0, -200.0..200.0)
            .prop_map(|(ratio, way_in, way_out)| Event::Flying(ratio, way_in, way_out)),
        6 => command.prop_map(Event::Command),
        3 => to_position,
        1 => (-400.0..400.0).prop_map(Event::Master),
    ];
    (event, 1_u32..400)
}

/// A master that keeps limits: times 1.5 still less than those of the slave.
struct Smooth {
    master: Master,
    profile: Profile,
    since: Seconds,
}

impl Smooth {
    fn at(velocity: f64) -> Self {
        let master = Master::at(0.0, velocity);
        Self {
            master,
            profile: to_velocity(&master.0, velocity, &Self::limits()),
            since: Seconds::ZERO,
        }
    }

    fn limits() -> Limits {
        Limits::new(500.0, 500.0, 500.0, 5_000.0).expect("above zero")
    }

    fn head(&mut self, velocity: f64) {
        self.profile = to_velocity(&self.master.0, velocity, &Self::limits());
        self.since = Seconds::ZERO;
    }

    fn lead(&mut self, axis: &mut AxisWithPlates) {
        self.since = self.since + CYCLE;
        self.master.0 = self.profile.at(self.since);
        axis.update(Some(&self.master.0), CYCLE);
    }

    /// A saw is planned for a master that keeps its velocity.
    fn is_steady(&self) -> bool {
        self.master.0.acceleration == 0.0
    }
}

/// A powered axis with two plates: 8 and 12 u high, over 200 u.
fn with_plates() -> AxisWithPlates {
    let mut axis = powered(&PARAMETERS);
    let mut tables = Tables::new(2);
    for (id, top) in [(1, 8.0), (2, 12.0)] {
        tables.insert(id, plate(top)).expect("room");
    }
    axis.select_cams(tables, 1, 2).expect("limits");
    axis
}

/// The command of an event; none if it is for the master, or not applicable.
fn command_of(event: &Event, master: &Smooth, axis: &AxisWithPlates) -> Option<Command> {
    let here = master.master.0;
    match event {
        _ if !master.is_steady() && !matches!(event, Event::Command(_)) => None,
        Event::Command(Command::GearInVelo(_)) if !master.is_steady() => None,
        Event::Flying(ratio, way_in, way_out) => Some(Command::from(flying_gear(
            &axis.set(),
            &here,
            *ratio,
            *way_in,
            *way_out,
        ))),
        Event::Cam(command) => Some(Command::CamIn(*command)),
        Event::Command(command) => Some(*command),
        Event::Pos {
            ratio,
            way,
            share,
            start_distance,
            mask,
            strategy,
        } => {
            let way = way.copysign(here.velocity);
            Some(Command::from(GearInPos {
                ratio: Ratio::of(*ratio),
                master_sync_position: here.position + way,
                slave_sync_position: axis.set().position + ratio * way * share,
                master_start_distance: *start_distance,
                strategy: *strategy,
                sync_mode: SyncMode::position_based(*mask),
                limits: SyncLimits::default(),
            }))
        }
        Event::Master(_) => None,
    }
}

proptest! {


    #[test]
    fn whatever_takes_over_keeps_the_limits_in_its_differences(
        events in proptest::collection::vec(events(), 1..20),
        velocity in -400.0..400.0,
    ) {
        let mut axis = with_plates();
        let mut master = Smooth::at(velocity);
        // A plate's own jerk is added to that of the ramp onto it.
        let on_plate = SlaveParameters { jerk: 1.5 * PARAMETERS.jerk, ..PARAMETERS };
        let (mut rides, mut since_plate) = (false, u32::MAX);
        let mut differences = Differences::of(&axis);
        master.lead(&mut axis);
        for (event, cycles) in events {
            if let Some(command) = command_of(&event, &master, &axis)
                && axis.command(&command).is_ok()
            {
                rides = matches!(command, Command::CamIn(_));
            }
            if let Event::Master(velocity) = event && axis.status() != AxisStatus::SynchronizedMotion {
                master.head(velocity);
            }
            for _ in 0..cycles {
                master.lead(&mut axis);
                since_plate = if rides { 0 } else { since_plate.saturating_add(1) };
                let limits = if since_plate < 3 { &on_plate } else { &PARAMETERS };
                if let Err(why) = differences.check(&axis, limits) {
                    prop_assert!(false, "{:?}: {} {:?}", event, why, axis.set());
                }
                prop_assert_eq!(axis.error(), None, "{:?}", event);
            }
        }
    }
}
