//! Gears: a slave that follows its master in proportion.
//!
//! The [`LinearGear`] couples permanently, the [`FlyingGear`] is engaged and released while the master
//! moves. Both give the slave's position; its limits are the axis's business.
//!
//! ```
//! use coaxle_curve::profile::Kinematics;
//! use coaxle_gear::{FlyingGear, FlyingGearParameters, FlyingGearPhase};
//!
//! let parameters = FlyingGearParameters {
//!     ratio: 1.0,
//!     master_sync_position: 460.0,
//!     slave_sync_position: 450.0,
//!     slave_desync_position: 450.0,
//!     slave_stop_position: 500.0,
//!     default_slave_negative: false,
//! };
//! let master = |position| Kinematics { position, velocity: 500.0, acceleration: 0.0 };
//! let mut gear = FlyingGear::enable(&parameters, &master(0.0), 400.0)?;
//! assert_eq!(gear.update(&master(100.0)).position, 400.0, "it stands");
//! assert_eq!(gear.phase(), FlyingGearPhase::Waiting);
//! assert_eq!(gear.update(&master(460.0)).velocity, 500.0, "as fast as its master");
//! # Ok::<(), coaxle_gear::FlyingGearError>(())
//! ```
//!
//! | PLC name | manual | here |
//! |--|--|--|
//! | `MC_GearIn` | TS5055 | [`GearIn`], [`Gear`]; once engaged it is a [`LinearGear`] |
//! | `MC_GearInMultiMaster`; `MC_GearInDyn`, `MC_CombineAxes` as cases of it | Tc2_MC2, PLCopen part 1 | [`GearInMultiMaster`], [`MultiMasterGear`] |
//! | `POSSYNC1`, `POSSYNC2` of its options | Tc2_MC2 | [`MultiMasterSync`] |
//! | `MC_FlyingGear`, `MC_FlyingGear_BkPlcMc` | `MC_FlyingGear_BkPlcMc` | [`FlyingGearParameters`], [`FlyingGearCoupling`], [`FlyingGear`] |
//!
//! The crate is `no_std`, allocates nothing and reads no clock.
#![no_std]

#[cfg(feature = "serde")]
extern crate alloc;
#[cfg(test)]
extern crate std;

mod flying;
mod gear_in;
mod linear;
mod multi_master;
mod ramp_limits;

pub use flying::{
    FlyingGear, FlyingGearChange, FlyingGearCoupling, FlyingGearError, FlyingGearParameters,
    FlyingGearPhase, FlyingGearRange,
};
pub use gear_in::{Gear, GearChange, GearIn};
pub use linear::{LinearGear, RatioZero};
pub use multi_master::{
    GearInMultiMaster, MultiMasterChange, MultiMasterGear, MultiMasterSync, Ratios, WrongRatios,
};

/// True for default values, which orders omit.
#[cfg(feature = "serde")]
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
