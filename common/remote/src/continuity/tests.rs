mod way_back;

use super::*;
use proptest::prelude::*;
use std::vec::Vec;

const CYCLE: f64 = 1e-3;

/// An axis, and what its master was seen to do.
struct Axis {
    continuity: Continuity,
    reach: Reach,
}

impl Axis {
    fn of(reach: Reach) -> Self {
        Self {
            continuity: Continuity::new(Span::from_millis(1), Seconds(0.06)),
            reach,
        }
    }

    fn cycle(&self, elapsed: u32) -> MasterCycle {
        MasterCycle {
            elapsed,
            reach: self.reach,
            shows_beats: false,
            newest: None,
        }
    }

    fn follow(&mut self, master: &Kinematics, elapsed: u32) -> Kinematics {
        self.continuity.follow(master, &self.cycle(elapsed))
    }

    fn brake(&mut self, elapsed: u32) -> Option<Kinematics> {
        self.continuity.brake(&self.cycle(elapsed))
    }

    fn rejoin(&mut self) {
        self.continuity.rejoin();
    }

    fn state(&self) -> ContinuityState {
        self.continuity.state()
    }
}

/// The axis of a master like [`master`].
fn continuity() -> Axis {
    Axis::of(Reach {
        velocity: 510.0,
        acceleration: 100.0,
    })
}

fn steady(position: f64, velocity: f64) -> Kinematics {
    Kinematics {
        position,
        velocity,
        acceleration: 0.0,
    }
}

/// The master in a cycle: 500 u/s, with a ripple.
fn master(cycle: u32) -> Kinematics {
    let t = CYCLE * f64::from(cycle);
    Kinematics {
        position: 500.0 * t + libm::sin(10.0 * t),
        velocity: 500.0 + 10.0 * libm::cos(10.0 * t),
        acceleration: -100.0 * libm::sin(10.0 * t),
    }
}

/// The largest velocity and acceleration by the differences of positions, and the largest
/// difference between these and the velocity fields, in the middle.
fn differences(sets: &[Kinematics]) -> (f64, f64, f64) {
    let velocity = |w: &[Kinematics]| (w[1].position - w[0].position) / CYCLE;
    let velocities: Vec<f64> = sets.windows(2).map(velocity).collect();
    let accelerations = velocities.windows(2).map(|w| (w[1] - w[0]) / CYCLE);
    let contradiction = sets
        .windows(2)
        .map(|w| (velocity(w) - 0.5 * (w[0].velocity + w[1].velocity)).abs());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m, v| v.abs().max(m));
    (
        largest(&mut velocities.iter().copied()),
        largest(&mut { accelerations }),
        largest(&mut { contradiction }),
    )
}

#[test]
fn as_long_as_nothing_happens_set_values_pass_as_they_are() {
    let mut axis = continuity();
    for cycle in 0..1_000 {
        assert_eq!(axis.follow(&master(cycle), 1), master(cycle));
        assert_eq!(axis.state(), ContinuityState::Following);
    }
}

#[test]
fn a_pause_says_nothing_of_the_velocity_at_its_end() {
    let mut axis = continuity();
    let at = |cycle: u32| steady(0.5 * f64::from(cycle), 500.0);
    for cycle in 0..1_000 {
        let _ = axis.follow(&at(cycle), 1);
    }
    // The node stood still for two seconds, and does not find its master at first.
    let mut sets = std::vec![axis.brake(2_000).unwrap()];
    for cycle in 3_000..12_000 {
        sets.push(axis.follow(&at(cycle), 1));
    }
    let (fastest, hardest, _) = differences(&sets);
    // 1.5 times the master's 500, and the rest of a curve that begins faster.
    assert!(fastest < 760.0 && hardest < 2_000.0, "{fastest} {hardest}");
}

#[test]
fn nothing_is_braked_that_never_moved() {
    let mut axis = continuity();
    assert_eq!(axis.brake(1), None);
    assert_eq!(axis.follow(&master(0), 1), master(0));
}

