//! Own cycle locked to that of a far node: the deadlines follow its cycle, a constant time behind.
//!
//! Without a lock the newest frame is 0 to one cycle old when the own cycle begins, and that age goes round with the drift. With one it is the same in each cycle.
//!
//! The wanted period is that of the far cycle by the own clock, which the [phase observer](crate::observer) knows, and a share of the phase that is still missing. Only
//! deadlines move: the clock stays what it is.

use crate::far_clock::FarClockOutput;
use crate::numbers::rounded;
use crate::{CycleTime, Seconds, Span};

/// Own cycle in relation to a far one. Runs once per own cycle, and says by how much the next deadline is to be moved.
///
/// ```
/// use coaxle_clock::cycle_lock::{CycleLock, FarPhase};
/// use coaxle_clock::{CycleTime, Seconds, Span};
///
/// let cycle = CycleTime::new(Span::from_millis(1))?;
/// let mut lock = CycleLock::new(cycle, Span::from_micros(300));
/// // The far clock is 50 ppm fast, and the phase is right: the period shrinks by as much.
/// let far = FarPhase { age: Seconds(2.3e-3), delay: Seconds(2e-3), drift_ppm: 50.0, cycle_time: cycle };
/// let moved: i64 = (0..10_000).map(|_| lock.advance(Some(&far), 1).as_nanos()).sum();
/// assert!((-500_000..-480_000).contains(&moved));
/// # Ok::<(), coaxle_clock::cycle::CycleTimeOutOfRange>(())
/// ```
#[derive(Clone, Debug)]
pub struct CycleLock {
    cycle_time: CycleTime,
    /// Time of a deadline after the arrival of the frame that is to be the newest one then.
    offset: Seconds,
    state: CycleLockState,
    phase: Option<Seconds>,
    /// Period of the own cycle minus the nominal one, s per s.
    pace: f64,
    /// Part of a nanosecond that no deadline has been moved by.
    left: f64,
}

/// State of a lock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum CycleLockState {
    /// The far clock is not known yet: nothing moves.
    #[default]
    Waiting,
    /// The deadlines are led to the far cycle.
    Locking,
    /// They follow it.
    Locked,
    /// The far clock is not known any more: the period stays what it was.
    Holdover,
    /// The cycle times are no multiples of each other, or the clocks drift by more than may be followed: nothing moves.
    Refused,
}

/// Far cycle in relation to the own one, at the ideal start of an own cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarPhase {
    /// Age of any frame by the far clock.
    pub age: Seconds,
    /// Delay of the way, as far as that clock knows it: of one that counts from arrivals it is zero.
    pub delay: Seconds,
    /// Drift of the far clock against the own one, ppm.
    pub drift_ppm: f64,
    /// Nominal cycle time of the far node.
    pub cycle_time: CycleTime,
}

impl FarPhase {
    /// Makes the phase by a far clock in its newest cycle, `age` after a frame; none while its time is slewed.
    #[must_use]
    pub fn of(newest: &FarClockOutput, age: Seconds, cycle_time: CycleTime) -> Option<Self> {
        let (observer, delay) = (&newest.observer, &newest.delay);
        // While far time is slewed, as to a delay that has just been measured, the age is by neither the old nor the new one.
        let is_slewed = observer.slew_remaining.0.abs() > SLEWED;
        (!is_slewed).then(|| Self {
            age,
            delay: delay.delay.unwrap_or(Seconds::ZERO),
            drift_ppm: observer.drift_ppm,
            cycle_time,
        })
    }
}

/// Time that may be left to be slewed, s: below what a cycle begins late by.
const SLEWED: f64 = 5e-6;

/// Share of the missing phase per second: a bandwidth of 0.1 Hz. The observer's estimate moves by microseconds within seconds, which
/// a faster one would pass on to the period, and to all who follow this node.
const GAIN: f64 = 0.63;
/// Greatest change of a period while the phase is right, s per s: two quartzes of 50 ppm each.
const MOST: f64 = 100e-6;
/// Greatest change while it is led there: the greatest drift that is followed, and a share for the phase.
const MOST_WHILE_LOCKING: f64 = 500e-6;
/// Greatest drift that is followed: the rest of the greatest change is for the phase.
const MOST_DRIFT: f64 = 400e-6;
/// Drift up to which the smaller bound leaves a share for the phase.
const USUAL_DRIFT: f64 = 80e-6;
/// Greatest change of the period within a second, s per s: a follower of this node sees it as a change of the drift.
const MOST_BEND: f64 = 200e-6;
/// Bend with which it is led to the right phase: the rest is for a drift that changes.
const BRAKE: f64 = 0.8 * MOST_BEND;
/// Part of a turn by which the phase is led within a second. A follower of this node sees that as a drift that changes for some seconds: of a millisecond 100 ppm left it
/// 15 µs off meanwhile, 150 ppm 30 µs, and as much as the bounds permit 150 µs (`locked-cycle`).
const RATE_OF_TURN: f64 = 0.1;
const LEAST_RATE: f64 = 50e-6;
/// Missing phase below which a cycle is locked, and above which it is no longer.
const LOCKED: f64 = 20e-6;
const LOST: f64 = 60e-6;

