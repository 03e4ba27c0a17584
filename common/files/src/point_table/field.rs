//! The fields of a point by their names, in cam files and in the PLC.

use coaxle_curve::law::MotionLaw;
use coaxle_node::config::Wrong;
use coaxle_plate::{PointType, WrittenPoint};

/// A field of `MC_MotionFunctionPoint`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Index,
    Law,
    Type,
    RelativeNext,
    Master,
    Slave,
    Velocity,
    Acceleration,
    Jerk,
}

impl Field {
    /// Every field, in the order of the structure.
    pub(super) const ALL: [Self; 9] = [
        Self::Index,
        Self::Law,
        Self::Type,
        Self::RelativeNext,
        Self::Master,
        Self::Slave,
        Self::Velocity,
        Self::Acceleration,
        Self::Jerk,
    ];

    /// Field name in cam files and in CSV.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Index => "index",
            Self::Law => "law",
            Self::Type => "type",
            Self::RelativeNext => "relative-next",
            Self::Master => "master",
            Self::Slave => "slave",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        }
    }

    /// Field name in the PLC.
    pub(super) const fn plc_name(self) -> &'static str {
        match self {
            Self::Index => "PointIndex",
            Self::Law => "FunctionType",
            Self::Type => "PointType",
            Self::RelativeNext => "RelIndexNextPoint",
            Self::Master => "MasterPos",
            Self::Slave => "SlavePos",
            Self::Velocity => "SlaveVelo",
            Self::Acceleration => "SlaveAcc",
            Self::Jerk => "SlaveJerk",
        }
    }

    /// The field of a name of either kind, regardless of case.
    pub(super) fn called(name: &str) -> Option<Self> {
        let is_it = |field: &Self| {
            // Names of the PLC are not case-sensitive, and people mix both kinds.
            field.name().eq_ignore_ascii_case(name) || field.plc_name().eq_ignore_ascii_case(name)
        };
        Self::ALL.into_iter().find(is_it)
    }

    /// Puts a value into a point.
    ///
    /// # Errors
    /// [`Wrong`]: a value of another kind.
    pub(super) fn set(self, point: &mut WrittenPoint, value: Value<'_>) -> Result<(), Wrong> {
        match self {
            Self::Law => point.law = Some(law(value)?),
            Self::Type => point.point_type = Some(point_type(value)?),
            Self::Index => point.index = Some(integer(value)?),
            Self::RelativeNext => point.relative_next = integer(value)?,
            Self::Master => point.master = value.number()?,
            Self::Slave => point.slave = value.number()?,
            Self::Velocity => point.velocity = value.number()?,
            Self::Acceleration => point.acceleration = value.number()?,
            Self::Jerk => point.jerk = value.number()?,
        }
        Ok(())
    }
}

/// A value of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    Number(f64),
    Word(&'a str),
}

impl Value<'_> {
    pub(super) fn number(self) -> Result<f64, Wrong> {
        match self {
            Self::Number(number) => Ok(number),
            Self::Word(word) => Err(Wrong::value(format_args!("{word:?}"), "a number")),
        }
    }
}

/// A point with defaults, and without positions.
pub(super) const fn default_point() -> WrittenPoint {
    WrittenPoint {
        index: None,
        law: None,
        point_type: None,
        relative_next: 1,
        // Not a number until it is set: a missing position is found, whatever the others are.
        master: f64::NAN,
        slave: f64::NAN,
        velocity: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
    }
}

fn law(value: Value<'_>) -> Result<MotionLaw, Wrong> {
    let found = match value {
        Value::Word(word) => MotionLaw::ALL
            .iter()
            .copied()
            .find(|law| is_law(*law, word)),
        Value::Number(code) => code_of(code).and_then(MotionLaw::from_code),
    };
    found.ok_or_else(|| {
        let expected =
            "a law by its name, such as polynom5 or MOTIONFUNCTYPE_POLYNOM5, or by its code";
        Wrong::value(received_text(value), expected)
    })
}

fn is_law(law: MotionLaw, word: &str) -> bool {
    // Programmers may correct the manual's spelling.
    let well_spelled = law.name().replace("SPLNE", "SPLINE");
    [law.file_name(), law.name(), &well_spelled]
        .iter()
        .any(|name| name.eq_ignore_ascii_case(word))
}

fn point_type(value: Value<'_>) -> Result<PointType, Wrong> {
    let found = match value {
        Value::Word(word) => PointType::ALL.into_iter().find(|kind| {
            // Both by name: `rest`, and MOTIONPOINTTYPE_REST.
            kind.file_name().eq_ignore_ascii_case(word)
                || type_name(*kind).eq_ignore_ascii_case(word)
        }),
        Value::Number(code) => code_of(code).and_then(PointType::from_code),
    };
    found.ok_or_else(|| {
        let expected = "a type by its name, such as rest or MOTIONPOINTTYPE_REST, or by its code";
        Wrong::value(received_text(value), expected)
    })
}

/// The PLC name of a type of point.
pub(super) fn type_name(kind: PointType) -> String {
    format!("MOTIONPOINTTYPE_{}", kind.file_name().to_uppercase())
}

fn received_text(value: Value<'_>) -> String {
    match value {
        Value::Number(number) => number.to_string(),
        Value::Word(word) => format!("{word:?}"),
    }
}

fn code_of(number: f64) -> Option<u16> {
    // Codes are words of 16 bits: 5.5 or -1 must not become a code by the cast.
    let is_code = number.fract() == 0.0 && (0.0..=65535.0).contains(&number);
    is_code.then_some(number as u16)
}

fn integer<T: TryFrom<i64>>(value: Value<'_>) -> Result<T, Wrong> {
    let number = value.number()?;
    // Below 10¹⁵ a float holds every whole number exactly.
    let is_whole = number.fract() == 0.0 && number.abs() < 1e15;
    let whole = is_whole.then_some(number as i64);
    let fits = whole.and_then(|whole| T::try_from(whole).ok());
    fits.ok_or_else(|| Wrong::value(number, "a whole number"))
}
