//! The plates as a whole, on random ones.

mod advice;
mod change;
mod characteristics;
mod evaluation;
mod inverse;
mod joints;
mod peaks;
mod plates;
mod refusals;
mod splines;
mod steps;
mod tables;
