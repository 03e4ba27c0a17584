//! Tests of the sender as a program.

mod command;
