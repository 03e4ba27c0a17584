//! A recorded motion, replayed.

mod recorded;
mod table;

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;

pub use table::ReplayError;
use table::{MotionRow, RecordedMotion};

use crate::config::{Interpolation, ReplayConfig};
use crate::source::{Activity, AxisSource, SourceSample};

/// A recorded motion, replayed.
///
/// Times are relative to the start of the node. Before the first row the axis stands at the first
/// position, after the last one at the last, unless the motion is repeated.
#[derive(Debug)]
pub struct Replay {
    rows: Vec<MotionRow>,
    interpolation: Interpolation,
    repeat: bool,
    velocity_recorded: bool,
}

impl Replay {
    /// Reads the file.
    ///
    /// # Errors
    /// [`ReplayError`] with the file and, if there is one, line and column.
    pub fn open(config: &ReplayConfig) -> Result<Self, ReplayError> {
        let motion = read(config)?;
        Ok(Self {
            velocity_recorded: motion.velocity_recorded,
            rows: motion.rows,
            interpolation: config.interpolation,
            repeat: config.repeat,
        })
    }

    /// Returns the motion at `seconds`, or none while the axis stands.
    fn motion_at(&self, seconds: f64) -> Option<Kinematics> {
        let (first, last) = self.ends();
        let length = last.time - first.time;
        let since_first = seconds - first.time;
        let passes = if self.repeat {
            // Above 0: times in the file rise strictly, and there are two rows at least.
            (since_first / length).floor()
        } else {
            0.0
        };
        // Rounding may put the remainder slightly outside the pass.
        let within = (since_first - passes * length).min(length);
        if since_first < 0.0 || (!self.repeat && since_first >= length) {
            return None;
        }
        let mut motion = self.within_pass(first.time + within.max(0.0));
        // Each pass continues where the last one ended, so that the axis never jumps back.
        motion.position += passes * (last.position - first.position);
        Some(motion)
    }

    fn within_pass(&self, time: f64) -> Kinematics {
        let after = self.rows.partition_point(|row| row.time <= time);
        // The last row has no segment behind it, and belongs to the end of the one before.
        let segment = after.clamp(1, self.rows.len() - 1);
        let (from, to) = (&self.rows[segment - 1], &self.rows[segment]);
        match self.interpolation {
            Interpolation::Cubic => cubic(from, to, time),
            Interpolation::Linear => linear(from, to, time, self.velocity_recorded),
        }
    }

    fn standing_at(&self, seconds: f64) -> f64 {
        let (first, last) = self.ends();
        if seconds < first.time {
            first.position
        } else {
            last.position
        }
    }

    fn ends(&self) -> (&MotionRow, &MotionRow) {
        (&self.rows[0], &self.rows[self.rows.len() - 1])
    }
}

/// Reads the file. A recording in MCAP has many axes, a table one.
fn read(config: &ReplayConfig) -> Result<RecordedMotion, ReplayError> {
    let wrong = |received: &str, expected: &str| ReplayError::Axis {
        file: config.file.display().to_string(),
        received: received.to_owned(),
        expected: expected.to_owned(),
    };
    // Both mistakes are answered: a name that is missing, and one that a table has no use for.
    match (recorded::is_recording(&config.file), &config.axis) {
        (true, Some(axis)) => recorded::read(&config.file, axis),
        (true, None) => Err(wrong("none", "the name of an axis in the recording")),
        (false, Some(_)) => Err(wrong(
            "a name",
            "none: only a recording, *.mcap, has several",
        )),
        (false, None) => table::read(&config.file),
    }
}

impl AxisSource for Replay {
    fn sample(&mut self, since_start: Span) -> SourceSample {
        let seconds = since_start.as_secs_f64();
        let (kinematics, activity) = match self.motion_at(seconds) {
            Some(motion) => (motion, Activity::Following),
            None => (
                Kinematics::at_rest(self.standing_at(seconds)),
                Activity::Idle,
            ),
        };
        SourceSample {
            motion: kinematics,
            seen: kinematics,
            enabled: true,
            activity,
            command_number: 1,
            target_position: kinematics.position,
        }
    }
}

