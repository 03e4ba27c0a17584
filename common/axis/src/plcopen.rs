//! The PLCopen state diagram.

use core::fmt;

/// State of an axis, as named in PLCopen Motion Control part 1.
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
    /// Stopping; only a harder stop or the loss of power can interrupt it.
    Stopping,
    /// In error, until reset.
    ErrorStop,
}

impl AxisStatus {
    /// States in the order of the diagram.
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

    /// The state after a transition; none where the diagram has no such arrow.
    ///
    /// Two deliberate deviations. An axis whose power is switched off while it moves is stopped
    /// first (`Stopping`) and disabled after a cycle at rest; PLCopen disables it at once, but
    /// others follow its set values, which would jump to the drive's position. And `MC_Stop` can be
    /// repeated while the axis stops, where in PLCopen only the loss of power aborts it. The axis
    /// decides if the second stop is harder than the first.
    #[must_use]
    pub const fn after(self, transition: Transition) -> Option<Self> {
        use AxisStatus::{
            ContinuousMotion, Disabled, DiscreteMotion, ErrorStop, Homing, Standstill, Stopping,
            SynchronizedMotion,
        };
        use Transition as T;
        match (self, transition) {
            // Arms from the most urgent: a fault counts in each state, a reset changes only an error stop.
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

            // Below this line the axis has power and no error.
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
            // PLCopen: neither can be aborted by another motion.
            (Homing | Stopping, _) => None,
        }
    }

    /// The state after a command, for an axis that accepts motion commands.
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

/// The state of an axis. It changes only by the arrows of the diagram.
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
        // Callers ask `after` before they accept a command. Here an impossible arrow must not do harm.
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
    /// Power for an axis that its mechanics have coupled to its master already.
    PowerOnCoupled,
    /// `MC_Power` without `Enable`.
    PowerOff,
    /// `MC_Reset`.
    Reset {
        /// True if the axis shall have power afterwards.
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
    /// Command to end a coupling: `MC_GearOut`, `MC_CamOut`. `Released` then gives the state of the axis.
    Uncouple,
    /// End of a coupling, by a command or by itself: the axis keeps its velocity.
    Released {
        /// True if that velocity is zero.
        at_rest: bool,
    },
    /// Roll-back of a flying saw's master: the axis comes to rest, and commands can take over.
    RolledBack,
    /// `MC_PhasingAbsolute`, `MC_PhasingRelative`: the coupling continues.
    Phase,
    /// `MC_MoveSuperImposed`: the motion of the axis continues.
    Superimpose,
    /// `MC_Halt`.
    Halt,
    /// `MC_Stop`.
    Stop,
    /// End of the axis's motion.
    Finished {
        /// True if the axis still has power.
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

    /// Two letters per state, `--` where there is no arrow; rows are states, columns as above.
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
