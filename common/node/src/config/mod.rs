//! Config files: TOML, kebab-case, units in the names, unknown fields refused.
//!
//! A config is parsed once into types that cannot hold a wrong value; every error names the file,
//! the line, the field, the value received and the one expected.

mod checked;
mod clock;
mod common_time;
mod document;
mod error;
mod forgery;
mod kind;
mod link;
mod list;
mod load;
mod place;
mod presentation;
mod real_time;
mod reworded;
pub mod schema;
mod term;
mod timing;
mod transport;
mod unit;
mod wrong;

pub use crate::guess::did_you_mean;
pub use checked::{
    AgeLimitMs, AtLeastZero, AxisLimit, BeaconsPerSecond, ChangeMicros, CommonBoundMicros,
    Coordinate, CycleMicros, DeadTimeMicros, DelayMicros, DurationSeconds, FaultMicros,
    FaultSeconds, Finite, FirstCount, Fraction, Increment, LeadMs, PeriodSeconds, Positive, Ppm,
    PresentAfterMs, WalkPpm,
};
pub use clock::{ClockConfig, DriftStep, JitterConfig, SineConfig};
pub use common_time::{
    CommonTimeChange, CommonTimeConfig, CommonTimeFaults, GrandmasterId, StatedBy,
};
pub(crate) use document::{document_of, document_of_table};
pub use error::{ConfigError, Mistake};
pub use forgery::{Forged, Forgery, Times};
pub(crate) use kind::check_kind;
pub use link::{BurstLossConfig, CorrelatedConfig, DelayStep, LinkConfig, Partition, SpikeConfig};
pub use list::at_most;
pub(crate) use load::error_in_part;
pub use load::{from_table, from_value, load, parse, parse_table};
pub use place::{Position, elements_of};
pub use presentation::{PresentAfterChoice, PresentAfterLimits, PresentAfterRange};
pub use real_time::RealTimeConfig;
pub use term::{Between, Term, Wave};
pub use timing::{CommonTimeSetup, TimingEndpoints, TimingLinkConfig, TimingServerConfig};
pub use transport::{TransportConfig, TransportMode};
pub use unit::Unit;
pub use wrong::Wrong;
