//! The simulation: a world in which true time is known.
//!
//! True time flows in an event queue; every node lives on a drifting clock of its own and calls the
//! very code that real machines run. Same seed, same bytes. Nodes cannot name [`True`] time; only
//! the [`World`] and its [`Oracle`] see it.
//!
//! A [`World`] takes nodes ([`NodeSetup`]), routers between them if there are any ([`RouterSetup`]), and links
//! ([`LinkSetup`]), and lets true time flow; an
//! [`Observer`] sees every cycle. After each one the [invariants](Violation) of the contract are
//! checked: a node that breaks one ends the run.

mod approach;
mod common_time;
mod error_stop;
mod events;
mod far_motion;
mod far_time;
mod hop;
mod invariants;
mod largest_lately;
mod link;
mod network;
mod observer;
mod oracle;
mod reported;
mod set_values;
mod setup;
mod traffic;
mod true_time;
mod world;

pub use approach::{ApproachCheck, Divergence};
pub use error_stop::{DistanceExceeded, ErrorStopCheck};
pub use far_motion::{
    FarAxisMode, FarMotion, FarMotionBounds, FarMotionCheck, FarMotionFault, Received,
};
pub use far_time::{FarTimeCheck, FarTimeFault, LARGEST_RATE_ERROR};
pub use hop::Load;
pub use invariants::{Breach, Violation};
pub use largest_lately::LargestLately;
pub use network::RouterTraffic;
pub use observer::{CycleSeen, Observer};
pub use oracle::{Oracle, Truth, TruthSample};
pub use reported::{ReportedCheck, ReportedMismatch, ReportedValue};
pub use set_values::{Excess, SetValueBound, SetValueCheck, Shares};
pub use setup::{Factory, LinkSetup, NodeSetup, RouterSetup};
pub use traffic::Traffic;
pub use true_time::True;
pub use world::World;
