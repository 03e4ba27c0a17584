//! A clock that deviates from its reference.

use std::collections::VecDeque;

use coaxle_clock::{Domain, Instant, Local, Span};

use super::random::Random;
use super::terms::Terms;
use crate::config::{ClockConfig, DriftStep, JitterConfig, Wrong};

/// Length of the straight pieces of a varying drift.
// Fine enough for a sine of a second: the mean of a piece differs from its middle by (2π · 0.01)²/24, 0.02 %.
const WANDERING_PIECE: Span = Span::from_millis(10);
/// Length of the pieces of a constant drift, which only keep its numbers small.
// 60 s · 0.1 of drift are 6 · 10⁹ ns, exact in a float.
const STEADY_PIECE: Span = Span::from_secs(60);
/// Limit of the sum of all deviations: no clock stands still or runs backwards.
// The limits of the single fields come to it in sum: 100 000 of drift and sine each, and 300 000 of terms.
const MOST_PPM: f64 = 500_000.0;
/// Pieces kept for instants of the past: at least five seconds' worth.
// 512 · 10 ms.
const HISTORY: usize = 512;

/// A node's clock: a reference clock `R` (true time, or the machine's monotonic clock) with a
/// deviation. Local time is zero at the origin and consists of straight pieces, continuous or with
/// jumps between them.
#[derive(Clone, Debug)]
pub struct DeviatedClock<R: Domain> {
    config: ClockConfig,
    random: Random,
    origin: Instant<R>,
    /// Integral of the random walk, ppm.
    walk_ppm: f64,
    terms: Terms,
    pieces: VecDeque<Piece>,
}

/// A straight piece: from `reference` on, local time runs `1 + rate` times as fast as the reference.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Start, since the origin, on the reference clock.
    reference: Span,
    /// Start on the local clock.
    local: Span,
    /// The part of `local` below a nanosecond, so that rounding never adds up.
    local_fraction: f64,
    rate: f64,
    length: Span,
    /// The latest local time reached by its end. Only a jump back makes it differ from its own end.
    reached: Span,
}

impl Piece {
    fn local_at(&self, reference: Span) -> Span {
        let passed = reference - self.reference;
        // Only the gain is a float, which would not hold whole nanoseconds beyond 2⁵³, 104 days.
        self.local + passed + self.gained(passed)
    }

    fn gained(&self, passed: Span) -> Span {
        let nanos = passed.as_nanos() as f64 * self.rate + self.local_fraction;
        Span::from_nanos(nearest(nanos) as i64)
    }

    fn reference_at(&self, local: Span) -> Span {
        let passed = (local - self.local).as_nanos() as f64 - self.local_fraction;
        // x/(1+r) = x − x·r/(1+r): only the small second term is rounded.
        let lost = passed * self.rate / (1.0 + self.rate);
        let reference = self.reference + (local - self.local)
            - Span::from_nanos(nearest(lost + self.local_fraction) as i64);
        // Local instants skipped by a jump forward all happen at the jump.
        reference.clamp(self.reference, self.end())
    }

    fn end(&self) -> Span {
        self.reference + self.length
    }
}

impl<R: Domain> DeviatedClock<R> {
    /// Creates the clock that reads zero at `origin`. Random parts are drawn from `seed`. Reads the
    /// files of terms.
    ///
    /// # Errors
    /// [`Wrong`] names the term whose file cannot be used.
    pub fn new(config: &ClockConfig, seed: u64, origin: Instant<R>) -> Result<Self, Wrong> {
        let mut clock = Self {
            config: config.clone(),
            random: Random::new(seed),
            origin,
            walk_ppm: 0.0,
            terms: Terms::of_clock(config, seed)?,
            pieces: VecDeque::with_capacity(HISTORY),
        };
        clock.push_piece(Span::ZERO, Span::ZERO, 0.0);
        Ok(clock)
    }

    /// Moves the origin of a clock that has not been read yet.
    pub const fn start_at(&mut self, origin: Instant<R>) {
        self.origin = origin;
    }

    /// Reading of this clock at an instant of the reference. Instants may lie back by a few
    /// seconds; further back the oldest known rate is assumed.
    pub fn local_at(&mut self, reference: Instant<R>) -> Instant<Local> {
        let since = reference - self.origin;
        while since >= self.newest().end() {
            // Pieces are made in order, whatever is asked: the random walk has one value for each.
            self.extend();
        }
        let begun = self.number_until(|piece| piece.reference <= since);
        // An instant before the oldest piece is calculated with that one.
        Instant::EPOCH + self.pieces[begun.saturating_sub(1)].local_at(since)
    }

    /// Instant of the reference at which this clock reads `local`, the first one if a jump back
    /// repeats the reading.
    pub fn reference_at(&mut self, local: Instant<Local>) -> Instant<R> {
        let local = local.since_epoch();
        while self.newest().reached <= local {
            self.extend();
        }
        // By the greatest reading so far: after a jump back the first reading counts.
        let first = self.number_until(|piece| piece.reached <= local);
        self.origin + self.pieces[first].reference_at(local)
    }

