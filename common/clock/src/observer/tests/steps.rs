//! Steps of the delay, of the sender's clock, and of its count of cycles.

use super::*;

#[test]
fn a_delay_step_is_noticed_at_once_and_slewed() {
    for step in [2e5, -2e5, 2e6, -2e6] {
        let mut world = World::new(millis(1), 30.0);
        let _ = world.run(20.0);
        world.delay += step;
        let output = world.run(0.1);
        assert_eq!(output.shifts, 1, "{step}");
        assert!(output.last_shift.is_some());
        assert_eq!(output.rebases, 0, "{step}");
        let remaining = output.slew_remaining.0;
        assert!((remaining + step * 1e-9).abs() < 4e-5, "{remaining}");
        let output = world.run(25.0);
        assert!(output.slew_remaining.as_micros().abs() < 1.0);
        assert!(world.error().abs() < 5e-6, "{}", world.error());
        assert!(world.is_monotone());
        // Beyond a millisecond it is what remains over ten seconds.
        let most = 1.1e-4_f64.max(1.1 * step.abs() * 1e-9 / 10.0);
        let pace = world.fastest_slew(20_000);
        assert!(pace < most, "{step}: {pace}");
    }
}

/// Found in a random schedule: two seconds after the start the sender's clock leaps by 26.5 ms, which is no whole number of
/// its cycles of 250 µs, and no time response attributes it. Far time was slewed by 100 ppm, and called synchronised, for
/// 265 s.
#[test]
fn a_clock_that_leaps_is_caught_up_with_in_a_minute_and_is_unsure_until_then() {
    let cycle = Span::from_micros(250);
    for leap in [26.5389e6, -26.5389e6] {
        let mut world = World::new(cycle, -30.0);
        world.delay = 30e6;
        assert_eq!(world.run(1.915).state, ObserverState::Synced);
        let before = world.outputs.len();
        world.delay -= leap;
        let output = world.run(0.5);
        assert_eq!((output.shifts, output.rebases), (1, 0), "{leap}");
        assert_eq!(output.state, ObserverState::Unsure, "{leap}");
        let remaining = output.slew_remaining.0;
        assert!((remaining - leap * 1e-9).abs() < 2e-4, "{remaining}");
        let found = world.outputs.len();
        let output = world.run(59.0);
        assert_eq!(output.state, ObserverState::Synced, "{leap}");
        assert!(world.error().abs() < 5e-6, "{}", world.error());
        let pace = world.fastest_slew(before);
        assert!(pace < 1.01e-3, "{leap}: {pace}");
        let most = 1e-3 + 1e-6;
        for output in &world.outputs[found..] {
            let is_far_off = output.slew_remaining.0.abs() > most;
            assert!(!is_far_off || output.state == ObserverState::Unsure);
        }
    }
}

#[test]
fn who_allows_no_catching_up_is_slewed_to_at_the_usual_limit() {
    let cycle = millis(1);
    let parameters = ObserverParameters {
        catch_up_slew_limit_ppm: 50.0,
        ..ObserverParameters::default()
    };
    let mut world = World::new(cycle, 0.0);
    world.observer = PhaseObserver::new(CycleTime::new(cycle).unwrap(), parameters).unwrap();
    let _ = world.run(20.0);
    world.delay += 10.3e6;
    let output = world.run(0.2);
    assert_eq!((output.shifts, output.rebases), (1, 0));
    let before = world.outputs.len();
    let _ = world.run(20.0);
    let pace = world.fastest_slew(before);
    assert!((90e-6..110e-6).contains(&pace), "{pace}");
}

#[test]
fn a_sender_that_stood_still_changes_the_index_map() {
    for cycles in [7.0, 400.0] {
        let mut world = World::new(millis(1), 30.0);
        let _ = world.run(20.0);
        world.due += 1e6 * (1.0 + world.drift) * cycles;
        let output = world.run(0.2);
        assert_eq!((output.shifts, output.rebases), (1, 1), "{cycles}");
        assert!(world.outputs.iter().filter(|o| o.rebased).count() == 1);
        assert!(output.slew_remaining.as_micros().abs() < 40.0);
        let output = world.run(5.0);
        assert_eq!(output.state, ObserverState::Synced);
        assert!(world.error().abs() < 5e-6, "{}", world.error());
        assert!(world.is_monotone());
    }
}

#[test]
fn steps_that_exchanges_tell_of_are_the_paths_until_they_say_otherwise() {
    for (cycles, rest) in [(7.0, 0.0), (60.0, 0.0), (12.0, 0.3)] {
        let mut world = World::new(millis(1), 30.0);
        let _ = world.run(20.0);
        world.observer.leave_steps_to_exchanges(true);
        world.due += 1e6 * (1.0 + world.drift) * (cycles + rest);
        let mut jumped = None;
        while jumped.is_none() {
            let _ = world.step();
            let jump = world.observer.line().unwrap().jumped;
            jumped = (jump != Seconds::ZERO).then_some(jump);
        }
        let step = jumped.unwrap();
        assert!((step.0 - 1e-3 * (cycles + rest)).abs() < 5e-5, "{step:?}");
        world.observer.attribute_step_to_path(step);
        let held = world.run(0.2);
        assert_eq!((held.shifts, held.rebases), (1, 0), "{cycles}");
        assert!(held.slew_remaining.as_micros().abs() < 40.0, "it is held");
        let mapped = world.observer.attribute_step_to_sender(step);
        assert_eq!(mapped, millis(cycles as i64));
        let told = world.step();
        assert!(told.rebased && told.rebases == 1);
        assert!(told.slew_remaining.as_micros().abs() < 40.0);
        assert!(world.is_monotone());
        // What can be slewed is.
        let small = world.observer.attribute_step_to_sender(Seconds(3e-3));
        assert_eq!(small, Span::ZERO);
    }
}

#[test]
fn whole_cycles_of_a_stamped_sender_are_slewed() {
    for (cycles, rebases) in [(7.0, 0), (60.0, 1)] {
        let mut world = World::new(millis(1), 30.0);
        world.stamped = true;
        let _ = world.run(20.0);
        world.due += 1e6 * (1.0 + world.drift) * cycles;
        let output = world.run(0.2);
        assert_eq!((output.shifts, output.rebases), (1, rebases), "{cycles}");
        assert!(world.is_monotone());
    }
}
