//! Tests of what starts and watches the processes of tests.

mod deaths;
mod runner;
