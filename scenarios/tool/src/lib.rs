//! Experiments with distributed axes.
//!
//! A [`Scenario`](scenario::Scenario) is a TOML file: senders, receivers, a network, events, and
//! what is expected of it all. It runs in the simulation ([`virtual_time`]) or as real processes over
//! real Zenoh ([`processes`]); both feed the same [`Evaluation`](evaluate::Evaluation), which
//! compares every receiver cycle with what the master really did and leaves a summary, a trace and
//! a report.

mod bar;
mod bench;
pub mod cam;
pub mod catalog;
pub mod cli;
pub mod command;
mod conform;
pub mod curves;
pub mod doctor;
mod edit;
pub mod evaluate;
pub mod event;
mod examples;
pub mod expect;
mod figures;
pub mod finished;
mod followed;
mod gateway;
pub mod gear;
pub mod group;
mod inspect;
pub mod invariants;
mod junit;
mod layout;
mod network;
pub mod node_config;
mod number;
pub mod overrides;
mod page;
mod plotting;
pub mod processes;
mod read;
pub mod record;
mod recorded;
mod recording;
pub mod report;
mod results_folder;
mod ros2;
pub mod router;
pub mod row;
pub mod run;
pub mod saw;
mod scale;
pub mod scenario;
pub mod schema;
mod scope;
pub mod secure;
mod signals;
pub mod soak;
pub mod status;
pub mod summary;
pub mod sweep;
mod sync_flags;
pub mod table;
mod timeline;
mod topology;
mod trace;
mod trace_recording;
mod units;
pub mod verdict;
pub mod virtual_time;
mod web;
