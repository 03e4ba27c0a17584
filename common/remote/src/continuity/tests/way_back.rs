//! Ways back that are disturbed go on.

use super::*;

/// Swarm schedule 4937: it took longer than its plan, which began again whenever the clock was found.
#[test]
fn a_way_back_goes_on_where_nothing_steps() {
    let at_rest = steady(230.0, 0.0);
    let cycles_until_back = |found_again: Option<u32>| {
        let mut axis = Axis::of(Reach {
            velocity: 30.0,
            acceleration: 100.0,
        });
        axis.follow(&steady(-470.0, 0.0), 1);
        axis.rejoin();
        let mut cycles = 0;
        while axis.state() != ContinuityState::Following {
            if found_again.is_some_and(|every| cycles % every == every - 1) {
                axis.rejoin();
            }
            axis.follow(&at_rest, 1);
            cycles += 1;
            assert!(cycles < 200_000);
        }
        cycles
    };
    assert_eq!(cycles_until_back(Some(20_000)), cycles_until_back(None));
}

/// Swarm schedule 50274: a beat that was larger than the usual ones began the way back from its start, every few seconds.
#[test]
fn a_way_back_goes_on_over_the_beats_of_its_master() {
    const VELOCITY: f64 = 81.0;
    let at = |cycle: u32| steady(1_000.0 + VELOCITY * f64::from(cycle) * CYCLE, VELOCITY);
    let seconds_until_back = |taken_for_steps: Option<u32>| {
        let mut axis = Axis::of(Reach {
            velocity: VELOCITY,
            acceleration: 200.0,
        });
        axis.follow(&steady(0.0, 0.0), 1);
        axis.rejoin();
        for cycle in 1..200_000_u32 {
            if taken_for_steps.is_some_and(|every| cycle % every == 0) {
                axis.rejoin();
            }
            // A frame less than in time, and two more in the next cycle.
            let seen = match cycle % 97 {
                0 => at(cycle - 1),
                1 => at(cycle + 1),
                _ => at(cycle),
            };
            let newest = Some(ReceivedMotion {
                set: seen,
                age: 0.0,
            });
            let of_cycle = MasterCycle {
                newest,
                ..axis.cycle(1)
            };
            axis.continuity.follow(&seen, &of_cycle);
            if axis.state() == ContinuityState::Following {
                return f64::from(cycle) * CYCLE;
            }
        }
        f64::INFINITY
    };
    let undisturbed = seconds_until_back(None);
    // In the last part of the way the shown values count, and steps in them are steps.
    let disturbed = seconds_until_back(Some(2 * 970));
    assert!(
        disturbed < 2.0 * undisturbed,
        "{disturbed} s, {undisturbed} s"
    );
}

/// Swarm schedule 41102: the velocity of the way was taken for that of a jump, as its master had shown none.
#[test]
fn a_way_back_to_a_master_that_has_never_moved_has_no_step_either() {
    for disturb in [
        |axis: &mut Axis| axis.rejoin(),
        // Lost for a while, and back.
        |axis: &mut Axis| {
            for _ in 0..200 {
                axis.brake(1);
            }
        },
    ] {
        let mut axis = Axis::of(Reach::default());
        axis.follow(&steady(-4_500.0, 0.0), 1);
        axis.rejoin();
        let (mut before, mut velocity, mut hardest) = (-4_500.0, 0.0_f64, 0.0_f64);
        for cycle in 0..60_000 {
            if cycle == 15_000 {
                disturb(&mut axis);
                // Not seen here, and checked by its last velocity.
                before = axis.continuity.last.expect("moving").0.position;
                velocity = axis.continuity.last.expect("moving").0.velocity;
            }
            let set = axis.follow(&steady(0.0, 0.0), 1);
            let now = (set.position - before) / CYCLE;
            if cycle > 0 {
                hardest = hardest.max((now - velocity).abs() / CYCLE);
            }
            (before, velocity) = (set.position, now);
        }
        assert_eq!(axis.state(), ContinuityState::Following);
        // It has up to 281 u/s: a step of them would be 281 000 u/s². A braking of 0.5 s takes 844.
        assert!(hardest < 2_000.0, "{hardest}");
    }
}
