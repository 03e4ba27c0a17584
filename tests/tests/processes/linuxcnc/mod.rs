//! Axes as pins of LinuxCNC: its realtime threads without a machine, beside a sender that is 200 ppm fast and a receiver.
//!
//! Values are judged by the instants that belong to them, and only those of cycles in which the receiver was not late: a busy machine
//! takes samples away, and makes none wrong.

#![expect(
    clippy::print_stdout,
    reason = "a test says what it has seen, or that it tested nothing"
)]

mod published;
mod world;

use world::{Sample, World};

/// Velocity of the conveyor, mm/s, and that of the carriage behind its gear.
const VELOCITY: f64 = 500.0;
const CARRIAGE: f64 = 250.0;

#[test]
fn set_values_are_neither_repeated_nor_missed_in_linuxcnc() {
    let Some(world) = World::start() else {
        return;
    };
    world.compile_components();
    let [free, locked] = world.run();
    let by_time = Steps::of(&free, |sample| sample.position, VELOCITY);
    let as_received = Steps::of(&free, |sample| sample.carriage_position, CARRIAGE);
    let in_step = Steps::of(&locked, |sample| sample.position, VELOCITY);
    println!("free: {by_time:?}\nbypass: {as_received:?}\nlocked: {in_step:?}");
    for steps in [&by_time, &in_step] {
        assert_eq!((steps.repeated, steps.missed), (0, 0), "{steps:?}");
    }
    if by_time.judged.min(in_step.judged) < 500 {
        println!("not judged further: the machine was too busy");
        return;
    }
    // The beat takes five seconds, and more than that was sampled.
    assert!(
        as_received.repeated + as_received.missed > 0,
        "{as_received:?}"
    );
    free.iter()
        .for_each(|sample| assert_eq!(sample.correction, 0));
    // Its period follows the far cycle, which is shorter by 200 ns.
    let moved: i32 = locked.iter().map(|sample| sample.correction).sum();
    let moved = f64::from(moved) / locked.len() as f64;
    assert!((-500.0..-50.0).contains(&moved), "{moved} ns");
    println!("period moved by {moved:.1} ns");
}

/// Steps of an axis from one cycle of the servo thread to the next.
#[derive(Debug, Default)]
struct Steps {
    judged: usize,
    /// Shorter than half of what the velocity makes in that time.
    repeated: usize,
    /// Longer by more than half of it.
    missed: usize,
    /// Largest deviation, as a part of that.
    worst: f64,
}

impl Steps {
    fn of(samples: &[Sample], position: impl Fn(&Sample) -> f64, velocity: f64) -> Self {
        let mut steps = Self::default();
        let pairs = samples.windows(2).filter(|pair| {
            let are_neighbours = pair[1].number == pair[0].number + 1;
            // A receiver that has lost its master on a busy machine stops its slaves.
            let is_at_speed =
                |sample: &Sample| (sample.velocity - VELOCITY).abs() < 0.01 * VELOCITY;
            are_neighbours && pair.iter().all(|it| it.is_on_time() && is_at_speed(it))
        });
        for pair in pairs {
            let expected = velocity * (pair[1].time - pair[0].time);
            let step = (position(&pair[1]) - position(&pair[0])) / expected;
            steps.judged += 1;
            steps.repeated += usize::from(step < 0.5);
            steps.missed += usize::from(step > 1.5);
            steps.worst = steps.worst.max((step - 1.0).abs());
        }
        steps
    }
}
