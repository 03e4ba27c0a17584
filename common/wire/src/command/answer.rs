//! The answer to an order.

use coaxle_axis::SyncPositions;
use coaxle_axis::guard::GuardRefusal;
use coaxle_saw::SawRefusal;
use coaxle_slave::{CouplingRefusal, Refusal};
use serde::{Deserialize, Serialize};

use super::COMMAND_VERSION;
use super::cam::{self, CamFigures, OrderCargo};
use super::far::{FarRefusal, FarView};
use super::outcome::{CommandOutcome, NotTaken, SlaveView};
use super::saw::{SawFigures, SawRefused};
use super::{BadOrder, CommandOrder};

/// What became of an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandAnswer {
    /// The version of everything else.
    pub version: u32,
    /// What became of it.
    #[serde(flatten)]
    pub verdict: CommandVerdict,
}

/// What became of an order, in words and figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    tag = "outcome",
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case"
)]
pub enum CommandVerdict {
    /// The slave, or the far node, has the command; after a dry run, it would have taken it.
    Accepted {
        /// Whether it was only tried.
        dry_run: bool,
        /// The number of the slave's job; none for what is done at once, and after a dry run.
        job: Option<u32>,
        /// What is checked again when the command is due, if it waits; it can still be refused then.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        awaits: Vec<String>,
        /// The slave with the command; after a dry run, without.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        axis: Option<SlaveView>,
        /// The far node with the command; after a dry run, without.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        far: Option<FarView>,
        /// Where master and slave are synchronous, if the command leads to such a pair of positions.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sync_positions: Option<SyncPositions>,
        /// What its flying saw comes to, if the command is about one.
        saw: Option<SawFigures>,
        /// What was read of a cam plate, or of a coupling by one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        cam: Option<CamFigures>,
    },
    /// The slave, or the far node, refuses the command.
    Refused {
        /// Whether it was only tried.
        dry_run: bool,
        /// NC error code, or one of TwinCAT's remote synchronisation: `0x` and four hexadecimal digits.
        code: String,
        /// Why, in words: what was received and what is expected.
        text: String,
        /// What it is about, where that has a number.
        field: Option<String>,
        /// That number.
        received: Option<f64>,
        /// The nearest one that would have passed, where it is known.
        would_pass: Option<f64>,
        /// The slave, which goes on with what it was doing.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        axis: Option<SlaveView>,
        /// The far node, which goes on as before.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        far: Option<FarView>,
        /// More, if it was to be a flying saw.
        saw: Option<SawRefused>,
    },
    /// The order did not get as far as a slave or a far node.
    NotTaken {
        /// Why: `malformed`, or one of [`NotTaken::name`].
        reason: String,
        /// The same in words.
        text: String,
    },
}

impl CommandAnswer {
    /// What a node says to an order, but for what it was to read of a plate.
    #[must_use]
    pub fn new(order: &CommandOrder, outcome: &CommandOutcome) -> Self {
        Self::with_cargo(order, outcome, &OrderCargo::Nothing)
    }

    /// What a node says to an order, with what the order takes back. What was to be read is calculated here.
    #[must_use]
    pub fn with_cargo(order: &CommandOrder, outcome: &CommandOutcome, cargo: &OrderCargo) -> Self {
        let dry_run = order.is_dry_run();
        let (command, reading) = match order {
            CommandOrder::Slave(order) => (Some(&order.command), None),
            CommandOrder::Cam(order) => (None, Some(&order.command)),
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

    /// What is said to an order that no slave and no far node gets.
    #[must_use]
    pub fn not_taken(reason: &NotTaken) -> Self {
        Self::of(CommandVerdict::NotTaken {
            reason: reason.name().to_owned(),
            text: reason.to_string(),
        })
    }

    /// What is said to something that is no order.
    #[must_use]
    pub fn malformed(error: &BadOrder) -> Self {
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

    /// Whether a slave or a far node took or would take the command.
    #[must_use]
    pub const fn is_accepted(&self) -> bool {
        matches!(self.verdict, CommandVerdict::Accepted { .. })
    }

    /// Whether the order got as far as a slave or a far node.
    #[must_use]
    pub const fn is_taken(&self) -> bool {
        !matches!(self.verdict, CommandVerdict::NotTaken { .. })
    }

    /// Reads an answer. Fields that are not known are ignored.
    ///
    /// # Errors
    /// What serde says of bytes that are no answer of this version.
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

    /// Writes the answer.
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
    let figures = Figures::of(refusal);
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

/// The numbers in a refusal.
#[derive(Default)]
struct Figures {
    field: Option<&'static str>,
    received: Option<f64>,
    would_pass: Option<f64>,
}

impl Figures {
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
