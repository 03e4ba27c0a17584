//! Counters of any width: differences with the right sign, added up, and jumps that no motion causes.

use super::parameters::CheckedEncoder;

/// A counter of 8 to 64 bits as one that never wraps.
#[derive(Clone, Debug)]
pub(super) struct Counter {
    /// Shift that brings the sign of a raw count to that of an i64.
    shift: u32,
    /// Counts in a second beyond which a difference is a jump.
    most_per_second: f64,
    state: Option<State>,
    refused: u32,
    resets: u32,
}

/// Result of a raw count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Counted {
    /// Count since the very first, which counts as itself.
    pub(super) count: i64,
    /// Seconds since the last count that was not refused; none for the first of all.
    pub(super) gap: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct State {
    count: i64,
    raw: u64,
    /// Seconds since that count.
    gap: f64,
    jumped: Option<Jumped>,
}

/// A refused count, and the number of later ones that fitted to it.
#[derive(Clone, Copy, Debug)]
struct Jumped {
    raw: u64,
    fitting: u8,
}

/// Number of counts in a row that confirm a jump as a preset counter.
const CONFIRMED: u8 = 3;
/// On top of what the speed explains, counts.
const MARGIN: f64 = 2.0;

impl Counter {
    pub(super) fn new(checked: &CheckedEncoder) -> Self {
        let given = &checked.given;
        Self {
            shift: 64 - u32::from(given.counter_bits),
            // Half as fast again as the declared maximum: an axis whose maximum was stated roughly is not refused.
            most_per_second: 1.5 * given.max_speed / given.increment,
            state: None,
            refused: 0,
            resets: 0,
        }
    }

    /// Takes the next count for the first.
    pub(super) const fn restart(&mut self) {
        self.state = None;
    }

    /// Number of jumps refused up to now.
    pub(super) const fn refused(&self) -> u32 {
        self.refused
    }

    /// Number of presets of the counter up to now.
    pub(super) const fn resets(&self) -> u32 {
        self.resets
    }

    /// Takes a raw count, `gap` seconds after the last one; none if it is refused.
    /// `counts_per_second` is the estimated motion of the axis: it bridges the gap of a preset
    /// counter.
    pub(super) fn update(&mut self, raw: u64, gap: f64, counts_per_second: f64) -> Option<Counted> {
        let Some(mut state) = self.state else {
            let count = self.signed(raw);
            self.state = Some(State::at(count, raw));
            return Some(Counted { count, gap: None });
        };
        // Refused counts leave the time since the last good one, over which the axis may have moved on.
        state.gap += gap;
        let difference = self.difference(state.raw, raw);
        let count = if self.is_motion(difference, state.gap) {
            state.count.wrapping_add(difference)
        } else if self.is_set_anew(&mut state, raw, gap) {
            self.resets = self.resets.saturating_add(1);
            // The preset says nothing of the way since the last good count; the estimated motion does.
            let bridged = libm::round(counts_per_second * state.gap) as i64;
            state.count.wrapping_add(bridged)
        } else {
            self.refused = self.refused.saturating_add(1);
            self.state = Some(state);
            return None;
        };
        self.state = Some(State::at(count, raw));
        let gap = Some(state.gap);
        Some(Counted { count, gap })
    }

    fn is_set_anew(&self, state: &mut State, raw: u64, gap: f64) -> bool {
        let fitting = match state.jumped {
            // Fitting to the refused count before, not to the last good one: a preset counter continues from its new
            // value.
            Some(last) if self.is_motion(self.difference(last.raw, raw), gap) => last.fitting + 1,
            _ => 0,
        };
        state.jumped = Some(Jumped { raw, fitting });
        // Three later readings agree with the first one, which a wrong bit in one or two readings does not bring
        // about.
        fitting >= CONFIRMED
    }

    fn is_motion(&self, difference: i64, gap: f64) -> bool {
        // The magnitude of the most negative difference has no i64: `abs` would overflow.
        difference.unsigned_abs() as f64 <= self.most_per_second * gap + MARGIN
    }

