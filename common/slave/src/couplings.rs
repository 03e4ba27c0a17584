//! The kinds of couplings, listed only here.

use core::fmt;

use coaxle_axis::{CommandState, Coupling, Engage, Job, NotPlanned, PlanInputs, Planned};
use coaxle_cam::{Cam, CouplingError};
use coaxle_gear::{
    FlyingGearCoupling, FlyingGearError, Gear, MultiMasterGear, RatioZero, WrongRatios,
};
use coaxle_saw::{Saw, SawRefusal};

/// Lists the couplings of a slave, one of each kind, and generates their kinds, the dispatch by
/// kind, and the wrappers of their plans, refusals and faults.
macro_rules! couplings {
    ($( #[doc = $doc:literal] $kind:ident => $field:ident: $coupling:ty, refuses by $refusal:ty, )*) => {
        /// A kind of coupling.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Kind {
            $( #[doc = $doc] $kind, )*
        }

        impl Kind {
            pub(super) const ALL: [Self; [$(Self::$kind),*].len()] = [$(Self::$kind),*];
        }

        /// The couplings of a slave, at most one of them engaged.
        #[derive(Debug)]
        pub(super) struct Couplings {
            $( pub(super) $field: $coupling, )*
        }

        impl Couplings {
            /// The coupling of a kind.
            pub(super) fn get(&self, kind: Kind) -> &dyn Coupling {
                match kind { $( Kind::$kind => &self.$field, )* }
            }

            /// The coupling of a kind, mutable.
            pub(super) fn get_mut(&mut self, kind: Kind) -> &mut dyn Coupling {
                match kind { $( Kind::$kind => &mut self.$field, )* }
            }

            $(
                pub(super) fn $field(
                    &self,
                    command: &<$coupling as Engage>::Command,
                    inputs: &PlanInputs,
                ) -> Result<Planned<Engagement>, NotPlanned<CouplingRefusal>> {
                    let planned = self.$field.plan(command, inputs)
                        .map_err(|why| why.map(CouplingRefusal::$kind))?;
                    Ok(Planned {
                        change: Engagement::$kind(planned.change),
                        awaits: planned.awaits,
                        effect: planned.effect,
                    })
                }
            )*

            /// Applies a plan.
            pub(super) fn apply(&mut self, engagement: &Engagement, job: Job) {
                match engagement {
                    $( Engagement::$kind(change) => self.$field.apply(change, job), )*
                }
            }

            /// Reason why a coupling was refused when it was due.
            pub(super) fn refusal(&self, kind: Kind) -> Option<CouplingRefusal> {
                match kind {
                    $( Kind::$kind => self.$field.refusal().map(CouplingRefusal::$kind), )*
                }
            }

            /// Fault of a coupling.
            pub(super) fn fault(&self, kind: Kind) -> Option<CouplingFault> {
                match kind {
                    $( Kind::$kind => self.$field.fault().map(CouplingFault::$kind), )*
                }
            }

            /// State of a job that changes a coupling; idle if none knows it.
            pub(super) fn state_of(&self, job: Job) -> CommandState<CouplingRefusal> {
                $(
                    let state = self.$field.state_of(job).map_error(CouplingRefusal::$kind);
                    if state != CommandState::Idle {
                        return state;
                    }
                )*
                CommandState::Idle
            }
        }

        /// Planned change of a coupling.
        #[derive(Clone, Copy, Debug)]
        #[expect(
            clippy::large_enum_variant,
            reason = "it lives on the stack: nothing is allocated on the cycle path"
        )]
        pub(super) enum Engagement {
            $( #[doc = $doc] $kind(<$coupling as Engage>::Change), )*
        }

        impl Engagement {
            pub(super) const fn kind(&self) -> Kind {
                match self { $( Self::$kind(_) => Kind::$kind, )* }
            }
        }

        /// Refusal of a coupling, or of a change to it.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum CouplingRefusal {
            $( #[doc = $doc] $kind($refusal), )*
        }

        impl CouplingRefusal {
            /// NC error code.
            #[must_use]
            pub fn code(&self) -> u32 {
                match self { $( Self::$kind(refusal) => refusal.code(), )* }
            }
        }

        impl fmt::Display for CouplingRefusal {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self { $( Self::$kind(refusal) => refusal.fmt(f), )* }
            }
        }

        $(
            impl From<$refusal> for CouplingRefusal {
                fn from(refusal: $refusal) -> Self {
                    Self::$kind(refusal)
                }
            }
        )*

        /// Fault of a coupling.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum CouplingFault {
            $( #[doc = $doc] $kind(<$coupling as Engage>::Fault), )*
        }

        impl CouplingFault {
            /// NC error code.
            #[must_use]
            pub fn code(&self) -> u32 {
                match self { $( Self::$kind(fault) => fault.code(), )* }
            }
        }

        impl fmt::Display for CouplingFault {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self { $( Self::$kind(fault) => fault.fmt(f), )* }
            }
        }
    };
}

couplings! {
    /// A constant ratio.
    Gear => gear: Gear, refuses by RatioZero,
    /// A gear that is engaged and released on the fly.
    FlyingGear => flying_gear: FlyingGearCoupling, refuses by FlyingGearError,
    /// The sum of several masters.
    MultiMasterGear => multi_master_gear: MultiMasterGear, refuses by WrongRatios,
    /// Cam plates.
    Cam => cam: Cam, refuses by CouplingError,
    /// A flying saw.
    Saw => saw: Saw, refuses by SawRefusal,
}

impl Couplings {
    /// Creates the couplings, none of them engaged. The axis uses its master for a saw in this way.
    pub(super) fn new(saw: Saw) -> Self {
        Self {
            gear: Gear::default(),
            flying_gear: FlyingGearCoupling::default(),
            multi_master_gear: MultiMasterGear::default(),
            cam: Cam::default(),
            saw,
        }
    }

    /// The next job that has ended, of those that changed a coupling.
    pub(super) fn ended(&mut self) -> Option<Job> {
        Kind::ALL
            .into_iter()
            .find_map(|kind| self.get_mut(kind).ended())
    }

    /// Ends every coupling, and clears values that are not kept after their end.
    pub(super) fn end_all(&mut self) {
        for kind in Kind::ALL {
            self.get_mut(kind).end();
        }
    }
}
