//! A custom receiver whose slave moves custom drive code.
//!
//! `cargo run -p coaxle-receiver --no-default-features --example own_drive`
//!
//! Three parts are custom: a type that implements [`Drive`], the config, and the loop. The loop
//! here has no network and no clock, so that it ends at once; `coaxle_host::node::run` is the one of the
//! real world.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use coaxle_axis::drive::{Actual, Drive, DriveState};
use coaxle_clock::{Instant, Seconds};
use coaxle_curve::profile::Kinematics;
use coaxle_node::Node;
use coaxle_receiver::{Drives, Receiver, ReceiverConfig};

const CONFIG: &str = r#"
name = "station"
cycle-time-us = 1000
master = { node = "conveyor" }

[[slave]]
name = "carriage"
limits = { velocity = 500, acceleration = 2000, jerk = 50000, min-position = -10, max-position = 300 }

[[slave.step]]
do = { power = true }

[[slave.step]]
when = { state = "standstill" }
do = { move-absolute = { position = 250 } }
"#;

/// A stepper drive: its positions are whole steps, commanded by pulses.
#[derive(Debug)]
struct Stepper {
    units_per_step: f64,
    steps: i64,
    velocity: f64,
    set: f64,
    state: DriveState,
    /// Pulses sent to the power stage since the start; other code may read them at any time.
    pulses: Arc<AtomicU64>,
}

impl Stepper {
    fn position(&self) -> f64 {
        self.steps as f64 * self.units_per_step
    }
}

impl Drive for Stepper {
    /// The drive stays at its position, and the axis starts from there.
    fn power_on(&mut self, _position: f64, _velocity: f64) {
        if self.state == DriveState::Off {
            self.state = DriveState::Following;
            self.set = self.position();
        }
    }

    fn reset(&mut self) {
        self.state = DriveState::Off;
        self.velocity = 0.0;
    }

    fn step(&mut self, set: &Kinematics, _elapsed: Seconds) {
        if self.state != DriveState::Following {
            return;
        }
        (self.set, self.velocity) = (set.position, set.velocity);
        let steps = (set.position / self.units_per_step).round() as i64;
        self.pulses
            .fetch_add(steps.abs_diff(self.steps), Ordering::Relaxed);
        self.steps = steps;
    }

    fn actual(&self) -> Actual {
        let powered = self.state != DriveState::Off;
        Actual {
            state: self.state,
            position: self.position(),
            velocity: self.velocity,
            following_error: if powered {
                self.set - self.position()
            } else {
                0.0
            },
            ..Actual::default()
        }
    }
}

/// Runs this number of cycles; returns the set position of the carriage, and the pulses for it.
///
/// # Errors
/// An invalid config.
pub(crate) fn run(cycles: u32) -> Result<(f64, u64), Box<dyn std::error::Error>> {
    let config: ReceiverConfig = coaxle_node::lab::NodeFile::parse_machine("station.toml", CONFIG)?;
    let pulses = Arc::new(AtomicU64::new(0));
    let stepper = Stepper {
        units_per_step: 0.01,
        steps: 0,
        velocity: 0.0,
        set: 0.0,
        state: DriveState::Off,
        pulses: Arc::clone(&pulses),
    };
    let drives = Drives::new().with("carriage", stepper);
    let mut receiver = Receiver::with_drives(&config, drives, Instant::EPOCH, 1)?;
    for _ in 0..cycles {
        let now = receiver.next_cycle();
        let _ = receiver.cycle(now);
        // Frames for other nodes, without a receiver here.
        while receiver.transmit().is_some() {}
    }
    let carriage = &receiver.snapshot().signals.slaves[0];
    Ok((
        carriage.position.unwrap_or(f64::NAN),
        pulses.load(Ordering::Relaxed),
    ))
}

#[allow(dead_code, reason = "a test runs the node without it")]
#[allow(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for cycles in [100, 500, 2_000] {
        let (position, pulses) = run(cycles)?;
        println!("after {cycles} cycles: carriage at {position:.3}, {pulses} pulses");
    }
    Ok(())
}