#[test]
fn without_a_master_it_is_braked_and_back_with_it_again() {
    let mut axis = continuity();
    let mut sets: Vec<Kinematics> = (0..100).map(|n| axis.follow(&master(n), 1)).collect();
    sets.extend((100..1_000).map(|_| axis.brake(1).unwrap()));
    assert_eq!(axis.state(), ContinuityState::Braking);
    let rest = sets[999];
    assert_eq!((rest.velocity, rest.acceleration), (0.0, 0.0));
    assert!(
        // Half a second at half the velocity on average.
        (rest.position - sets[99].position - 0.25 * 510.0).abs() < 5.0,
        "{rest:?}"
    );
    let mut cycles = 1_000..10_000;
    while axis.state() != ContinuityState::Following {
        sets.push(axis.follow(&master(cycles.next().unwrap()), 1));
    }
    let next = cycles.next().unwrap();
    assert_eq!(axis.follow(&master(next), 1), master(next), "to the bit");
    let (velocity, acceleration, contradiction) = differences(&sets);
    // Master and half of it on top, with its ripple.
    assert!(velocity < 1.6 * 510.0, "{velocity}");
    assert!(acceleration < 4_000.0, "{acceleration}");
    assert!(contradiction < 0.02, "{contradiction}");
    assert!(next < 5_000, "{next}");
}

#[test]
fn another_run_is_joined_from_where_the_last_one_was() {
    let mut axis = continuity();
    let mut sets: Vec<Kinematics> = (0..1_500).map(|n| axis.follow(&master(n), 1)).collect();
    axis.rejoin();
    sets.extend((0..9_000).map(|n| axis.follow(&master(n), 1)));
    assert_eq!(axis.state(), ContinuityState::Following);
    let (velocity, acceleration, _) = differences(&sets);
    assert!(velocity < 1.6 * 510.0, "{velocity}");
    assert!(acceleration < 2_000.0, "{acceleration}");
}

/// `clock-flip-1s-sender`: 24 m were made up in 30 s at four times the velocity of the master, which the slave behind could not.
#[test]
fn a_way_back_of_metres_is_no_faster_than_one_of_millimetres() {
    let mut axis = continuity();
    let at = |cycle: u32| steady(0.5 * f64::from(cycle), 500.0);
    let mut sets = std::vec![axis.follow(&at(0), 1)];
    axis.rejoin();
    let mut cycles = 48_000..240_000;
    while axis.state() != ContinuityState::Following {
        let cycle = cycles.next().expect("it is back by then");
        sets.push(axis.follow(&at(cycle), 1));
    }
    let (velocity, acceleration, _) = differences(&sets);
    assert!(velocity < 1.55 * 510.0, "{velocity}");
    assert!(acceleration < 2_000.0, "{acceleration}");
    let took = sets.len() as f64 * CYCLE;
    // Quintic over 24 m, whose steepest slope of 1.875 is half of 510 u/s.
    assert!((took - 1.875 * 24_000.0 / 255.0).abs() < 2.0, "{took} s");
}

#[test]
fn a_master_at_rest_is_joined_too() {
    let mut axis = Axis::of(Reach::default());
    let _ = axis.follow(&steady(100.0, 0.0), 1);
    axis.rejoin();
    let sets: Vec<Kinematics> = (0..31_000)
        .map(|_| axis.follow(&steady(0.0, 0.0), 1))
        .collect();
    assert_eq!(axis.state(), ContinuityState::Following);
    let (velocity, acceleration, _) = differences(&sets);
    assert!(
        // 1.875·100/30 = 6.25 u/s, and 5.77·100/30² = 0.64 u/s².
        velocity < 7.0 && acceleration < 1.0,
        "{velocity}, {acceleration}"
    );
}

#[test]
fn skipped_cycles_change_nothing_of_the_curve() {
    let run = |step: u32| -> Vec<Kinematics> {
        let mut axis = continuity();
        let _ = axis.follow(&master(0), 1);
        let braked = (0..60 / step).map(|_| axis.brake(step).unwrap()).last();
        let back = (0..600 / step).map(|n| axis.follow(&master(61 + n * step), step));
        let back: Vec<Kinematics> = back.collect();
        braked
            .into_iter()
            .chain(back.into_iter().step_by(6 / step as usize))
            .collect()
    };
    for (one, three) in run(1).iter().zip(&run(3)) {
        assert!(
            (one.position - three.position).abs() < 2.0,
            "{one:?} {three:?}"
        );
    }
}

