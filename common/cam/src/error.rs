//! Reasons why a coupling, or a change to one, is refused.

use super::modes::ActivationMode;
use super::rules::{MOST_POINTS_REPLACED_IN_USE, Operation};
use coaxle_curve::figure::{Beyond, Rounded, UpTo};
use coaxle_curve::law::Quantity;
use coaxle_plate::{CamError, TableType};

/// `MC_CAM_ID`, TF5050 chapter 8.1: the number of a plate, 1 to 255.
#[doc(alias = "MC_CAM_ID")]
pub type TableId = u32;

/// A refusal. [`CouplingError::code`] is the NC's number; the text names the received value and the
/// permitted range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CouplingError {
    /// 0x4B32: not a table id.
    #[doc(alias = "MC_ERROR_CAMTABLEID_INVALID")]
    #[error("{:#06x}: received table id {received}, expected 1 to 255", self.code())]
    TableId {
        /// The id received.
        received: TableId,
    },
    /// 0x4063: there is a table of that id already.
    #[error("{:#06x}: received table id {table}, expected one not in the store", self.code())]
    TableExists {
        /// The id received.
        table: TableId,
    },
    /// 0x4A11: the store is full.
    #[error("{:#06x}: the store holds {capacity} tables and is full", self.code())]
    StoreFull {
        /// Capacity of the store, tables.
        capacity: usize,
    },
    /// 0x4216: there is no table of that id.
    #[error("{:#06x}: received table id {table}, expected one in the store", self.code())]
    TableUnknown {
        /// The id received.
        table: TableId,
    },
    /// 0x4259: the table is coupled, or queued for coupling.
    #[error("{:#06x}: table {table} is in use {uses} times, expected none", self.code())]
    TableInUse {
        /// The id received.
        table: TableId,
        /// Number of its uses.
        uses: u32,
    },
    /// 0x4259: the table is coupled, or queued for coupling, and its points cannot change to those of the
    /// other one.
    #[error(
        "{:#06x}: table {table} is in use {uses} times, expected none, or a motion function of at most \
         {MOST_POINTS_REPLACED_IN_USE} points for one of as many and of the same course: {table} is a {table_type:?} of {rows}",
        self.code()
    )]
    NotReplaceable {
        /// The id received.
        table: TableId,
        /// Number of its uses.
        uses: u32,
        /// Type of the table.
        table_type: TableType,
        /// Number of its points or rows.
        rows: usize,
    },
    /// 0x4A11: the plates would have more points and rows than there is memory for.
    #[error("{:#06x}: received {received} points or rows, expected at most {room}: delete other tables", self.code())]
    TooManyRows {
        /// Number of points or rows of the plate.
        received: usize,
        /// Number for which there is memory.
        room: usize,
    },
    /// 0x4B30: no plate came with the command.
    #[doc(alias = "MC_ERROR_POINTER_INVALID")]
    #[error("{:#06x}: received no plate, expected one", self.code())]
    NoTable,
    /// 0x4B31: more points were written than can be read at a time.
    #[doc(alias = "MC_ERROR_ARRAYSIZE_INVALID")]
    #[error(
        "{:#06x}: {changed} points of table {table} were written since it was selected, expected at most {most} to read it: \
         select it anew",
        self.code()
    )]
    TooManyChanged {
        /// The table.
        table: TableId,
        /// Number of points written.
        changed: usize,
        /// Greatest number of written points with which it can be read.
        most: usize,
    },
    /// 0x4256: the slave is not coupled by a cam plate.
    #[error("{:#06x}: the slave is not coupled by a cam plate", self.code())]
    NotCoupled,
    /// 0x425C: `MC_CamIn` on a slave of `MC_CamIn_V2`, or the other way round.
    #[error("{:#06x}: MC_CamIn and MC_CamIn_V2 exclude each other on one slave until it is uncoupled", self.code())]
    OtherKindOfCoupling,
    /// 0x425E: the slave has all the plates it can have.
    #[error("{:#06x}: the slave has {most} plates, and may have no more", self.code())]
    TooManyTables {
        /// Greatest number of plates.
        most: usize,
    },
    /// 0x4261: the plate is not one of the slave's.
    #[error("{:#06x}: received table id {table}, expected that of a plate the slave is coupled by", self.code())]
    TableNotCoupled {
        /// The id received.
        table: TableId,
    },
    /// 0x4261: the command has to name one of the slave's plates.
    #[error("{:#06x}: received no table id, expected one since the slave is coupled by {coupled} plates", self.code())]
    Ambiguous {
        /// Number of coupled plates.
        coupled: usize,
    },
    /// 0x4261: the plate is already one of the slave's, and could not be identified any more.
    #[error("{:#06x}: received table id {table}, expected one the slave is not coupled by yet", self.code())]
    TableCoupledAlready {
        /// The id received.
        table: TableId,
    },
    /// 0x4283 for an online change, else 0x4B04: the mode does not go with the operation.
    #[error("{:#06x}: received activation mode {mode:?}, which does not go with {operation:?}", self.code())]
    ModeNotAllowed {
        /// Operation of the command.
        operation: Operation,
        /// Activation mode of the command.
        mode: ActivationMode,
    },
    /// 0x4283: a linear plate has no next cycle.
    #[error("{:#06x}: table {table} is linear and has no next cycle, expected a cyclic one", self.code())]
    NoNextCycle {
        /// The plate.
        table: TableId,
    },
    /// 0x4250: the position of the master on the plate is not known before a relative coupling is active.
    #[error("{:#06x}: received activation mode {mode:?} with a relative master, expected an absolute one", self.code())]
    ModeNeedsAbsoluteMaster {
        /// The mode received.
        mode: ActivationMode,
    },
    /// 0x4219: there is no plate whose master position could be kept.
    #[error("{:#06x}: automatic master offset: there is no plate whose master position could be kept", self.code())]
    NoReferencePlate,
    /// 0x425F: the automatic master offset contradicts a relative start.
    #[error("{:#06x}: automatic master offset: received a relative master, expected an absolute one", self.code())]
    AutoOffsetWithRelativeMaster,
    /// 0x425B or 0x4A17: an invalid scaling or offset.
    #[error("{:#06x}: {field}: received {received}, expected {}", self.code(), scaling_expected(.field))]
    Scaling {
        /// Name of the value.
        field: &'static str,
        /// Value received.
        received: f64,
    },
    /// 0x422B: the activation position is outside the plate, or not finite.
    #[error("{:#06x}: activation position: received {received}, expected {from} to {to}", self.code())]
    ActivationPosition {
        /// Position received.
        received: f64,
        /// Start of the plate.
        from: f64,
        /// End of the plate.
        to: f64,
    },
    /// 0x426D: the master moves away from the activation position.
    #[error("{:#06x}: activation position: received {received}, expected it ahead of the master at {}", self.code(), Rounded(*master))]
    ActivationPassed {
        /// Position received.
        received: f64,
        /// Position of the master.
        master: f64,
    },
    /// 0x426F: a slave that moves cannot wait for the activation.
    #[error("{:#06x}: the slave moves at {} u/s, expected standstill to wait for the activation", self.code(), Rounded(*velocity))]
    SlaveMoving {
        /// Velocity of the slave, u/s.
        velocity: f64,
    },
    /// 0x4287: another change of that kind is queued.
    #[error("{:#06x}: another change is queued for table {table}", self.code())]
    Pending {
        /// The plate it is queued for.
        table: TableId,
    },
    /// 0x421A: the slave would jump.
    #[error(
        "{:#06x}: the slave would jump by {} u, expected at most {} u: move it there, or ramp it in",
        self.code(), Beyond { value: *distance, limit: *allowed }, Rounded(*allowed)
    )]
    Jump {
        /// Size of the jump, u.
        distance: f64,
        /// Greatest deviation from the slave's own motion in a cycle, u.
        allowed: f64,
    },
    /// 0x421A: the slave's velocity would jump.
    #[error(
        "{:#06x}: the slave's velocity would jump by {} u/s, expected at most {} u/s: ramp it in, or \
         change where both courses have one velocity, at rest say",
        self.code(), Beyond { value: *change, limit: *allowed }, Rounded(*allowed)
    )]
    VelocityJump {
        /// Size of the jump, u/s.
        change: f64,
        /// Greatest change of velocity in a cycle beyond that of the slave's own motion, u/s.
        allowed: f64,
    },
    /// 0x42DD: the slave could not follow its new course.
    #[error(
        "{:#06x}: {quantity} of the slave: received {} {unit}, expected at most {} {unit}, with a master at {} u/s: \
         lead it at up to {} u/s, scale the plate down, or take a longer ramp",
        self.code(), Beyond { value: *received, limit: *limit }, Rounded(*limit), Rounded(*speed), UpTo(*fastest),
        unit = quantity.unit()
    )]
    BeyondLimits {
        /// Limited quantity.
        quantity: Quantity,
        /// Value needed.
        received: f64,
        /// Limit of the slave.
        limit: f64,
        /// Speed of the master, u/s.
        speed: f64,
        /// Greatest speed of the master there, u/s.
        fastest: f64,
    },
    /// 0x4A1C: a parameter is out of range.
    #[error("{:#06x}: {name}: received {received}, expected {expected}", self.code())]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value received.
        received: f64,
        /// Permitted values.
        expected: &'static str,
    },
    /// 0x4B34: the number of points does not match the points given.
    #[doc(alias = "MC_ERROR_NUMPOINTS_INVALID")]
    #[error("{:#06x}: received a number of {received} points with {given} points", self.code())]
    NumberOfPoints {
        /// Number of points in the command.
        received: usize,
        /// Number of points given.
        given: usize,
    },
    /// 0x42A0: the master or the slave has an error.
    #[error("{:#06x}: the master or the slave has error {code:#06x}", self.code())]
    AxisError {
        /// The axis's own error, 0 if the master's values are just not finite.
        code: u32,
    },
    /// 0x42DC: the set values are no longer finite: positions or scalings are too extreme.
    #[error("{:#06x}: the set values are no numbers, expected less extreme positions and scalings", self.code())]
    NotFinite,
    /// The plate's own error.
    #[error(transparent)]
    Cam(CamError),
}

