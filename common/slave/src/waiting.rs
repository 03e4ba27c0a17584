//! Set values that wait for their instants, in a ring.

use alloc::boxed::Box;
use alloc::vec;

use coaxle_clock::Span;
use coaxle_curve::between::{Ends, between};
use coaxle_curve::profile::Kinematics;

/// Part of the time by which a delay may change in motion.
// Twice what a node slews its own by.
pub(crate) const SLEW: i64 = 500;

/// Greatest share by which a motion is shown faster or slower meanwhile.
const MOST_GAINED: f64 = 1.0 / SLEW as f64;

/// Set values that wait for the instants at which they are due. Between two of them lies the quintic through both.
#[derive(Debug)]
pub struct WaitingSets {
    /// A ring in the order of their instants.
    places: Box<[WaitingSet]>,
    first: usize,
    kept: usize,
    /// Time of the newest cycle, since the start.
    now: Span,
}

/// A set value and the instant at which it is due.
#[derive(Clone, Copy, Debug)]
struct WaitingSet {
    at: Span,
    /// Time in which it was calculated, since the one before.
    passed: Span,
    set: Kinematics,
}

impl WaitingSets {
    /// Creates a ring for delays of up to `cycles` cycles.
    #[must_use]
    pub fn new(cycles: u32) -> Self {
        let none = WaitingSet {
            at: Span::ZERO,
            passed: Span::ZERO,
            set: Kinematics::at_rest(0.0),
        };
        // One before the present instant, one of the present cycle, and one in reserve.
        let places = cycles as usize + 3;
        Self {
            places: vec![none; places].into(),
            first: 0,
            kept: 0,
            now: Span::ZERO,
        }
    }

    /// Goes on to the next cycle, `passed` after the one before.
    pub fn advance(&mut self, passed: Span) {
        self.now += passed;
    }

    /// Forgets all of them.
    pub const fn clear(&mut self) {
        self.kept = 0;
    }

    /// Returns true if all of them are these.
    #[must_use]
    pub fn are_all(&self, set: &Kinematics) -> bool {
        (0..self.kept).all(|n| self.at_place(n).set == *set)
    }

    /// Adds a set value that was calculated in the time `passed` since the one before, and is due after the time `by`.
    pub fn push(&mut self, set: &Kinematics, passed: Span, by: Span) {
        let due = WaitingSet {
            at: self.now + by,
            passed,
            set: *set,
        };
        // A shorter delay by more than a cycle: the newest set values count.
        while self.kept > 0 && self.at_place(self.kept - 1).at >= due.at {
            self.kept -= 1;
        }
        if self.kept == self.places.len() {
            self.first = (self.first + 1) % self.places.len();
            self.kept -= 1;
        }
        let place = (self.first + self.kept) % self.places.len();
        self.places[place] = due;
        self.kept += 1;
    }

    /// Returns the set values of the present instant; none if none wait. Before the first of them lies a motion at its velocity.
    pub fn due(&mut self) -> Option<Kinematics> {
        while self.kept > 1 && self.at_place(1).at <= self.now {
            self.first = (self.first + 1) % self.places.len();
            self.kept -= 1;
        }
        if self.kept == 0 {
            return None;
        }
        let before = self.at_place(0);
        let since = (self.now - before.at).as_secs_f64();
        if since == 0.0 {
            return Some(before.set);
        }
        if since < 0.0 || self.kept == 1 {
            return Some(Kinematics {
                acceleration: 0.0,
                position: before.set.position + before.set.velocity * since,
                ..before.set
            });
        }
        let after = self.at_place(1);
        let gap = (after.at - before.at).as_secs_f64();
        let pace = 1.0 + before.gained_until(after);
        let [from, to] = [before, after].map(|one| at_pace(&one.set, pace));
        Some(between(
            &from,
            &to,
            gap,
            since / gap,
            Ends::WithAccelerations,
        ))
    }

    const fn at_place(&self, n: usize) -> &WaitingSet {
        &self.places[(self.first + n) % self.places.len()]
    }
}

impl WaitingSet {
    /// Share by which the motion up to `next` is shown faster than it was calculated, while the hold-back is slewed.
    ///
    /// An axis behind a far one is calculated the faster the more the hold-back grows, and is shown at its own pace. One that
    /// moves by itself is shown faster while the hold-back falls. Its own velocities at both ends, and another distance between them,
    /// would be a motion with 5.8 · rate · velocity / cycle of acceleration: at 0.93 ‰ and 349 mm/s some 1900 mm/s² (a swarm schedule).
    fn gained_until(&self, next: &Self) -> f64 {
        let gap = (next.at - self.at).as_secs_f64();
        let most = (next.passed.as_secs_f64() / gap - 1.0).clamp(-MOST_GAINED, MOST_GAINED);
        let mean = 0.5 * (self.set.velocity + next.set.velocity)
            + (self.set.acceleration - next.set.acceleration) * gap / 12.0;
        // The last of a motion that fades can be too small for a product, 1e-321 · 5e-4: nothing is moved in that gap.
        let way = mean * gap;
        if most == 0.0 || way == 0.0 {
            return 0.0;
        }
        let distance = next.set.position - self.set.position;
        (distance / way - 1.0).clamp(most.min(0.0), most.max(0.0))
    }
}

/// A state of a motion that is run through at this pace.
fn at_pace(set: &Kinematics, pace: f64) -> Kinematics {
    Kinematics {
        position: set.position,
        velocity: set.velocity * pace,
        acceleration: set.acceleration * pace * pace,
    }
}
