//! Commands to a slave axis, from bytes: each of them, with values near those of the axis and its master.

use coaxle_cam::{
    Activation, ActivationMode, AxisScaling, CamAdd, CamExchange, CamIn, CamInV2, CamRemove,
    CamScaling, CamScalingV2, JumpHandling, OnlineChangeMode, OperationMode, ScalingData,
    ScalingMode, StartMode,
};
use coaxle_curve::law::MotionLaw;
use coaxle_curve::profile::Kinematics;
use coaxle_gear::{FlyingGearParameters, GearIn, GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_plate::MotionPoint;
use coaxle_saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode, SyncStrategy};
use coaxle_slave::{CamPoints, Command, Dynamics, SlaveParameters, SyncPosition};

use crate::bytes::Bytes;

/// Plates of the axis; 4 is unknown.
const TABLES: [u32; 5] = [1, 2, 3, 4, 0];

/// Number of commands that are read.
pub(crate) const COMMANDS: u8 = 27;

/// Axis, master and limits that the values refer to.
pub(crate) struct Around {
    pub(crate) limits: SlaveParameters,
    pub(crate) slave: Kinematics,
    pub(crate) master: Kinematics,
}

/// Reads a command of this number; none at the end of the input.
pub(crate) fn command(number: u8, bytes: &mut Bytes<'_>, around: &Around) -> Option<Command> {
    let most = around.limits.velocity;
    Some(match number % COMMANDS {
        0 => Command::Power(bytes.bit()?),
        1 => Command::Reset {},
        2 => Command::MoveAbsolute {
            position: 1_000.0 * bytes.share()?,
            velocity: velocity(bytes, most)?,
            dynamics: dynamics(bytes, around)?,
        },
        3 => Command::MoveRelative {
            distance: distance(bytes)?,
            velocity: velocity(bytes, most)?,
            dynamics: dynamics(bytes, around)?,
        },
        4 => Command::MoveVelocity {
            velocity: most * bytes.share()?,
            dynamics: dynamics(bytes, around)?,
        },
        5 => Command::Halt {
            dynamics: dynamics(bytes, around)?,
        },
        6 => Command::Stop {
            dynamics: dynamics(bytes, around)?,
        },
        7 => Command::Home {
            position: distance(bytes)?,
        },
        8 => Command::GearIn(GearIn {
            ratio: ratio(bytes, around)?,
            dynamics: dynamics(bytes, around)?,
        }),
        9 => Command::GearInMultiMaster(multi_master(bytes, around)?),
        10 => Command::PhasingAbsolute {
            shift: distance(bytes)?,
            velocity: velocity(bytes, most)?,
            dynamics: dynamics(bytes, around)?,
        },
        11 => Command::PhasingRelative {
            shift: distance(bytes)?,
            velocity: velocity(bytes, most)?,
            dynamics: dynamics(bytes, around)?,
        },
        12 => Command::MoveSuperimposed {
            distance: distance(bytes)?,
            velocity: velocity(bytes, most)?,
            dynamics: dynamics(bytes, around)?,
        },
        13 => Command::GearOut {},
        14 => Command::FlyingGear(flying_gear(bytes, around)?),
        15 => Command::GearInPos(gear_in_pos(bytes, around)?),
        16 => Command::GearInVelo(GearInVelo {
            ratio: Ratio::of(ratio(bytes, around)?),
            sync_mode: sync_mode(bytes)?,
            limits: sync_limits(bytes, around)?,
        }),
        17 => Command::CamOut {},
        18 => Command::SetCamOnlineChangeMode {
            table: bytes.one_of(&TABLES)?,
            mode: OnlineChangeMode {
                activation: activation(bytes, around)?,
                master_scaling_mode: bytes.one_of(&MODES)?,
                slave_scaling_mode: bytes.one_of(&MODES)?,
                jump: jump(bytes)?,
            },
        },
        19 => Command::WriteMotionFunction {
            table: bytes.one_of(&TABLES)?,
            points: points(bytes)?,
        },
        other => cam_command(other, bytes, around)?,
    })
}

const MODES: [ScalingMode; 3] = [
    ScalingMode::UserDefined,
    ScalingMode::AutoOffset,
    ScalingMode::Off,
];

