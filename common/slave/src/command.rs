//! What a slave axis can be told to do.

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
/// Positions are in u, velocities in u/s. What a command leaves open is what the axis can do.
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
    /// `MC_Power`: gives power, or takes it away after stopping the axis.
    #[doc(alias = "MC_Power")]
    Power(bool),
    /// `MC_Reset`: acknowledges the error of an axis that has come to rest.
    #[doc(alias = "MC_Reset")]
    Reset {},
    /// `MC_Home` (set position): declares that the axis stands here.
    #[doc(alias = "MC_Home")]
    #[doc(alias = "MC_SetPosition")]
    Home {
        /// Where it stands, u.
        position: f64,
    },
    /// `MC_MoveAbsolute`: goes to a position.
    #[doc(alias = "MC_MoveAbsolute")]
    MoveAbsolute {
        /// Where to, u.
        position: f64,
        /// Highest speed on the way, u/s.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// How it gets there.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_MoveRelative`: goes a distance from the present set position.
    #[doc(alias = "MC_MoveRelative")]
    MoveRelative {
        /// How far, u.
        distance: f64,
        /// Highest speed on the way, u/s.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// How it gets there.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_MoveVelocity`: ramps to a velocity and keeps it.
    #[doc(alias = "MC_MoveVelocity")]
    MoveVelocity {
        /// The velocity, u/s; its sign is the direction.
        velocity: f64,
        /// How it gets there.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_Halt`: comes to rest; other commands can take over meanwhile.
    #[doc(alias = "MC_Halt")]
    Halt {
        /// How it gets there.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_Stop`: comes to rest; nothing can take over meanwhile but a stop that ends earlier.
    #[doc(alias = "MC_Stop")]
    Stop {
        /// How it gets there.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_GearIn`: couples to the master by a constant ratio, on a ramp.
    #[doc(alias = "MC_GearIn")]
    GearIn(GearIn),
    /// `MC_GearInMultiMaster`: couples to the sum of several masters, on a ramp; given again, it
    /// changes the ratios, from cycle to cycle if need be.
    #[doc(alias = "MC_GearInMultiMaster")]
    #[doc(alias = "MC_GearInDyn")]
    #[doc(alias = "MC_CombineAxes")]
    GearInMultiMaster(GearInMultiMaster),
    /// `MC_PhasingAbsolute`: shifts the master as the coupled slave sees it, against where it is.
    ///
    /// The slave is led as if the (first) master were so far ahead, on a ramp over time, beside
    /// whatever the master does. The shift stays until another, or until the axis is uncoupled.
    #[doc(alias = "MC_PhasingAbsolute")]
    PhasingAbsolute {
        /// How far the master is ahead then, u of the master.
        shift: f64,
        /// How fast it gets there, u/s of the master. What a command leaves open is what is left of
        /// the slave's limits at its present motion, where the coupling has a constant ratio.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// How it gets there, in u of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_PhasingRelative`: the same, against the shift that there is.
    #[doc(alias = "MC_PhasingRelative")]
    PhasingRelative {
        /// How much farther the master is ahead then, u of the master.
        shift: f64,
        /// How fast it gets there, u/s of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// How it gets there, in u of the master.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_MoveSuperImposed`: adds a distance to whatever moves the axis, which goes on.
    #[doc(alias = "MC_MoveSuperImposed")]
    MoveSuperimposed {
        /// How far, u.
        distance: f64,
        /// How much faster the axis may be meanwhile, u/s. What a command leaves open is what the
        /// motion leaves of the limits.
        #[cfg_attr(feature = "serde", serde(default))]
        velocity: Option<f64>,
        /// How it gets there.
        #[cfg_attr(feature = "serde", serde(default))]
        dynamics: Dynamics,
    },
    /// `MC_GearOut`: uncouples. The velocity is kept, the acceleration led to zero within the jerk.
    #[doc(alias = "MC_GearOut")]
    GearOut {},
    /// `MC_FlyingGear`: waits for the master and is coupled and released on the fly. The slave must
    /// be at rest.
    #[doc(alias = "MC_FlyingGear")]
    FlyingGear(FlyingGearParameters<SyncPosition>),
    /// `MC_GearInPos`: the universal flying saw to a pair of positions, from any motion of the
    /// slave.
    #[doc(alias = "MC_GearInPos")]
    GearInPos(GearInPos<SyncPosition>),
    /// `MC_GearInVelo`: the universal flying saw to the gear's velocity, from any motion of the
    /// slave.
    #[doc(alias = "MC_GearInVelo")]
    GearInVelo(GearInVelo),
    /// `MC_ReadFlyingSawCharacteristics`: asks for the characteristic values of the flying saw that
    /// couples the axis, or did so last ([`SlaveAxis::saw_plan`](super::SlaveAxis::saw_plan)).
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
    /// `MC_CamAdd`: superposes one more plate.
    #[doc(alias = "MC_CamAdd")]
    CamAdd(CamAdd),
    /// `MC_CamExchange`: puts a plate in the place of another.
    #[doc(alias = "MC_CamExchange")]
    CamExchange(CamExchange),
    /// `MC_CamRemove`: takes a plate out.
    #[doc(alias = "MC_CamRemove")]
    CamRemove(CamRemove),
    /// `MC_CamScaling_V2`: scales one of the plates.
    #[doc(alias = "MC_CamScaling_V2")]
    CamScalingV2(CamScalingV2),
    /// `MC_SetCamOnlineChangeMode`: when points take effect that are written from now on.
    #[doc(alias = "MC_SetCamOnlineChangeMode")]
    SetCamOnlineChangeMode {
        /// The plate.
        table: TableId,
        /// When its points change, or that those that wait are discarded.
        #[cfg_attr(feature = "serde", serde(default))]
        mode: OnlineChangeMode,
    },
    /// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: puts points in the place of those
    /// with the same index.
    #[doc(alias = "MC_WriteMotionFunction")]
    #[doc(alias = "MC_WriteMotionFunctionPoint")]
    WriteMotionFunction {
        /// The plate.
        table: TableId,
        /// The points. What waits adds up, so that more of them can come in several commands.
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
    /// The PLC's name of it.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Power(_) => "MC_Power",
            Self::Reset {} => "MC_Reset",
            Self::Home { .. } => "MC_Home",
            Self::MoveAbsolute { .. } => "MC_MoveAbsolute",
            Self::MoveRelative { .. } => "MC_MoveRelative",
            Self::MoveVelocity { .. } => "MC_MoveVelocity",
            Self::Halt { .. } => "MC_Halt",
            Self::Stop { .. } => "MC_Stop",
            Self::GearIn(_) => "MC_GearIn",
            Self::GearInMultiMaster(_) => "MC_GearInMultiMaster",
            Self::PhasingAbsolute { .. } => "MC_PhasingAbsolute",
            Self::PhasingRelative { .. } => "MC_PhasingRelative",
            Self::MoveSuperimposed { .. } => "MC_MoveSuperImposed",
            Self::GearOut {} => "MC_GearOut",
            Self::FlyingGear(_) => "MC_FlyingGear",
            Self::GearInPos(_) => "MC_GearInPos",
            Self::GearInVelo(_) => "MC_GearInVelo",
            Self::ReadFlyingSawCharacteristics {} => "MC_ReadFlyingSawCharacteristics",
            Self::CamIn(_) => CamIn::NAME,
            Self::CamOut {} => CamOut::NAME,
            Self::CamScaling(_) => CamScaling::NAME,
            Self::CamInV2(_) => CamInV2::NAME,
            Self::CamAdd(_) => CamAdd::NAME,
            Self::CamExchange(_) => CamExchange::NAME,
            Self::CamRemove(_) => CamRemove::NAME,
            Self::CamScalingV2(_) => CamScalingV2::NAME,
            Self::SetCamOnlineChangeMode { .. } => "MC_SetCamOnlineChangeMode",
            Self::WriteMotionFunction { .. } => "MC_WriteMotionFunction",
        }
    }

    /// The command to a flying saw that it is, if it is one and its positions do not count from now.
    #[must_use]
    pub const fn as_saw(&self) -> Option<SawCommand> {
        match self {
            Self::GearInPos(command) => match command.positions() {
                (SyncPosition::At(master), SyncPosition::At(slave)) => {
                    Some(SawCommand::GearInPos(command.at(master, slave)))
                }
                _ => None,
            },
            Self::GearInVelo(command) => Some(SawCommand::GearInVelo(*command)),
            _ => None,
        }
    }

    /// Its arrow in the state diagram, for an axis that has power or not; none if it concerns a
    /// plate and not the axis, or only asks for something.
    pub(super) const fn transition(&self, powered: bool) -> Option<Transition> {
        Some(match self {
            Self::Power(true) => Transition::PowerOn,
            Self::Power(false) => Transition::PowerOff,
            Self::Reset {} => Transition::Reset { powered },
            Self::Home { .. } => Transition::Home,
            Self::MoveAbsolute { .. } | Self::MoveRelative { .. } => Transition::Move,
            Self::MoveVelocity { .. } => Transition::MoveWithoutEnd,
            Self::Halt { .. } => Transition::Halt,
            Self::Stop { .. } => Transition::Stop,
            Self::GearIn(_)
            | Self::FlyingGear(_)
            | Self::GearInMultiMaster(_)
            | Self::GearInPos(_)
            | Self::GearInVelo(_)
            | Self::CamIn(_)
            | Self::CamScaling(_)
            | Self::CamInV2(_)
            | Self::CamAdd(_)
            | Self::CamExchange(_)
            | Self::CamRemove(_)
            | Self::CamScalingV2(_) => Transition::Couple,
            Self::PhasingAbsolute { .. } | Self::PhasingRelative { .. } => Transition::Phase,
            Self::MoveSuperimposed { .. } => Transition::Superimpose,
            Self::GearOut {} | Self::CamOut {} => Transition::Uncouple,
            Self::SetCamOnlineChangeMode { .. }
            | Self::WriteMotionFunction { .. }
            | Self::ReadFlyingSawCharacteristics {} => return None,
        })
    }
}
