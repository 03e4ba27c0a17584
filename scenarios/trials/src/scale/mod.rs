//! `coaxle scale`: cost of growing numbers of nodes and axes.
//!
//! Each size is measured in a process of its own, so that its memory is its own. The nodes and the bytes between them are
//! those of real machines; time is virtual, and the processor is measured.

mod cli;
mod cost;
mod lockstep;
mod plot;
mod size;

pub use cli::{ScaleArgs, scale};
