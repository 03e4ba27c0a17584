//! A sender with a wandering clock and a link with jitter, in virtual time. The receiver's clock is
//! the true one.

use crate::link::{Batches, Correlated, CorrelatedDelay, HoldUpTimes, HoldUps, PowerSaving};
use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

#[derive(Clone, Copy)]
pub(crate) struct Case {
    pub(crate) cycle: f64,
    pub(crate) sender_jitter: f64,
    pub(crate) network_jitter: f64,
    pub(crate) stamp_noise: Option<f64>,
    pub(crate) walk: f64,
    pub(crate) loss: f64,
    pub(crate) spikes: f64,
    pub(crate) in_order: bool,
    pub(crate) seconds: f64,
    /// Time and size of a step of the drift.
    pub(crate) drift_step: Option<(f64, f64)>,
    /// Time and size of a step of the delay.
    pub(crate) delay_step: Option<(f64, f64)>,
    /// Beginning and end of other network jitter, and the factor on it.
    pub(crate) load: Option<(f64, f64, f64)>,
    /// Stalls per second that hold up everything for 2 to 10 ms.
    pub(crate) stalls: f64,
    /// Width and time constant of an autoregressive delay, s.
    pub(crate) ar_delay: Option<(f64, f64)>,
    /// A correlated delay on top of the jitter.
    pub(crate) correlated: Option<Correlated>,
    pub(crate) hold_ups: Option<HoldUps>,
    pub(crate) power_saving: Option<PowerSaving>,
    /// Grid of the arrivals seen, rounded down, s.
    pub(crate) arrival_grid: Option<f64>,
    /// Amplitude and period of a swinging drift, s/s and s.
    pub(crate) sine_drift: Option<(f64, f64)>,
    /// Gain of the sender's clock, s/s, and the period, s, in whose last second its servo takes that back.
    pub(crate) servo: Option<(f64, f64)>,
    /// Replacement of all jitter by the result of an efficient estimator, normal noise of this width.
    pub(crate) efficient: Option<f64>,
}

impl Case {
    pub(crate) const fn new(sender_us: f64, network_us: f64, stamps: bool) -> Self {
        Self {
            cycle: 1e-3,
            sender_jitter: sender_us * 1e-6,
            network_jitter: network_us * 1e-6,
            stamp_noise: if stamps { Some(1e-6) } else { None },
            walk: 1e-8,
            loss: 0.01,
            spikes: 1e-4,
            in_order: true,
            seconds: 240.0,
            drift_step: None,
            delay_step: None,
            load: None,
            stalls: 0.0,
            ar_delay: None,
            correlated: None,
            hold_ups: None,
            power_saving: None,
            arrival_grid: None,
            sine_drift: None,
            servo: None,
            efficient: None,
        }
    }

    /// Arrivals at a busy PC without real-time priority: send stamps, but 10 µs of normal and
    /// `network_us` of exponential jitter after them, outliers and hold-ups.
    pub(crate) const fn busy(network_us: f64) -> Self {
        Self {
            stamp_noise: Some(10e-6),
            spikes: 1e-2,
            stalls: 1.0,
            seconds: 60.0,
            ..Self::new(100.0, network_us, true)
        }
    }

    /// Busy arrivals where queues and sleeping cores correlate the delays of consecutive messages, as measured
    /// between processes on one busy PC.
    pub(crate) const fn correlated_delay() -> Self {
        Self {
            ar_delay: Some((15e-6, 0.3)),
            ..Self::busy(75.0)
        }
    }

