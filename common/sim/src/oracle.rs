//! The oracle: the true motion of the master, also between its cycles.

use std::collections::VecDeque;

use coaxle_clock::{CycleTime, Domain, Instant, Remote, Seconds, Span};
use coaxle_curve::profile::Kinematics;

/// A cycle of a master: its state at the ideal start, on the reference clock `R`.
#[derive(Clone, Copy, Debug)]
pub struct TruthSample<R: Domain> {
    /// Ideal start of the cycle.
    pub at: Instant<R>,
    /// The sender's run.
    pub epoch: u64,
    /// The sender's cycle count.
    pub count: u64,
    /// The axis, with velocity and acceleration over the sender's own time.
    pub axis: Kinematics,
    /// Presentation delay that its frame states; zero without one.
    pub present_after: Span,
}

/// The master at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The sender's run.
    pub epoch: u64,
    /// Position, u.
    pub position: f64,
    /// Velocity, u/s of reference time.
    pub velocity: f64,
    /// Pace of the sender's own time, s per second of reference time.
    pub pace: f64,
    /// The sender's own ideal time: whole nanoseconds, and the fraction.
    far_time: Instant<Remote>,
    far_fraction: f64,
}

impl Truth {
    /// Lead of `far_time` over the true reading of the sender's clock.
    #[must_use]
    pub fn error_of(&self, far_time: Instant<Remote>) -> Seconds {
        // Subtracted as integers: a count of nanoseconds of days in f64 has lost its fraction.
        let whole = (far_time - self.far_time).as_nanos() as f64;
        Seconds((whole - self.far_fraction) * 1e-9)
    }

    /// The sender's own time since an earlier instant of the same run.
    #[must_use]
    pub fn seconds_since(&self, earlier: &Self) -> Seconds {
        let whole = (self.far_time - earlier.far_time).as_nanos() as f64;
        Seconds((whole + self.far_fraction - earlier.far_fraction) * 1e-9)
    }
}

/// Keeps the last few seconds of a master. Samples are added in order and queried in any order.
#[derive(Clone, Debug)]
pub struct Oracle<R: Domain> {
    cycle_time: CycleTime,
    memory: Span,
    samples: VecDeque<TruthSample<R>>,
}

/// Cycles that may be missing between two samples for the motion between them to be known.
const LARGEST_GAP: u64 = 20;

/// Number of newest samples that are searched first, because nearly all queries lie among them.
const NEAR: usize = 16;

impl<R: Domain> Oracle<R> {
    /// Creates an oracle for a sender with this nominal cycle time that keeps samples for `memory`.
    #[must_use]
    pub const fn new(cycle_time: CycleTime, memory: Span) -> Self {
        Self {
            cycle_time,
            memory,
            samples: VecDeque::new(),
        }
    }

