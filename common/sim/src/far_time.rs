//! Check that a corrected far time passes like a time.

use coaxle_clock::{Instant, Remote};

/// Monitors the far time that the set values of a far axis refer to.
///
/// Within a run of the far node, and as long as it is shown, it never stands still or runs back,
/// and no cycle gains or loses more than a share of its length.
#[derive(Clone, Copy, Debug)]
pub struct FarTimeCheck {
    cycle_time: f64,
    /// The run, and the time in it.
    last: Option<(u64, Instant<Remote>)>,
    largest: f64,
}

/// Fault of a far time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FarTimeFault {
    /// Time that stands still or runs back, by this many s.
    NotLater(f64),
    /// Cycle that gains or loses this share of its length.
    Rate(f64),
}

/// Greatest share of its length that a cycle may gain or lose: while an observer locks it slews by
/// up to half of it, and clocks differ by up to a tenth of a percent.
pub const LARGEST_RATE_ERROR: f64 = 0.501;

impl FarTimeCheck {
    /// Creates the check for a receiver of this cycle time, s.
    #[must_use]
    pub const fn new(cycle_time: f64) -> Self {
        Self {
            cycle_time,
            last: None,
            largest: 0.0,
        }
    }

    /// Restarts the check while no far time is shown.
    pub const fn restart(&mut self) {
        self.last = None;
    }

    /// Takes the next far time, in this run of the far node, `cycles` own cycles after the one before.
    pub fn push(
        &mut self,
        run: u64,
        far_time: Instant<Remote>,
        cycles: u32,
    ) -> Option<FarTimeFault> {
        let (run_before, before) = self.last.replace((run, far_time))?;
        // A restarted node counts from its own beginning: the difference of both times means nothing.
        if run_before != run {
            return None;
        }
        let gained = (far_time - before).as_secs_f64();
        // Standing still counts as a fault as well: extrapolated set values would repeat.
        if gained <= 0.0 {
            return Some(FarTimeFault::NotLater(-gained));
        }
        // Never 0, by which the rate would be divided.
        let passed = f64::from(cycles.max(1)) * self.cycle_time;
        let rate = gained / passed - 1.0;
        self.largest = self.largest.max(rate.abs());
        (rate.abs() > LARGEST_RATE_ERROR).then_some(FarTimeFault::Rate(rate))
    }

    /// The largest share that a cycle has gained or lost.
    #[must_use]
    pub const fn largest(&self) -> f64 {
        self.largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault of each far time after the first, ns, a cycle of 1 ms after the one before.
    fn faults(times: &[i64]) -> Vec<Option<FarTimeFault>> {
        let mut check = FarTimeCheck::new(1e-3);
        let mut push = |time: &i64| check.push(1, Instant::from_nanos(*time), 1);
        let all: Vec<_> = times.iter().map(&mut push).collect();
        assert_eq!(all[0], None);
        all[1..].to_vec()
    }

    #[test]
    fn a_time_that_stands_or_goes_back_is_found() {
        let [slow, stands, back, on] = faults(&[0, 500_000, 500_000, 499_999, 1_499_999])[..]
        else {
            panic!("four");
        };
        assert_eq!((slow, on), (None, None));
        assert_eq!(stands, Some(FarTimeFault::NotLater(0.0)));
        assert_eq!(back, Some(FarTimeFault::NotLater(1e-9)));
    }

    #[test]
    fn a_cycle_gains_and_loses_no_more_than_half_of_its_length() {
        for (gained, expected) in [
            (1_500_900, None),
            (499_100, None),
            (1_502_000, Some(0.502)),
            (498_000, Some(-0.502)),
        ] {
            let rate = match faults(&[0, gained])[0] {
                Some(FarTimeFault::Rate(rate)) => Some((rate * 1e6).round() / 1e6),
                _ => None,
            };
            assert_eq!(rate, expected);
        }
    }

    #[test]
    fn skipped_cycles_count() {
        let mut check = FarTimeCheck::new(1e-3);
        let mut push = |time: i64, cycles| check.push(1, Instant::from_nanos(time), cycles);
        assert_eq!(push(0, 1), None);
        assert_eq!(push(10_100_000, 10), None);
        assert!(push(20_200_000, 1).is_some());
        assert!(check.largest() > 9.0);
    }

    #[test]
    fn another_run_and_what_was_not_shown_begin_anew() {
        let mut check = FarTimeCheck::new(1e-3);
        assert_eq!(check.push(1, Instant::from_nanos(9_000_000), 1), None);
        assert_eq!(check.push(2, Instant::from_nanos(0), 1), None);
        check.restart();
        assert_eq!(check.push(2, Instant::from_nanos(-5), 1), None);
        assert!(check.push(2, Instant::from_nanos(-5), 1).is_some());
    }
}
