//! The observer while it follows the lower edge of the phases, and what may happen then.

use super::*;
use std::sync::OnceLock;

/// A sender of a sharp edge whose delays are correlated from the first message on.
fn correlated(cycle: Span) -> World {
    World {
        normal: 300.0,
        exponential: 5e3,
        extra: Some(Correlated::half_normal(15e3, 0.3)),
        ..World::new(cycle, 30.0)
    }
}

/// World half a minute later: the edge is followed and well known.
fn following_the_edge() -> World {
    static WORLD: OnceLock<World> = OnceLock::new();
    let world = WORLD.get_or_init(|| {
        let mut world = correlated(millis(1));
        let _ = world.run(35.0);
        world
    });
    assert!(world.follows_edge());
    world.clone()
}

/// Error of the edge against the least delay that the jitter allows: nearly nothing, s.
const TOLERANCE: f64 = 3e-6;
/// After a step of the delay the points on the edge are few, s.
const TOLERANCE_AFTER_STEP: f64 = 6e-6;
/// The usual slew limit, s/s.
const SLEW: f64 = 100.5e-6;

impl World {
    fn follows_edge(&self) -> bool {
        self.observer.stream.as_ref().unwrap().choice.is_edge()
    }
    /// Largest error of the drift shown since output `since`, ppm.
    fn worst_drift(&self, since: usize) -> f64 {
        let drifts = self.outputs[since..].iter();
        drifts
            .map(|output| (output.drift_ppm + self.drift * 1e6).abs())
            .fold(0.0, f64::max)
    }

    /// The states shown, each as often as it was entered.
    fn states(&self) -> Vec<ObserverState> {
        let mut states: Vec<_> = self.outputs.iter().map(|output| output.state).collect();
        states.dedup();
        states
    }
}

#[test]
fn states_follow_each_other_in_order() {
    use ObserverState::{Holdover, Locking, Lost, Startup, Synced, Unsure};
    let mut world = following_the_edge();
    assert_eq!(world.states(), [Startup, Locking, Synced, Unsure, Synced]);
    world.silent = true;
    let _ = world.run(3.0);
    world.silent = false;
    let _ = world.run(20.0);
    let expected = [
        Startup, Locking, Synced, Unsure, Synced, Holdover, Lost, Locking, Synced,
    ];
    assert_eq!(world.states(), expected);
    assert!(world.is_monotone());
    assert!(world.error().abs() < TOLERANCE, "{}", world.error());
}

#[test]
fn the_edge_is_entered_and_left_without_haste() {
    let mut world = correlated(millis(1));
    let extra = world.extra.take();
    let _ = world.run(30.0);
    assert!(!world.follows_edge());
    world.extra = extra;
    let _ = world.run(30.0);
    assert!(world.follows_edge());
    world.extra = None;
    let _ = world.run(600.0);
    assert!(!world.follows_edge());
    assert!(world.error().abs() < TOLERANCE, "{}", world.error());
    assert!(world.is_monotone());
    let slew = world.fastest_slew(5_000);
    assert!(slew < SLEW, "{slew}");
}

#[test]
fn an_edge_that_is_followed_early_is_not_followed_in_haste() {
    let world = following_the_edge();
    assert!(world.is_monotone());
    let slew = world.fastest_slew(0);
    assert!(slew < SLEW, "{slew}");
}

#[test]
fn silence_does_not_move_the_edge() {
    for (seconds, relocks) in [(0.5, 0), (3.0, 1)] {
        let mut world = following_the_edge();
        let before = world.outputs.len();
        world.silent = true;
        let _ = world.run(seconds);
        assert!(world.error().abs() < TOLERANCE, "{}", world.error());
        world.silent = false;
        for _ in 0..100 {
            let output = world.run(0.1);
            assert!(world.error().abs() < TOLERANCE, "{}", world.error());
            assert_eq!((output.relocks, output.shifts), (relocks, 0));
        }
        assert!(world.worst_drift(before) < 0.3);
        assert!(world.is_monotone() && world.fastest_slew(before) < SLEW);
    }
}

