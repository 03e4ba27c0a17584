//! A whole receiver node without a network: `coaxle_receiver::Receiver`.

use core::ffi::c_char;

use coaxle_clock::{Instant, Local};
use coaxle_node::Node;

use crate::axis_struct::coaxle_axis;
use crate::caller_drive::coaxle_actual;
use crate::command::coaxle_command;
use crate::command_checked::taken;
use crate::failure::Failure;
use crate::handle::{HandleHead, call, free, handle, make};
use crate::memory::{
    fitting, read, readable_array, text, writable, writable_array, writable_if_any, write,
};
use crate::slave_structs::coaxle_slave_state;
use crate::whole_node::{WholeNode, coaxle_receiver_parameters, find, not_there};

/// A receiver node by its config: far clocks, far axes, encoders, presentation and plans, slaves with their programs, all in one.
///
/// Each cycle: `coaxle_receiver_message` for what has arrived, then `coaxle_receiver_cycle`, then the set values to the drives, and
/// `coaxle_receiver_send` until nothing is left.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_receiver {
    head: HandleHead,
    node: WholeNode,
}

handle!(coaxle_receiver, b"receiver");

/// Makes a receiver of the text of its config (docs/REFERENCE.md). `name` stands for the file in errors.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_new(
    parameters: *const coaxle_receiver_parameters,
    name: *const c_char,
    config: *const c_char,
    out: *mut *mut coaxle_receiver,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let (name, config) = (text(name, "name")?, text(config, "config")?);
            Ok(coaxle_receiver {
                head: HandleHead::new::<coaxle_receiver>(),
                node: WholeNode::new(&read(parameters)?, name, config)?,
            })
        })
    }
}

/// Frees a receiver; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_free(receiver: *mut coaxle_receiver) {
    // SAFETY: as for this function.
    unsafe { free(receiver) }
}

/// Passes out the key of its subscription with this number, from 0: messages under it are for `coaxle_receiver_message`. The text stays
/// until the receiver is freed.
///
/// # Errors
/// `COAXLE_NOT_THERE` beyond the last one.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_subscription(
    receiver: *mut coaxle_receiver,
    number: u32,
    key: *mut *const c_char,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let subscription = node.subscriptions.get(number as usize);
            let (found, _) = subscription.ok_or_else(|| not_there("subscription", number))?;
            *writable(key, "key")? = found.as_ptr();
            Ok(())
        })
    }
}

/// Takes a message of a subscription, which arrived at `arrived_ns` of the own clock. One that is damaged or foreign is counted and
/// named in the node's signals, as it would be there.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_message(
    receiver: *mut coaxle_receiver,
    subscription: u32,
    arrived_ns: i64,
    bytes: *const u8,
    length: usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let bytes = readable_array(bytes, length, "bytes")?;
            let number = subscription as usize;
            let (_, reader) = (node.subscriptions.get_mut(number))
                .ok_or_else(|| not_there("subscription", subscription))?;
            let at = Instant::<Local>::from_nanos(arrived_ns);
            reader.read(bytes, |message| node.receiver.receive(at, number, message));
            Ok(())
        })
    }
}

/// Passes out when the next cycle is due, ns of the own clock: a lock of the cycle moves it.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_next_cycle(
    receiver: *mut coaxle_receiver,
    due_ns: *mut i64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            *writable(due_ns, "due_ns")? = node.receiver.next_cycle().as_nanos();
            Ok(())
        })
    }
}

/// Runs one cycle, which really began at `now_ns` of the own clock.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_cycle(receiver: *mut coaxle_receiver, now_ns: i64) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let _ = node.receiver.cycle(Instant::from_nanos(now_ns));
            Ok(())
        })
    }
}

/// Writes the next message of the newest cycle, which leaves at `now_ns` of the own clock, into `bytes`, and passes out its key and its
/// `length`: 0 if none is left.
///
/// # Errors
/// `COAXLE_CAPACITY` if it does not fit: it is the next one again.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_send(
    receiver: *mut coaxle_receiver,
    now_ns: i64,
    key: *mut *const c_char,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let (key, length) = (writable(key, "key")?, writable(length, "length")?);
            let place = writable_array(bytes, capacity, "bytes")?;
            *length = 0;
            let Some(publication) = node.next_message(Instant::from_nanos(now_ns)) else {
                return Ok(());
            };
            *key = publication.as_ptr();
            *length = node.message.len();
            fitting(place, node.message.len())?.copy_from_slice(&node.message);
            node.unsent = None;
            Ok(())
        })
    }
}

