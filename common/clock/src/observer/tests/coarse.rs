//! Arrivals that are seen on a coarse grid, as where they are polled for.

use super::*;

/// A sender that wakes up some 5 µs late. Its messages are polled for every `grid_us`, and seen `late` ns later.
fn polled(grid_us: i64, drift_ppm: f64, late: f64) -> World {
    World {
        grid: grid_us * 1_000,
        normal: 5e3,
        exponential: 0.0,
        seen_late: late,
        delay: 200e3,
        ..World::new(millis(1), drift_ppm)
    }
}

/// Far time after two minutes.
struct Followed {
    /// Mean error in the second minute, s, and its scatter.
    mean: f64,
    rms: f64,
    /// Part of the cycles from the second second on in which the error was within three standard deviations.
    covered: f64,
    output: ObserverOutput,
}

fn followed(mut world: World) -> Followed {
    let _ = world.run(1.0);
    let (mut covered, mut errors) = (0, Vec::new());
    for _ in 0..120_000 {
        let output = world.step();
        errors.push(world.error());
        // The unseen wait is late by its mean, which is a constant.
        let slewed = output.slew_remaining.0.abs();
        let off = world.error().abs() - world.seen_late * 1e-9 - 5e-6 - slewed;
        covered += u32::from(off < 3.0 * output.offset_sigma.0);
    }
    assert!(world.is_monotone());
    let errors = &errors[60_000..];
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let square = errors.iter().map(|error| (error - mean) * (error - mean));
    Followed {
        mean,
        rms: libm::sqrt(square.sum::<f64>() / n),
        covered: f64::from(covered) / 120_000.0,
        output: *world.outputs.last().unwrap(),
    }
}

#[test]
fn a_tooth_that_returns_is_no_shift() {
    for grid in [250, 500, 1_000] {
        for drift in [500.0, -500.0, 100.0, -100.0] {
            for late in [5e3, 20e3] {
                let followed = followed(World {
                    wakes_late: true,
                    ..polled(grid, drift, late)
                });
                let Followed { mean, rms, .. } = followed;
                let case = std::format!("{grid} µs, {drift} ppm, {late} ns");
                assert!(mean.abs() < 8e-6 + late * 1e-9, "{case}: {mean}");
                assert!(rms < 4e-6, "{case}: {rms}");
                // A grid of half a cycle may hide half of itself for the first seconds.
                let least = if grid == 1_000 { 0.98 } else { 0.88 };
                assert!(followed.covered > least, "{case}: {}", followed.covered);
                let off = followed.output.drift_ppm + drift;
                assert!(off.abs() < 0.4, "{case}: {off} ppm");
            }
        }
    }
}

/// Arrivals on a grid of a millisecond, of messages sent late by `late` ns in the mean, are followed.
fn assert_followed_by_teeth(drift: f64, late: f64) -> ObserverOutput {
    let Followed {
        mean, rms, output, ..
    } = followed(polled(1_000, drift, late));
    assert!(
        mean.abs() < 8e-6 && rms < 3e-6,
        "{drift} ppm: {mean}, {rms}"
    );
    assert!(
        (output.drift_ppm + drift).abs() < 0.4,
        "{drift} ppm: {}",
        output.drift_ppm
    );
    output
}

#[test]
fn three_of_them_tell_where_nobody_says_how_late_he_sends() {
    for drift in [500.0, -500.0, 100.0, -100.0] {
        let _ = assert_followed_by_teeth(drift, 5e3);
    }
}

#[test]
fn one_of_a_grid_that_is_a_whole_cycle_to_the_nanosecond_tells() {
    for drift in [500.0, -500.0, 100.0, -100.0] {
        let output = assert_followed_by_teeth(drift, 0.0);
        assert_eq!(output.shifts, 0);
    }
}

/// The first tooth may come at any time after the start: a tenth of the time from one to the next, or nine.
#[test]
fn wherever_in_a_cell_the_first_message_comes() {
    for drift in [500.0, -500.0, 100.0, -100.0] {
        for tenths in 0..10 {
            let followed = followed(World {
                delay: 200e3 + 100e3 * f64::from(tenths),
                ..polled(1_000, drift, 0.0)
            });
            let Followed { mean, rms, .. } = followed;
            let case = std::format!("{drift} ppm, {tenths} tenths");
            assert!(mean.abs() < 8e-6 && rms < 4e-6, "{case}: {mean}, {rms}");
            // Until the first tooth nothing says that messages are polled for.
            assert!(followed.covered > 0.92, "{case}: {}", followed.covered);
        }
    }
}

/// Silences, and runs that begin anywhere in a cell.
#[test]
fn teeth_are_found_after_silences_and_restarts() {
    for drift in [300.0, -300.0] {
        for tenths in 0..10 {
            let mut world = World {
                wakes_late: true,
                delay: 200e3 + 100e3 * f64::from(tenths),
                ..polled(1_000, drift, 0.0)
            };
            let assert_settled = |world: &mut World, what: &str| {
                let _ = world.run(60.0);
                let worst = (0..10_000).map(|_| {
                    let output = world.step();
                    let off = world.error().abs();
                    assert!(off < 5e-6 + 3.0 * output.offset_sigma.0, "{what}: {off}");
                    off
                });
                let worst = worst.fold(0.0, f64::max);
                assert!(
                    worst < 12e-6,
                    "{drift} ppm, {tenths} tenths, {what}: {worst}"
                );
            };
            assert_settled(&mut world, "start");
            world.silent = true;
            let _ = world.run(2.0);
            world.silent = false;
            assert_settled(&mut world, "silence");
            world.epoch += 1;
            world.count = 0;
            world.due += 370e3;
            assert_settled(&mut world, "restart");
        }
    }
}

#[test]
fn before_a_tooth_came_nothing_is_sure_where_arrivals_do_not_echo_the_stamps() {
    let mut world = World {
        wakes_late: true,
        ..polled(1_000, 10.0, 5e3)
    };
    for _ in 0..40 {
        let output = world.run(1.0);
        let off = world.error().abs();
        assert!(off < 3.0 * output.offset_sigma.0, "{off}");
        assert!(output.offset_sigma.0 > 250e-6);
    }
}

#[test]
fn steps_of_the_path_that_do_not_return_are_no_teeth() {
    let mut world = World {
        wakes_late: true,
        ..World::new(millis(1), 30.0)
    };
    for step in [1e6, 1e6, -1e6] {
        let _ = world.run(4.0);
        world.delay += step;
    }
    let output = world.run(20.0);
    assert_eq!(output.shifts, 3);
    assert!(
        (output.drift_ppm + 30.0).abs() < 1.0,
        "{}",
        output.drift_ppm
    );
}
