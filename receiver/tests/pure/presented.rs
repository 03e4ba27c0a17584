//! A far axis that is shown later: between its frames, through losses and silences, and brought to another delay.

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Instant, Span};
use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node, PresentAfter};
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals};
use coaxle_receiver::{ContinuityState, FilterState, Receiver};

use crate::nodes::{self, MILLISECOND, to_and_fro as master};

/// Time from a cycle of the master to the arrival of its frame.
const WAY: i64 = 5 * MILLISECOND;
/// Cycle of the master by the clock of the receiver, 40 ppm long.
const CYCLE: i64 = 1_000_040;

struct Bench {
    receiver: Receiver,
    next: u64,
    delay: Span,
    /// Cycles whose frames are lost.
    is_lost: fn(u64) -> bool,
    before: Option<(f64, f64)>,
    hardest: f64,
}

impl Bench {
    fn new(rest: &str, delay: Span) -> Self {
        let text = format!(
            "mode = 'observer'\nmaster = {{ node = 'a' }}\ndelay = {{ fixed-us = 5000 }}\n\
             sync.time-sync = {{ age-of-data-limit = 10, max-cycle-index-difference = 50 }}\n{rest}"
        );
        Self {
            receiver: nodes::receiver(&text),
            next: 0,
            delay,
            is_lost: |_| false,
            before: None,
            hardest: 0.0,
        }
    }

    fn send_until(&mut self, now: i64) {
        while self.next as i64 * CYCLE + WAY <= now {
            let count = self.next;
            self.next += 1;
            if (self.is_lost)(count) {
                continue;
            }
            // Primes: 997 messages in sequence have different jitters, of up to a microsecond.
            let jitter = (count * 7_919 % 997) as i64;
            let header = FrameHeader {
                present_after: PresentAfter::new(self.delay),
                ..nodes::header_of(count)
            };
            let set = master(count as f64 * 1e-3);
            let axes = &[Some(AxisSample {
                set,
                ..AxisSample::default()
            })];
            let at = Instant::from_nanos(count as i64 * CYCLE + WAY + jitter);
            let message = Message::Frame(Frame { header, axes });
            self.receiver.receive(at, 0, &message);
        }
    }

    /// Runs until then, s; passes on the axis, its node and the own time.
    fn run(&mut self, until_s: f64, mut each: impl FnMut(&FarAxisSignals, &FarNodeSignals, i64)) {
        while self.receiver.next_cycle().as_nanos() < (until_s * 1e9) as i64 {
            let now = self.receiver.next_cycle();
            self.send_until(now.as_nanos());
            let _ = self.receiver.cycle(now);
            while self.receiver.transmit().is_some() {}
            let signals = &self.receiver.snapshot().signals;
            let axis = &signals.axes[0];
            if let Some(position) = axis.corrected_position {
                let velocity = self.before.map(|(before, _)| (position - before) * 1e3);
                if let (Some(velocity), Some((_, last))) = (velocity, self.before) {
                    self.hardest = self.hardest.max((velocity - last).abs() * 1e3);
                }
                self.before = Some((position, velocity.unwrap_or_default()));
            }
            each(axis, &signals.far[0], now.as_nanos());
        }
    }
}

/// Distance of the axis from where its master was at the instant that it shows, u.
fn off(axis: &FarAxisSignals) -> f64 {
    let at = axis.far_time_ns.expect("it follows") as f64 * 1e-9;
    (axis.corrected_position.expect("received") - master(at).position).abs()
}

#[test]
fn it_is_its_master_at_the_instant_shown_and_nothing_is_predicted() {
    let mut bench = Bench::new("", Span::from_millis(20));
    bench.run(4.0, |_, _, _| {});
    bench.hardest = 0.0;
    // One in seven is lost, and three in a row now and then.
    bench.is_lost = |count| count.is_multiple_of(7) || (count % 100) < 3;
    let mut worst = 0.0_f64;
    bench.run(10.0, |axis, far, now| {
        assert_eq!(
            (axis.state, axis.interpolated),
            (Some(FilterState::Observer), Some(true))
        );
        worst = worst.max(off(axis));
        // 20 ms of the far clock before the present one.
        let lag = now as f64 * 1e6 / CYCLE as f64 - axis.far_time_ns.expect("known") as f64;
        assert!((lag - 20e6).abs() < 20_000.0, "{lag}");
        assert_eq!(far.present_after_us, Some(20_000.0));
    });
    assert!(worst < 1e-6, "{worst}");
    assert!(bench.hardest < 5_100.0, "{}", bench.hardest);
    let signals = &bench.receiver.snapshot().signals;
    // Only before the first frames were old enough.
    assert!(signals.axes[0].extrapolated_cycles < 40);
    let needed = signals.far[0].needed_present_after_us.expect("known");
    // 5 ms of way and up to a cycle, three lost ones in a row, and a cycle of each side.
    assert!((8_000.0..12_000.0).contains(&needed), "{needed}");
}