impl CycleLock {
    /// Creates the lock of a node with this cycle time, whose cycles are to begin `offset` after the frames have arrived.
    #[must_use]
    pub const fn new(cycle_time: CycleTime, offset: Span) -> Self {
        Self {
            cycle_time,
            offset: Seconds(offset.as_nanos() as f64 * 1e-9),
            state: CycleLockState::Waiting,
            phase: None,
            pace: 0.0,
            left: 0.0,
        }
    }

    /// State in the newest cycle.
    #[must_use]
    pub const fn state(&self) -> CycleLockState {
        self.state
    }

    /// Time by which the newest cycle began later than wanted; none while the far clock is not known.
    #[must_use]
    pub const fn phase(&self) -> Option<Seconds> {
        self.phase
    }

    /// Change of the period, ppm of the nominal one.
    #[must_use]
    pub fn period_ppm(&self) -> f64 {
        self.pace * 1e6
    }

    /// Takes the phase at the start of a cycle, `elapsed` cycles after the one before. Returns the time by which the next deadline is to be moved.
    pub fn advance(&mut self, far: Option<&FarPhase>, elapsed: u32) -> Span {
        let period = self.cycle_time.as_secs_f64();
        let wanted = self.wanted(far);
        let bend = MOST_BEND * period * f64::from(elapsed);
        self.pace += (wanted - self.pace).clamp(-bend, bend);
        self.left += self.pace * period * 1e9;
        let whole = rounded(self.left);
        self.left -= whole as f64;
        Span::from_nanos(whole)
    }

    /// Wanted change of the period.
    fn wanted(&mut self, far: Option<&FarPhase>) -> f64 {
        let Some(far) = far else {
            self.phase = None;
            self.state = match self.state {
                CycleLockState::Waiting => CycleLockState::Waiting,
                CycleLockState::Refused => CycleLockState::Refused,
                _ => CycleLockState::Holdover,
            };
            return self.pace;
        };
        let drift = far.drift_ppm * 1e-6;
        let Some(turn) = self
            .common_turn(far.cycle_time)
            .filter(|_| drift.abs() <= MOST_DRIFT)
        else {
            self.phase = None;
            self.state = CycleLockState::Refused;
            return 0.0;
        };
        let late = far.age.0 - far.delay.0 - self.offset.0;
        let phase = late - turn * rounded(late / turn) as f64;
        self.phase = Some(Seconds(phase));
        let limit = if self.state == CycleLockState::Locked {
            LOST
        } else {
            LOCKED
        };
        self.state = match phase.abs() <= limit {
            true => CycleLockState::Locked,
            false => CycleLockState::Locking,
        };
        let is_usual = self.state == CycleLockState::Locked && drift.abs() <= USUAL_DRIFT;
        let most = if is_usual { MOST } else { MOST_WHILE_LOCKING };
        // A fast far clock has shorter cycles, and a cycle that begins late needs a shorter one, too.
        (-drift / (1.0 + drift) - rate(phase, turn)).clamp(-most, most)
    }

    /// Time after which both cycles begin alike again: the shorter of both cycle times, if the longer one is a multiple of it.
    fn common_turn(&self, far: CycleTime) -> Option<f64> {
        let [own, far] = [self.cycle_time, far].map(|time| time.span().as_nanos());
        let (shorter, longer) = (own.min(far), own.max(far));
        (longer % shorter == 0).then_some(shorter as f64 * 1e-9)
    }
}

