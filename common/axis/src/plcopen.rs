//! The PLCopen state diagram: what an axis may be asked for, and what becomes of it.

use core::fmt;

/// What an axis is doing, as PLCopen Motion Control part 1 names it.
#[doc(alias = "MC_ReadStatus")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum AxisStatus {
    /// Without power.
    #[default]
    Disabled,
    /// Powered, at rest, without a job.
    Standstill,
    /// Finding its position.
    Homing,
    /// On its way to a standstill: at a position, or by a halt.
    DiscreteMotion,
    /// At a velocity, without an end.
    ContinuousMotion,
    /// Coupled to a master.
    SynchronizedMotion,
    /// Stopping; nothing can interrupt that but a harder stop, and the loss of power.
    Stopping,
    /// In error, until reset.
    ErrorStop,
}

impl AxisStatus {
    /// All of them, in the order of the diagram.
    pub const ALL: [Self; 8] = [
        Self::Disabled,
        Self::Standstill,
        Self::Homing,
        Self::DiscreteMotion,
        Self::ContinuousMotion,
        Self::SynchronizedMotion,
        Self::Stopping,
        Self::ErrorStop,
    ];

    /// The name in status reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Disabled => "disabled",
            Self::Standstill => "standstill",
            Self::Homing => "homing",
            Self::DiscreteMotion => "discrete-motion",
            Self::ContinuousMotion => "continuous-motion",
            Self::SynchronizedMotion => "synchronized-motion",
            Self::Stopping => "stopping",
            Self::ErrorStop => "error-stop",
        }
    }

    /// What becomes of the axis; none where the diagram has no such arrow.
    ///
    /// Two deliberate deviations: an axis whose power is taken away while it moves is stopped first
    /// (`Stopping`) and is disabled after a cycle at rest, where PLCopen has it disabled at once: others follow
    /// its set values, which would jump to where the drive is; and `MC_Stop` can
    /// be given again while the axis stops, where PLCopen lets nothing but the loss of power abort it.
    /// Whether the second stop is harder than the first, the axis decides.
    #[must_use]
    pub const fn after(self, transition: Transition) -> Option<Self> {
        use AxisStatus::{
            ContinuousMotion, Disabled, DiscreteMotion, ErrorStop, Homing, Standstill, Stopping,
            SynchronizedMotion,
        };
        use Transition as T;
        match (self, transition) {
            (_, T::Fault) => Some(ErrorStop),

            (ErrorStop, T::Reset { powered: true }) => Some(Standstill),
            (ErrorStop, T::Reset { powered: false }) => Some(Disabled),
            (_, T::Reset { .. }) => Some(self),

            (Disabled, T::PowerOn) => Some(Standstill),
            (Disabled, T::PowerOnCoupled) => Some(SynchronizedMotion),
            (_, T::PowerOnCoupled) => None,
            (_, T::PowerOn) => Some(self),
            (Disabled | Standstill, T::PowerOff) => Some(Disabled),
            (ErrorStop, T::PowerOff) => Some(ErrorStop),
            (_, T::PowerOff) => Some(Stopping),

            (Disabled | ErrorStop, _) => None,

            (Standstill, T::Home) => Some(Homing),
            (Stopping, T::Finished { powered: false }) => Some(Disabled),
            (Homing | DiscreteMotion | ContinuousMotion | Stopping, T::Finished { .. }) => {
                Some(Standstill)
            }
            (Standstill | Homing | Stopping, T::Stop) => Some(Stopping),

            (SynchronizedMotion, T::Released { at_rest: true }) => Some(Standstill),
            (SynchronizedMotion, T::Released { at_rest: false }) => Some(ContinuousMotion),
            (SynchronizedMotion, T::RolledBack) => Some(DiscreteMotion),
            (SynchronizedMotion, T::Phase) => Some(SynchronizedMotion),
            (Standstill, T::Superimpose) => Some(DiscreteMotion),
            (DiscreteMotion | ContinuousMotion | SynchronizedMotion, T::Superimpose) => Some(self),

            (Standstill | DiscreteMotion | ContinuousMotion | SynchronizedMotion, _) => {
                self.commanded(transition)
            }
            (Homing | Stopping, _) => None,
        }
    }

    /// What a command makes of an axis that takes motion commands.
    const fn commanded(self, transition: Transition) -> Option<Self> {
        match transition {
            Transition::Move | Transition::Halt => Some(Self::DiscreteMotion),
            Transition::MoveWithoutEnd => Some(Self::ContinuousMotion),
            Transition::Couple => Some(Self::SynchronizedMotion),
            Transition::Uncouple if matches!(self, Self::SynchronizedMotion) => {
                Some(Self::ContinuousMotion)
            }
            Transition::Stop => Some(Self::Stopping),
            _ => None,
        }
    }
}

impl fmt::Display for AxisStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The state of an axis. It changes by the arrows of the diagram, and by nothing else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateMachine {
    status: AxisStatus,
}

impl StateMachine {
    /// The state.
    #[must_use]
    pub const fn status(&self) -> AxisStatus {
        self.status
    }