#[test]
fn a_silence_within_the_delay_takes_nothing_away_and_a_longer_one_is_no_step() {
    let mut bench = Bench::new("", Span::from_millis(50));
    bench.run(4.0, |_, _, _| {});
    bench.hardest = 0.0;
    // Longer than the age limit of 10 ms.
    bench.is_lost = |count| (5_000..5_040).contains(&count);
    let mut worst = 0.0_f64;
    bench.run(6.0, |axis, _, _| {
        assert!(
            axis.synced && axis.continuity == ContinuityState::Following,
            "{axis:?}"
        );
        worst = worst.max(off(axis));
    });
    // A quintic over 41 cycles.
    assert!(worst < 0.02, "{worst}");
    assert!(bench.hardest < 6_500.0, "{}", bench.hardest);
    bench.is_lost = |count| (7_000..7_300).contains(&count);
    let mut braked = false;
    bench.run(12.0, |axis, _, _| {
        braked |= axis.continuity == ContinuityState::Braking
    });
    assert!(braked);
    assert!(bench.hardest < 12_000.0, "{}", bench.hardest);
    let axis = &bench.receiver.snapshot().signals.axes[0];
    assert!(axis.synced && off(axis) < 1e-6);
}

#[test]
fn a_delay_that_is_too_short_predicts_the_rest_and_says_so() {
    let mut bench = Bench::new("", Span::from_millis(3));
    bench.run(4.0, |_, _, _| {});
    let before = bench.receiver.snapshot().signals.axes[0].extrapolated_cycles;
    let mut worst = 0.0_f64;
    bench.run(6.0, |axis, _, _| {
        assert_eq!(axis.interpolated, Some(false));
        worst = worst.max(off(axis));
    });
    // 3 ms are predicted: ⅙·10⁵·(3 ms)³.
    assert!((1e-5..1e-3).contains(&worst), "{worst}");
    let signals = &bench.receiver.snapshot().signals;
    assert_eq!(signals.axes[0].extrapolated_cycles, before + 2_000);
    assert!(signals.far[0].needed_present_after_us > signals.far[0].present_after_us);
}

#[test]
fn another_delay_is_gone_to_without_a_step() {
    let mut bench = Bench::new("", Span::from_millis(20));
    bench.run(4.0, |_, _, _| {});
    bench.hardest = 0.0;
    for (until, millis) in [(6.0, 45), (8.0, 0), (10.0, 30)] {
        bench.delay = Span::from_millis(millis);
        bench.run(until, |_, _, _| {});
        let axis = &bench.receiver.snapshot().signals.axes[0];
        assert_eq!(axis.continuity, ContinuityState::Following, "{millis}");
        assert_eq!(axis.interpolated, (millis > 0).then_some(true));
    }
    assert!(bench.hardest < 12_000.0, "{}", bench.hardest);
}

#[test]
fn whoever_wants_it_now_predicts_as_before() {
    let later = Span::from_millis(20);
    let shown = |rest, delay| {
        let mut bench = Bench::new(rest, delay);
        let mut shown = Vec::new();
        bench.run(3.0, |axis, _, _| {
            shown.push((axis.corrected_position, axis.far_time_ns, axis.interpolated));
        });
        shown
    };
    assert_eq!(shown("present = 'now'", later), shown("", Span::ZERO));
}

#[test]
fn showing_later_does_not_allocate() {
    let mut bench = Bench::new("", Span::from_millis(20));
    bench.is_lost = |count| count.is_multiple_of(7);
    assert_no_alloc(|| {
        for (until, millis) in [(2.0, 20), (2.2, 900), (2.4, 0), (3.0, 20)] {
            bench.delay = Span::from_millis(millis);
            bench.run(until, |_, _, _| {});
        }
    });
    // In a debug build, an allocation ends the test at once.
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert!(bench.receiver.snapshot().signals.axes[0].interpolated == Some(true));
}
