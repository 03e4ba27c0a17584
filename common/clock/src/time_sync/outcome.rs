//! Outcome of a cycle: correction times, state, errors and warnings of the manual.

use crate::instant::Seconds;

/// Output of one cycle of [`TimeSync`](super::TimeSync).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSyncOutput {
    /// Start-up, synchronised or failed.
    pub state: TimeSyncState,
    /// Operation goes on, but not at its best.
    #[doc(alias = "iWarningId")]
    pub warning: Option<SyncWarning>,
    /// Time to extrapolate the received data by, s. None after a fault, until new data come.
    #[doc(alias = "fCorrectionTime")]
    pub correction_time: Option<Seconds>,
    /// Correction time of time mode, whether synchronised or not.
    pub time_mode_correction: Option<Seconds>,
    /// Beats since the block was started.
    pub beats: u32,
    /// The manual's diagnostic values.
    pub diagnostic: TimeSyncDiagnostic,
}

/// `bStartUp`, `bSynced`, `bError` and `iErrorId` in one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeSyncState {
    /// The drift is not known yet: the correction time only hides repeated and skipped data.
    #[doc(alias = "bStartUp")]
    StartUp,
    /// The drift is known and corrected.
    #[doc(alias = "bSynced")]
    Synced,
    /// A fault; it stays until the block is restarted (or restarts itself).
    #[doc(alias = "bError")]
    Failed(SyncError),
}

/// `ST_TimeSyncDiagnostic`, TS5066 chapter 3.11.
#[doc(alias = "ST_TimeSyncDiagnostic")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeSyncDiagnostic {
    /// The index read now minus the index read in the previous cycle: 1 in step, 0 read twice,
    /// 2 one missed.
    #[doc(alias = "iCycleIndexDiff")]
    pub cycle_index_diff: i32,
    /// Cycles without new data since the block was started.
    #[doc(alias = "iTotalEqualDataCounter")]
    pub total_equal_data: u64,
    /// Cycles without new data in a row.
    #[doc(alias = "iConsecutiveEqualDataCounter")]
    pub consecutive_equal_data: u32,
    /// Drift of the sender's clock against the own one, ppm; negative when the sender's cycle is
    /// the longer one, 0 until known.
    #[doc(alias = "fDrift")]
    pub drift_ppm: f64,
}

/// `E_Sync_ErrorCodes`, TS5066 chapter 3.16.
#[doc(alias = "E_Sync_ErrorCodes")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[error("{:#06x}: {}", self.code(), self.reason())]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SyncError {
    /// The corrected and the received index lie too far apart.
    #[doc(alias = "E_Sync_TimeSync_Error_MaxCycleIndexDiffExceeded")]
    MaxCycleIndexDiffExceeded,
    /// No new data for too long.
    #[doc(alias = "E_Sync_TimeSync_Error_MaxDataAgeExceeded")]
    MaxDataAgeExceeded,
    /// Sync was lost, and neither of the above says why.
    #[doc(alias = "E_Sync_TimeSync_Error_UnknownSyncLoss")]
    UnknownSyncLoss,
    /// A parameter has a value it must not have.
    #[doc(alias = "E_Sync_Error_WrongParameter")]
    WrongParameter,
    /// The corrected set position lies too far from the received one.
    #[doc(alias = "E_Sync_Extrapolate_Error_MaxPosDiffExceeded")]
    MaxPositionDiffExceeded,
}

impl SyncError {
    /// The manual's error code.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::MaxCycleIndexDiffExceeded => 0x4b51,
            Self::MaxDataAgeExceeded => 0x4b52,
            Self::UnknownSyncLoss => 0x4b53,
            Self::WrongParameter => 0x4b56,
            Self::MaxPositionDiffExceeded => 0x4b59,
        }
    }

    /// Description of the error.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::MaxCycleIndexDiffExceeded => "corrected and received cycle index differ too much",
            Self::MaxDataAgeExceeded => "no new data for too long",
            Self::UnknownSyncLoss => "synchronisation lost for an unknown reason",
            Self::WrongParameter => "a parameter is wrong",
            Self::MaxPositionDiffExceeded => "corrected and received position differ too much",
        }
    }
}

/// `E_Sync_WarningCodes`, TS5066 chapter 3.17.
#[doc(alias = "E_Sync_WarningCodes")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SyncWarning {
    /// The last beat gave a drift that differs from the one before by more than half.
    #[doc(alias = "E_Sync_Warning_DriftChangedSignificantly")]
    DriftChangedSignificantly,
}

impl SyncWarning {
    /// The manual's warning code.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::DriftChangedSignificantly => 1,
        }
    }

    /// Description of the warning.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::DriftChangedSignificantly => "the drift changed by more than half",
        }
    }
}
