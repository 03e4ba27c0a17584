//! No cycle of an encoder master allocates.

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Seconds, Span};
use coaxle_remote::{EncoderMaster, EncoderParameters, EncoderSample};

#[test]
fn a_cycle_allocates_nothing() {
    let parameters = EncoderParameters {
        increment: 0.01,
        ..EncoderParameters::default()
    };
    let checked = parameters.checked(Span::from_millis(1)).unwrap();
    let mut master = EncoderMaster::new(&checked);
    let last = assert_no_alloc(|| {
        let mut last = master.update(None, Seconds::ZERO, 1);
        for cycle in 0..2_000_u64 {
            // Rest, motion, losses, a wild count and rest again.
            let count = cycle.clamp(400, 1_000) * 7;
            let sample = match cycle {
                700 => Some(EncoderSample::next(1 << 40)),
                _ if cycle % 13 == 0 => None,
                _ => Some(EncoderSample::next(count)),
            };
            // Two cycles at once now and then, as after an overrun.
            last = master.update(sample, Seconds(1e-3), 1 + (cycle % 50) as u32 / 49);
        }
        last
    });
    assert!(last.standstill);
}
