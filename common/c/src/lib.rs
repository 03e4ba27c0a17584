//! Coaxle for C and C++.
//!
//! `include/coaxle.h` is this interface as a header, made by cbindgen; `docs/EMBEDDING.md` is its manual. A program of one's own calls
//! it from its own loop: the library opens no connection, starts no thread, reads no clock, and allocates nothing after the `_new`
//! functions.
//!
//! | room | here |
//! |--|--|
//! | `coaxle_clock` | [`coaxle_far_clock`], [`coaxle_cycle_lock`] |
//! | `coaxle_remote` | [`coaxle_far_axis`](struct@coaxle_far_axis), [`coaxle_encoder`](struct@coaxle_encoder) |
//! | `coaxle_wire` | [`coaxle_key`]: frames, plans, time requests and responses as bytes |
//! | `coaxle_slave`, `coaxle_cam` | [`coaxle_slave`](struct@coaxle_slave), [`coaxle_tables`] |
//! | `coaxle_drive_memory` | [`coaxle_drive_process`], [`coaxle_drive_node`]: the memory of a drive, from both ends |
//! | `coaxle_receiver` | [`coaxle_receiver`](struct@coaxle_receiver): a whole node by its config |
//!
//! The border is in `handle` (calls), `memory` (pointers) and `failure` (errors): a function of the interface is a call of it with a closure.
#![allow(non_camel_case_types, reason = "names as in C")]
#![allow(
    clippy::missing_errors_doc,
    reason = "every function returns 0 or an error code; the header lists them"
)]
#![allow(
    clippy::result_large_err,
    reason = "an error has its sentence in place: failing allocates nothing"
)]

mod axis_struct;
mod caller_drive;
mod command;
mod command_checked;
mod common_time;
mod cycle_lock;
mod drive_memory;
mod drive_memory_structs;
mod encoder;
mod failure;
mod far_axis;
mod far_axis_structs;
mod far_clock;
mod handle;
mod memory;
mod phase;
mod plan;
mod receiver;
mod slave;
mod slave_structs;
mod tables;
mod time_messages;
mod whole_node;
mod wire;

use core::ffi::{c_char, c_void};

pub use axis_struct::*;
pub use caller_drive::*;
pub use command::*;
pub use common_time::*;
pub use cycle_lock::*;
pub use drive_memory::*;
pub use drive_memory_structs::*;
pub use encoder::*;
pub use failure::*;
pub use far_axis::*;
pub use far_axis_structs::*;
pub use far_clock::*;
pub use phase::*;
pub use plan::*;
pub use receiver::*;
pub use slave::*;
pub use slave_structs::*;
pub use tables::*;
pub use time_messages::*;
pub use whole_node::*;
pub use wire::*;

/// Version of this interface. It grows when a function or a struct is added; what there is stays as it is.
pub const COAXLE_ABI_VERSION: u32 = 1;

/// Returns the version of the interface of the library that is loaded: at least that of the header.
#[unsafe(no_mangle)]
pub extern "C" fn coaxle_abi_version() -> u32 {
    COAXLE_ABI_VERSION
}

/// Returns the sentence of the newest error of a handle, which stays until its next one. For `NULL`: of the newest error of this thread
/// without a handle, as of a `_new` function.
///
/// # Safety
/// `handle` is `NULL` or one of this library, not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_last_error(handle: *const c_void) -> *const c_char {
    // SAFETY: as for this function.
    unsafe { handle::newest_error(handle) }
}
