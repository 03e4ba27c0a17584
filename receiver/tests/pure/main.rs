//! Tests of the receiver without a network: nodes, clocks and links are values that a test steps.

mod bench;
mod cam_files;
mod cam_orders;
mod cam_steps;
mod cascade;
mod commanded;
mod continuity;
mod delay_steps;
mod encoder;
mod far;
mod far_axes;
mod far_motion;
mod far_orders;
mod faults;
mod limits;
mod masters;
mod modes;
mod no_alloc;
mod nodes;
mod own_drive;
mod paths;
mod pending_coupling;
mod planned;
mod presented;
mod programs;
mod reports;
mod slave;
mod slaves;
mod standby;
mod two_senders;
mod virtual_axes;

use assert_no_alloc::AllocDisabler;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;
