//! `coaxle scale`: what nodes cost as they become more, and their axes.
//!
//! Each size is measured in a process of its own, so that its memory is its own. The nodes are those that machines run, with the
//! bytes that travel between them; time is virtual, and what is measured is the processor.

mod cli;
mod cost;
mod lockstep;
mod plot;
mod size;

pub use cli::{ScaleArgs, scale};