/// Random schedules 119, 311 and 523: a jump that had passed was taken for the velocity of the
/// axis, which kept it.
#[test]
fn a_jump_that_passed_is_no_velocity() {
    let mut axis = continuity();
    let jumped = |n: u32| {
        steady(
            0.5 * f64::from(n) + if n < 100 { 0.0 } else { 220.0 },
            500.0,
        )
    };
    let mut sets: Vec<_> = (0..101).map(|n| axis.follow(&jumped(n), 1)).collect();
    axis.rejoin();
    sets.extend((101..2_000).map(|n| axis.follow(&jumped(n), 1)));
    let (velocity, ..) = differences(&sets[100..]);
    assert!(velocity < 1.6 * 510.0, "{velocity}");
}

proptest! {
    /// Faults in any order and at any distance from each other.
    #[test]
    fn nothing_is_a_step(
        parts in prop::collection::vec((0..3_u8, 1..400_u32, -1_000.0..1_000.0_f64), 1..20),
    ) {
        let mut axis = continuity();
        let mut sets = Vec::new();
        let (mut cycle, mut offset) = (0, 0.0);
        for (what, cycles, by) in parts {
            match what {
                0 => {}
                1 => {
                    offset += by;
                    axis.rejoin();
                }
                _ => {
                    for _ in 0..cycles {
                        sets.extend(axis.brake(1));
                        cycle += 1;
                    }
                }
            }
            for _ in 0..cycles {
                cycle += 1;
                let mut master = master(cycle);
                master.position += offset;
                sets.push(axis.follow(&master, 1));
            }
        }
        let (velocity, acceleration, contradiction) = differences(&sets);
        prop_assert!(velocity < 2.0 * 510.0, "{velocity}");
        prop_assert!(acceleration < 20_000.0, "{acceleration}");
        prop_assert!(contradiction < 0.5, "{contradiction}");
    }
}

/// `master-in-motion` with 5 % of loss: the first message of a motion was taken for a step of a
/// micrometre, and brought back at half of a velocity that was almost 0.
#[test]
fn a_master_that_has_just_begun_to_move_is_soon_come_back_to() {
    let mut axis = Axis::of(Reach::default());
    let master = |cycle: u32| {
        let t = CYCLE * f64::from(cycle);
        Kinematics {
            position: 0.5 * 5_000.0 * t * t,
            velocity: 5_000.0 * t,
            acceleration: 5_000.0,
        }
    };
    let _ = axis.follow(&steady(-0.001, 0.0), 1);
    axis.rejoin();
    let sets: Vec<_> = (0..150)
        .map(|cycle| {
            let master = master(cycle);
            axis.reach = Reach {
                velocity: master.velocity,
                acceleration: master.acceleration,
            };
            axis.follow(&master, 1)
        })
        .collect();
    assert_eq!(axis.state(), ContinuityState::Following);
    let (_, acceleration, contradiction) = differences(&sets);
    // The master's own, and up to the same amount on the way back.
    assert!(acceleration < 2.1 * 5_000.0, "{acceleration}");
    // ¼·a·T: towards a master that has not moved yet, the difference of the accelerations ends within a cycle.
    assert!(contradiction < 1.26, "{contradiction}");
}

