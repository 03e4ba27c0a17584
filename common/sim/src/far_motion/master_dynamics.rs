//! Dynamics of a master, by its frames.

use super::{FarMotion, Received};
use crate::largest_lately::LargestLately;

/// Time for which unexpected motions of the master are remembered, s: between one and two of these. A receiver remembers them for
/// up to 2 s. With 1 s the check forgot a forged position while the receiver still took it into account (wide schedule 503740).
const MEMORY: f64 = 2.0;
/// Greatest distance of neighbouring frames, cycles of the master: some are always lost.
const NEXT: f64 = 4.5;
/// Frames after which the dynamics of the master are known.
const KNOWN: u8 = 16;

/// Greatest velocity and acceleration of a master, and the motion in its frames that these do not explain.
#[derive(Clone, Copy, Debug)]
pub(super) struct MasterDynamics {
    /// The frame before the newest, and its acceleration there if the frame before that arrived, too.
    frame: Option<Received>,
    at_frame: Option<f64>,
    pub(super) fastest: f64,
    pub(super) acceleration: f64,
    pub(super) corrections: LargestLately,
    /// Changes of accelerations and velocities from frame to frame, and mismatch of positions and
    /// velocities.
    acceleration_noise: LargestLately,
    velocity_noise: LargestLately,
    position_noise: LargestLately,
    /// Distances from frame to frame, as seen here.
    pub(super) received_steps: LargestLately,
    frames: u8,
}

impl MasterDynamics {
    pub(super) fn new() -> Self {
        Self {
            frame: None,
            at_frame: None,
            fastest: 0.0,
            acceleration: 0.0,
            corrections: LargestLately::over(MEMORY),
            acceleration_noise: LargestLately::over(MEMORY),
            velocity_noise: LargestLately::over(MEMORY),
            position_noise: LargestLately::over(MEMORY),
            received_steps: LargestLately::over(MEMORY),
            frames: 0,
        }
    }

    /// True if bounds can be taken from it: those of too few frames are of chance.
    pub(super) const fn is_known(&self) -> bool {
        self.frames >= KNOWN
    }

    /// Learns from the newest frame.
    pub(super) fn learn(&mut self, now: &FarMotion, passed: f64) {
        self.corrections
            .push(now.correction.unwrap_or(0.0).abs(), passed);
        let frame = now.received;
        // Greatest ever, not the newest: an axis may still be on its way from a fast phase of its master.
        self.fastest = self.fastest.max(frame.velocity.abs());
        self.fastest = self.fastest.max(now.promised.unwrap_or(0.0).abs());
        // Set values are extrapolated with the stated one, too: the first frame of a motion may have no velocity yet (swarm schedule 484).
        self.acceleration = self.acceleration.max(frame.acceleration.abs());
        let mut seen = [0.0; 4];
        if let Some(before) = self.frame.replace(frame)
            && before.run == frame.run
            // Frames of other runs, repeated and overtaken ones have no difference that is a motion.
            && frame.at > before.at
        {
            let time = frame.at - before.at;
            let rate = (frame.velocity - before.velocity) / time;
            let changed = rate.abs() * time;
            let way = frame.position - before.position;
            let mean = 0.5 * (frame.velocity + before.velocity);
            self.acceleration = self.acceleration.max(rate.abs());
            // Velocities between these two explain at most this much (the trapezoidal rule); the
            // rest is a jump.
            let explained = 0.25 * self.acceleration * time * time;
            let beside = ((way - mean * time).abs() - explained).max(0.0);
            // Over a gap the velocity may change arbitrarily.
            let is_next = time < NEXT * frame.cycle_time;
            self.frames = KNOWN.min(self.frames + 1);
            let at_frame = is_next.then_some(rate);
            let turned = match (self.at_frame, at_frame) {
                (Some(before), Some(now)) => (now - before).abs(),
                _ => 0.0,
            };
            self.at_frame = at_frame;
            seen = [
                turned,
                if is_next { changed } else { 0.0 },
                beside,
                way.abs(),
            ];
        }
        let [turned, changed, beside, step] = seen;
        self.acceleration_noise.push(turned, passed);
        self.velocity_noise.push(changed, passed);
        self.position_noise.push(beside, passed);
        self.received_steps.push(step, passed);
    }

    /// Unexplained motion in its frames, extrapolated by the correction, u.
    pub(super) fn noise(&self) -> f64 {
        let correction = self.corrections.largest();
        // Both ends of a step are off by it.
        2.0 * self.position_noise.largest()
            + self.velocity_noise.largest() * correction
            + self.acceleration_noise.largest() * correction * correction
    }
}
