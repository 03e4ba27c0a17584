//! Some of the parameters, to be changed while the others stay.

use coaxle_clock::Seconds;
use coaxle_clock::time_sync::TimeSyncParameters;

use super::extrapolate::{ExtrapolateParameters, FallBackMode};
use super::parameters::{AxisSyncParameters, StartUpMode};

macro_rules! changes {
    ($(#[$meta:meta])* $name:ident of $whole:ident { $($($key:literal)? $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[cfg_attr(
            feature = "serde",
            serde(default, rename_all = "kebab-case", deny_unknown_fields)
        )]
        pub struct $name {
            $(
                #[doc = concat!("See [`", stringify!($whole), "::", stringify!($field), "`].")]
                #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
                $(#[cfg_attr(feature = "serde", serde(rename = $key))])?
                pub $field: Option<$type>,
            )*
        }

        impl $name {
            /// Completes these parameters with those of `whole`.
            #[must_use]
            pub fn over(&self, whole: $whole) -> $whole {
                // Every field is named, so that a parameter added to the block but not here does not compile.
                $whole { $($field: self.$field.map_or(whole.$field, Into::into),)* }
            }
        }
    };
}

changes! {
    /// Some of [`TimeSyncParameters`].
    TimeSyncChanges of TimeSyncParameters {
        "data-cycle-time-s" data_cycle_time: Seconds,
        threshold_for_sync: f64,
        max_cycle_index_difference: f64,
        age_of_data_limit: u16,
        no_of_periods_for_mean_drift: u16,
        "delay-time-offset-s" delay_time_offset: Seconds,
        slope1_numerator: f64,
        slope1_denominator: f64,
        end_of_transition_limit: u16,
        new_drift_bending_cycles: u16,
        time_mode_blending_cycles: u16,
        force_time_mode: bool,
        automatic_re_init: bool,
        sys_cmd: u32,
    }
}

changes! {
    /// Some of [`ExtrapolateParameters`].
    ExtrapolateChanges of ExtrapolateParameters {
        max_position_diff: f64,
        use_acc_for_extrapolation: bool,
        t1_factor_pos: f64,
        t1_factor_velo: f64,
        "blending-time-s" blending_time: Seconds,
        sys_cmd: u32,
    }
}

/// Some of [`AxisSyncParameters`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct AxisSyncChanges {
    /// See [`AxisSyncParameters::start_up_mode`].
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub start_up_mode: Option<StartUpMode>,
    /// See [`AxisSyncParameters::fall_back_mode`].
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub fall_back_mode: Option<FallBackMode>,
    /// Changes of the extrapolation.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub extrapolate: ExtrapolateChanges,
    /// Changes of the time sync.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub time_sync: TimeSyncChanges,
}

impl AxisSyncChanges {
    /// Completes these parameters with those of `whole`.
    #[must_use]
    pub fn over(&self, whole: AxisSyncParameters) -> AxisSyncParameters {
        AxisSyncParameters {
            start_up_mode: self.start_up_mode.unwrap_or(whole.start_up_mode),
            fall_back_mode: self.fall_back_mode.unwrap_or(whole.fall_back_mode),
            extrapolate: self.extrapolate.over(whole.extrapolate),
            time_sync: self.time_sync.over(whole.time_sync),
        }
    }

    /// True if there is nothing to change.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(feature = "serde")]
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
