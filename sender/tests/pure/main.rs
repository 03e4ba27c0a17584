//! Tests of the sender without a network.

mod followers;
mod no_alloc;
mod node;

use assert_no_alloc::AllocDisabler;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;
