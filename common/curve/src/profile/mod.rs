//! Motion profiles: from one state to another within limits of velocity, acceleration and jerk.
//!
//! A profile is planned once, in closed form up to one bisection, and then evaluated at any time since
//! its start:
//!
//! ```
//! use coaxle_clock::Seconds;
//! use coaxle_curve::profile::{Kinematics, Limits, to_position};
//!
//! let limits = Limits::new(100.0, 500.0, 500.0, 5_000.0)?;
//! let profile = to_position(&Kinematics::at_rest(0.0), 50.0, &limits);
//! let half_way = profile.at(Seconds(profile.duration().0 / 2.0));
//! assert!((half_way.position - 25.0).abs() < 1e-9);
//! assert_eq!(profile.at(profile.duration()).position, 50.0);
//! # Ok::<(), coaxle_curve::profile::InvalidLimit>(())
//! ```
//!
//! Positions are in user units (u, say mm or degrees), time in seconds.

mod band;
mod bracket;
mod extremes;
mod limits;
mod line;
mod phases;
mod plan;
mod velocity_change;

#[cfg(test)]
mod line_tests;
#[cfg(test)]
mod properties;

pub use band::Band;
pub use bracket::{Bracket, bracket};
pub use extremes::ProfileExtremes;
pub use limits::{InvalidLimit, Limits};
pub use line::{to_line, towards};
pub use phases::{Kinematics, Profile};
pub use plan::{to_position, to_velocity};
