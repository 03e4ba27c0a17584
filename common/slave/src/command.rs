//! Commands to a slave axis.

pub mod key;
pub(super) mod table;

use coaxle_axis::{Dynamics, Transition};
use coaxle_cam::{
    CamAdd, CamExchange, CamIn, CamInV2, CamRemove, CamScaling, CamScalingV2, OnlineChangeMode,
    TableId,
};
use coaxle_gear::{FlyingGearParameters, GearIn, GearInMultiMaster};
use coaxle_saw::{GearInPos, GearInVelo, SawCommand};

use super::cam_points::CamPoints;
use super::sync_position::SyncPosition;
use crate::commands;

commands! {
    /// A command to a slave axis.
    ///
    /// Positions are in u, velocities in u/s. The default of a limit in a command is that of the axis.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[cfg_attr(
        feature = "serde",
        serde(
            rename_all = "kebab-case",
            rename_all_fields = "kebab-case",
            deny_unknown_fields
        )
    )]
    pub enum Command, each CommandTraits = CommandTraits::NONE;

    /// `MC_Power`: switches power on, or off after stopping the axis.
    "MC_Power" Power(bool) => CommandTraits::arrow(Transition::PowerOn),
    /// `MC_Reset`: acknowledges the error of an axis that has come to rest.
    "MC_Reset" Reset {} => CommandTraits::arrow(Transition::Reset { powered: true }),
    /// `MC_Home` (set position): sets the position of the axis at rest.
    #[doc(alias = "MC_SetPosition")]
    "MC_Home" Home {
        /// Position of the axis, u.
        position: f64,
    } => CommandTraits::arrow(Transition::Home),
    /// `MC_MoveAbsolute`: moves to a position.
    "MC_MoveAbsolute" MoveAbsolute {
        /// Target position, u.
        position: f64,
        /// Highest speed on the way, u/s.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Move),
    /// `MC_MoveRelative`: moves a distance from the present set position.
    "MC_MoveRelative" MoveRelative {
        /// Distance, u.
        distance: f64,
        /// Highest speed on the way, u/s.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Move),
    /// `MC_MoveVelocity`: ramps to a velocity and keeps it.
    "MC_MoveVelocity" MoveVelocity {
        /// The velocity, u/s; its sign is the direction.
        velocity: f64,
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::MoveWithoutEnd),
    /// `MC_Halt`: brings the axis to rest; other commands can take over meanwhile.
    "MC_Halt" Halt {
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Halt),
    /// `MC_Stop`: brings the axis to rest; only a stop that ends earlier can take over meanwhile.
    "MC_Stop" Stop {
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Stop),
    /// `MC_GearIn`: couples to the master by a constant ratio, on a ramp.
    "MC_GearIn" GearIn(GearIn) => CommandTraits::arrow(Transition::Couple),
    /// `MC_GearInMultiMaster`: couples to the sum of several masters, on a ramp; repeated, it
    /// changes the ratios, even from cycle to cycle.
    #[doc(alias = "MC_GearInDyn")]
    #[doc(alias = "MC_CombineAxes")]
    "MC_GearInMultiMaster" GearInMultiMaster(GearInMultiMaster) => CommandTraits::arrow(Transition::Couple),
    /// `MC_PhasingAbsolute`: shifts the master as the coupled slave sees it, relative to its actual
    /// position.
    ///
    /// The slave is led as if the (first) master were ahead by the shift, on a ramp over time, in
    /// addition to the master's motion. The shift stays until another one, or until the axis is
    /// uncoupled.
    "MC_PhasingAbsolute" PhasingAbsolute {
        /// Lead of the master after the shift, u of the master.
        shift: f64,
        /// Velocity of the shift, u/s of the master. By default the rest of the slave's limits at
        /// its present motion, if the coupling has a constant ratio.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the shift, in u of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Phase),
    /// `MC_PhasingRelative`: shifts the master relative to the present shift.
    "MC_PhasingRelative" PhasingRelative {
        /// Additional lead of the master after the shift, u of the master.
        shift: f64,
        /// Velocity of the shift, u/s of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the shift, in u of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Phase),
    /// `MC_MoveSuperImposed`: adds a distance to the current motion of the axis, which continues.
    "MC_MoveSuperImposed" MoveSuperimposed {
        /// Distance, u.
        distance: f64,
        /// Additional speed of the axis meanwhile, u/s. By default the rest of the limits at the
        /// current motion.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the added motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    } => CommandTraits::arrow(Transition::Superimpose),
    /// `MC_GearOut`: uncouples. The velocity is kept, the acceleration is led to zero within the jerk.
    "MC_GearOut" GearOut {} => CommandTraits::arrow(Transition::Uncouple),
    /// `MC_FlyingGear`: waits for the master, couples and releases on the fly. The slave must be at rest.
    "MC_FlyingGear" FlyingGear(FlyingGearParameters<SyncPosition>) => CommandTraits::arrow(Transition::Couple).at_mark(),
    /// `MC_GearInPos`: the universal flying saw to a pair of positions, from any motion of the slave.
    "MC_GearInPos" GearInPos(GearInPos<SyncPosition>) => CommandTraits::arrow(Transition::Couple).at_mark(),
    /// `MC_GearInVelo`: the universal flying saw to the gear's velocity, from any motion of the
    /// slave.
    "MC_GearInVelo" GearInVelo(GearInVelo) => CommandTraits::arrow(Transition::Couple),
    /// `MC_ReadFlyingSawCharacteristics`: reads the characteristic values of the current or last
    /// flying saw of the axis ([`SlaveAxis::saw_plan`](super::SlaveAxis::saw_plan)).
    "MC_ReadFlyingSawCharacteristics" ReadFlyingSawCharacteristics {},
    /// `MC_CamIn`: couples the slave by a plate, or switches to another.
    "MC_CamIn" CamIn(CamIn) => CommandTraits::arrow(Transition::Couple).at_mark(),
    /// `MC_CamOut`: uncouples, as `GearOut` does.
    "MC_CamOut" CamOut {} => CommandTraits::arrow(Transition::Uncouple),
    /// `MC_CamScaling`: scales the plate.
    "MC_CamScaling" CamScaling(CamScaling) => CommandTraits::arrow(Transition::Couple),
    /// `MC_CamIn_V2`: couples the slave by one of several plates, or adds, exchanges, removes one.
    "MC_CamIn_V2" CamInV2(CamInV2) => CommandTraits::arrow(Transition::Couple),
    /// `MC_CamAdd`: superposes a further plate.
    "MC_CamAdd" CamAdd(CamAdd) => CommandTraits::arrow(Transition::Couple),
    /// `MC_CamExchange`: replaces a plate by another.
    "MC_CamExchange" CamExchange(CamExchange) => CommandTraits::arrow(Transition::Couple),
    /// `MC_CamRemove`: removes a plate.
    "MC_CamRemove" CamRemove(CamRemove) => CommandTraits::arrow(Transition::Couple),
    /// `MC_CamScaling_V2`: scales one of the plates.
    "MC_CamScaling_V2" CamScalingV2(CamScalingV2) => CommandTraits::arrow(Transition::Couple),
    /// `MC_SetCamOnlineChangeMode`: sets the activation of points written from now on.
    "MC_SetCamOnlineChangeMode" SetCamOnlineChangeMode {
        /// The plate.
        table: TableId,
        /// Activation of its points, or discarding of the pending ones.
        #[cfg_attr(feature = "serde", serde(default))]
        mode: OnlineChangeMode,
    },
    /// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: replaces the points with equal indices.
    #[doc(alias = "MC_WriteMotionFunctionPoint")]
    "MC_WriteMotionFunction" WriteMotionFunction {
        /// The plate.
        table: TableId,
        /// The points. Pending ones add up, so that more of them can follow in further commands.
        points: CamPoints,
    } => CommandTraits::NONE.at_mark(),
}

impl From<SawCommand> for Command {
    fn from(command: SawCommand) -> Self {
        match command {
            SawCommand::GearInPos(command) => command.into(),
            SawCommand::GearInVelo(command) => Self::GearInVelo(command),
        }
    }
}

impl From<GearInPos> for Command {
    fn from(command: GearInPos) -> Self {
        Self::GearInPos(command.at(
            SyncPosition::At(command.master_sync_position),
            SyncPosition::At(command.slave_sync_position),
        ))
    }
}

impl From<FlyingGearParameters> for Command {
    fn from(gear: FlyingGearParameters) -> Self {
        Self::FlyingGear(FlyingGearParameters {
            ratio: gear.ratio,
            master_sync_position: gear.master_sync_position.into(),
            slave_sync_position: gear.slave_sync_position.into(),
            slave_desync_position: gear.slave_desync_position.into(),
            slave_stop_position: gear.slave_stop_position.into(),
            default_slave_negative: gear.default_slave_negative,
        })
    }
}

impl Command {
    /// The command as one to a flying saw, if it is one with absolute positions.
    #[must_use]
    pub const fn as_saw(&self) -> Option<SawCommand> {
        match self {
            Self::GearInPos(command) => match command.positions() {
                // Other positions become absolute at the axis, which alone knows where it and its master are.
                (SyncPosition::At(master), SyncPosition::At(slave)) => {
                    Some(SawCommand::GearInPos(command.at(master, slave)))
                }
                _ => None,
            },
            Self::GearInVelo(command) => Some(SawCommand::GearInVelo(*command)),
            _ => None,
        }
    }

    /// Arrow in the state diagram, for an axis with or without power; none for a command to a
    /// plate, or one that only reads.
    pub(super) const fn transition(&self, powered: bool) -> Option<Transition> {
        match self {
            Self::Power(false) => Some(Transition::PowerOff),
            Self::Reset {} => Some(Transition::Reset { powered }),
            _ => self.row().traits.transition,
        }
    }
}

/// Traits of a command that its row states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandTraits {
    /// Arrow in the state diagram, for an axis with power; none for a command that leaves the motion
    /// as it is.
    pub transition: Option<Transition>,
    /// True if its master positions may count from a registration mark.
    pub at_mark: bool,
}

impl CommandTraits {
    /// A command that leaves the motion of the axis as it is.
    const NONE: Self = Self {
        transition: None,
        at_mark: false,
    };

    /// A command with this arrow in the state diagram.
    const fn arrow(transition: Transition) -> Self {
        Self {
            transition: Some(transition),
            at_mark: false,
        }
    }

    /// Lets its master positions count from a registration mark.
    const fn at_mark(self) -> Self {
        Self {
            at_mark: true,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use coaxle_cam::CamOut;

    use super::*;

    #[test]
    fn keys_follow_from_the_variants() {
        let keys: [&str; 4] = [
            "power",
            "move-absolute",
            "gear-in-multi-master",
            "cam-in-v2",
        ];
        for key in keys {
            assert!(Command::ROWS.iter().any(|row| row.key == key), "{key}");
        }
        assert_eq!(Command::Power(true).key(), "power");
        assert_eq!(Command::CamOut {}.name(), "MC_CamOut");
    }

    /// The cam crate names its commands in its refusals.
    #[test]
    fn cam_commands_have_their_names_in_the_cam_crate() {
        for (key, name) in [
            ("cam-in", CamIn::NAME),
            ("cam-out", CamOut::NAME),
            ("cam-scaling", CamScaling::NAME),
            ("cam-in-v2", CamInV2::NAME),
            ("cam-add", CamAdd::NAME),
            ("cam-exchange", CamExchange::NAME),
            ("cam-remove", CamRemove::NAME),
            ("cam-scaling-v2", CamScalingV2::NAME),
        ] {
            let row = Command::ROWS.iter().find(|row| row.key == key);
            assert_eq!(row.map(|row| row.name), Some(name));
        }
    }
}
