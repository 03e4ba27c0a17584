//! Tests of the command line `coaxle`, as a user starts it.

mod bench;
mod cam;
mod cams_live;
mod command;
mod documented;
mod inspect;
mod mistakes;
mod saw;
mod secure;
mod shared;
mod topology;
