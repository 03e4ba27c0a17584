//! Commands of a caller, checked.

use ::coaxle_slave::{CamPoints, Command, Dynamics, SyncPosition};
use coaxle_cam::{
    Activation, ActivationMode, AxisScaling, CamAdd, CamExchange, CamIn, CamInV2, CamRemove,
    CamScaling, CamScalingV2, JumpHandling, OnlineChangeMode, OperationMode, ScalingData,
    ScalingMode, StartMode,
};
use coaxle_curve::law::MotionLaw;
use coaxle_gear::{FlyingGearParameters, GearIn, GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_plate::{MotionPoint, PointType};
use coaxle_saw::{
    GearInPos, GearInSyncMode, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode, SyncStrategy,
};

#[allow(clippy::wildcard_imports, reason = "the numbers of a command")]
use crate::command::*;
use crate::failure::Failure;
use crate::memory::read;

/// Reads a command of the caller.
///
/// # Safety
/// As for [`read`].
pub(crate) unsafe fn taken(command: *const coaxle_command) -> Result<Command, Failure> {
    // SAFETY: as for this function.
    unsafe { read(command) }?.checked()
}

impl coaxle_command {
    /// Checks what the types of a [`Command`] rule out; the axis checks the rest.
    pub(crate) fn checked(&self) -> Result<Command, Failure> {
        let dynamics = self.dynamics();
        let velocity = given(self.velocity);
        Ok(match self.kind {
            COAXLE_POWER_ON => Command::Power(true),
            COAXLE_POWER_OFF => Command::Power(false),
            COAXLE_RESET => Command::Reset {},
            COAXLE_HOME => Command::Home {
                position: self.position,
            },
            COAXLE_MOVE_ABSOLUTE => Command::MoveAbsolute {
                position: self.position,
                velocity,
                dynamics,
            },
            COAXLE_MOVE_RELATIVE => Command::MoveRelative {
                distance: self.distance,
                velocity,
                dynamics,
            },
            COAXLE_MOVE_VELOCITY => Command::MoveVelocity {
                velocity: self.velocity,
                dynamics,
            },
            COAXLE_HALT => Command::Halt { dynamics },
            COAXLE_STOP => Command::Stop { dynamics },
            COAXLE_GEAR_IN => Command::GearIn(GearIn {
                ratio: self.ratio,
                dynamics,
            }),
            COAXLE_GEAR_IN_MULTI_MASTER => Command::GearInMultiMaster(self.multi_master()?),
            COAXLE_PHASING_ABSOLUTE => Command::PhasingAbsolute {
                shift: self.distance,
                velocity,
                dynamics,
            },
            COAXLE_PHASING_RELATIVE => Command::PhasingRelative {
                shift: self.distance,
                velocity,
                dynamics,
            },
            COAXLE_MOVE_SUPERIMPOSED => Command::MoveSuperimposed {
                distance: self.distance,
                velocity,
                dynamics,
            },
            COAXLE_GEAR_OUT => Command::GearOut {},
            COAXLE_FLYING_GEAR => Command::FlyingGear(self.flying_gear()?),
            COAXLE_GEAR_IN_POS => Command::GearInPos(self.gear_in_pos()?),
            COAXLE_GEAR_IN_VELO => Command::GearInVelo(GearInVelo {
                ratio: self.ratio()?,
                sync_mode: self.sync_mode()?,
                limits: self.sync_limits(),
            }),
            COAXLE_CAM_IN => Command::CamIn(self.cam_in()?),
            COAXLE_CAM_OUT => Command::CamOut {},
            COAXLE_CAM_SCALING => Command::CamScaling(CamScaling {
                activation: self.activation()?,
                scaling: self.scaling()?,
                jump: self.jump()?,
            }),
            COAXLE_CAM_IN_V2 => Command::CamInV2(CamInV2 {
                activation: self.activation()?,
                table: self.table,
                scaling: self.scaling()?,
                operation: self.operation()?,
                reference: self.reference_table,
                jump: self.jump()?,
            }),
            COAXLE_CAM_ADD => Command::CamAdd(CamAdd {
                activation: self.activation()?,
                table: self.table,
                scaling: self.scaling()?,
                jump: self.jump()?,
            }),
            COAXLE_CAM_EXCHANGE => Command::CamExchange(CamExchange {
                activation: self.activation()?,
                table: self.table,
                reference: self.reference_table,
                scaling: self.scaling()?,
                jump: self.jump()?,
            }),
            COAXLE_CAM_REMOVE => Command::CamRemove(CamRemove {
                activation: self.activation()?,
                table: self.table,
                jump: self.jump()?,
            }),
            COAXLE_CAM_SCALING_V2 => Command::CamScalingV2(CamScalingV2 {
                activation: self.activation()?,
                table: self.table,
                scaling: self.scaling()?,
                jump: self.jump()?,
            }),
            COAXLE_SET_CAM_ONLINE_CHANGE_MODE => Command::SetCamOnlineChangeMode {
                table: self.table,
                mode: OnlineChangeMode {
                    activation: self.activation()?,
                    master_scaling_mode: scaling_mode(
                        "master_scaling_mode",
                        self.master_scaling_mode,
                    )?,
                    slave_scaling_mode: scaling_mode(
                        "slave_scaling_mode",
                        self.slave_scaling_mode,
                    )?,
                    jump: self.jump()?,
                },
            },
            COAXLE_WRITE_MOTION_FUNCTION => Command::WriteMotionFunction {
                table: self.table,
                points: self.points()?,
            },
            other => return Err(Failure::range("kind", other, "1 to 28")),
        })
    }

    const fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    fn dynamics(&self) -> Dynamics {
        Dynamics {
            acceleration: given(self.acceleration),
            deceleration: given(self.deceleration),
            jerk: given(self.jerk),
        }
    }

    fn multi_master(&self) -> Result<GearInMultiMaster, Failure> {
        let number = self.number_of_ratios as usize;
        let ratios = self.ratios.get(..number).unwrap_or(&[]);
        Ok(GearInMultiMaster {
            ratios: Ratios::new(ratios).map_err(|wrong| Failure::of_nc(0x421b, wrong))?,
            dynamics: self.dynamics(),
            sync_mode: match self.has(COAXLE_POSSYNC2) {
                true => MultiMasterSync::PosSync2,
                false => MultiMasterSync::PosSync1,
            },
        })
    }

    fn flying_gear(&self) -> Result<FlyingGearParameters<SyncPosition>, Failure> {
        let slave = |position| sync_position("slave_sync_kind", self.slave_sync_kind, position);
        Ok(FlyingGearParameters {
            ratio: self.ratio,
            master_sync_position: self.master_sync_position()?,
            slave_sync_position: slave(self.slave_sync_position)?,
            slave_desync_position: slave(self.slave_desync_position)?,
            slave_stop_position: slave(self.slave_stop_position)?,
            default_slave_negative: self.has(COAXLE_DEFAULT_SLAVE_NEGATIVE),
        })
    }

    fn gear_in_pos(&self) -> Result<GearInPos<SyncPosition>, Failure> {
        let start = self.has(COAXLE_HAS_MASTER_START_DISTANCE);
        Ok(GearInPos {
            ratio: self.ratio()?,
            master_sync_position: self.master_sync_position()?,
            slave_sync_position: sync_position(
                "slave_sync_kind",
                self.slave_sync_kind,
                self.slave_sync_position,
            )?,
            master_start_distance: start.then_some(self.master_start_distance),
            strategy: match self.strategy {
                COAXLE_STRATEGY_NONE => None,
                COAXLE_STRATEGY_LATE => Some(SyncStrategy::Late),
                COAXLE_STRATEGY_SLOW => Some(SyncStrategy::Slow),
                COAXLE_STRATEGY_EARLY => Some(SyncStrategy::Early),
                other => return Err(Failure::range("strategy", other, "0 to 3")),
            },
            sync_mode: self.sync_mode()?,
            limits: self.sync_limits(),
        })
    }

    fn master_sync_position(&self) -> Result<SyncPosition, Failure> {
        let (kind, position) = (self.master_sync_kind, self.master_sync_position);
        sync_position("master_sync_kind", kind, position)
    }

    fn ratio(&self) -> Result<Ratio, Failure> {
        let denominator = u16::try_from(self.ratio_denominator).map_err(|_| {
            Failure::range("ratio_denominator", self.ratio_denominator, "1 to 65535")
        })?;
        Ok(Ratio {
            numerator: self.ratio,
            denominator,
        })
    }

    fn sync_mode(&self) -> Result<SyncMode, Failure> {
        let mask = SyncMask::from_bits(self.sync_mask).ok_or_else(|| {
            let received = format_args!("{:#010x}", self.sync_mask);
            Failure::range("sync_mask", received, "flags of TF5055")
        })?;
        Ok(SyncMode {
            base: match self.has(COAXLE_TIME_BASED) {
                true => GearInSyncMode::TimeBased,
                false => GearInSyncMode::PositionBased,
            },
            mask,
        })
    }

    fn sync_limits(&self) -> SyncLimits {
        let min = self.has(COAXLE_HAS_MIN_POSITION);
        let max = self.has(COAXLE_HAS_MAX_POSITION);
        SyncLimits {
            velocity: given(self.velocity),
            acceleration: given(self.acceleration),
            deceleration: given(self.deceleration),
            jerk: given(self.jerk),
            min_position: min.then_some(self.min_position),
            max_position: max.then_some(self.max_position),
            master_velocity: given(self.master_velocity),
        }
    }

    fn cam_in(&self) -> Result<CamIn, Failure> {
        let start_mode = [
            StartMode::Absolute,
            StartMode::Relative,
            StartMode::MasterAbsoluteSlaveRelative,
            StartMode::MasterRelativeSlaveAbsolute,
        ]
        .into_iter()
        .find(|mode| u32::from(*mode as u8) == self.start_mode);
        Ok(CamIn {
            table: self.table,
            start_mode: start_mode
                .ok_or_else(|| Failure::range("start_mode", self.start_mode, "1 to 4"))?,
            master_offset: self.master_offset,
            slave_offset: self.slave_offset,
            master_scaling: self.master_scaling,
            slave_scaling: self.slave_scaling,
            activation: self.activation()?,
            master_scaling_mode: scaling_mode("master_scaling_mode", self.master_scaling_mode)?,
            slave_scaling_mode: scaling_mode("slave_scaling_mode", self.slave_scaling_mode)?,
            jump: self.jump()?,
        })
    }

    fn activation(&self) -> Result<Activation, Failure> {
        let mode = u8::try_from(self.activation_mode);
        let mode = mode.ok().and_then(ActivationMode::from_code);
        let in_turn = self.has(COAXLE_ACTIVATION_IN_TURN);
        Ok(Activation {
            mode: mode
                .ok_or_else(|| Failure::range("activation_mode", self.activation_mode, "0 to 9"))?,
            position: if in_turn {
                0.0
            } else {
                self.activation_position
            },
            in_turn: in_turn.then_some(self.activation_position),
        })
    }

    fn scaling(&self) -> Result<ScalingData, Failure> {
        Ok(ScalingData {
            master: AxisScaling {
                mode: scaling_mode("master_scaling_mode", self.master_scaling_mode)?,
                relative: self.has(COAXLE_MASTER_RELATIVE),
                offset: self.master_offset,
                scaling: self.master_scaling,
            },
            slave: AxisScaling {
                mode: scaling_mode("slave_scaling_mode", self.slave_scaling_mode)?,
                relative: self.has(COAXLE_SLAVE_RELATIVE),
                offset: self.slave_offset,
                scaling: self.slave_scaling,
            },
        })
    }

    fn operation(&self) -> Result<OperationMode, Failure> {
        [
            OperationMode::Default,
            OperationMode::Additive,
            OperationMode::Exchange,
            OperationMode::Remove,
        ]
        .into_iter()
        .find(|mode| u32::from(*mode as u8) == self.operation)
        .ok_or_else(|| Failure::range("operation", self.operation, "0 to 3"))
    }

    fn jump(&self) -> Result<JumpHandling, Failure> {
        match self.jump {
            COAXLE_JUMP_REFUSE => Ok(JumpHandling::Refuse),
            COAXLE_JUMP_ALLOW => Ok(JumpHandling::Allow),
            COAXLE_JUMP_RAMP_IN => Ok(JumpHandling::RampIn {
                master_length: self.ramp_length,
            }),
            other => Err(Failure::range("jump", other, "0, 1 or 2")),
        }
    }

    fn points(&self) -> Result<CamPoints, Failure> {
        let number = self.number_of_points as usize;
        let given = self.points.get(..number).filter(|given| !given.is_empty());
        let given = given
            .ok_or_else(|| Failure::range("number_of_points", self.number_of_points, "1 to 4"))?;
        // Overwritten before it is looked at.
        let mut points = [given[0].checked()?; CamPoints::MOST];
        for (place, point) in points.iter_mut().zip(given) {
            *place = point.checked()?;
        }
        CamPoints::new(&points[..number])
            .map_err(|wrong| Failure::range("number_of_points", wrong.received, "1 to 4"))
    }
}

impl coaxle_motion_point {
    pub(crate) fn checked(&self) -> Result<MotionPoint, Failure> {
        let law = u16::try_from(self.function)
            .ok()
            .and_then(MotionLaw::from_code);
        let point_type = u16::try_from(self.point_type)
            .ok()
            .and_then(PointType::from_code);
        let wrong = |field, received| Failure::range(field, received, "a number of TF5050");
        Ok(MotionPoint {
            index: self.index,
            function: law.ok_or_else(|| wrong("function", self.function))?,
            point_type: point_type.ok_or_else(|| wrong("point_type", self.point_type))?,
            relative_next: self.relative_next,
            master: self.master,
            slave: self.slave,
            velocity: self.velocity,
            acceleration: self.acceleration,
            jerk: self.jerk,
        })
    }
}

/// A limit of a command; 0 is that of the axis.
fn given(limit: f64) -> Option<f64> {
    // What is no number is passed on, and refused.
    (limit != 0.0).then_some(limit)
}

fn sync_position(field: &str, kind: u32, position: f64) -> Result<SyncPosition, Failure> {
    match kind {
        COAXLE_AT => Ok(SyncPosition::At(position)),
        COAXLE_AHEAD => Ok(SyncPosition::Ahead(position)),
        COAXLE_IN_TURN => Ok(SyncPosition::InTurn(position)),
        other => Err(Failure::range(field, other, "0, 1 or 2")),
    }
}

fn scaling_mode(field: &str, received: u32) -> Result<ScalingMode, Failure> {
    [
        ScalingMode::UserDefined,
        ScalingMode::AutoOffset,
        ScalingMode::Off,
    ]
    .into_iter()
    .find(|mode| u32::from(*mode as u8) == received)
    .ok_or_else(|| Failure::range(field, received, "0, 1 or 2"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::memory::Growing as _;

    #[test]
    fn every_command_has_a_number() {
        let point = coaxle_motion_point {
            index: 1,
            function: 1,
            point_type: 1,
            relative_next: 1,
            master: 0.0,
            slave: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
            jerk: 0.0,
        };
        let names = (COAXLE_POWER_ON..=COAXLE_WRITE_MOTION_FUNCTION).map(|kind| {
            let command = coaxle_command {
                kind,
                number_of_ratios: 1,
                ratio_denominator: 1,
                start_mode: 1,
                number_of_points: 1,
                points: [point; 4],
                ..coaxle_command::ZERO
            };
            command.checked().expect("a command of defaults").name()
        });
        let names: BTreeSet<_> = names.collect();
        // What only reads is a function of its own.
        let reads = "MC_ReadFlyingSawCharacteristics";
        let rows = Command::ROWS.iter().map(|row| row.name);
        let expected: BTreeSet<_> = rows.filter(|name| *name != reads).collect();
        assert_eq!(names, expected);
    }
}