    /// The drift at the newest instant evaluated, ppm.
    #[must_use]
    pub fn drift_ppm(&self) -> f64 {
        self.newest().rate * 1e6
    }

    /// Number of pieces up to the last one for which this holds: nearly all instants lie in the newest.
    fn number_until(&self, holds: impl Fn(&Piece) -> bool) -> usize {
        let newest_first = self.pieces.iter().rev();
        self.pieces.len() - newest_first.take_while(|piece| !holds(piece)).count()
    }

    fn newest(&self) -> &Piece {
        self.pieces.back().expect("a clock has at least one piece")
    }

    fn extend(&mut self) {
        let last = *self.newest();
        let exact = last.length.as_nanos() as f64 * last.rate + last.local_fraction;
        let gained = nearest(exact);
        // The rest below a nanosecond goes on in the next piece.
        let mut local = last.local + last.length + Span::from_nanos(gained as i64);
        for step in &self.config.steps {
            // Exactly equal: pieces end at every step.
            if step_instant(step) == last.end() {
                local += step.phase_us.span();
            }
        }
        self.push_piece(last.end(), local, exact - gained);
    }

    fn push_piece(&mut self, reference: Span, local: Span, local_fraction: f64) {
        let length = self.length_from(reference);
        let rate = self.rate_from(reference, length) * 1e-6;
        let mut piece = Piece {
            reference,
            local,
            local_fraction,
            rate,
            length,
            reached: local,
        };
        piece.reached = piece.local_at(piece.end());
        if let Some(last) = self.pieces.back() {
            piece.reached = piece.reached.max(last.reached);
        }
        if self.pieces.len() == HISTORY {
            self.pieces.pop_front();
        }
        self.pieces.push_back(piece);
    }

    /// Pieces end at every step, so that a step is exact.
    fn length_from(&self, start: Span) -> Span {
        let wanders = self.config.random_walk_ppm.get() > 0.0
            || self.config.sine.is_some()
            || !self.terms.is_constant();
        let piece = if wanders {
            WANDERING_PIECE
        } else {
            STEADY_PIECE
        };
        self.config
            .steps
            .iter()
            .map(|step| step_instant(step) - start)
            // Steps of the past, and the one that begins this piece, end nothing.
            .filter(|until| *until > Span::ZERO)
            .fold(piece, Span::min)
    }

    fn rate_from(&mut self, start: Span, length: Span) -> f64 {
        // The middle of the piece: the linear part of a change falls out.
        let middle = (start + length / 2).as_secs_f64();
        let steps: f64 = self
            .config
            .steps
            .iter()
            .filter(|step| step_instant(step) <= start)
            .map(|step| step.drift_ppm.get())
            .sum();
        let sine = self.config.sine.map_or(0.0, |sine| {
            let turn = core::f64::consts::TAU * middle / sine.period_s.get();
            sine.amplitude_ppm.get() * libm::sin(turn)
        });
        let walk = self.config.random_walk_ppm.get();
        if walk > 0.0 {
            // The variance of a random walk grows with time: its step with the root of it.
            self.walk_ppm += walk * length.as_secs_f64().sqrt() * self.random.normal();
        }
        let sum = self.config.drift_ppm.get() + steps + sine + self.walk_ppm;
        let end = (start + length).as_secs_f64();
        // Terms have their exact mean: a pulse shorter than a piece is not missed.
        let sum = sum + self.terms.mean(start.as_secs_f64(), end);
        sum.clamp(-MOST_PPM, MOST_PPM)
    }
}

/// The nearest whole number; ties go to the even one. Without a library call for the usual gains of
/// clocks: from `WHOLE_FROM` on, all f64 values are whole numbers.
fn nearest(nanos: f64) -> f64 {
    const WHOLE_FROM: f64 = (1_u64 << 52) as f64;
    const UP: f64 = 1.5 * WHOLE_FROM;
    if nanos.abs() < 0.5 * WHOLE_FROM {
        // From 2⁵² to 2⁵³ a float has no fraction: adding rounds to the nearest whole number, ties to even.
        (nanos + UP) - UP
    } else {
        nanos.round_ties_even()
    }
}

fn step_instant(step: &DriftStep) -> Span {
    step.at_s.span()
}

/// Jitter of each wake-up around its ideal instant.
#[derive(Clone, Debug)]
pub struct CycleJitter {
    jitter: Option<JitterConfig>,
    random: Random,
}

impl CycleJitter {
    /// The jitter of a clock, drawn from `seed`.
    #[must_use]
    pub fn new(config: &ClockConfig, seed: u64) -> Self {
        Self {
            jitter: config.jitter,
            random: Random::new(seed),
        }
    }

    /// Deviation of the next wake-up; may be negative.
    #[expect(
        clippy::should_implement_trait,
        reason = "an endless source, not an iterator"
    )]
    pub fn next(&mut self) -> Span {
        match &self.jitter {
            // Drawn only where there is jitter: a clock without it uses no numbers.
            Some(jitter) => Span::from_micros_f64(self.random.jitter_us(jitter)),
            None => Span::ZERO,
        }
    }
}

#[cfg(test)]
mod tests;
