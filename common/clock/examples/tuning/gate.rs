//! The age gate beside a receiver that stands still and a sender that sleeps.

use coaxle_clock::{Age, AgeGate, CycleTime, Instant, Span};

use crate::outcome::RunOutcome;

/// Ages of the messages of a receiver that stood still for two seconds, then empties its mailbox in pieces, beside a sender that
/// is 1.5 % slow and sleeps for three seconds.
pub(crate) fn outcome() -> RunOutcome {
    let mut outcome = RunOutcome::default();
    let cycle = CycleTime::new(Span::from_millis(1)).unwrap();
    let mut gate = AgeGate::new(cycle, Span::from_millis(7));
    let (mut next, mut fresh) = (0_u64, 0_u32);
    for tick in 0..14_000_i64 {
        let now = Instant::EPOCH + Span::from_micros(1_000 * tick);
        if (1_000..3_000).contains(&tick) {
            continue;
        }
        // Sent at 1.015 ms, and nothing from 9 to 12 s, in which the count stands still.
        let awake = tick - (tick - 9_000).clamp(0, 3_000);
        let sent = (awake as f64 / 1.015) as u64;
        // Three a cycle: a backlog of two seconds takes one to be emptied.
        for _ in 0..3 {
            if next < sent {
                let jitter = next.wrapping_mul(2_654_435_761) % 400;
                let is_fresh = gate.judge(next, now - Span::from_micros(jitter as i64), now);
                let is_fresh = is_fresh == Age::Fresh;
                fresh += u32::from(is_fresh);
                outcome.digest(f64::from(u8::from(is_fresh)));
                next += 1;
            }
        }
    }
    outcome.add("fresh messages", f64::from(fresh), 1.0);
    outcome
}