fn cam_command(number: u8, bytes: &mut Bytes<'_>, around: &Around) -> Option<Command> {
    let activation = activation(bytes, around)?;
    let table = bytes.one_of(&TABLES)?;
    let jump = jump(bytes)?;
    let scaling = ScalingData {
        master: scaling(bytes)?,
        slave: scaling(bytes)?,
    };
    Some(match number {
        20 => Command::CamIn(CamIn {
            table,
            start_mode: bytes.one_of(&[
                StartMode::Absolute,
                StartMode::Relative,
                StartMode::MasterAbsoluteSlaveRelative,
                StartMode::MasterRelativeSlaveAbsolute,
            ])?,
            master_offset: scaling.master.offset,
            slave_offset: scaling.slave.offset,
            master_scaling: scaling.master.scaling,
            slave_scaling: scaling.slave.scaling,
            activation,
            master_scaling_mode: scaling.master.mode,
            slave_scaling_mode: scaling.slave.mode,
            jump,
        }),
        21 => Command::CamScaling(CamScaling {
            activation,
            scaling,
            jump,
        }),
        22 => Command::CamInV2(CamInV2 {
            activation,
            table,
            scaling,
            operation: bytes.one_of(&[
                OperationMode::Default,
                OperationMode::Additive,
                OperationMode::Exchange,
                OperationMode::Remove,
            ])?,
            reference: bytes.one_of(&TABLES)?,
            jump,
        }),
        23 => Command::CamAdd(CamAdd {
            activation,
            table,
            scaling,
            jump,
        }),
        24 => Command::CamExchange(CamExchange {
            activation,
            table,
            reference: bytes.one_of(&TABLES)?,
            scaling,
            jump,
        }),
        25 => Command::CamRemove(CamRemove {
            activation,
            table,
            jump,
        }),
        _ => Command::CamScalingV2(CamScalingV2 {
            activation,
            table,
            scaling,
            jump,
        }),
    })
}

/// A distance or a position, u: mostly some units, rarely a million.
fn distance(bytes: &mut Bytes<'_>) -> Option<f64> {
    let share = bytes.share()?;
    Some(share * bytes.one_of(&[1.0, 30.0, 1_000.0, 1e6])?)
}

fn velocity(bytes: &mut Bytes<'_>, most: f64) -> Option<Option<f64>> {
    bytes.option(|bytes| Some(most * bytes.decades(-3.0, 0.1)?))
}

fn dynamics(bytes: &mut Bytes<'_>, around: &Around) -> Option<Dynamics> {
    // One byte for the usual case: those of the axis.
    if bytes.bit()? {
        return Some(Dynamics::default());
    }
    let SlaveParameters {
        acceleration,
        deceleration,
        jerk,
        ..
    } = around.limits;
    let mut below = |most: f64| bytes.option(|bytes| Some(most * bytes.decades(-4.0, 0.1)?));
    Some(Dynamics {
        acceleration: below(acceleration)?,
        deceleration: below(deceleration.unwrap_or(acceleration))?,
        jerk: below(jerk)?,
    })
}

/// A ratio up to 3, or that of the present velocities.
fn ratio(bytes: &mut Bytes<'_>, around: &Around) -> Option<f64> {
    if bytes.bit()? {
        return Some(around.slave.velocity / around.master.velocity);
    }
    Some(3.0 * bytes.share()?)
}

fn multi_master(bytes: &mut Bytes<'_>, around: &Around) -> Option<GearInMultiMaster> {
    let count = 1 + usize::from(bytes.byte()? % 4);
    let mut ratios = [0.0; 4];
    for one in &mut ratios[..count] {
        *one = 2.0 * bytes.share()?;
    }
    Some(GearInMultiMaster {
        ratios: Ratios::new(&ratios[..count]).ok()?,
        dynamics: dynamics(bytes, around)?,
        sync_mode: bytes.one_of(&[MultiMasterSync::PosSync1, MultiMasterSync::PosSync2])?,
    })
}

/// A position of an axis: mostly ahead of it.
fn ahead(bytes: &mut Bytes<'_>, of: &Kinematics) -> Option<SyncPosition> {
    let way = 200.0 * bytes.share()?;
    Some(match bytes.byte()? % 4 {
        0 => SyncPosition::At(way),
        1 => SyncPosition::InTurn(way),
        2 => SyncPosition::Ahead(way),
        _ => SyncPosition::At(of.position + way),
    })
}

