//! Tests of the gateway as a node.

mod no_alloc;
mod node;

use assert_no_alloc::AllocDisabler;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;
