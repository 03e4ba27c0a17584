//! The pure crates on a machine without operating system.
#![no_std]

use core::panic::PanicInfo;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, Span};
use coaxle_remote::{AxisSync, AxisSyncParameters, FilterMode};

/// A cycle of the far axis; NaN when the block does not start.
#[unsafe(no_mangle)]
pub extern "C" fn coaxle_cycle(index: u16, position: f64, velocity: f64) -> f64 {
    let axis = NcToPlcAxis {
        set_position: position,
        set_velocity: velocity,
        ..NcToPlcAxis::default()
    };
    match AxisSync::start(Span::from_millis(1), AxisSyncParameters::default()) {
        Ok(mut sync) => {
            let out = sync.update(CycleIndex(index), &axis, FilterMode::Auto, 1);
            out.axis.set_position
        }
        Err(_) => f64::NAN,
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

mod no_allocation {
    use core::alloc::{GlobalAlloc, Layout};

    struct Nothing;

    // SAFETY: it hands out no memory at all, which every caller of an allocator must expect.
    unsafe impl GlobalAlloc for Nothing {
        unsafe fn alloc(&self, _: Layout) -> *mut u8 {
            core::ptr::null_mut()
        }

        unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
    }

    #[global_allocator]
    static ALLOCATOR: Nothing = Nothing;
}