/// Passes out the number of a far axis by its name, `<node>.<axis id>`, or the one of its config.
///
/// # Errors
/// `COAXLE_NOT_THERE`, and the names that there are.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_find_axis(
    receiver: *mut coaxle_receiver,
    name: *const c_char,
    number: *mut u32,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let names = node.far_axes.iter().map(String::as_str);
            *writable(number, "number")? = find(text(name, "name")?, names, "far axis")?;
            Ok(())
        })
    }
}

/// Passes out the number of a slave by its name.
///
/// # Errors
/// `COAXLE_NOT_THERE`, and the names that there are.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_find_slave(
    receiver: *mut coaxle_receiver,
    name: *const c_char,
    number: *mut u32,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let names = node.slaves.iter().map(|(name, _)| name.as_str());
            *writable(number, "number")? = find(text(name, "name")?, names, "slave")?;
            Ok(())
        })
    }
}

/// Passes out a far axis of the newest cycle, as its slaves follow it. Its state word says whether its clock is known (operational) and
/// whether it is in error.
///
/// # Errors
/// `COAXLE_NOT_THERE` while nothing has been received of it.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_axis(
    receiver: *mut coaxle_receiver,
    number: u32,
    out: *mut coaxle_axis,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let axis = node.receiver.far_axis(number as usize);
            let axis = axis.ok_or_else(|| not_there("data of far axis", number))?;
            *writable(out, "out")? = coaxle_axis::of(&axis);
            Ok(())
        })
    }
}

/// Passes out set values and state of a slave in the newest cycle.
///
/// # Errors
/// `COAXLE_NOT_THERE` beyond the last slave, and while it has no set values.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_slave(
    receiver: *mut coaxle_receiver,
    number: u32,
    out: *mut coaxle_slave_state,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let state = node.slave_state(number as usize);
            write(out, &state.ok_or_else(|| not_there("slave", number))?)
        })
    }
}

/// Executes a command of a slave, beside those of its program. It takes effect with the next cycle. Passes out the number of its job;
/// `job` may be `NULL`.
///
/// # Errors
/// The NC code of the refusal; the slave is unchanged then.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_execute(
    receiver: *mut coaxle_receiver,
    slave: u32,
    command: *const coaxle_command,
    job: *mut u32,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let command = taken(command)?;
            let number = node.slave_number(slave)?;
            let job = writable_if_any(job, "job")?;
            let accepted = (node.receiver.command(number, &command))
                .map_err(|refusal| Failure::of_nc(refusal.code(), refusal))?;
            if let Some(job) = job {
                *job = accepted.number;
            }
            Ok(())
        })
    }
}

/// Takes the actual values of the caller's drive of a slave, for the next cycle.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_report_actual(
    receiver: *mut coaxle_receiver,
    slave: u32,
    actual: *const coaxle_actual,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let (_, drive) =
                (node.slaves.get(slave as usize)).ok_or_else(|| not_there("slave", slave))?;
            drive.report(&read(actual)?)
        })
    }
}

/// Writes the health of the node as one word into `word`, which has room for `capacity` bytes and is ended by a 0: `ok`, or the fault.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_receiver_health(
    receiver: *mut coaxle_receiver,
    word: *mut c_char,
    capacity: usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_node(receiver, |node| {
            let place = writable_array(word.cast::<u8>(), capacity, "word")?;
            let health = node.receiver.snapshot().health.name().name().as_bytes();
            let place = fitting(place, health.len() + 1)?;
            place[..health.len()].copy_from_slice(health);
            place[health.len()] = 0;
            Ok(())
        })
    }
}

/// Runs a function of a node.
///
/// # Safety
/// As for [`call`].
unsafe fn with_node(
    receiver: *mut coaxle_receiver,
    body: impl FnOnce(&mut WholeNode) -> Result<(), Failure>,
) -> i32 {
    // SAFETY: as for this function.
    unsafe { call(receiver, |of| body(&mut of.node)) }
}