#[test]
fn a_restart_begins_without_the_edge_of_before() {
    let mut world = following_the_edge();
    world.epoch = 8;
    world.count = 0;
    world.due += 0.4e6;
    let _ = world.step();
    assert!(!world.follows_edge());
    let output = world.run(1.0);
    assert_eq!((output.relocks, output.rebases), (1, 1));
    let _ = world.run(60.0);
    assert!(world.error().abs() < TOLERANCE, "{}", world.error());
    assert!(world.is_monotone());
}

#[test]
fn a_step_of_the_delay_is_followed_without_a_kick_of_the_drift() {
    // Time until it is noticed, s: for what may as well be load sixteen windows, here of a second as points scatter.
    // Then it is also hard to distinguish from a drift.
    for (step, noticed, drift_ppm) in [
        (30e3, 16.0, 2.5),
        (-30e3, 4.0, 0.3),
        (200e3, 4.0, 0.3),
        (-200e3, 4.0, 0.3),
        (2e6, 4.0, 0.3),
        (-2e6, 4.0, 0.3),
    ] {
        let mut world = following_the_edge();
        let before = world.outputs.len();
        world.delay += step;
        let _ = world.run(noticed + step.abs() * 1e-9 / 100e-6);
        let error = world.error();
        assert!(error.abs() < TOLERANCE_AFTER_STEP, "{step}: {error}");
        let drift = world.worst_drift(before);
        assert!(drift < drift_ppm, "{step}: {drift}");
        // Beyond a millisecond it is what remains over ten seconds.
        let slew = SLEW.max(1.005 * step.abs() * 1e-9 / 10.0);
        assert!(world.is_monotone() && world.fastest_slew(before) < slew);
        let output = world.run(30.0);
        assert_eq!((output.rebases, output.relocks), (0, 0), "{step}");
        let error = world.error();
        assert!(error.abs() < TOLERANCE_AFTER_STEP, "{step}: {error}");
    }
}

#[test]
fn whole_cycles_of_a_sender_that_stood_still_go_into_the_index_map() {
    for cycles in [7.0, 400.0] {
        let mut world = following_the_edge();
        let before = world.outputs.len();
        world.due += 1e6 * (1.0 + world.drift) * cycles;
        let output = world.run(0.2);
        assert_eq!(output.rebases, 1, "{cycles}");
        assert_eq!(output.state, ObserverState::Synced);
        // The edge then finds the part that is not whole.
        assert!(world.error().abs() < 30e-6, "{}", world.error());
        let output = world.run(20.0);
        assert_eq!(output.rebases, 1, "{cycles}");
        assert!(world.error().abs() < TOLERANCE, "{}", world.error());
        assert!(world.is_monotone() && world.fastest_slew(before) < SLEW);
        let drift = world.worst_drift(before);
        assert!(drift < 1.0, "{drift}");
    }
}

/// Largest difference between the movement of the line and the jumps reported.
fn largest_unmatched(world: &mut World, seconds: f64) -> f64 {
    let mut worst = 0.0_f64;
    for _ in 0..(seconds / world.cycle.as_secs_f64()) as usize {
        let before = world.observer.line();
        let _ = world.step();
        if let (Some(before), Some(after)) = (before, world.observer.line()) {
            let jumped = (after.jumped - before.jumped).0;
            let now = Instant::from_nanos(world.now);
            let earlier = before.at(now);
            let moved = after.at(now).since(earlier.instant).0 - earlier.fraction_ns * 1e-9;
            if jumped != 0.0 {
                worst = worst.max((moved + jumped).abs());
            }
        }
    }
    worst
}