/// Wide schedules 300665 and 300893: with bursts of loss, an axis that was brought back relative to the shown positions, which stood, ran
/// away from its master.
#[test]
fn relative_to_values_that_stand_until_the_next_frame_it_does_not_run_away() {
    const VELOCITY: f64 = -500.0;
    // A frame in every other cycle, then none for 14 cycles, again and again for 3 s.
    let frame_before = |cycle: u32| match cycle % 30 {
        within @ 16.. if cycle < 3_000 => cycle - (within - 16),
        _ => cycle - cycle % 2,
    };
    let at = |cycle: u32| steady(VELOCITY * f64::from(cycle) * CYCLE, VELOCITY);
    let mut axis = Axis::of(Reach {
        velocity: 500.0,
        acceleration: 2_000.0,
    });
    axis.follow(&steady(100.0, 0.0), 1);
    axis.rejoin();
    let (mut before, mut farthest, mut fastest) = (100.0, 0.0_f64, f64::MIN);
    for cycle in 1..6_000 {
        let frame = frame_before(cycle);
        let age = f64::from(cycle - frame) * CYCLE;
        let newest = Some(ReceivedMotion {
            set: at(frame),
            age,
        });
        let of_cycle = MasterCycle {
            newest,
            ..axis.cycle(1)
        };
        let set = match cycle - frame {
            ..=8 => axis.continuity.follow(&at(frame), &of_cycle),
            _ => axis.continuity.brake(&of_cycle).unwrap(),
        };
        farthest = farthest.max((set.position - at(cycle).position).abs());
        fastest = fastest.max((set.position - before) / CYCLE);
        before = set.position;
    }
    assert!(farthest < 320.0, "{farthest} from its master");
    assert!(fastest < 20.0, "{fastest} against its master's {VELOCITY}");
    assert_eq!(axis.state(), ContinuityState::Following);
    assert_eq!(before, at(frame_before(5_999)).position);
}

/// Wide schedule 500647: while an axis was brought back, an extrapolated position of its master moved at −245 000 u/s for 20 cycles of
/// 250 µs, and the axis went along.
#[test]
fn an_impossible_velocity_of_the_master_is_not_added() {
    const STEP: f64 = 250e-6;
    let reach = Reach {
        velocity: 945.0,
        acceleration: 50_000.0,
    };
    let mut axis = Axis {
        continuity: Continuity::new(Span::from_micros(250), Seconds(0.06)),
        reach,
    };
    let at = |cycle: u32| steady(-534.0 * f64::from(cycle) * STEP, -534.0);
    axis.follow(&at(0), 1);
    axis.follow(&at(1), 1);
    axis.rejoin();
    let mut before = at(1).position;
    for cycle in 2..20_000 {
        let shown = match cycle {
            400..420 => steady(
                at(cycle).position + 9_343.0 - 245_000.0 * f64::from(cycle - 400) * STEP,
                -245_000.0,
            ),
            _ => at(cycle),
        };
        if cycle == 390 || cycle == 420 {
            axis.rejoin();
        }
        let set = axis.follow(&shown, 1);
        let velocity = (set.position - before) / STEP;
        assert!(
            velocity.abs() < 1.6 * reach.velocity,
            "{velocity} in cycle {cycle}"
        );
        before = set.position;
    }
    assert_eq!(axis.state(), ContinuityState::Following);
}

/// Wide schedules 606543 and 702652: an encoder states the velocity of its first frame as a change within a cycle. Its axis, beside it by
/// that acceleration, was led to ten times its velocity, backwards.
#[test]
fn an_impossible_acceleration_adds_no_more_than_the_velocity_of_the_master() {
    let master = |cycle: u32| steady(0.4 * f64::from(cycle), 400.0);
    let hard = Kinematics {
        acceleration: 4e5,
        ..master(0)
    };
    let fastest = |sets: &[Kinematics]| {
        let ways = sets.windows(2).map(|two| two[1].position - two[0].position);
        let by_positions = ways.map(|way| way.abs() / CYCLE).fold(0.0, f64::max);
        let stated = sets.iter().map(|set| set.velocity.abs());
        stated.fold(by_positions, f64::max)
    };
    let reach = Reach {
        velocity: 400.0,
        acceleration: 4e5,
    };
    let mut axis = Axis::of(reach);
    let _ = axis.follow(&master(0), 1);
    axis.rejoin();
    let mut sets = std::vec![axis.follow(&hard, 1)];
    sets.extend((1..2_000).map(|cycle| axis.follow(&master(cycle), 1)));
    assert_eq!(axis.state(), ContinuityState::Following);
    // On the way back half of it is added, too.
    assert!(fastest(&sets) <= 2.5 * 400.0, "{}", fastest(&sets));
    let mut axis = Axis::of(reach);
    let _ = axis.follow(&hard, 1);
    let sets: Vec<_> = (0..600).filter_map(|_| axis.brake(1)).collect();
    assert!(fastest(&sets) <= 2.0 * 400.0, "{}", fastest(&sets));
    assert_eq!(sets[599].velocity, 0.0);
}
