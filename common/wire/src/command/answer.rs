//! The response to an order.

use coaxle_axis::SyncPositions;
use coaxle_axis::guard::GuardRefusal;
use coaxle_saw::SawRefusal;
use coaxle_slave::{CouplingRefusal, Refusal};
use serde::{Deserialize, Serialize};

use super::cam::{self, CamFigures, OrderCargo};
use super::far::{FarRefusal, FarView};
use super::order::CommandOrder;
use super::outcome::{CommandOutcome, NotTaken, SlaveView};
use super::saw::{SawFigures, SawRefused};
use super::{COMMAND_VERSION, InvalidOrder};

/// Response to an order, with its version.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandAnswer {
    /// Version of everything else.
    pub version: u32,
    /// Result of the order.
    #[serde(flatten)]
    pub verdict: CommandVerdict,
}

/// Result of an order, in words and figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    tag = "outcome",
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case"
)]
pub enum CommandVerdict {
    /// The slave or the far node accepted the command; after a dry run: would have accepted it.
    Accepted {
        /// True after a dry run.
        dry_run: bool,
        /// Number of the slave's job; none for a command that is done at once, and after a dry run.
        job: Option<u32>,
        /// Conditions checked again when a waiting command is due; it can still be refused then.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        awaits: Vec<String>,
        /// Slave with the command; after a dry run, without it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        axis: Option<SlaveView>,
        /// Far node with the command; after a dry run, without it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        far: Option<FarView>,
        /// Positions at which master and slave are synchronous, if the command leads to such a pair.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sync_positions: Option<SyncPositions>,
        /// Figures of its flying saw, if the command is about one.
        saw: Option<SawFigures>,
        /// Values read of a cam plate, or of a coupling by one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        cam: Option<CamFigures>,
    },
    /// The slave or the far node refuses the command.
    Refused {
        /// True after a dry run.
        dry_run: bool,
        /// NC error code, or one of TwinCAT's remote synchronisation: `0x` and four hexadecimal digits.
        code: String,
        /// Reason in words: received and expected value.
        text: String,
        /// Field that is refused, if it has a number.
        field: Option<String>,
        /// Value received for it.
        received: Option<f64>,
        /// Nearest value that would have been accepted, if it is known.
        would_pass: Option<f64>,
        /// Slave, which continues unchanged.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        axis: Option<SlaveView>,
        /// Far node, which continues unchanged.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        far: Option<FarView>,
        /// Details of a refused flying saw.
        saw: Option<SawRefused>,
    },
    /// The order did not reach a slave or a far node.
    NotTaken {
        /// Reason: `malformed`, or one of [`NotTaken::name`].
        reason: String,
        /// Reason in words.
        text: String,
    },
}

impl CommandAnswer {
    /// Makes the response of a node to an order, without values read of a plate.
    #[must_use]
    pub fn new(order: &CommandOrder, outcome: &CommandOutcome) -> Self {
        Self::with_cargo(order, outcome, &OrderCargo::Nothing)
    }

    /// Makes the response of a node to an order, with the cargo that the order takes back. Values to read
    /// are calculated here.
    #[must_use]
    pub fn with_cargo(order: &CommandOrder, outcome: &CommandOutcome, cargo: &OrderCargo) -> Self {
        let dry_run = order.is_dry_run();
        let (command, reading) = match order {
            CommandOrder::Slave(order) => (Some(&order.command), None),
            CommandOrder::Plate(order) => (None, Some(&order.command)),
            CommandOrder::Far(_) => (None, None),
        };
        match *outcome {
            CommandOutcome::Accepted {
                job,
                awaits,
                slave,
                sync_positions,
                ref saw,
            } => match reading.map_or(Ok(None), |reading| cam::read(reading, cargo)) {
                Ok(cam) => Self::of(CommandVerdict::Accepted {
                    dry_run,
                    job: job.filter(|_| !dry_run),
                    awaits: awaits.names().map(str::to_owned).collect(),
                    axis: Some(slave),
                    far: None,
                    // The figures of a saw have them.
                    sync_positions: sync_positions.filter(|_| saw.is_none()),
                    saw: saw.zip(command).map(|(saw, of)| SawFigures::of(&saw, of)),
                    cam,
                }),
                Err(error) => {
                    let refusal = Refusal::Coupling(CouplingRefusal::Cam(error));
                    Self::of(refused(&refusal, dry_run, slave, None))
                }
            },
            CommandOutcome::CamInfo { info, slave } => Self::of(CommandVerdict::Accepted {
                dry_run,
                job: None,
                awaits: Vec::new(),
                axis: Some(slave),
                far: None,
                sync_positions: None,
                saw: None,
                cam: Some(CamFigures::Info(Box::new(info))),
            }),
            CommandOutcome::Refused {
                refusal,
                slave,
                ref saw,
            } => Self::of(refused(
                &refusal,
                dry_run,
                slave,
                SawRefused::of(&refusal, saw.as_ref()),
            )),
            CommandOutcome::FarAccepted { far } => Self::of(CommandVerdict::Accepted {
                dry_run,
                job: None,
                awaits: Vec::new(),
                axis: None,
                far: Some(far),
                sync_positions: None,
                saw: None,
                cam: None,
            }),
            CommandOutcome::FarRefused { refusal, far } => {
                Self::of(far_refused(&refusal, dry_run, far))
            }
            CommandOutcome::NotTaken(reason) => Self::not_taken(&reason),
        }
    }

    /// Makes the response to an order that reaches neither a slave nor a far node.
    #[must_use]
    pub fn not_taken(reason: &NotTaken) -> Self {
        Self::of(CommandVerdict::NotTaken {
            reason: reason.name().to_owned(),
            text: reason.to_string(),
        })
    }

