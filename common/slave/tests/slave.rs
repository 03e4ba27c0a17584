//! Tests of the slave as a crate: its example, and its memory.

#[path = "../examples/saw_in_your_loop.rs"]
mod saw_in_your_loop;

use std::mem::size_of;

use coaxle_slave::SlaveAxis;

#[test]
fn every_piece_is_as_long_as_the_other() {
    let cuts = saw_in_your_loop::run(20.0).expect("a station");
    assert!(cuts.len() >= 9, "{}", cuts.len());
    for (number, cut) in (1..).zip(&cuts) {
        let expected = 1_000.0 * f64::from(number);
        assert!((cut.place - expected).abs() < 1e-6, "{}", cut.place);
        assert!(cut.slip.abs() < 1e-6, "{}", cut.slip);
    }
}

/// Plates are allocated separately, when they are selected.
#[test]
fn an_axis_without_plates_takes_less_than_six_kilobytes() {
    let size = size_of::<SlaveAxis>();
    assert!(size < 6 * 1_024, "{size} bytes");
}