/// Rate at which a phase is led to zero, s per s: half a turn takes five seconds, and no faster than what the greatest bend can end there.
fn rate(phase: f64, turn: f64) -> f64 {
    let most = (RATE_OF_TURN * turn).clamp(LEAST_RATE, MOST_DRIFT);
    let most = most.min(libm::sqrt(2.0 * BRAKE * phase.abs()));
    (GAIN * phase).clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// An own cycle and a far one, which drift.
    struct World {
        lock: CycleLock,
        own: CycleTime,
        far: CycleTime,
        /// Far time at the newest own cycle, s.
        far_time: f64,
        /// Change of the newest period, ppm.
        moved_ppm: f64,
        shortest_ppm: f64,
        longest_ppm: f64,
    }

    const DELAY: f64 = 2e-3;

    fn cycle(micros: i64) -> CycleTime {
        CycleTime::new(Span::from_micros(micros)).unwrap()
    }

    impl World {
        fn new(own_us: i64, far_us: i64, phase: f64) -> Self {
            let own = cycle(own_us);
            Self {
                lock: CycleLock::new(own, Span::from_micros(own_us * 3 / 10)),
                own,
                far: cycle(far_us),
                far_time: phase,
                moved_ppm: 0.0,
                shortest_ppm: 0.0,
                longest_ppm: 0.0,
            }
        }

        /// Runs for a time with a far clock that is fast by so many ppm, and is known or not.
        fn run(&mut self, seconds: f64, drift_ppm: f64, is_known: bool) {
            let cycles = (seconds / self.own.as_secs_f64()).round() as u64;
            for _ in 0..cycles {
                let newest = ((self.far_time - DELAY) / self.far.as_secs_f64()).floor();
                let far = FarPhase {
                    age: Seconds(self.far_time - newest * self.far.as_secs_f64()),
                    delay: Seconds(DELAY),
                    drift_ppm,
                    cycle_time: self.far,
                };
                let moved = self.lock.advance(is_known.then_some(&far), 1);
                let period = self.own.as_secs_f64() + moved.as_secs_f64();
                self.far_time += period * (1.0 + drift_ppm * 1e-6);
                self.moved_ppm = self.lock.period_ppm();
                self.shortest_ppm = self.shortest_ppm.min(self.moved_ppm);
                self.longest_ppm = self.longest_ppm.max(self.moved_ppm);
            }
        }

        fn phase_us(&self) -> f64 {
            self.lock.phase().expect("a phase").0 * 1e6
        }
    }

    #[test]
    fn a_drift_that_jumps_and_a_silence_are_survived_within_the_bounds() {
        let mut world = World::new(1_000, 1_000, 0.000_7);
        world.run(10.0, 50.0, true);
        assert_eq!(world.lock.state(), CycleLockState::Locked);
        world.run(20.0, 50.0, true);
        assert!(world.phase_us().abs() < 0.1, "{}", world.phase_us());
        assert!((world.moved_ppm + 50.0).abs() < 0.1, "{}", world.moved_ppm);
        // Silence: the period stays.
        world.run(3.0, 50.0, false);
        assert_eq!(world.lock.state(), CycleLockState::Holdover);
        assert!((world.moved_ppm + 50.0).abs() < 0.1, "{}", world.moved_ppm);
        (world.shortest_ppm, world.longest_ppm) = (-50.0, -50.0);
        world.run(10.0, 50.0, true);
        assert_eq!(world.lock.state(), CycleLockState::Locked);
        assert!(world.shortest_ppm > -100.0 && world.longest_ppm < 0.0);
        // The clock jumps by 200 ppm.
        world.run(10.0, 250.0, true);
        assert_eq!(world.lock.state(), CycleLockState::Locked);
        assert!(world.shortest_ppm >= -500.0, "{}", world.shortest_ppm);
        world.run(20.0, 250.0, true);
        assert!(world.phase_us().abs() < 0.1, "{}", world.phase_us());
    }

    #[test]
    fn what_cannot_be_followed_is_refused_and_moves_nothing() {
        for (own, far, drift) in [
            (1_000, 1_500, 20.0),
            (1_000, 1_000, 450.0),
            (700, 1_000, 0.0),
        ] {
            let mut world = World::new(own, far, 0.0);
            world.run(5.0, drift, true);
            assert_eq!(
                world.lock.state(),
                CycleLockState::Refused,
                "{own} {far} {drift}"
            );
            assert_eq!(world.moved_ppm, 0.0);
        }
        let mut world = World::new(1_000, 1_000, 0.0);
        world.run(5.0, 20.0, false);
        assert_eq!(world.lock.state(), CycleLockState::Waiting);
        assert_eq!(world.moved_ppm, 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_phase_is_locked_to_within_ten_seconds(
            phase in 0.0..1.0,
            drift in -350.0..350.0,
            (own, far) in prop_oneof![Just((1_000, 1_000)), Just((2_000, 500)), Just((250, 1_000))],
        ) {
            let mut world = World::new(own, far, phase * 1e-6 * far as f64);
            world.run(10.0, drift, true);
            prop_assert_eq!(world.lock.state(), CycleLockState::Locked);
            prop_assert!(world.shortest_ppm >= -500.0 && world.longest_ppm <= 500.0);
            world.run(20.0, drift, true);
            prop_assert!(world.phase_us().abs() < 0.1);
        }
    }
}