    /// Adds the next cycle of the master.
    pub fn push(&mut self, sample: TruthSample<R>) {
        while self
            .samples
            .front()
            .is_some_and(|oldest| sample.at - oldest.at > self.memory)
        {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Latest known instant of the master.
    #[must_use]
    pub fn known_until(&self) -> Option<Instant<R>> {
        self.samples.back().map(|sample| sample.at)
    }

    /// The master at `at`; none before it began, after the last sample, and in gaps.
    #[must_use]
    pub fn at(&self, at: Instant<R>) -> Option<Truth> {
        let after = self.first_after(at);
        let place = after.checked_sub(1)?;
        let from = self.samples.get(place)?;
        match self.samples.get(after).filter(|to| is_known(from, to)) {
            Some(to) => Some(self.between(from, to, self.pace(from, to), at)),
            None => (from.at == at).then(|| self.between(from, from, self.pace_up_to(place), at)),
        }
    }

    /// Presentation delay of what is to be shown `left` after `at`: stated that delay before it is shown, as it belongs to the frame that states it. None where
    /// that is unknown.
    #[must_use]
    pub fn shown_after(&self, at: Instant<R>, left: Span) -> Option<Span> {
        let mut delay = self.stated_at(at)?;
        // It changes by less than a thousandth of the time: each step leaves so much of the error.
        for _ in 0..4 {
            delay = self.stated_at(at - (delay - left).max(Span::ZERO))?;
        }
        Some(delay)
    }

    /// Presentation delay of a frame at `at`, between those of its neighbours; that of the one before where it steps.
    fn stated_at(&self, at: Instant<R>) -> Option<Span> {
        let after = self.first_after(at);
        let from = self.samples.get(after.checked_sub(1)?)?;
        let before = from.present_after;
        let Some(to) = self.samples.get(after).filter(|to| is_known(from, to)) else {
            return Some(before);
        };
        let (change, length) = (to.present_after - before, to.at - from.at);
        if change == Span::ZERO || change.abs() * 500 > length {
            return Some(before);
        }
        let share = (at - from.at).as_secs_f64() / length.as_secs_f64();
        Some(before + Span::from_nanos((change.as_nanos() as f64 * share).round() as i64))
    }

    /// Pace up to a sample that nothing follows. In swarm schedule 61153 a receiver's cycle was due at the nanosecond of such a sample: with a pace of 1 a
    /// master that is shown 253 ms later was 66 µs off at 263 ppm.
    fn pace_up_to(&self, place: usize) -> f64 {
        let to = &self.samples[place];
        let before = place.checked_sub(1).map(|before| &self.samples[before]);
        let before = before.filter(|from| is_known(from, to));
        before.map_or(1.0, |from| self.pace(from, to))
    }

    /// The sender's own time between two samples over that of reference.
    fn pace(&self, from: &TruthSample<R>, to: &TruthSample<R>) -> f64 {
        let own = (to.count - from.count) as f64 * self.cycle_time.as_secs_f64();
        let length = (to.at - from.at).as_secs_f64();
        // Without a length there is none to compare.
        if length > 0.0 { own / length } else { 1.0 }
    }

    /// The number of the first sample after `at`.
    fn first_after(&self, at: Instant<R>) -> usize {
        let newest = self.samples.iter().rev().take(NEAR);
        match newest.take_while(|sample| sample.at > at).count() {
            // All of the near ones are later: only now is a search of the whole memory due.
            NEAR => self.samples.partition_point(|sample| sample.at <= at),
            later => self.samples.len() - later,
        }
    }

    fn between(
        &self,
        from: &TruthSample<R>,
        to: &TruthSample<R>,
        pace: f64,
        at: Instant<R>,
    ) -> Truth {
        let length = (to.at - from.at).as_secs_f64();
        let share = if length > 0.0 {
            (at - from.at).as_secs_f64() / length
        } else {
            0.0
        };
        let cycle = self.cycle_time.span().as_nanos();
        let cycles = (to.count - from.count) as f64;
        // Velocities are those of the sender's own time. Taken for those of reference time, at a drift of 800 ppm they led the curve of a
        // master at 500 mm/s and 10 ms off by 0.6 µm between two cycles, and its velocity by 0.4 mm/s.
        let own_length = cycles * self.cycle_time.as_secs_f64();
        let (position, own_velocity) = hermite(&from.axis, &to.axis, own_length, share);
        // Linear in the sender's time between two cycles: a change of its drift within milliseconds is far below a nanosecond.
        let beyond = share * cycles * cycle as f64;
        Truth {
            epoch: from.epoch,
            position,
            velocity: own_velocity * pace,
            pace,
            // Whole cycles exactly, the rest in a float that stays small.
            far_time: Instant::from_nanos(cycle * from.count as i64 + beyond.trunc() as i64),
            far_fraction: beyond.fract(),
        }
    }
}

/// True if the motion between two samples is known: not across runs, and not over a gap.
fn is_known<R: Domain>(from: &TruthSample<R>, to: &TruthSample<R>) -> bool {
    from.epoch == to.epoch && to.count - from.count <= LARGEST_GAP
}

/// The quintic through both states; exact for constant velocity and constant acceleration.
fn hermite(from: &Kinematics, to: &Kinematics, length: f64, x: f64) -> (f64, f64) {
    // The last sample alone, between itself.
    if length <= 0.0 {
        return (from.position, from.velocity);
    }
    let (c1, c2) = (
        from.velocity * length,
        0.5 * from.acceleration * length * length,
    );
    // Conditions at x = 1 minus what the terms up to x² already fulfil: position d, slope e, second derivative f.
    let d = to.position - from.position - c1 - c2;
    let e = to.velocity * length - c1 - 2.0 * c2;
    let f = to.acceleration * length * length - 2.0 * c2;
    let c3 = 10.0 * d - 4.0 * e + 0.5 * f;
    let c4 = -15.0 * d + 7.0 * e - f;
    let c5 = 6.0 * d - 3.0 * e + 0.5 * f;
    let position = from.position + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))));
    let slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)));
    (position, slope / length)
}

#[cfg(test)]
mod tests;
