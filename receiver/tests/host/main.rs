//! Tests of the receiver as a program: its command line, its processes, its files.

mod circles;
mod command;
mod drive_process;
mod recording;