fn flying_gear(
    bytes: &mut Bytes<'_>,
    around: &Around,
) -> Option<FlyingGearParameters<SyncPosition>> {
    Some(FlyingGearParameters {
        ratio: ratio(bytes, around)?,
        master_sync_position: ahead(bytes, &around.master)?,
        slave_sync_position: ahead(bytes, &around.slave)?,
        slave_desync_position: ahead(bytes, &around.slave)?,
        slave_stop_position: ahead(bytes, &around.slave)?,
        default_slave_negative: bytes.bit()?,
    })
}

fn gear_in_pos(bytes: &mut Bytes<'_>, around: &Around) -> Option<GearInPos<SyncPosition>> {
    let strategies = [
        None,
        Some(SyncStrategy::Late),
        Some(SyncStrategy::Slow),
        Some(SyncStrategy::Early),
    ];
    Some(GearInPos {
        ratio: Ratio::of(ratio(bytes, around)?),
        master_sync_position: ahead(bytes, &around.master)?,
        slave_sync_position: ahead(bytes, &around.slave)?,
        master_start_distance: bytes.option(|bytes| Some(200.0 * bytes.share()?))?,
        strategy: bytes.one_of(&strategies)?,
        sync_mode: sync_mode(bytes)?,
        limits: sync_limits(bytes, around)?,
    })
}

fn sync_mode(bytes: &mut Bytes<'_>) -> Option<SyncMode> {
    let kind = bytes.byte()?;
    // Most checks refuse most inputs: none of them is the most frequent case.
    let mask = if kind & 2 == 0 {
        0
    } else {
        u32::from_le_bytes([bytes.byte()?, bytes.byte()?, bytes.byte()?, bytes.byte()?])
    };
    let mask = SyncMask::from_bits_truncate(mask);
    Some(if kind & 1 == 0 {
        SyncMode::position_based(mask)
    } else {
        SyncMode::time_based(mask)
    })
}

fn sync_limits(bytes: &mut Bytes<'_>, around: &Around) -> Option<SyncLimits> {
    if bytes.bit()? {
        return Some(SyncLimits::default());
    }
    let limits = around.limits;
    let mut about = |most: f64| bytes.option(|bytes| Some(most * bytes.decades(-2.0, 0.1)?));
    Some(SyncLimits {
        velocity: about(limits.velocity)?,
        acceleration: about(limits.acceleration)?,
        deceleration: about(limits.acceleration)?,
        jerk: about(limits.jerk)?,
        ..SyncLimits::default()
    })
}

fn activation(bytes: &mut Bytes<'_>, around: &Around) -> Option<Activation> {
    let mode = bytes.one_of(&ActivationMode::ALL)?;
    let way = 400.0 * bytes.share()?;
    Some(match bytes.byte()? % 4 {
        0 => Activation {
            in_turn: Some(way),
            ..Activation::new(mode)
        },
        1 => Activation::at(mode, around.master.position + way),
        _ => Activation::at(mode, way),
    })
}

fn jump(bytes: &mut Bytes<'_>) -> Option<JumpHandling> {
    Some(match bytes.byte()? % 3 {
        0 => JumpHandling::Refuse,
        1 => JumpHandling::Allow,
        _ => JumpHandling::RampIn {
            master_length: bytes.decades(-1.0, 3.0)?,
        },
    })
}

fn scaling(bytes: &mut Bytes<'_>) -> Option<AxisScaling> {
    // One byte for the plate as it is.
    if bytes.bit()? {
        return Some(AxisScaling::default());
    }
    Some(AxisScaling {
        mode: bytes.one_of(&MODES)?,
        relative: bytes.bit()?,
        offset: 400.0 * bytes.share()?,
        scaling: 4.0 * bytes.share()?,
    })
}

fn points(bytes: &mut Bytes<'_>) -> Option<CamPoints> {
    let count = 1 + usize::from(bytes.byte()? % 4);
    let mut points = [MotionPoint::rest(1, 0.0, 0.0); 4];
    for point in &mut points[..count] {
        let index = u32::from(bytes.byte()? % 6);
        // Near the points of the plates, which are 60 x apart.
        *point = MotionPoint {
            function: bytes.one_of(MotionLaw::ALL)?,
            ..MotionPoint::rest(
                index,
                60.0 * f64::from(index) + 60.0 * bytes.share()?,
                50.0 * bytes.share()?,
            )
        };
    }
    CamPoints::new(&points[..count]).ok()
}
