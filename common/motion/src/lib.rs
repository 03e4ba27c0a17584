//! What moves: the crates that it is made of, under one name.
//!
//! Each of them has a front page of its own; here is the table of all of them.
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `NCTOPLC_AXLESTRUCT`, `NCTOPLC_AXIS_REF` | TS5066 | [`axis::NcToPlcAxis`], [`axis::ImageLayout`] |
//! | `nStateDWord`, `nAxisState`, `nCoupleState` | TS5066 | [`axis::StateWord`], [`axis::AxisState`], [`axis::CoupleState`] |
//! | `FB_AxisSync` | TS5066 3.1 | [`remote::AxisSync`] |
//! | `FB_AxisExtrapolateValues` | TS5066 3.3 | [`remote::AxisExtrapolate`] |
//! | `ST_AxisSyncParameters` | TS5066 3.4 | [`remote::AxisSyncParameters`] |
//! | `ST_AxisSyncDiagnostic` | TS5066 3.5 | [`remote::AxisSyncDiagnostic`] |
//! | `E_Sync_FallBackMode` | TS5066 3.6 | [`remote::FallBackMode`] |
//! | `E_Sync_FilterMode` | TS5066 3.7 | [`remote::FilterMode`] |
//! | `E_Sync_FilterState` | TS5066 3.8 | [`remote::FilterState`] |
//! | `E_Sync_StartUpMode` | TS5066 3.9 | [`remote::StartUpMode`] |
//! | `ST_AxisExtrapolateDiagnostic` | TS5066 3.12 | [`remote::ExtrapolateDiagnostic`] |
//! | `ST_AxisExtrapolateParameters` | TS5066 3.13 | [`remote::ExtrapolateParameters`] |
//! | `E_Sync_ExtrapolateMode`, `E_Sync_ExtrapolateState` | TS5066 3.14, 3.15 | [`remote::ExtrapolateMode`] |
//! | `Execute`, `Busy`, `Active`, `InSync`, `Done`, `CommandAborted`, `Error`, `ErrorID` | PLCopen part 1 | [`plc`] |
//! | the PLCopen state diagram, `MC_ReadStatus`, `MC_ReadAxisError` | PLCopen part 1 | [`axis::AxisStatus`], [`slave::SlaveAxis`] |
//!
//! Commands to an axis are data ([`slave::Command`]); as function blocks, with an `Execute` input,
//! they are a [`slave::CommandBlock`] where nothing else is said.
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `MC_Power` | PLCopen part 1 | [`slave::Command::Power`], [`slave::Power`] |
//! | `MC_Reset` | PLCopen part 1 | [`slave::Command::Reset`] |
//! | `MC_Home`, `MC_SetPosition` | PLCopen part 1 | [`slave::Command::Home`] |
//! | `MC_MoveAbsolute`, `MC_MoveAbsolut_BkPlcMc` | PLCopen part 1, `MC_FlyingGear_BkPlcMc` | [`slave::Command::MoveAbsolute`] |
//! | `MC_MoveRelative` | PLCopen part 1 | [`slave::Command::MoveRelative`] |
//! | `MC_MoveVelocity` | PLCopen part 1, TS5055, TF5050 | [`slave::Command::MoveVelocity`] |
//! | `MC_Halt` | PLCopen part 1, TS5055, TF5055 | [`slave::Command::Halt`] |
//! | `MC_Stop` | PLCopen part 1, TS5055, TF5055 | [`slave::Command::Stop`] |
//! | `MC_GearIn` | TS5055 | [`slave::Command::GearIn`], [`gear::LinearGear`] |
//! | `MC_GearOut`, `ST_GearOutOptions` | TS5055 12.2.1, TF5055 | [`slave::Command::GearOut`]; it has no options |
//! | `MC_FlyingGear`, `MC_FlyingGear_BkPlcMc` | `MC_FlyingGear_BkPlcMc` | [`slave::Command::FlyingGear`], [`slave::EnableFlyingGear`], [`gear::FlyingGear`] |
//! | `MC_BufferMode` | TS5055, TF5055, TF5050 | none: a command acts at once, as in the original |
//! | `MC_MoveSuperImposed` | mentioned in TF5050 | none |
//!
//! | of the flying saw | manual | here |
//! |--|--|--|
//! | `MC_GearInVelo`, `ST_GearInVeloOptions` | TS5055 12.1.1, TF5055 4.1, 5.5 | [`saw::GearInVelo`], [`slave::Command::GearInVelo`], [`slave::FlyingSawBlock`] |
//! | `MC_GearInPos`, `ST_GearInPosOptions` | TS5055 12.1.2, TF5055 4.2, 5.4 | [`saw::GearInPos`], [`slave::Command::GearInPos`], [`slave::FlyingSawBlock`] |
//! | `MC_ReadFlyingSawCharacteristics` | TS5055 12.1.3, TF5055 4.3 | [`slave::Command::ReadFlyingSawCharacteristics`], [`slave::ReadFlyingSawCharacteristicsBlock`], [`saw::SawPlan::characteristics`] |
//! | `MC_FlyingSawCharacValues` | TS5055 12.3.2, TF5055 5.3 | [`saw::FlyingSawCharacteristics`] |
//! | `ST_SyncMode`, `E_GearInSyncMode` | TS5055 12.3.1, TF5055 5.1, 5.2 | [`saw::SyncMode`], [`saw::GearInSyncMode`]; [`saw`] has a table of the flags |
//!
//! | of cam plates | TF5050 | here |
//! |--|--|--|
//! | `MC_CamTableSelect` | 4.1 | [`slave::SlaveAxis::select_cams`], [`cam::coupling::Tables::insert`] |
//! | `MC_CamOut`, `ST_CamOutOptions` | 4.2 | [`slave::Command::CamOut`]; it has no options |
//! | `MC_CamIn`, `ST_CamInOptions` | 4.3, 8.16 | [`slave::Command::CamIn`] |
//! | `MC_CamScaling` | 4.5 | [`slave::Command::CamScaling`] |
//! | `MC_CamIn_V2` | 5.1 | [`slave::Command::CamInV2`] |
//! | `MC_CamAdd` | 5.2 | [`slave::Command::CamAdd`] |
//! | `MC_CamExchange` | 5.3 | [`slave::Command::CamExchange`] |
//! | `MC_CamRemove` | 5.4 | [`slave::Command::CamRemove`] |
//! | `MC_CamScaling_V2` | 5.5 | [`slave::Command::CamScalingV2`] |
//! | `MC_ReadMotionFunction`, `MC_ReadMotionFunctionPoint` | 6.1, 6.2 | [`cam::coupling::Tables::read`], [`cam::coupling::TableBlock`] |
//! | `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint` | 6.3, 6.4 | [`slave::Command::WriteMotionFunction`] |
//! | `MC_SetCamOnlineChangeMode` | 6.5 | [`slave::Command::SetCamOnlineChangeMode`] |
//! | `MC_ReadMotionFunctionValues` | 6.6 | [`cam::Plate::values`] |
//! | `MC_ReadCamTableSlaveDynamics` | 7.1 | [`cam::Plate::slave_dynamics`] |
//! | `MC_CamInfo`, `MC_CamInfo_V2` | 7.2, 7.3 | [`cam::coupling::CamCoupling::info`] |
//! | `MC_ReadCamTableCharacteristics` | 7.4 | [`cam::Plate::characteristics`] |
//! | `MC_ReadCamTableMasterPosition` | 7.5 | [`cam::Plate::master_positions`] |
//! | `MC_CAM_ID` | 8.1 | [`cam::coupling::TableId`] |
//! | `MC_CAM_REF` | 8.2 | [`cam::Plate`] |
//! | `MC_CamActivationMode`, `MC_CAMACTIVATION_…` | 8.3 | [`cam::coupling::ActivationMode`] |
//! | `MC_CamScalingMode`, `MC_CAMSCALING_…` | 8.4 | [`cam::coupling::ScalingMode`] |
//! | `MC_CamInfoData` | 8.5 | [`cam::coupling::CamInfo`] |
//! | `MC_InterpolationType`, `MC_INTERPOLATIONTYPE_…` | 8.6 | [`cam::Interpolation`] |
//! | `MC_MotionFunctionPoint`, `MC_MotionFunctionPoint_ID` | 8.7, 8.8 | [`cam::MotionPoint`] |
//! | `MC_MotionFunctionType` | 8.9 | [`law::MotionLaw`] |
//! | `MC_MotionPointType` | 8.10 | [`cam::PointType`] |
//! | `MC_TableCharacValues` | 8.11 | [`cam::Characteristics`] |
//! | `MC_TableErrorCodes`, `MC_ERROR_…` | 8.12 | [`cam::CamError`], [`cam::coupling::CouplingError`] |
//! | `MC_TableType`, `MC_TABLETYPE_…` | 8.13 | [`cam::TableType`] |
//! | `MC_ValueSelectType`, `MC_VALUETYPE_…` | 8.14 | [`cam::ValueSelect`] |
//! | `MC_StartMode`, `MC_STARTMODE_…` | 8.15 | [`cam::coupling::StartMode`] |
//! | `MC_CamOperationMode` | 8.18 | [`cam::coupling::OperationMode`] |
//!
//! Structures of options and data, and where something is not the original, are in the tables of
//! [`cam`], [`cam::coupling`], [`saw`] and [`slave`].
//!
//! `FB_TimeSync` and what belongs to it is in `coaxle-clock`.
//!
//! The crate is `no_std` and asks no machine for the time.
#![no_std]

pub use coaxle_axis as axis;
pub use coaxle_axis::drive;
pub use coaxle_curve::{law, profile};
pub use coaxle_gear as gear;
pub use coaxle_remote as remote;
pub use coaxle_saw as saw;

/// Cam plates, and couplings by them.
pub mod cam {
    pub use coaxle_plate::*;

    /// Couplings by cam plates.
    pub mod coupling {
        pub use coaxle_cam::*;
        pub use coaxle_plc::{CouplingBlock, TableBlock};
    }
}

/// The PLC face of a command.
pub mod plc {
    pub use coaxle_axis::CommandState;
    pub use coaxle_plc::{Execute, Outputs};
}

/// The slave axis.
pub mod slave {
    pub use coaxle_plc::{
        BlockError, CommandBlock, EnableFlyingGear, FlyingGearOutputs, FlyingSawBlock,
        FlyingSawOutputs, Power, PowerOutputs, ReadFlyingSawCharacteristicsBlock,
    };
    pub use coaxle_slave::*;
}
