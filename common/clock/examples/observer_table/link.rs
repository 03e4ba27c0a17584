//! Properties of real links beside independent jitter: correlated delays, and hold-ups that keep back everything for
//! a while.

use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// A correlated delay on top of the jitter.
#[derive(Clone, Copy)]
pub(crate) enum Correlated {
    /// The magnitude of a first-order autoregressive process of this standard deviation and time
    /// constant, s.
    HalfNormal { width: f64, time: f64 },
    /// Two levels, `height` apart, held for exponentially distributed times of these means, s.
    Telegraph { height: f64, up: f64, down: f64 },
    /// Two levels, `height` apart, held for this time each, s.
    Levels { height: f64, held: f64 },
}

/// Power saving: an access point keeps messages back until its next beacon, and sends them one after the other then.
#[derive(Clone, Copy)]
pub(crate) struct PowerSaving {
    /// Period of the beacons, s.
    pub(crate) beacons: f64,
    /// Time of a message on the air, s.
    pub(crate) airtime: f64,
}

/// Follows [`PowerSaving`] through time.
pub(crate) struct Batches {
    kind: PowerSaving,
    /// The beacon of the newest message, and when that message was through, s.
    beacon: f64,
    through: f64,
}

impl Batches {
    pub(crate) const fn new(kind: PowerSaving) -> Self {
        Self {
            kind,
            beacon: 0.0,
            through: 0.0,
        }
    }

    /// Arrival of a message that reaches the access point at `arrived`. To be called in order.
    pub(crate) fn deliver(&mut self, arrived: f64) -> f64 {
        let beacon = (arrived / self.kind.beacons).ceil() * self.kind.beacons;
        self.beacon = self.beacon.max(beacon);
        // A queue: a batch that is not through by the next beacon delays the batch of that one.
        self.through = self.through.max(self.beacon) + self.kind.airtime;
        self.through
    }
}

/// Hold-ups at random times: what would arrive during one arrives at its end.
#[derive(Clone, Copy)]
pub(crate) struct HoldUps {
    pub(crate) per_second: f64,
    /// Length, s
    pub(crate) length: f64,
}

/// Follows a [`Correlated`] delay through time.
pub(crate) struct CorrelatedDelay {
    kind: Correlated,
    random: Xoshiro256PlusPlus,
    /// The autoregressive process, or the present level.
    value: f64,
    /// Remaining time of the present level.
    remaining: f64,
}

impl CorrelatedDelay {
    pub(crate) fn new(kind: Correlated, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x3333);
        let value = match kind {
            // Stationary from the first message on.
            Correlated::HalfNormal { width, .. } => width * normal(&mut random),
            // Makes the first step begin a time on the lower level.
            Correlated::Telegraph { height, .. } | Correlated::Levels { height, .. } => height,
        };
        Self {
            kind,
            random,
            value,
            remaining: 0.0,
        }
    }

    /// The delay `passed` seconds after the previous one.
    pub(crate) fn after(&mut self, passed: f64) -> f64 {
        match self.kind {
            Correlated::HalfNormal { width, time } => {
                let kept = (-passed / time).exp();
                // Keeps the process stationary, with `width` as its standard deviation.
                let fresh = width * (1.0 - kept * kept).sqrt();
                self.value = kept * self.value + fresh * normal(&mut self.random);
                self.value.abs()
            }
            Correlated::Telegraph { height, up, down } => {
                self.remaining -= passed;
                if self.remaining <= 0.0 {
                    self.value = height - self.value;
                    let mean = if self.value > 0.0 { up } else { down };
                    self.remaining = mean * exponential(&mut self.random);
                }
                self.value
            }
            Correlated::Levels { height, held } => {
                self.remaining -= passed;
                if self.remaining <= 0.0 {
                    self.value = height - self.value;
                    self.remaining += held;
                }
                self.value
            }
        }
    }
}

/// Follows [`HoldUps`] through time.
pub(crate) struct HoldUpTimes {
    kind: HoldUps,
    random: Xoshiro256PlusPlus,
    begin: f64,
}

impl HoldUpTimes {
    pub(crate) fn new(kind: HoldUps, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xCCCC);
        let begin = exponential(&mut random) / kind.per_second;
        Self {
            kind,
            random,
            begin,
        }
    }

    /// Real arrival of a message that would otherwise arrive at `arrived`. To be called in order.
    pub(crate) fn hold(&mut self, arrived: f64) -> f64 {
        // Over all hold-ups that ended before this message.
        while arrived >= self.begin + self.kind.length {
            let pause = exponential(&mut self.random) / self.kind.per_second;
            self.begin += self.kind.length + pause;
        }
        if arrived < self.begin {
            arrived
        } else {
            self.begin + self.kind.length
        }
    }
}

fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    StandardNormal.sample(random)
}

fn exponential(random: &mut Xoshiro256PlusPlus) -> f64 {
    Exp1.sample(random)
}
