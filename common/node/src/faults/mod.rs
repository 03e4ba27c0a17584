//! Injected faults, in both worlds: deviated clocks and lossy links.
//!
//! They belong to the contract of a node because the real world applies them to a real quartz and a
//! real subscription, while the simulation has only these. Same seed, same faults.

mod clock;
mod common_time;
mod link;
mod random;
#[cfg(test)]
mod statistics;
mod tampering;
mod terms;

pub use clock::{CycleJitter, DeviatedClock};
pub use common_time::FaultyCommonTime;
pub use link::{Deliveries, LinkModel};
pub use random::{Random, link_seed, seed_of};
pub use tampering::Tampering;
pub use terms::{check_clock, check_link};
