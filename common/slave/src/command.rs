//! Commands to a slave axis.

use coaxle_axis::{Dynamics, Transition};
use coaxle_cam::{
    CamAdd, CamExchange, CamIn, CamInV2, CamOut, CamRemove, CamScaling, CamScalingV2,
    OnlineChangeMode, TableId,
};
use coaxle_gear::{FlyingGearParameters, GearIn, GearInMultiMaster};
use coaxle_saw::{GearInPos, GearInVelo, SawCommand};

use super::cam_points::CamPoints;
use super::sync_position::SyncPosition;

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
pub enum Command {
    /// `MC_Power`: switches power on, or off after stopping the axis.
    #[doc(alias = "MC_Power")]
    Power(bool),
    /// `MC_Reset`: acknowledges the error of an axis that has come to rest.
    #[doc(alias = "MC_Reset")]
    Reset {},
    /// `MC_Home` (set position): sets the position of the axis at rest.
    #[doc(alias = "MC_Home")]
    #[doc(alias = "MC_SetPosition")]
    Home {
        /// Position of the axis, u.
        position: f64,
    },
    /// `MC_MoveAbsolute`: moves to a position.
    #[doc(alias = "MC_MoveAbsolute")]
    MoveAbsolute {
        /// Target position, u.
        position: f64,
        /// Highest speed on the way, u/s.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_MoveRelative`: moves a distance from the present set position.
    #[doc(alias = "MC_MoveRelative")]
    MoveRelative {
        /// Distance, u.
        distance: f64,
        /// Highest speed on the way, u/s.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_MoveVelocity`: ramps to a velocity and keeps it.
    #[doc(alias = "MC_MoveVelocity")]
    MoveVelocity {
        /// The velocity, u/s; its sign is the direction.
        velocity: f64,
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_Halt`: brings the axis to rest; other commands can take over meanwhile.
    #[doc(alias = "MC_Halt")]
    Halt {
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_Stop`: brings the axis to rest; only a stop that ends earlier can take over meanwhile.
    #[doc(alias = "MC_Stop")]
    Stop {
        /// Dynamics of the motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_GearIn`: couples to the master by a constant ratio, on a ramp.
    #[doc(alias = "MC_GearIn")]
    GearIn(GearIn),
    /// `MC_GearInMultiMaster`: couples to the sum of several masters, on a ramp; repeated, it
    /// changes the ratios, even from cycle to cycle.
    #[doc(alias = "MC_GearInMultiMaster")]
    #[doc(alias = "MC_GearInDyn")]
    #[doc(alias = "MC_CombineAxes")]
    GearInMultiMaster(GearInMultiMaster),
    /// `MC_PhasingAbsolute`: shifts the master as the coupled slave sees it, relative to its actual
    /// position.
    ///
    /// The slave is led as if the (first) master were ahead by the shift, on a ramp over time, in
    /// addition to the master's motion. The shift stays until another one, or until the axis is
    /// uncoupled.
    #[doc(alias = "MC_PhasingAbsolute")]
    PhasingAbsolute {
        /// Lead of the master after the shift, u of the master.
        shift: f64,
        /// Velocity of the shift, u/s of the master. By default the rest of the slave's limits at
        /// its present motion, if the coupling has a constant ratio.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the shift, in u of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_PhasingRelative`: shifts the master relative to the present shift.
    #[doc(alias = "MC_PhasingRelative")]
    PhasingRelative {
        /// Additional lead of the master after the shift, u of the master.
        shift: f64,
        /// Velocity of the shift, u/s of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the shift, in u of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_MoveSuperImposed`: adds a distance to the current motion of the axis, which continues.
    #[doc(alias = "MC_MoveSuperImposed")]
    MoveSuperimposed {
        /// Distance, u.
        distance: f64,
        /// Additional speed of the axis meanwhile, u/s. By default the rest of the limits at the
        /// current motion.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// Dynamics of the added motion.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_GearOut`: uncouples. The velocity is kept, the acceleration is led to zero within the jerk.
    #[doc(alias = "MC_GearOut")]
    GearOut {},
    /// `MC_FlyingGear`: waits for the master, couples and releases on the fly. The slave must be at rest.
    #[doc(alias = "MC_FlyingGear")]
    FlyingGear(FlyingGearParameters<SyncPosition>),
    /// `MC_GearInPos`: the universal flying saw to a pair of positions, from any motion of the slave.
    #[doc(alias = "MC_GearInPos")]
    GearInPos(GearInPos<SyncPosition>),
    /// `MC_GearInVelo`: the universal flying saw to the gear's velocity, from any motion of the
    /// slave.
    #[doc(alias = "MC_GearInVelo")]
    GearInVelo(GearInVelo),
    /// `MC_ReadFlyingSawCharacteristics`: reads the characteristic values of the current or last
    /// flying saw of the axis ([`SlaveAxis::saw_plan`](super::SlaveAxis::saw_plan)).
    #[doc(alias = "MC_ReadFlyingSawCharacteristics")]
    ReadFlyingSawCharacteristics {},
    /// `MC_CamIn`: couples the slave by a plate, or switches to another.
    #[doc(alias = "MC_CamIn")]
    CamIn(CamIn),
    /// `MC_CamOut`: uncouples, as `GearOut` does.
    #[doc(alias = "MC_CamOut")]
    CamOut {},
    /// `MC_CamScaling`: scales the plate.
    #[doc(alias = "MC_CamScaling")]
    CamScaling(CamScaling),
    /// `MC_CamIn_V2`: couples the slave by one of several plates, or adds, exchanges, removes one.
    #[doc(alias = "MC_CamIn_V2")]
    CamInV2(CamInV2),
    /// `MC_CamAdd`: superposes a further plate.
    #[doc(alias = "MC_CamAdd")]
    CamAdd(CamAdd),
    /// `MC_CamExchange`: replaces a plate by another.
    #[doc(alias = "MC_CamExchange")]
    CamExchange(CamExchange),
    /// `MC_CamRemove`: removes a plate.
    #[doc(alias = "MC_CamRemove")]
    CamRemove(CamRemove),
    /// `MC_CamScaling_V2`: scales one of the plates.
    #[doc(alias = "MC_CamScaling_V2")]
    CamScalingV2(CamScalingV2),
    /// `MC_SetCamOnlineChangeMode`: sets the activation of points written from now on.
    #[doc(alias = "MC_SetCamOnlineChangeMode")]
    SetCamOnlineChangeMode {
        /// The plate.
        table: TableId,
        /// Activation of its points, or discarding of the pending ones.
        #[cfg_attr(feature = "serde", serde(default))]
        mode: OnlineChangeMode,
    },
    /// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: replaces the points with equal indices.
    #[doc(alias = "MC_WriteMotionFunction")]
    #[doc(alias = "MC_WriteMotionFunctionPoint")]
    WriteMotionFunction {
        /// The plate.
        table: TableId,
        /// The points. Pending ones add up, so that more of them can follow in further commands.
        points: CamPoints,
    },
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
    /// PLC name of the command.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        // Power decides the arrow only.
        self.entry(false).0
    }

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
        self.entry(powered).1
    }

    /// PLC name and arrow of each command.
    // A common table: no command can be missing from one of them.
    const fn entry(&self, powered: bool) -> (&'static str, Option<Transition>) {
        use Transition as To;
        match self {
            Self::Power(true) => ("MC_Power", Some(To::PowerOn)),
            Self::Power(false) => ("MC_Power", Some(To::PowerOff)),
            Self::Reset {} => ("MC_Reset", Some(To::Reset { powered })),
            Self::Home { .. } => ("MC_Home", Some(To::Home)),
            Self::MoveAbsolute { .. } => ("MC_MoveAbsolute", Some(To::Move)),
            Self::MoveRelative { .. } => ("MC_MoveRelative", Some(To::Move)),
            Self::MoveVelocity { .. } => ("MC_MoveVelocity", Some(To::MoveWithoutEnd)),
            Self::Halt { .. } => ("MC_Halt", Some(To::Halt)),
            Self::Stop { .. } => ("MC_Stop", Some(To::Stop)),
            Self::GearIn(_) => ("MC_GearIn", Some(To::Couple)),
            Self::GearInMultiMaster(_) => ("MC_GearInMultiMaster", Some(To::Couple)),
            Self::PhasingAbsolute { .. } => ("MC_PhasingAbsolute", Some(To::Phase)),
            Self::PhasingRelative { .. } => ("MC_PhasingRelative", Some(To::Phase)),
            Self::MoveSuperimposed { .. } => ("MC_MoveSuperImposed", Some(To::Superimpose)),
            Self::GearOut {} => ("MC_GearOut", Some(To::Uncouple)),
            Self::FlyingGear(_) => ("MC_FlyingGear", Some(To::Couple)),
            Self::GearInPos(_) => ("MC_GearInPos", Some(To::Couple)),
            Self::GearInVelo(_) => ("MC_GearInVelo", Some(To::Couple)),
            Self::ReadFlyingSawCharacteristics {} => ("MC_ReadFlyingSawCharacteristics", None),
            Self::CamIn(_) => (CamIn::NAME, Some(To::Couple)),
            Self::CamOut {} => (CamOut::NAME, Some(To::Uncouple)),
            Self::CamScaling(_) => (CamScaling::NAME, Some(To::Couple)),
            Self::CamInV2(_) => (CamInV2::NAME, Some(To::Couple)),
            Self::CamAdd(_) => (CamAdd::NAME, Some(To::Couple)),
            Self::CamExchange(_) => (CamExchange::NAME, Some(To::Couple)),
            Self::CamRemove(_) => (CamRemove::NAME, Some(To::Couple)),
            Self::CamScalingV2(_) => (CamScalingV2::NAME, Some(To::Couple)),
            Self::SetCamOnlineChangeMode { .. } => ("MC_SetCamOnlineChangeMode", None),
            Self::WriteMotionFunction { .. } => ("MC_WriteMotionFunction", None),
        }
    }
}
