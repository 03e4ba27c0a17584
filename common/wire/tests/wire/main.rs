//! Tests of the wire format: frames, commands and time requests, by the document and by the code.

mod beacon;
mod cam_orders;
mod command;
mod document;
mod exchange;
mod followers;
mod frame;
mod golden;
mod intake;
mod no_alloc;
mod plan;
mod wire_example;
mod wire_exchange;
mod wire_plan;

use assert_no_alloc::AllocDisabler;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;
