//! The guard against brute force, and against streams of every kind. Positions are judged by their
//! differences, never by stated values.

mod behaviour;
mod closed_forms;
mod decades;
mod identity;
mod interruptions;
mod limits;
mod long_gap;
mod motion;
mod random;
mod rejoin;
mod root;
mod streams;
mod trouble;
mod watch;
