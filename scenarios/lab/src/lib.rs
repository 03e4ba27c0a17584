//! Experiments with distributed axes, in virtual time.
//!
//! A [`Scenario`](scenario::Scenario) is a TOML file: senders, receivers, a network, events, and expectations. It is
//! played on a [`Stage`](stage::Stage): in the simulation ([`virtual_time`]), or as processes, which `coaxle-trials` has.
//! Either feeds the same [`Evaluation`](evaluate::Evaluation), which compares every receiver cycle with the master's true motion.
//!
//! From the top down:
//!
//! * many runs: [`soak`] draws random schedules of faults and commands and shrinks failing ones, [`sweep`] runs a scenario over a grid;
//! * one run: [`run`] plays a scenario and leaves its trace and its summary in a folder; [`catalog`] has the scenarios that are shipped;
//! * results: [`summary`], [`expect`] and [`verdict`]; [`invariants`] hold in every cycle of every run; [`curves`] are
//!   drawn by reports;
//! * while it runs: [`virtual_time`], [`evaluate`], [`row`], [`timeline`], [`topology`];
//! * files: [`scenario`], [`event`], [`group`], [`router`], [`overrides`].
//!
//! Nothing here needs Zenoh, a terminal or a browser. Same seed, same bytes.
//!
//! ```
//! let source = coaxle_lab::catalog::find("beat")?;
//! let scenario = source.read(&["duration-s=5".to_owned(), "expect=[]".to_owned()])?;
//! let finished = coaxle_lab::virtual_time::run(&scenario, &mut (), &mut ())?;
//! let bypass = &finished.figures()["bypass"];
//! assert_eq!(bypass.mode, "bypass");
//! # Ok::<(), anyhow::Error>(())
//! ```

pub mod catalog;
pub mod curves;
pub mod evaluate;
pub mod event;
pub mod expect;
pub mod figures;
pub mod finished;
mod followed;
pub mod group;
pub mod invariants;
pub mod junit;
mod layout;
pub mod number;
pub mod overrides;
pub mod read;
pub mod record;
pub mod results_folder;
pub mod router;
pub mod row;
pub mod run;
pub mod scenario;
pub mod shell;
pub mod soak;
pub mod stage;
pub mod summary;
pub mod sweep;
pub mod timeline;
pub mod topology;
mod trace;
mod trace_recording;
pub mod units;
pub mod verdict;
pub mod virtual_time;
