//! How much memory a slave takes.

use std::mem::size_of;

use coaxle_slave::SlaveAxis;

/// Plates are beside it, allocated when they are selected.
#[test]
fn an_axis_without_plates_takes_less_than_six_kilobytes() {
    let size = size_of::<SlaveAxis>();
    assert!(size < 6 * 1_024, "{size} bytes");
}
