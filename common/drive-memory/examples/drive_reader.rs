//! A drive process that reads the set values of a slave, acts as its drive, and writes back actual
//! values.
//!
//! `cargo run -p coaxle-drive-memory --example drive_reader -- /dev/shm/coaxle-carriage`
//!
//! runs with a receiver that has `drive = { kind = "shared-memory", path =
//! "/dev/shm/coaxle-carriage", … }`, for example `coaxle receiver receiver/configs/drive.toml`. The
//! process waits for the receiver and attaches again after a restart of the receiver. The drive is
//! simulated here; a real process would pass the set values on to its drive.

#![allow(
    clippy::disallowed_methods,
    reason = "a drive process is no node: it has its own time"
)]

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use coaxle_drive_memory::{DriveProcess, ProcessValues, SetValues};

/// Polling interval for set values, several times per cycle, so that the response comes within the cycle.
// A cycle lasts a millisecond in the configs that come with the receiver: five looks per cycle.
const LOOK: Duration = Duration::from_micros(200);
/// Interval between attempts to attach to the receiver.
const TRY: Duration = Duration::from_millis(100);

/// A simulated drive: with power, its position is the set position of the previous cycle.
#[derive(Debug, Default)]
struct Drive {
    position: f64,
    velocity: f64,
}

impl Drive {
    fn follow(&mut self, set: &SetValues) -> ProcessValues {
        if set.enable {
            // No lag and no following error: the response carries the position of the very set values that it answers.
            (self.position, self.velocity) = (set.position, set.velocity);
            ProcessValues::following(self.position, self.velocity).of(set)
        } else {
            // A drive without power holds its position. Its velocity would otherwise stay that of the last cycle.
            self.velocity = 0.0;
            ProcessValues::off(self.position).of(set)
        }
    }
}

/// Acts as the drive until `stop` is set, and shows the set values once a second and whenever power
/// is switched on or off.
pub(crate) fn run(path: &Path, stop: &AtomicBool, mut show: impl FnMut(String)) {
    let mut drive = Drive::default();
    while !stop.load(Ordering::Relaxed) {
        match DriveProcess::attach(path) {
            Ok(mut process) => {
                let (name, id) = process.slave();
                show(format!("attached to {name}, axis {id}"));
                attached(&mut process, &mut drive, stop, &mut show);
                show("the receiver has ended".to_owned());
            }
            // A receiver that has not started yet is no reason to end: the attempts go on until it is there.
            Err(error) => show(error.to_string()),
        }
        std::thread::sleep(TRY);
    }
}

fn attached(
    process: &mut DriveProcess,
    drive: &mut Drive,
    stop: &AtomicBool,
    show: &mut impl FnMut(String),
) {
    // `last` begins empty with each attachment: a new run of the receiver counts from the start.
    let (mut last, mut shown) = (None::<SetValues>, Instant::now());
    while process.is_attached() && !stop.load(Ordering::Relaxed) {
        let set = process.set_values();
        // A single response per cycle: its heartbeat shows that the set values were read.
        if let Some(set) = set.filter(|set| last.is_none_or(|last| last.counter != set.counter)) {
            process.answer(&drive.follow(&set));
            // A change of power is shown at once, the rest once a second: a line per cycle would be a thousand a second.
            let switched = last.is_none_or(|last| last.enable != set.enable);
            if switched || shown.elapsed() >= Duration::from_secs(1) {
                let SetValues {
                    counter,
                    enable,
                    position,
                    velocity,
                    ..
                } = set;
                show(format!(
                    "cycle {counter}: enable {enable}, position {position:.3}, velocity {velocity:.3}"
                ));
                shown = Instant::now();
            }
            last = Some(set);
        }
        std::thread::sleep(LOOK);
    }
}

#[allow(dead_code, reason = "a test runs the drive without it")]
#[allow(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let path = std::env::args().nth(1);
    let path = path.unwrap_or_else(|| "/dev/shm/coaxle-carriage".to_owned());
    let mut before = String::new();
    run(path.as_ref(), &AtomicBool::new(false), |line| {
        // The failed attempts of a wait have the same text: ten lines a second would hide all others.
        if line != before {
            println!("{line}");
            before = line;
        }
    });
}