    /// Makes the response to bytes that are not an order.
    #[must_use]
    pub fn malformed(error: &InvalidOrder) -> Self {
        Self::of(CommandVerdict::NotTaken {
            reason: "malformed".to_owned(),
            text: error.to_string(),
        })
    }

    const fn of(verdict: CommandVerdict) -> Self {
        Self {
            version: COMMAND_VERSION,
            verdict,
        }
    }

    /// True if a slave or a far node accepted or would accept the command.
    #[must_use]
    pub const fn is_accepted(&self) -> bool {
        matches!(self.verdict, CommandVerdict::Accepted { .. })
    }

    /// True if the order reached a slave or a far node.
    #[must_use]
    pub const fn is_taken(&self) -> bool {
        !matches!(self.verdict, CommandVerdict::NotTaken { .. })
    }

    /// Reads a response. Unknown fields are ignored.
    ///
    /// # Errors
    /// The error of serde for bytes that are not a response of this version.
    pub fn from_json(bytes: &[u8]) -> serde_json::Result<Self> {
        let answer: Self = serde_json::from_slice(bytes)?;
        if answer.version == COMMAND_VERSION {
            Ok(answer)
        } else {
            Err(serde::de::Error::custom(format_args!(
                "version: received {}, expected {COMMAND_VERSION}",
                answer.version
            )))
        }
    }

    /// Writes the response.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("all keys of an answer are texts")
    }
}

fn refused(
    refusal: &Refusal,
    dry_run: bool,
    axis: SlaveView,
    saw: Option<SawRefused>,
) -> CommandVerdict {
    let figures = RefusalFigures::of(refusal);
    CommandVerdict::Refused {
        dry_run,
        code: format!("{:#06x}", refusal.code()),
        text: refusal.to_string(),
        field: figures.field.map(str::to_owned),
        received: figures.received,
        would_pass: figures.would_pass,
        axis: Some(axis),
        far: None,
        saw,
    }
}

fn far_refused(refusal: &FarRefusal, dry_run: bool, far: FarView) -> CommandVerdict {
    CommandVerdict::Refused {
        dry_run,
        code: format!("{:#06x}", refusal.code()),
        text: refusal.to_string(),
        field: Some(refusal.field()),
        received: refusal.received(),
        would_pass: None,
        axis: None,
        far: Some(far),
        saw: None,
    }
}

/// Numbers in a refusal.
#[derive(Default)]
struct RefusalFigures {
    field: Option<&'static str>,
    received: Option<f64>,
    would_pass: Option<f64>,
}

impl RefusalFigures {
    fn of(refusal: &Refusal) -> Self {
        let (field, received, would_pass) = match *refusal {
            Refusal::SyncPosition(wrong) => {
                return Self::new(wrong.field(), wrong.received(), None);
            }
            Refusal::NotAtRest { velocity } => ("velocity", velocity, Some(0.0)),
            Refusal::Guard(refusal) => return Self::of_guard(&refusal),
            Refusal::Coupling(CouplingRefusal::Saw(refusal)) => return Self::of_saw(&refusal),
            _ => return Self::default(),
        };
        Self::new(field, received, would_pass)
    }

    const fn of_guard(refusal: &GuardRefusal) -> Self {
        match *refusal {
            GuardRefusal::AboveLimit {
                field,
                received,
                limit,
            } => Self::new(field, received, Some(limit)),
            GuardRefusal::SoftwareLimit { reached, limit } => {
                Self::new("position", reached, Some(limit))
            }
            GuardRefusal::Value {
                field, received, ..
            } => Self::new(field, received, None),
        }
    }

    fn of_saw(refusal: &SawRefusal) -> Self {
        match *refusal {
            SawRefusal::RatioZero { numerator } => Self::new("ratio.numerator", numerator, None),
            SawRefusal::DenominatorZero => Self::new("ratio.denominator", 0.0, None),
            SawRefusal::NotFinite { field, received } | SawRefusal::Limit { field, received } => {
                Self::new(field, received, None)
            }
            SawRefusal::SyncVelocity { velocity, limit } => {
                Self::new("velocity", velocity, Some(limit.copysign(velocity)))
            }
            SawRefusal::MasterNotAhead { sync_position, .. } => {
                Self::new("master-sync-position", sync_position, None)
            }
            SawRefusal::SlaveNotAhead { sync_position, .. } => {
                Self::new("slave-sync-position", sync_position, None)
            }
            SawRefusal::MasterAtRest { slave_velocity, .. } => {
                Self::new("velocity", slave_velocity, Some(0.0))
            }
            SawRefusal::StartDistance { received } => {
                Self::new("master-start-distance", received, None)
            }
            SawRefusal::NoRamp { slave_acceleration } => {
                Self::new("acceleration", slave_acceleration, None)
            }
            SawRefusal::MasterStands => Self::new("master-velocity", 0.0, None),
            SawRefusal::TooShort { needed, available } => {
                Self::new("duration", needed, Some(available))
            }
            SawRefusal::NothingLeft { velocity, limit } => {
                Self::new("velocity", velocity, Some(limit.copysign(velocity)))
            }
            SawRefusal::TableInUse { table } => Self::new("table", table.into(), None),
            SawRefusal::NoTable { axis_id } => Self::new("axis-id", axis_id.into(), None),
            SawRefusal::Violation(violation) => Self::new(
                violation.check.quantity(),
                violation.measured,
                Some(violation.limit),
            ),
            SawRefusal::TimeBasedPosition => Self::default(),
        }
    }

    const fn new(field: &'static str, received: f64, would_pass: Option<f64>) -> Self {
        Self {
            field: Some(field),
            received: Some(received),
            would_pass,
        }
    }
}