/// Returns the cubic Hermite polynomial through positions and velocities of both rows.
fn cubic(from: &MotionRow, to: &MotionRow, time: f64) -> Kinematics {
    let h = to.time - from.time;
    let s = (time - from.time) / h;
    let step = to.position - from.position;
    // p(s) = p₀ + s·(c₁ + s·(c₂ + s·c₃))
    let c1 = h * from.velocity;
    // Conditions p(1) = p₁ and p'(1) = h·v₁ for the last two.
    let c2 = 3.0 * step - h * (2.0 * from.velocity + to.velocity);
    let c3 = h * (from.velocity + to.velocity) - 2.0 * step;
    Kinematics {
        position: from.position + s * (c1 + s * (c2 + s * c3)),
        velocity: (c1 + s * (2.0 * c2 + 3.0 * s * c3)) / h,
        acceleration: match (from.acceleration, to.acceleration) {
            // Recorded accelerations are better than the second derivative of the cubic, which jumps at each row.
            (Some(a), Some(b)) => a + s * (b - a),
            _ => (2.0 * c2 + 6.0 * s * c3) / (h * h),
        },
    }
}

/// Interpolates by straight lines from row to row.
fn linear(from: &MotionRow, to: &MotionRow, time: f64, velocity_recorded: bool) -> Kinematics {
    let h = to.time - from.time;
    let s = (time - from.time) / h;
    let between = |a: f64, b: f64| a + s * (b - a);
    let slope = (to.position - from.position) / h;
    Kinematics {
        position: between(from.position, to.position),
        // Differentiated velocities belong to a parabola; on a straight line the slope is the velocity.
        velocity: if velocity_recorded {
            between(from.velocity, to.velocity)
        } else {
            slope
        },
        acceleration: match (from.acceleration, to.acceleration) {
            (Some(a), Some(b)) => between(a, b),
            _ if velocity_recorded => (to.velocity - from.velocity) / h,
            _ => 0.0,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::Instance;
    use coaxle_recording::{Facts, RowEncoder, Table, Writer};
    use std::fs;

    mod declared {
        #![allow(
            unreachable_pub,
            reason = "the macro declares what a crate shows to others"
        )]

        coaxle_node::signals! {
            /// An axis.
            pub struct MovedSignals of Axis {
                /// Position of the axis; none before it is known.
                position: Option<f64> ["u"],
                /// Velocity of the axis.
                velocity: f64 ["u/s"],
            }
        }
    }

    /// Makes a parabola in cycles of 10 ms; the first two have no position.
    fn recording(end: usize) -> Vec<u8> {
        let table = Table {
            name: "press".to_owned(),
            role: "sender".to_owned(),
            instances: ["ram", "table"]
                .map(Instance::of::<declared::MovedSignals>)
                .into(),
        };
        let mut encoder = RowEncoder::of(&table);
        let mut writer = Writer::create(Vec::new(), &[table], &Facts::new(), 0).unwrap();
        for k in 0..200_i64 {
            let t = (k - 2) as f64 * 0.01;
            let moved = declared::MovedSignals {
                position: (k >= 2).then_some(t * t),
                velocity: 2.0 * t,
            };
            let at = 1_000_000_000 + k * 10_000_000;
            let row = encoder.encode(at, at, &[declared::MovedSignals::default(), moved]);
            writer.row(0, &row.unwrap()).unwrap();
        }
        let mut file = writer.finish().unwrap();
        file.truncate(file.len().min(end));
        file
    }

    fn replayed(recording: &[u8], axis: Option<&str>) -> Result<Replay, ReplayError> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("motion.mcap");
        fs::write(&file, recording).unwrap();
        Replay::open(&ReplayConfig {
            file,
            axis: axis.map(str::to_owned),
            repeat: false,
            interpolation: Interpolation::Cubic,
        })
    }

    #[test]
    fn an_axis_of_a_recording_moves_as_it_did_from_where_it_was_known() {
        for name in ["table", "press/table"] {
            let mut replay = replayed(&recording(usize::MAX), Some(name)).unwrap();
            for t in [0.0, 0.033, 1.234, 1.96] {
                let sample = at(&mut replay, t);
                assert_close(sample.motion.position, t * t);
                assert_close(sample.motion.velocity, 2.0 * t);
            }
        }
    }

    #[test]
    fn what_a_recording_does_not_hold_is_named() {
        let said = |recording: &[u8], axis| {
            let error = replayed(recording, axis).unwrap_err().to_string();
            error
                .split_once("motion.mcap: ")
                .expect("the file")
                .1
                .to_owned()
        };
        let whole = recording(usize::MAX);
        let other = said(&whole, Some("knife"));
        assert_eq!(
            other,
            r#"axis: received "knife", expected one of "ram", "table""#
        );
        let none = said(&whole, None);
        assert!(
            none.starts_with("axis: received none, expected the name"),
            "{none}"
        );
        let still = said(&whole, Some("ram"));
        assert_eq!(still, "received 0 rows, expected at least 2");
        let broken = said(&recording(whole.len() / 2), Some("table"));
        assert!(broken.contains("coaxle recover"), "{broken}");
    }

    fn replay(text: &str, repeat: bool, interpolation: Interpolation) -> Replay {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("motion.csv");
        fs::write(&file, text).unwrap();
        let config = ReplayConfig {
            file,
            axis: None,
            repeat,
            interpolation,
        };
        Replay::open(&config).unwrap()
    }

    fn at(replay: &mut Replay, seconds: f64) -> SourceSample {
        replay.sample(Span::from_secs_f64(seconds))
    }

    fn assert_close(received: f64, expected: f64) {
        let slack = 1e-9 * (1.0 + expected.abs());
        assert!((received - expected).abs() < slack, "{received} {expected}");
    }

    /// Returns the rows of p = t², exact for a cubic.
    fn parabola(columns: usize) -> String {
        let header = ["time_s", "position", "velocity", "acceleration"][..columns].join(",");
        let rows = (0..=20).map(|k| {
            let t = f64::from(k) * 0.1;
            [t, t * t, 2.0 * t, 2.0].map(|x| x.to_string())[..columns].join(",")
        });
        std::iter::once(header)
            .chain(rows)
            .collect::<Vec<_>>()
            .join("\n")
    }

    #[test]
    fn a_cubic_gives_back_what_was_recorded_between_the_rows() {
        for columns in [2, 3, 4] {
            let mut replay = replay(&parabola(columns), false, Interpolation::Cubic);
            for t in [0.0, 0.033, 0.1, 1.234, 1.999] {
                let sample = at(&mut replay, t);
                assert_close(sample.motion.position, t * t);
                assert_close(sample.motion.velocity, 2.0 * t);
                assert_close(sample.motion.acceleration, 2.0);
                assert_eq!(sample.activity, Activity::Following);
            }
        }
    }

    #[test]
    fn a_line_is_straight_between_the_rows() {
        let text = "time_s,position\n0,0\n1,10\n3,10\n";
        let mut replay = replay(text, false, Interpolation::Linear);
        let sample = at(&mut replay, 0.25);
        assert_close(sample.motion.position, 2.5);
        assert_close(sample.motion.velocity, 10.0);
        assert_eq!(sample.motion.acceleration, 0.0);
        assert_eq!(at(&mut replay, 2.0).motion, Kinematics::at_rest(10.0));
    }

    #[test]
    fn a_line_keeps_a_recorded_velocity() {
        let text = "position,time_s,velocity\n0,0,4\n10,1,6\n";
        let mut replay = replay(text, false, Interpolation::Linear);
        let sample = at(&mut replay, 0.5);
        assert_close(sample.motion.velocity, 5.0);
        assert_close(sample.motion.acceleration, 2.0);
    }

    #[test]
    fn the_axis_stands_before_the_first_row_and_after_the_last() {
        let text = "time_s,position\n1,5\n2,6\n3,9\n";
        let mut replay = replay(text, false, Interpolation::Cubic);
        for (t, position) in [(0.0, 5.0), (3.0, 9.0), (100.0, 9.0)] {
            let sample = at(&mut replay, t);
            assert_eq!(sample.motion, Kinematics::at_rest(position));
            assert_eq!(sample.activity, Activity::Idle);
        }
    }

    #[test]
    fn repeated_it_goes_on_where_it_ended() {
        let text = "time_s,position\n0,0\n1,2\n2,4\n";
        let mut replay = replay(text, true, Interpolation::Cubic);
        for t in [0.5, 1.5, 2.0, 3.25, 4.0, 1_000.75] {
            let sample = at(&mut replay, t);
            assert_close(sample.motion.position, 2.0 * t);
            assert_close(sample.motion.velocity, 2.0);
        }
    }
}
