//! Gears: a slave that follows a master in proportion.

mod flying;
mod linear;

pub use flying::{FlyingGear, FlyingGearError, FlyingGearParameters, FlyingGearPhase};
pub use linear::{LinearGear, RatioZero};
