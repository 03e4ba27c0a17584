//! Who follows whom over all nodes of a plant, before it runs or while it does.
//!
//! A node knows its own axes and those it follows. What several nodes add up to none of them shows: the sum of the delays
//! from a root to a drive, an axis that nobody publishes, two units of one axis, a circle. [`PlantAnalysis::of`] takes the
//! nodes, as [`PlantNode`]s from their configs or their statuses, and returns
//!
//! * the **routes** from each root of a motion to each slave, with the delay, the lag and the hold-back of each stage, by the
//!   rule that receivers follow (`lag-ms`, docs/PRESENTATION.md);
//! * a **proposal** for `present-after-ms` of each node that generates axes, where the delays are known;
//! * **findings**: contradictions, each with file, field, the value received and the values expected.
//!
//! ```
//! use coaxle_clock::{CycleTime, Span};
//! use coaxle_node::Channel;
//! use coaxle_node::circles::AxisAddress;
//! use coaxle_node::config::PresentAfterRange;
//! use coaxle_node::keys::NodeName;
//! use coaxle_topology::*;
//!
//! let cycle = CycleTime::new(Span::from_millis(1))?;
//! let node = |name: &str, role, axes| PlantNode {
//!     file: format!("{name}.toml"),
//!     name: NodeName::new(name).expect("a name"),
//!     role,
//!     cycle_time: Some(cycle),
//!     axes,
//!     is_complete: true,
//!     hold_back: None,
//! };
//! let axis = |name: &str, published, origin| PlantAxis {
//!     name: name.to_owned(),
//!     field: "axis[0]".to_owned(),
//!     published,
//!     unit: None,
//!     modulo: None,
//!     limits: None,
//!     origin,
//! };
//! let conveyor = AxisOrigin::Root { motion: RootMotion::Program, present_after: Some(PresentAfterRange::only(Span::from_millis(20))), followers: vec![] };
//! let far = AxisOrigin::Far(FarReference {
//!     field: "far[0]".to_owned(),
//!     sources: vec![AxisAddress::read("line/axes/1").expect("an address")],
//!     way: WaySource::Constant { delay: Span::from_millis(5), origin: WayOrigin::Configured },
//!     showing: Showing::Later(LagRule::Full),
//!     measured: None,
//! });
//! let line = node("line", PlantRole::Sender, vec![axis("conveyor", Some((Channel::Axes, 1)), conveyor)]);
//! let saw = node("saw", PlantRole::Receiver, vec![
//!     axis("line.1", None, far),
//!     axis("carriage", Some((Channel::Slaves, 1)), AxisOrigin::Slave { masters: vec![0] }),
//! ]);
//! let plant = PlantAnalysis::of(&[line, saw]);
//! assert!(plant.findings.is_empty());
//! assert_eq!(plant.routes[0].way, ["line/conveyor", "saw/line.1", "saw/carriage"]);
//! assert_eq!(plant.routes[0].shown, ShownAs::Interpolated);
//! // 5 ms, two cycles of the sender and one of the receiver, a quarter and a cycle.
//! assert_eq!(plant.proposals[0].present_after_ms, Some(11.0));
//! # Ok::<(), coaxle_clock::cycle::CycleTimeOutOfRange>(())
//! ```

mod about;
mod about_watch;
mod analysis;
mod dot;
mod finding;
mod graph;
mod plant;
mod presentation;
mod proposal;
mod routes;
mod way;

pub use about::{InvalidAbout, about_from_json, about_to_json};
pub use about_watch::{AboutContradiction, AboutWatch};
pub use analysis::{
    AxisSummary, LinkSummary, NodeSummary, PlantAnalysis, Proposal, RouteSummary, StageSummary,
};
pub use dot::{dot, label, short};
pub use finding::PlantFinding;
pub use plant::{
    AxisOrigin, FarReference, LagRule, MeasuredStage, MeasuredWay, PlantAxis, PlantNode, PlantRole,
    RootMotion, Showing, StatedLimits,
};
pub use presentation::ShownAs;
pub use way::{WayOrigin, WaySource};