impl From<CamError> for CouplingError {
    fn from(error: CamError) -> Self {
        Self::Cam(error)
    }
}

impl CouplingError {
    /// Returns the NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::TableExists { .. } => 0x4063,
            Self::TableUnknown { .. } => 0x4216,
            Self::NoReferencePlate => 0x4219,
            Self::Jump { .. } | Self::VelocityJump { .. } => 0x421A,
            Self::ActivationPosition { .. } => 0x422B,
            Self::ModeNeedsAbsoluteMaster { .. } => 0x4250,
            Self::NotCoupled => 0x4256,
            Self::TableInUse { .. } | Self::NotReplaceable { .. } => 0x4259,
            // The NC has a code for scalings and another for offsets.
            Self::Scaling { field, .. } if field.ends_with("scaling") => 0x425B,
            Self::OtherKindOfCoupling => 0x425C,
            Self::TooManyTables { .. } => 0x425E,
            Self::AutoOffsetWithRelativeMaster => 0x425F,
            Self::TableNotCoupled { .. }
            | Self::Ambiguous { .. }
            | Self::TableCoupledAlready { .. } => 0x4261,
            Self::ActivationPassed { .. } => 0x426D,
            Self::SlaveMoving { .. } => 0x426F,
            Self::NoNextCycle { .. }
            | Self::ModeNotAllowed {
                operation: Operation::OnlineChange,
                ..
            } => 0x4283,
            Self::Pending { .. } => 0x4287,
            Self::AxisError { .. } => 0x42A0,
            Self::NotFinite => 0x42DC,
            Self::BeyondLimits { .. } => 0x42DD,
            Self::StoreFull { .. } | Self::TooManyRows { .. } => 0x4A11,
            Self::Scaling { .. } => 0x4A17,
            Self::Parameter { .. } => 0x4A1C,
            // All but an online change, which has a code of its own above.
            Self::ModeNotAllowed { .. } => 0x4B04,
            Self::NoTable => 0x4B30,
            Self::TooManyChanged { .. } => 0x4B31,
            Self::TableId { .. } => 0x4B32,
            Self::NumberOfPoints { .. } => 0x4B34,
            Self::Cam(error) => error.code(),
        }
    }
}

/// Returns the permitted values of a scaling or an offset.
fn scaling_expected(field: &str) -> &'static str {
    if field == "master scaling" {
        "a finite number other than 0"
    } else {
        "a finite number"
    }
}
