//! The time that no node of the simulation can read.

use coaxle_clock::Domain;

/// True time, which only the world knows.
pub enum True {}

impl Domain for True {
    const NAME: &'static str = "true";
}
