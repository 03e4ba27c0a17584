//! Kinds of plates.

/// Course of a plate, passed once or repeated: `Periodic` of `MC_CamTableSelect`.
#[doc(alias = "Periodic")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Course {
    /// The slave holds still outside the master's range.
    #[default]
    Linear,
    /// The plate repeats for ever in both directions. The slave's gain over one cycle (the lift) is added
    /// each turn forwards and subtracted each turn backwards.
    Cyclic,
}

/// `MC_TableType`, TF5050 chapter 8.13.
#[doc(alias = "MC_TableType")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u16)]
pub enum TableType {
    /// A position table with equal steps of the master.
    #[doc(alias = "MC_TABLETYPE_EQUIDISTANT")]
    Equidistant = 10,
    /// A position table with any ascending steps of the master.
    #[doc(alias = "MC_TABLETYPE_NONEQUIDISTANT")]
    NonEquidistant = 11,
    /// A motion function.
    #[doc(alias = "MC_TABLETYPE_MOTIONFUNCTION")]
    MotionFunction = 22,
}

impl TableType {
    /// Returns the PLC's number of the type.
    #[must_use]
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// Returns the type with that number, if there is one.
    #[must_use]
    pub fn from_code(code: u16) -> Option<Self> {
        [
            Self::Equidistant,
            Self::NonEquidistant,
            Self::MotionFunction,
        ]
        .into_iter()
        .find(|kind| kind.code() == code)
    }
}