#[test]
fn jumps_of_an_edge_that_was_not_followed_are_not_told_first_message_late() {
    let mut world = correlated(millis(1));
    // The first messages are held up for 5 ms and come together.
    let arrived = world.due + world.delay + 5e6;
    for k in 0..6 {
        let arrived = Instant::from_nanos(arrived as i64 + 1_000 * k);
        world.observer.observe(7, world.count, arrived, None);
        world.count += 1;
        world.due += 1e6 * (1.0 + world.drift);
    }
    let worst = largest_unmatched(&mut world, 5.0);
    assert!(worst < 20e-6, "{worst}");
}

#[test]
fn jumps_of_an_edge_that_was_not_followed_are_not_told_calm_first() {
    let mut world = correlated(millis(1));
    let extra = world.extra.take();
    let _ = world.run(30.0);
    world.extra = extra;
    let worst = largest_unmatched(&mut world, 20.0);
    assert!(worst < 20e-6, "{worst}");
}

#[test]
fn messages_are_measured_again_after_a_shift_while_the_widths_do_not_fit() {
    let mut world = correlated(millis(1));
    let extra = world.extra.take();
    let _ = world.run(30.0);
    world.extra = extra;
    let _ = world.run(60.0);
    let at = world
        .observer
        .stream
        .as_ref()
        .unwrap()
        .line
        .as_ref()
        .unwrap()
        .at;
    let dt = (world.count as f64 - at as f64) * 1e-3;
    assert!(
        at as u64 > world.count - 5_000,
        "{at} of {}, {dt}",
        world.count
    );
}

#[test]
fn a_skip_is_no_delay_for_the_edge_either_slow() {
    let mut world = correlated(millis(100));
    world.extra = Some(Correlated::half_normal(15e3, 30.0));
    let _ = world.run(1_200.0);
    assert!(world.follows_edge());
    world.due += 1e8 * (1.0 + world.drift) * 7.0;
    for _ in 0..30 {
        let output = world.run(2.0);
        if output.rebases == 1 {
            assert!(world.error().abs() < 50e-6, "{}", world.error());
        }
    }
}

#[test]
fn a_whole_skip_leaves_the_edge_where_it_was() {
    for cycles in [7.0, 400.0] {
        let mut world = following_the_edge();
        world.due += 1e6 * (1.0 + world.drift) * cycles;
        let output = world.run(2.0);
        let sigma = output.offset_sigma.0;
        assert!(
            world.error().abs() < TOLERANCE,
            "{} {}",
            world.error(),
            sigma
        );
    }
}

#[test]
fn a_sharp_telegraph_is_noticed_by_its_many_small_shifts() {
    let mut world = correlated(millis(1));
    world.extra = Some(Correlated::telegraph(13e3, 2.0));
    let _ = world.run(60.0);
    assert!(world.follows_edge());
    assert!(world.outputs.last().unwrap().shifts <= 3);
    let mut outside = 0;
    for _ in 0..60_000 {
        let output = world.step();
        outside += usize::from(world.error().abs() > 3.0 * output.offset_sigma.0 + 1e-6);
    }
    assert!(outside < 600, "{outside} of 60 000");
}

/// Steps in a row that are too slow for a change of the drift at once.
#[test]
fn an_edge_that_goes_up_again_and_again_is_left_as_after_a_change_of_the_drift() {
    const HEIGHT: f64 = 200e-6;
    let mut world = following_the_edge();
    let steps = |world: &World| world.observer.line().unwrap().drift_steps;
    let mut raised = 0;
    while steps(&world) == 0 {
        assert!(raised < 9, "the staircase is not left");
        world.delay += HEIGHT * 1e9;
        raised += 1;
        let _ = world.run(3.5);
    }
    // What had been taken for the path's is taken back, and exchanges begin again with another line.
    let line = world.observer.line().unwrap();
    let taken_back = line.taken_back.0 / HEIGHT;
    assert!(
        (taken_back - f64::from(raised)).abs() < 0.2,
        "{taken_back} of {raised}"
    );
    let _ = world.run(30.0);
    assert!(world.follows_edge() && steps(&world) == 1);
    let drift = world.worst_drift(world.outputs.len() - 1);
    assert!(drift < 1.0, "{drift}");
    assert!(world.is_monotone());
}
