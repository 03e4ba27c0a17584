//! Tests that cross crates, in virtual time: see `tests`.
