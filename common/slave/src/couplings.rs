//! The kinds of couplings, listed only here.

use core::fmt;

use coaxle_axis::{
    CommandState, Coupling, Engage, Job, MasterDemands, NotPlanned, PlanInputs, Planned, Scan,
    StateWord, Step,
};
use coaxle_cam::{Cam, CouplingError, Tables};
use coaxle_gear::{
    FlyingGearCoupling, FlyingGearError, Gear, MultiMasterGear, RatioZero, WrongRatios,
};
use coaxle_saw::{Saw, SawRefusal};

/// Store that a coupling of this kind shares with those of other axes: the plates, or nothing.
macro_rules! shared {
    (&$tables:ident) => {
        &()
    };
    (&mut $tables:ident) => {
        &mut ()
    };
    (&$tables:ident on plates) => {
        $tables
    };
    (&mut $tables:ident on plates) => {
        $tables
    };
}

/// Lists the couplings of a slave, one of each kind, and generates their kinds, the dispatch by
/// kind, and the wrappers of their plans, refusals and faults.
macro_rules! couplings {
    ($(
        #[doc = $doc:literal]
        $kind:ident => $field:ident: $coupling:ty, refuses by $refusal:ty $(, on $plates:ident)?;
    )*) => {
        /// A kind of coupling.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Kind {
            $( #[doc = $doc] $kind, )*
        }

        impl Kind {
            pub(super) const ALL: [Self; [$(Self::$kind),*].len()] = [$(Self::$kind),*];
        }

        /// The couplings of a slave, at most one of them engaged.
        #[derive(Debug, Default)]
        pub(super) struct Couplings {
            $( pub(super) $field: $coupling, )*
        }

        impl Couplings {
            /// The state of the coupling of a kind.
            // An object where no store is needed. The rest differs in its types by kind, and is dispatched below.
            pub(super) fn get(&self, kind: Kind) -> &dyn Coupling {
                match kind { $( Kind::$kind => &self.$field, )* }
            }

            fn get_mut(&mut self, kind: Kind) -> &mut dyn Coupling {
                match kind { $( Kind::$kind => &mut self.$field, )* }
            }

            $(
                #[allow(unused_variables, reason = "only some couplings are on plates")]
                pub(super) fn $field(
                    &self,
                    tables: &Tables,
                    command: &<$coupling as Engage>::Command,
                    inputs: &PlanInputs,
                ) -> Result<Planned<Engagement>, NotPlanned<CouplingRefusal>> {
                    let planned = self.$field.plan(shared!(&tables $(on $plates)?), command, inputs)
                        .map_err(|why| why.map(CouplingRefusal::$kind))?;
                    Ok(Planned {
                        change: Engagement::$kind(planned.change),
                        awaits: planned.awaits,
                        effect: planned.effect,
                    })
                }
            )*

            /// Applies a plan.
            pub(super) fn apply(&mut self, tables: &mut Tables, engagement: &Engagement, job: Job) {
                match engagement {
                    $( Engagement::$kind(change) => {
                        self.$field.apply(shared!(&mut tables $(on $plates)?), change, job);
                    } )*
                }
            }

            /// Runs one cycle of the coupling of a kind.
            pub(super) fn update(&mut self, kind: Kind, tables: &mut Tables, scan: &Scan) -> Step {
                match kind {
                    $( Kind::$kind => {
                        self.$field.update(shared!(&mut tables $(on $plates)?), scan)
                    } )*
                }
            }

            /// Ends the coupling of a kind.
            pub(super) fn end(&mut self, kind: Kind, tables: &mut Tables) {
                match kind {
                    $( Kind::$kind => self.$field.end(shared!(&mut tables $(on $plates)?)), )*
                }
            }

            /// Passes an error stop of the axis, with this NC code, to the coupling of a kind.
            pub(super) fn fail(&mut self, kind: Kind, tables: &mut Tables, code: u32) {
                match kind {
                    $( Kind::$kind => {
                        self.$field.fail(shared!(&mut tables $(on $plates)?), code);
                    } )*
                }
            }

            /// The bits of `nStateDWord` for pending changes of the coupling of a kind.
            pub(super) fn queued(&self, kind: Kind, tables: &Tables) -> StateWord {
                match kind {
                    $( Kind::$kind => self.$field.queued(shared!(&tables $(on $plates)?)), )*
                }
            }

            /// Scaling of the master positions by the coupling of a kind.
            pub(super) fn master_scaling(&self, kind: Kind, tables: &Tables) -> f64 {
                match kind {
                    $( Kind::$kind => {
                        self.$field.master_scaling(shared!(&tables $(on $plates)?))
                    } )*
                }
            }

            /// Greatest demands on the slave by a master of the coupling of a kind.
            pub(super) fn demands_of(
                &self,
                kind: Kind,
                tables: &Tables,
                master: usize,
            ) -> MasterDemands {
                match kind {
                    $( Kind::$kind => {
                        self.$field.demands_of(shared!(&tables $(on $plates)?), master)
                    } )*
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
                    // Numbers of jobs are unique in an axis: at most one kind knows one.
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
    Gear => gear: Gear, refuses by RatioZero;
    /// A gear that is engaged and released on the fly.
    FlyingGear => flying_gear: FlyingGearCoupling, refuses by FlyingGearError;
    /// The sum of several masters.
    MultiMasterGear => multi_master_gear: MultiMasterGear, refuses by WrongRatios;
    /// Cam plates.
    Cam => cam: Cam, refuses by CouplingError, on plates;
    /// A flying saw.
    Saw => saw: Saw, refuses by SawRefusal;
}

impl Couplings {
    /// Creates the couplings, none of them engaged. The axis uses its master for a saw in this way.
    pub(super) fn new(saw: Saw) -> Self {
        Self {
            saw,
            ..Self::default()
        }
    }

    /// The next job that has ended, of those that changed a coupling.
    pub(super) fn ended(&mut self) -> Option<Job> {
        Kind::ALL
            .into_iter()
            // Every kind is asked: a change may end in the cycle in which another coupling takes over.
            .find_map(|kind| self.get_mut(kind).ended())
    }

    /// Ends every coupling, and clears values that are not kept after their end.
    pub(super) fn end_all(&mut self, tables: &mut Tables) {
        // Ending is idempotent, so that couplings which are not engaged need no check.
        for kind in Kind::ALL {
            self.end(kind, tables);
        }
    }
}
