//! Conditions of a step. Each stands once, in the table at the end of this file: its field in configs, its
//! value, the test of it, and the cause that can still meet it.

use std::fmt;

use coaxle_axis::{AxisStatus, StateWord};
use coaxle_cam::TableId;
use coaxle_node::config::{AtLeastZero, Finite};
use coaxle_slave::CouplingPhase;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::master_reaches::MasterReaches;
use super::outcome::Outcome;
use super::prospect::{
    Prospect, by_master, by_master_position, by_motion, by_plate, by_result, by_standstill,
    by_start, by_state,
};
use super::situation::Inputs;

/// Defines the conditions: the fields of [`When`], their names in [`WaitsFor`], and their tests.
///
/// A condition that is not met yet has a [`Prospect`]. With `handles`, a step that requires it handles a trouble by
/// itself.
macro_rules! conditions {
    ($(
        $(#[$meta:meta])*
        $field:ident $name:ident: $value:ty {
            holds: $holds:expr,
            prospect: $prospect:expr,
            $(handles: $handles:expr,)?
        }
    )*) => {
        /// A condition; everything that is given has to hold.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
        pub struct When {
            $(
                $(#[$meta])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $field: Option<$value>,
            )*
        }

        /// Condition that a program waits for: a field of its step, as written in a config.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum WaitsFor {
            /// A mark to be used.
            AtMark,
            $(
                $(#[$meta])*
                $name,
            )*
        }

        impl WaitsFor {
            const fn field(self) -> &'static str {
                match self {
                    Self::AtMark => "at_mark",
                    $(Self::$name => stringify!($field),)*
                }
            }
        }

        impl When {
            /// Returns the unmet conditions, in the order of the table, with their prospects.
            pub(super) fn unmet(
                &self,
                inputs: Inputs<'_>,
            ) -> impl Iterator<Item = (WaitsFor, Prospect)> + use<> {
                [$(
                    self.$field.and_then(|wanted| {
                        let holds: fn($value, &Inputs<'_>) -> bool = $holds;
                        let prospect: fn($value, &Inputs<'_>) -> Prospect = $prospect;
                        (!holds(wanted, &inputs))
                            .then(|| (WaitsFor::$name, prospect(wanted, &inputs)))
                    }),
                )*]
                .into_iter()
                .flatten()
            }

            /// True if it requires a trouble, which the step then handles itself.
            pub(super) fn handles_trouble(&self) -> bool {
                false $($(|| {
                    let handles: fn($value) -> bool = $handles;
                    self.$field.is_some_and(handles)
                })?)*
            }
        }
    };
}

/// The unmet condition that is hardest to meet; the first of equals.
pub(super) fn hardest(
    unmet: impl Iterator<Item = (WaitsFor, Prospect)>,
) -> Option<(WaitsFor, Prospect)> {
    unmet.reduce(|a, b| if b.1 > a.1 { b } else { a })
}

impl When {
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for WaitsFor {
    /// Writes the field as configs have it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, word) in self.field().split('_').enumerate() {
            f.write_str(if n > 0 { "-" } else { "" })?;
            f.write_str(word)?;
        }
        Ok(())
    }
}

// Comparisons with a position that is not finite are unmet.
conditions! {
    /// Least time since the program began, s of the node's own clock.
    time_s TimeS: AtLeastZero {
        holds: |least, at| at.passed.since_start.0 >= least.get(),
        prospect: |_, _| Prospect::Spontaneous,
    }
    /// Least time since the step before, s.
    after_s AfterS: AtLeastZero {
        holds: |least, at| at.passed.since_step.0 >= least.get(),
        prospect: |_, _| Prospect::Spontaneous,
    }
    /// A detected mark that is neither used nor past the slave's position 0, or none.
    mark_seen MarkSeen: bool {
        holds: |wanted, at| at.passed.mark_seen == wanted,
        prospect: |wanted, at| if wanted { by_master(at) } else { Prospect::Spontaneous },
    }
    /// The slave moves with its master, or does not.
    in_sync InSync: bool {
        holds: |wanted, at| (at.slave.phase == Some(CouplingPhase::InSync)) == wanted,
        prospect: |wanted, at| match at.slave.phase {
            None if wanted => by_start(at),
            _ => Prospect::Spontaneous,
        },
    }
    /// The slave has stood for a cycle, or has not.
    standstill Standstill: bool {
        holds: |wanted, at| at.slave.stands == wanted,
        prospect: |wanted, at| if wanted { by_standstill(at) } else { by_motion(at, |_| true) },
    }
    /// The master is there, without error and in a mode that synchronises in sync, or is not.
    master_ready MasterReady: bool {
        holds: |wanted, at| at.slave.master_ready == wanted,
        prospect: |wanted, _| if wanted { Prospect::ByMaster } else { Prospect::Spontaneous },
    }
    /// The master's position is above this, in its units.
    master_above MasterAbove: Finite {
        holds: |limit, at| at.slave.master.is_some_and(|master| master > limit.get()),
        prospect: |_, at| by_master_position(at),
    }
    /// The master's position is below this, in its units.
    master_below MasterBelow: Finite {
        holds: |limit, at| at.slave.master.is_some_and(|master| master < limit.get()),
        prospect: |_, at| by_master_position(at),
    }
    /// The master comes to a position within a time, as its node has promised (CODESYS `SMC_GetTravelTime`).
    #[doc(alias = "SMC_GetTravelTime")]
    master_reaches MasterReaches: MasterReaches {
        holds: |wanted, at| wanted.holds(at.slave),
        prospect: |_, at| by_master_position(at),
    }
    /// The slave's set position is above this, u.
    position_above PositionAbove: Finite {
        holds: |limit, at| at.slave.set.position > limit.get(),
        prospect: |_, at| by_motion(at, |velocity| velocity > 0.0),
    }
    /// The slave's set position is below this, u.
    position_below PositionBelow: Finite {
        holds: |limit, at| at.slave.set.position < limit.get(),
        prospect: |_, at| by_motion(at, |velocity| velocity < 0.0),
    }
    /// The slave is in this state of the PLCopen diagram.
    state State: AxisStatus {
        holds: |wanted, at| at.slave.status == wanted,
        prospect: by_state,
    }
    /// The slave is in error stop, or is not.
    error_stop ErrorStop: bool {
        holds: |wanted, at| (at.slave.status == AxisStatus::ErrorStop) == wanted,
        prospect: |wanted, _| if wanted { Prospect::Spontaneous } else { Prospect::ByOrder },
        handles: |wanted| wanted,
    }
    /// Number of the cam plate that couples the slave (the first of several); 0: none.
    cam_table CamTable: TableId {
        holds: |wanted, at| at.slave.cam_table == wanted,
        prospect: by_plate,
    }
    /// A plate waits for its moment to couple the slave, or none does.
    cam_table_queued CamTableQueued: bool {
        holds: |wanted, at| at.slave.queues(StateWord::CAM_TABLE_QUEUED) == wanted,
        prospect: |wanted, at| if wanted { Prospect::ByOrder } else { by_master(at) },
    }
    /// Points of the plate that couples the slave wait for their moment, or none do.
    cam_data_queued CamDataQueued: bool {
        holds: |wanted, at| at.slave.queues(StateWord::CAM_DATA_QUEUED) == wanted,
        prospect: |wanted, at| if wanted { Prospect::ByOrder } else { by_master(at) },
    }
    /// The program's last command has come to its end, or has not.
    done Done: bool {
        holds: |wanted, at| (at.passed.outcome == Some(Outcome::Done)) == wanted,
        prospect: |_, at| by_result(at),
    }
    /// The program's last command was aborted, or was not.
    aborted Aborted: bool {
        holds: |wanted, at| (at.passed.outcome == Some(Outcome::Aborted)) == wanted,
        prospect: |_, at| by_result(at),
        handles: |wanted| wanted,
    }
    /// Error stop of the slave since the program's last command, or none.
    failed Failed: bool {
        holds: |wanted, at| (at.passed.outcome == Some(Outcome::Failed)) == wanted,
        prospect: |wanted, at| if wanted { Prospect::Spontaneous } else { by_result(at) },
        handles: |wanted| wanted,
    }
    /// The program's last command was refused, or was not.
    refused Refused: bool {
        holds: |wanted, at| (at.passed.outcome == Some(Outcome::Refused)) == wanted,
        prospect: |_, at| by_result(at),
        handles: |wanted| wanted,
    }
    /// The program's last command was a flying saw whose master ran back past the coupling
    /// position, or was not.
    rolled_back RolledBack: bool {
        holds: |wanted, at| (at.passed.outcome == Some(Outcome::RolledBack)) == wanted,
        prospect: |_, at| by_result(at),
        handles: |wanted| wanted,
    }
    /// A step has waited for its `timeout-s` since the program's last command, or none has.
    timed_out TimedOut: bool {
        holds: |wanted, at| at.passed.timed_out == wanted,
        prospect: |_, _| Prospect::Never,
        handles: |wanted| wanted,
    }
}
