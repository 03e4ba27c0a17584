//! The encoder master, and the methods without one.

use coaxle_clock::{Seconds, Span};
use coaxle_remote::{EncoderMaster, EncoderOutput, EncoderParameters, EncoderSample};

use crate::world::{CYCLE, Case};

/// Calculates a position from counts.
pub trait Follower {
    /// Runs one cycle; returns the position `horizon` seconds after the newest count.
    fn update(&mut self, count: Option<i64>, horizon: f64) -> f64;

    /// Further output of this cycle.
    fn output(&self) -> Option<EncoderOutput> {
        None
    }
}

/// The parameters that a user sets for a run: the increment, its speed, and the vibration where
/// there is any.
pub fn parameters(case: &Case) -> EncoderParameters {
    EncoderParameters {
        increment: case.increment,
        // 2000 mm/s, the largest of the table, with its spread of 4 % and a ripple of 1 % on top, rounded.
        max_speed: 2_100.0,
        vibration: case.vibration * case.increment,
        ..EncoderParameters::default()
    }
}

pub struct Conditioned {
    master: EncoderMaster,
    missed: u32,
    output: EncoderOutput,
}

impl Conditioned {
    pub fn new(parameters: EncoderParameters) -> Self {
        let checked = parameters.checked(Span::from_millis(1)).unwrap();
        Self {
            master: EncoderMaster::new(&checked),
            missed: 0,
            output: EncoderOutput::default(),
        }
    }
}

impl Follower for Conditioned {
    fn update(&mut self, count: Option<i64>, horizon: f64) -> f64 {
        self.missed += 1;
        let sample = count.map(|count| EncoderSample::next(count as u64).after(self.missed));
        if sample.is_some() {
            self.missed = 0;
        }
        self.output = self.master.update(sample, Seconds(horizon), 1);
        self.output.set.position
    }

    fn output(&self) -> Option<EncoderOutput> {
        Some(self.output)
    }
}

/// The newest count, moved by the difference of the last two.
#[derive(Debug, Default)]
pub struct Differences {
    increment: f64,
    last: Option<f64>,
    velocity: f64,
    gap: f64,
}

impl Differences {
    pub fn new(increment: f64) -> Self {
        Self {
            increment,
            ..Self::default()
        }
    }
}

impl Follower for Differences {
    fn update(&mut self, count: Option<i64>, horizon: f64) -> f64 {
        self.gap += CYCLE;
        if let Some(count) = count {
            // The middle of an increment is the mean of all positions with this count.
            let position = (count as f64 + 0.5) * self.increment;
            let last = self.last.replace(position).unwrap_or(position);
            self.velocity = (position - last) / self.gap;
            self.gap = 0.0;
        }
        self.last.unwrap_or(0.0) + self.velocity * horizon
    }
}

/// Differences through a PT1 filter, as in an encoder axis of a PLC; the velocity compensates the lag.
#[derive(Debug)]
pub struct Pt1 {
    raw: Differences,
    time: f64,
    state: Option<(f64, f64)>,
}

impl Pt1 {
    pub fn new(increment: f64, time: f64) -> Self {
        Self {
            raw: Differences::new(increment),
            time,
            state: None,
        }
    }
}

impl Follower for Pt1 {
    fn update(&mut self, count: Option<i64>, horizon: f64) -> f64 {
        let now = self.raw.update(count, horizon);
        let share = 1.0 - (-CYCLE / self.time).exp();
        let (p, v) = self.state.unwrap_or((now, 0.0));
        // Lag of the discrete filter with the share s on a ramp: T·((1 - s) + (1 - s)² + …) = T·(1/s - 1).
        let lag = CYCLE * (1.0 / share - 1.0);
        let next = (p + share * (now - p), v + share * (self.raw.velocity - v));
        self.state = Some(next);
        next.0 + next.1 * lag
    }
}

/// A loop of position and velocity, with both poles at the same bandwidth, rad/s.
#[derive(Debug)]
pub struct AlphaBeta {
    increment: f64,
    bandwidth: f64,
    state: Option<(f64, f64)>,
    gap: f64,
}

impl AlphaBeta {
    pub const fn new(increment: f64, bandwidth: f64) -> Self {
        Self {
            increment,
            bandwidth,
            state: None,
            gap: 0.0,
        }
    }
}

impl Follower for AlphaBeta {
    fn update(&mut self, count: Option<i64>, horizon: f64) -> f64 {
        self.gap += CYCLE;
        if let Some(count) = count {
            let position = (count as f64 + 0.5) * self.increment;
            let pole = (-self.bandwidth * self.gap).exp();
            let (p, v) = self.state.unwrap_or((position, 0.0));
            let predicted = p + v * self.gap;
            let error = position - predicted;
            // α = 1 - z² and β = (1 - z)² place both poles at z, the critically damped loop.
            let beta = (1.0 - pole) * (1.0 - pole);
            self.state = Some((
                predicted + (1.0 - pole * pole) * error,
                v + beta / self.gap * error,
            ));
            self.gap = 0.0;
        }
        let (p, v) = self.state.unwrap_or((0.0, 0.0));
        p + v * horizon
    }
}
