//! Gears: a slave that follows a master in proportion.

mod linear;

pub use linear::{LinearGear, RatioZero};
