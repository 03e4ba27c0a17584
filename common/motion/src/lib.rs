//! What moves.
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
//! | `MC_FlyingGear` | `MC_FlyingGear_BkPlcMc` | [`gear::FlyingGear`], [`slave::EnableFlyingGear`] |
//! | `MC_Power`, `MC_Reset`, `MC_Home`, `MC_MoveAbsolute` … `MC_Stop`, `MC_GearIn`, `MC_GearOut` | PLCopen part 1, TS5055 | [`slave`] has the table |
//! | the PLCopen state diagram, `MC_ReadStatus` | PLCopen part 1 | [`axis::AxisStatus`] |
//! | `MC_MotionFunctionType` | TF5050 8.9 | [`law::MotionLaw`] |
//! | the cam plates of TF5050, their reading and changing | TF5050 | [`cam`] has the table |
//! | `MC_CamTableSelect`, `MC_CamIn`, `MC_CamOut`, `MC_CamScaling`, `MC_CamIn_V2`, `MC_CamAdd`, `MC_CamExchange`, `MC_CamRemove`, `MC_CamScaling_V2`, `MC_SetCamOnlineChangeMode`, `MC_CamInfo`, `MC_CamInfo_V2` | TF5050 | [`cam::coupling`] has the table |
//! | `Execute`, `Busy`, `Active`, `InSync`, `Done`, `CommandAborted`, `Error`, `ErrorID` | PLCopen part 1 | [`plc`] |
//! | `MC_GearInPos`, `MC_GearInVelo`, `MC_ReadFlyingSawCharacteristics`, the flying saw | TS5055, TF5055 | [`saw`] has the table |
//!
//! `FB_TimeSync` and what belongs to it is in `coaxle-clock`.
//!
//! The crate is `no_std` and asks no machine for the time.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod axis;
pub mod cam;
pub mod drive;
pub mod gear;
pub mod law;
pub mod plc;
pub mod profile;
pub mod remote;
pub mod saw;
pub mod slave;
