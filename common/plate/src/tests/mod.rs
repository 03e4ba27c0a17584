//! The plates as a whole, on random ones.

mod change;
mod characteristics;
mod evaluation;
mod inverse;
mod plates;
mod refusals;
mod splines;
mod steps;
mod tables;