    /// True if [`bound`] holds: independent jitter and a drift that does nothing but wander.
    pub(crate) const fn has_bound(&self) -> bool {
        let undisturbed = self.stalls == 0.0 && self.hold_ups.is_none() && self.load.is_none();
        let independent = self.ar_delay.is_none() && self.correlated.is_none();
        let steady =
            self.drift_step.is_none() && self.delay_step.is_none() && self.sine_drift.is_none();
        let steady = steady && self.servo.is_none() && self.power_saving.is_none();
        undisturbed && independent && steady && self.arrival_grid.is_none()
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Message {
    pub(crate) count: i64,
    /// Arrival, ns
    pub(crate) arrived: i64,
    /// Send stamp, ns
    pub(crate) stamp: Option<i64>,
}

/// A time request and its response, ns: when the one left and the other arrived on the local clock (`t1`, `t4`),
/// and when the one arrived and the other left on the sender's (`t2`, `t3`).
#[allow(dead_code, reason = "for followers that use exchanges")]
#[derive(Clone, Copy)]
pub(crate) struct Exchange {
    pub(crate) t1: i64,
    pub(crate) t2: i64,
    pub(crate) t3: i64,
    pub(crate) t4: i64,
}

impl Exchange {
    /// Sets both clocks forward.
    pub(crate) const fn moved(self, local: i64, far: i64) -> Self {
        Self {
            t1: self.t1 + local,
            t2: self.t2 + far,
            t3: self.t3 + far,
            t4: self.t4 + local,
        }
    }
}

pub(crate) struct Run {
    /// Messages in the order of their arrival.
    pub(crate) messages: Vec<Message>,
    /// Exchanges in the order of `t4`. Generated runs have none.
    pub(crate) exchanges: Vec<Exchange>,
    /// Due time of each count, s.
    due: Vec<f64>,
    cycle: f64,
}

pub(crate) const MIN_DELAY: f64 = 300e-6;

impl Run {
    pub(crate) fn new(case: &Case, seed: u64) -> Self {
        let mut random =
            Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        let mut uniform = {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5555);
            move || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
        };
        // Log-uniform 1 to 100 ppm, either sign.
        let size = 1e-6 * 100f64.powf(uniform());
        let mut drift = if uniform() < 0.5 { size } else { -size };
        let cycles = (case.seconds / case.cycle) as i64 + 20;
        let step_walk = case.walk * case.cycle.sqrt();
        let mut due = Vec::with_capacity(cycles as usize);
        let mut messages = Vec::with_capacity(cycles as usize);
        // At any phase of the receiver's cycle.
        let mut now = 0.0123 + uniform() * case.cycle;
        let (mut stepped, mut last, mut delayed) = (false, 0.0_f64, 0.0);
        let mut correlated = case.correlated.map(|kind| CorrelatedDelay::new(kind, seed));
        let mut hold_ups = case.hold_ups.map(|kind| HoldUpTimes::new(kind, seed));
        let mut batches = case.power_saving.map(Batches::new);
        let mut other = {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xAAAA);
            move || -> f64 { StandardNormal.sample(&mut random) }
        };
        for count in 0..cycles {
            due.push(now);
            let normal = |random: &mut Xoshiro256PlusPlus| -> f64 { StandardNormal.sample(random) };
            let late = case.sender_jitter * normal(&mut random);
            let exponential: f64 = Exp1.sample(&mut random);
            let load = case.load.map_or(1.0, |(from, to, times)| {
                if (from..to).contains(&now) {
                    times
                } else {
                    1.0
                }
            });
            let mut arrived = now + late + MIN_DELAY + load * case.network_jitter * exponential;
            if let Some((width, time)) = case.ar_delay {
                let kept = (-case.cycle / time).exp();
                delayed = kept * delayed + width * (1.0 - kept * kept).sqrt() * other();
                arrived += delayed;
            }
            if let Some(delay) = &mut correlated {
                arrived += delay.after(case.cycle);
            }
            let stamp = case
                .stamp_noise
                .filter(|_| case.efficient.is_none())
                .map(|noise| ((late + noise * normal(&mut random)) * 1e9).round() as i64);
            if let Some((at, by)) = case.delay_step
                && now > at
            {
                arrived += by;
            }
            let spike = uniform();
            let size = uniform();
            if spike < case.spikes {
                arrived += 1e-3 + 4e-3 * size;
            } else if spike > 1.0 - case.stalls * case.cycle {
                arrived += 2e-3 + 8e-3 * size;
            }
            if let Some(width) = case.efficient {
                arrived = now + MIN_DELAY + width / case.sender_jitter * late;
            }
            if let Some(hold_ups) = &mut hold_ups {
                arrived = hold_ups.hold(arrived);
            }
            if case.in_order && case.efficient.is_none() {
                arrived = arrived.max(last);
                last = arrived;
            }
            if let Some(batches) = &mut batches {
                arrived = batches.deliver(arrived);
            }
            if let Some(grid) = case.arrival_grid {
                arrived = (arrived / grid).floor() * grid;
            }
            let lost = uniform() < case.loss;
            if !lost {
                messages.push(Message {
                    count,
                    arrived: (arrived * 1e9).round() as i64,
                    stamp,
                });
            }
            drift += step_walk * normal(&mut random);
            if let Some((at, by)) = case.drift_step
                && now > at
                && !stepped
            {
                stepped = true;
                drift += by;
            }
            let swing = case.sine_drift.map_or(0.0, |(size, period)| {
                size * (std::f64::consts::TAU * now / period).sin()
            });
            let servo = case.servo.map_or(0.0, |(rate, period)| {
                // In the last second of a period the servo takes back what the clock gained in the others.
                let is_back = now.rem_euclid(period) > period - 1.0;
                if is_back { rate - rate * period } else { rate }
            });
            now += case.cycle * (1.0 + drift + swing - servo);
        }
        messages.sort_by_key(|message| message.arrived);
        Self::of_parts(messages, due, case.cycle)
    }