    /// Follows an arrow; without such an arrow the state stays.
    pub const fn follow(&mut self, transition: Transition) -> AxisStatus {
        if let Some(next) = self.status.after(transition) {
            self.status = next;
        }
        self.status
    }
}

/// An arrow of the state diagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transition {
    /// `MC_Power` with `Enable`.
    PowerOn,
    /// Power for an axis that the mechanics have coupled to its master already.
    PowerOnCoupled,
    /// `MC_Power` without `Enable`.
    PowerOff,
    /// `MC_Reset`.
    Reset {
        /// Whether the axis shall have power afterwards.
        powered: bool,
    },
    /// `MC_Home`.
    Home,
    /// A motion with an end: `MC_MoveAbsolute`, `MC_MoveRelative`.
    Move,
    /// A motion without an end: `MC_MoveVelocity`.
    MoveWithoutEnd,
    /// A coupling to a master.
    Couple,
    /// The end of a coupling is asked for: `MC_GearOut`, `MC_CamOut`. What becomes of the axis,
    /// `Released` says.
    Uncouple,
    /// A coupling has ended, by a command or by itself: the axis keeps its velocity.
    Released {
        /// Whether that is none.
        at_rest: bool,
    },
    /// The master of a flying saw has run back: the axis comes to rest, and commands can take over.
    RolledBack,
    /// `MC_PhasingAbsolute`, `MC_PhasingRelative`: the coupling goes on.
    Phase,
    /// `MC_MoveSuperImposed`: what moves the axis goes on.
    Superimpose,
    /// `MC_Halt`.
    Halt,
    /// `MC_Stop`.
    Stop,
    /// What the axis was doing has come to its end.
    Finished {
        /// Whether the axis still has power.
        powered: bool,
    },
    /// An error.
    Fault,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;

    const COLUMNS: [Transition; 20] = [
        Transition::PowerOn,
        Transition::PowerOnCoupled,
        Transition::PowerOff,
        Transition::Reset { powered: true },
        Transition::Reset { powered: false },
        Transition::Home,
        Transition::Move,
        Transition::MoveWithoutEnd,
        Transition::Couple,
        Transition::Uncouple,
        Transition::Released { at_rest: false },
        Transition::Released { at_rest: true },
        Transition::RolledBack,
        Transition::Phase,
        Transition::Superimpose,
        Transition::Halt,
        Transition::Stop,
        Transition::Finished { powered: true },
        Transition::Finished { powered: false },
        Transition::Fault,
    ];

    /// Two letters a state, `--` where there is no arrow; rows are states, columns as above.
    const DIAGRAM: [&str; 8] = [
        //    on  onc off rst rs0 hom mov vel cpl unc rel re0 rbk pha sup hlt stp fin fi0 flt
        "Di:  St  Sy  Di  Di  Di  --  --  --  --  --  --  --  --  --  --  --  --  --  --  Er",
        "St:  St  --  Di  St  St  Ho  Mo  Co  Sy  --  --  --  --  --  Mo  Mo  Sp  --  --  Er",
        "Ho:  Ho  --  Sp  Ho  Ho  --  --  --  --  --  --  --  --  --  --  --  Sp  St  St  Er",
        "Mo:  Mo  --  Sp  Mo  Mo  --  Mo  Co  Sy  --  --  --  --  --  Mo  Mo  Sp  St  St  Er",
        "Co:  Co  --  Sp  Co  Co  --  Mo  Co  Sy  --  --  --  --  --  Co  Mo  Sp  St  St  Er",
        "Sy:  Sy  --  Sp  Sy  Sy  --  Mo  Co  Sy  Co  Co  St  Mo  Sy  Sy  Mo  Sp  --  --  Er",
        "Sp:  Sp  --  Sp  Sp  Sp  --  --  --  --  --  --  --  --  --  --  --  Sp  St  Di  Er",
        "Er:  Er  --  Er  St  Di  --  --  --  --  --  --  --  --  --  --  --  --  --  --  Er",
    ];

    fn short(status: Option<AxisStatus>) -> &'static str {
        match status {
            None => "--",
            Some(AxisStatus::Disabled) => "Di",
            Some(AxisStatus::Standstill) => "St",
            Some(AxisStatus::Homing) => "Ho",
            Some(AxisStatus::DiscreteMotion) => "Mo",
            Some(AxisStatus::ContinuousMotion) => "Co",
            Some(AxisStatus::SynchronizedMotion) => "Sy",
            Some(AxisStatus::Stopping) => "Sp",
            Some(AxisStatus::ErrorStop) => "Er",
        }
    }

    #[test]
    fn a_state_changes_along_arrows_only() {
        for status in AxisStatus::ALL {
            for transition in COLUMNS {
                let mut machine = StateMachine { status };
                let expected = status.after(transition).unwrap_or(status);
                assert_eq!(machine.follow(transition), expected);
                assert_eq!(machine.status(), expected);
            }
        }
    }

    #[test]
    fn the_state_diagram() {
        for (status, row) in AxisStatus::ALL.into_iter().zip(DIAGRAM) {
            let mut after = String::from(short(Some(status))) + ":";
            for transition in COLUMNS {
                after += "  ";
                after += short(status.after(transition));
            }
            assert_eq!(after, row, "{status}");
        }
    }
}
