//! An axis that is only measured, in increments.

use std::collections::VecDeque;

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;

use crate::config::EncoderConfig;
use crate::program::MotionProgram;
use crate::source::{Activity, AxisSource, SourceSample};

/// An axis measured by an encoder: its controller only knows a number of increments.
///
/// Velocity is the difference quotient of such numbers, acceleration either zero or the difference
/// quotient of those. Neither is good enough for extrapolation with an acceleration.
#[derive(Debug)]
pub struct EncoderSource {
    moved_by: MotionProgram,
    resolution: f64,
    differentiate_acceleration: bool,
    window: usize,
    /// The newest readings, oldest first: at most one more than the window.
    readings: VecDeque<EncoderReading>,
}

#[derive(Clone, Copy, Debug)]
struct EncoderReading {
    at: Span,
    increments: f64,
    /// Velocity; none of a first reading.
    velocity: Option<f64>,
}

impl EncoderSource {
    /// Makes the encoder on an axis at the start of its program.
    #[must_use]
    pub fn new(config: &EncoderConfig) -> Self {
        let window = usize::from(config.velocity_window_cycles.get());
        Self {
            moved_by: MotionProgram::new(&config.program),
            resolution: config.resolution.get(),
            differentiate_acceleration: config.differentiate_acceleration,
            window,
            // Sized once: sampling must not allocate.
            readings: VecDeque::with_capacity(window + 1),
        }
    }

    /// Returns the values in the controller for an encoder at `position`.
    fn read(&mut self, at: Span, position: f64) -> Kinematics {
        // A counter holds the last increment passed.
        let increments = (position / self.resolution).floor();
        let (velocity, acceleration) = match self.readings.front() {
            // A repeated instant has no difference quotient.
            Some(oldest) if at > oldest.at => {
                let elapsed = (at - oldest.at).as_secs_f64();
                let travelled = (increments - oldest.increments) * self.resolution;
                let velocity = travelled / elapsed;
                // The older velocity is a mean over a window before it, so that this acceleration is late by a whole
                // window. From a velocity that is not known it would be one that no axis has: 1.3 · 10⁶ u/s² at 325 u/s.
                let change = (oldest.velocity).map_or(0.0, |before| (velocity - before) / elapsed);
                (Some(velocity), change)
            }
            _ => (None, 0.0),
        };
        // Removed before adding: the oldest one left is a window of cycles before the next reading.
        if self.readings.len() == self.window {
            self.readings.pop_front();
        }
        self.readings.push_back(EncoderReading {
            at,
            increments,
            velocity,
        });
        Kinematics {
            position: increments * self.resolution,
            velocity: velocity.unwrap_or(0.0),
            acceleration: if self.differentiate_acceleration {
                acceleration
            } else {
                0.0
            },
        }
    }
}

impl AxisSource for EncoderSource {
    fn sample(&mut self, since_start: Span) -> SourceSample {
        let really = self.moved_by.sample(since_start);
        let seen = self.read(since_start, really.motion.position);
        SourceSample {
            // The truth beside the reading, by which a run judges what receivers make of it.
            motion: really.motion,
            seen,
            enabled: really.enabled,
            activity: Activity::Measured,
            // A measured axis executes no commands.
            command_number: 0,
            target_position: seen.position,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn encoder(rest: &str) -> EncoderSource {
        let text = format!(
            "{rest}\n[program]\nstart-velocity = 10.0\n\
             limits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}"
        );
        EncoderSource::new(&parse::<EncoderConfig>("e.toml", &text).unwrap())
    }

    fn samples(encoder: &mut EncoderSource, cycles: i64) -> Vec<SourceSample> {
        (0..cycles)
            .map(|k| encoder.sample(Span::from_millis(k)))
            .collect()
    }

    #[test]
    fn positions_come_in_whole_increments() {
        let mut encoder = encoder("resolution = 0.25");
        for sample in samples(&mut encoder, 500) {
            let increments = sample.seen.position / 0.25;
            assert_eq!(increments, increments.round());
            let behind = sample.motion.position - sample.seen.position;
            assert!((-1e-9..0.25).contains(&behind), "{sample:?}");
            assert_eq!(sample.motion.velocity, 10.0);
            assert_eq!(sample.seen.acceleration, 0.0);
        }
    }

    #[test]
    fn a_longer_window_makes_a_smoother_velocity() {
        let ripple = |window: u16| {
            let mut encoder = encoder(&format!(
                "resolution = 0.003\nvelocity-window-cycles = {window}"
            ));
            samples(&mut encoder, 1_000)[100..]
                .iter()
                .map(|sample| (sample.seen.velocity - 10.0).abs())
                .fold(0.0, f64::max)
        };
        // One increment more or less within the window.
        for window in [1, 8, 50] {
            let one_increment = 0.003 / (f64::from(window) * 1e-3);
            let ripple = ripple(window);
            assert!(ripple <= one_increment * 1.000_001, "{window}: {ripple}");
            assert!(ripple > 0.1 * one_increment, "{window}: {ripple}");
        }
    }

    #[test]
    fn the_velocity_is_right_across_skipped_cycles() {
        let mut encoder = encoder("resolution = 0.001\nvelocity-window-cycles = 1");
        let _ = encoder.sample(Span::ZERO);
        let sample = encoder.sample(Span::from_millis(40));
        assert!((sample.seen.velocity - 10.0).abs() <= 0.001 / 0.040 * 1.000_001);
    }

    #[test]
    fn an_acceleration_is_only_there_if_wanted_and_then_it_is_coarse() {
        let mut encoder = encoder(
            "resolution = 0.003\ndifferentiate-acceleration = true\nvelocity-window-cycles = 1",
        );
        let worst = samples(&mut encoder, 1_000)[100..]
            .iter()
            .map(|sample| sample.seen.acceleration.abs())
            .fold(0.0, f64::max);
        // The axis moves at constant velocity; one increment per cycle² is the error.
        assert!(worst > 1_000.0, "{worst}");
    }

    /// Wide schedules 606543 and 702652.
    #[test]
    fn a_velocity_that_is_not_known_yet_gives_no_acceleration() {
        for window in [1, 6] {
            let mut encoder = encoder(&format!(
                "resolution = 0.001\ndifferentiate-acceleration = true\nvelocity-window-cycles = {window}"
            ));
            let first = samples(&mut encoder, 20);
            assert!((first[1].seen.velocity - 10.0).abs() <= 1.0, "{first:?}");
            let hardest = first.iter().map(|sample| sample.seen.acceleration.abs());
            // One increment per cycle².
            assert!(hardest.fold(0.0, f64::max) <= 1_000.000_1, "{first:?}");
        }
    }

    #[test]
    fn the_first_reading_has_no_velocity_yet() {
        let mut encoder = encoder("resolution = 0.5");
        assert_eq!(encoder.sample(Span::ZERO).seen, Kinematics::at_rest(0.0));
    }
}