    /// Makes a run from messages in the order of their arrival and the due time of each count, s.
    pub(crate) const fn of_parts(messages: Vec<Message>, due: Vec<f64>, cycle: f64) -> Self {
        Self {
            messages,
            exchanges: Vec::new(),
            due,
            cycle,
        }
    }

    /// Due time of a count, s.
    pub(crate) fn due(&self, count: usize) -> Option<f64> {
        self.due.get(count).copied()
    }

    /// Cycle time, s
    pub(crate) const fn cycle(&self) -> f64 {
        self.cycle
    }

    /// The sender's rate against the local clock at local time `now`, ppm.
    pub(crate) fn drift_ppm(&self, now: f64) -> f64 {
        let k = self.count_at(now);
        (self.cycle / (self.due[k + 1] - self.due[k]) - 1.0) * 1e6
    }

    /// The far time, s, at local time `now`.
    pub(crate) fn far(&self, now: f64) -> f64 {
        let k = self.count_at(now);
        let part = (now - self.due[k]) / (self.due[k + 1] - self.due[k]);
        (k as f64 + part) * self.cycle
    }

    /// The count that was last due at local time `now`; the last but one at the end of the run.
    fn count_at(&self, now: f64) -> usize {
        let guess = ((now - self.due[0]) / self.cycle) as isize;
        let mut k = guess.clamp(0, self.due.len() as isize - 2) as usize;
        while k > 0 && self.due[k] > now {
            k -= 1;
        }
        while k + 2 < self.due.len() && self.due[k + 1] <= now {
            k += 1;
        }
        k
    }
}

/// The Bayesian Cramér–Rao bound of the ripple, s: a drift that wanders, observed through a location
/// parameter with the Fisher information of the jitter.
pub(crate) fn bound(case: &Case) -> f64 {
    let width = efficient_width(case);
    // Spectral density of the measurements: one of this variance in each cycle that is not lost.
    let noise = case.cycle * width * width / (1.0 - case.loss);
    // Steady state of the Kalman–Bucy filter of a drift that walks: √2·q^¼·r^¾ is its variance of the offset.
    (2f64.sqrt() * case.walk.sqrt() * noise.powf(0.75)).sqrt()
}

/// The width of the normal jitter that says as much of its location as the jitter of a case, s.
pub(crate) fn efficient_width(case: &Case) -> f64 {
    let sigma = case.stamp_noise.unwrap_or(case.sender_jitter);
    let tau = case.network_jitter;
    let density = |e: f64| -> f64 {
        let z = e / sigma - sigma / tau;
        let below = 0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2);
        (0.5 * (sigma / tau).powi(2) - e / tau).exp() * below / tau
    };
    // Fiftieth of the narrower part: the information is then right to three digits.
    let step = 0.02 * sigma.min(tau);
    let (mut information, mut e) = (0.0, -8.0 * sigma);
    while e < 8.0 * sigma + 20.0 * tau {
        let slope = (density(e + step) - density(e - step)) / (2.0 * step);
        let here = density(e);
        if here > 1e-30 {
            information += slope * slope / here * step;
        }
        e += step;
    }
    information.sqrt().recip()
}