    fn difference(&self, from: u64, to: u64) -> i64 {
        self.signed(to.wrapping_sub(from))
    }

    const fn signed(&self, raw: u64) -> i64 {
        // The arithmetic shift to the right repeats the sign bit of a narrow counter; bits above its width fall out
        // on the left.
        ((raw << self.shift) as i64) >> self.shift
    }
}

impl State {
    const fn at(count: i64, raw: u64) -> Self {
        Self {
            count,
            raw,
            gap: 0.0,
            jumped: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use coaxle_clock::Span;
    use proptest::prelude::*;

    use super::super::parameters::EncoderParameters;
    use super::*;

    const GAP: f64 = 1e-3;

    /// At most 3 counts in a millisecond.
    fn counter(bits: u8) -> Counter {
        let parameters = EncoderParameters {
            increment: 0.01,
            max_speed: 20.0,
            counter_bits: bits,
            ..EncoderParameters::default()
        };
        Counter::new(&parameters.checked(Span::from_millis(1)).unwrap())
    }

    fn masked(count: i64, bits: u8) -> u64 {
        count as u64 & (u64::MAX >> (64 - bits))
    }

    proptest! {
        #[test]
        fn a_counter_of_any_width_is_followed_across_its_ends(
            bits in 8_u8..=64,
            start in any::<i32>(),
            steps in prop::collection::vec(-5_i64..=5, 1..400),
        ) {
            let mut counter = counter(bits);
            let mut count = i64::from(start);
            let first = counter.update(masked(count, bits), GAP, 0.0).unwrap();
            let origin = first.count - count;
            for step in steps {
                count += step;
                let counted = counter.update(masked(count, bits), GAP, 0.0).unwrap();
                prop_assert_eq!(counted.count, count + origin);
            }
            prop_assert_eq!(counter.refused(), 0);
        }
    }

    #[test]
    fn the_first_count_has_a_sign() {
        for bits in [8, 16, 24, 32, 63, 64] {
            let first = counter(bits).update(masked(-7, bits), GAP, 0.0);
            assert_eq!(
                first,
                Some(Counted {
                    count: -7,
                    gap: None
                })
            );
        }
    }

    #[test]
    fn one_wrong_count_is_refused_and_the_next_spans_the_gap() {
        let mut counter = counter(32);
        for count in [100, 103] {
            assert!(counter.update(count, GAP, 0.0).is_some());
        }
        assert_eq!(counter.update(1 << 20, GAP, 0.0), None);
        let next = counter.update(109, GAP, 0.0).unwrap();
        assert_eq!((next.count, next.gap), (109, Some(2.0 * GAP)));
        assert_eq!((counter.refused(), counter.resets()), (1, 0));
    }

    #[test]
    fn what_a_lost_sample_explains_is_no_jump() {
        let mut counter = counter(16);
        let _ = counter.update(0, GAP, 0.0);
        assert_eq!(counter.update(6, GAP, 0.0), None, "3 and 2");
        let next = counter.update(30, 9.0 * GAP, 0.0);
        assert_eq!(next.unwrap().count, 30, "30 and 2 in ten cycles");
    }

    #[test]
    fn a_counter_that_was_set_anew_moves_nothing() {
        let mut counter = counter(32);
        let speed = 2_000.0;
        let _ = counter.update(500, GAP, speed);
        let _ = counter.update(502, GAP, speed);
        for raw in [9_000_004, 9_000_006, 9_000_008] {
            assert_eq!(counter.update(raw, GAP, speed), None);
        }
        let after = counter.update(9_000_010, GAP, speed).unwrap();
        assert_eq!(after.count, 510, "eight counts in four cycles");
        assert_eq!((counter.refused(), counter.resets()), (3, 1));
        assert_eq!(counter.update(9_000_012, GAP, speed).unwrap().count, 512);
    }
}
