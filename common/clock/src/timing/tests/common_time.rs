//! A common time beside the timing channel: used, left behind, and contradicted.

use super::*;
use crate::common_time::{CommonReading, CommonTimeLack, FarCommonReading};
use crate::far_clock::CommonTimeOutput;

/// Rate of the common time against the local clock.
const TAI_DRIFT: f64 = -40e-6;
/// Stated greatest error of each node, ns.
const BOUND: i64 = 100;

/// Readings by both nodes of a clock that they have in common.
#[derive(Clone, Copy)]
struct Common {
    /// Error of the far node's reading, ns.
    off: f64,
    /// Growth of that, ns in each cycle.
    growth: f64,
    grandmasters: [u64; 2],
}

impl Common {
    const RIGHT: Self = Self {
        off: 0.0,
        growth: 0.0,
        grandmasters: [1, 1],
    };

    fn reading(&self, world: &mut World, node: usize, at: f64) -> CommonReading {
        let noise = Normal::new(0.0, 10.0).unwrap().sample(&mut world.random);
        let off = if node == 1 { self.off } else { 0.0 };
        let tai = at * (1.0 + TAI_DRIFT) + noise + off;
        CommonReading {
            time: Instant::from_nanos(tai.round() as i64),
            bound: Span::from_nanos(BOUND),
            grandmaster: self.grandmasters[node],
        }
    }

    /// Runs cycles in which both read it with every beacon.
    fn run(&mut self, world: &mut World, from: i64, cycles: i64) -> (CommonTimeOutput, Vec<f64>) {
        let mut errors = Vec::new();
        let mut newest = None;
        for n in from..from + cycles {
            self.off += self.growth;
            if n % EVERY == 0 {
                let here = (n * CYCLE) as f64 - 5e6;
                let there = here + 600_000.0;
                let own = self.reading(world, 0, here);
                let far = FarCommonReading {
                    epoch: world.epoch,
                    at: world.far_span(there),
                    common: self.reading(world, 1, there),
                };
                (world.clock).common_time(local(here), Some(own), Some(far));
            }
            let (output, error) = world.cycle(n);
            errors.extend(error);
            newest = output.common_time;
        }
        (newest.expect("readings were exchanged"), errors)
    }
}

#[test]
fn it_is_followed_and_neither_ways_nor_their_inequality_are_in_it() {
    for beacons in [true, false] {
        let mut world = World::new(1);
        world.beacons = beacons;
        // The ways of the timing channel are off by half of that.
        world.unequal = 3_000.0;
        let mut common = Common::RIGHT;
        let (output, _) = common.run(&mut world, 1, 20_000);
        assert_eq!(output.timing.state, TimingState::InUse);
        let (output, errors) = common.run(&mut world, 20_001, 20_000);
        assert!(rms(&errors) < 20.0, "{beacons}: {} ns", rms(&errors));
        assert!(largest_step(&errors) < SMOOTH, "{}", largest_step(&errors));
        assert!(!output.is_contradicted());
        // What the ways have it off by.
        let apart = output.timing.apart.unwrap().0 * 1e9;
        assert!(
            !beacons || (1_300.0..1_700.0).contains(&apart.abs()),
            "{apart}"
        );
    }
}

#[test]
fn one_that_leaps_is_contradicted_and_far_time_goes_on_as_it_did() {
    for leap in [20_000.0, -20_000.0] {
        let mut world = World::new(2);
        let mut common = Common::RIGHT;
        let (output, _) = common.run(&mut world, 1, 20_000);
        assert_eq!(output.timing.state, TimingState::InUse);
        common.off = leap;
        let (output, errors) = common.run(&mut world, 20_001, 10_000);
        assert!(output.is_contradicted(), "{output:?}");
        let apart = output.timing.apart.unwrap().0 * 1e9;
        assert!((apart.abs() - 20_000.0).abs() < 1_000.0, "{apart}");
        let largest = errors
            .iter()
            .fold(0.0_f64, |largest, error| largest.max(error.abs()));
        assert!(largest < 500.0, "{leap}: {largest} ns");
        // Back where it was.
        common.off = 0.0;
        let (output, errors) = common.run(&mut world, 30_001, 10_000);
        assert_eq!(output.timing.state, TimingState::InUse);
        assert!(rms(&errors[8_000..]) < 20.0, "{}", rms(&errors[8_000..]));
    }
}

#[test]
fn one_in_free_run_is_contradicted_where_the_ways_leave_it_no_room() {
    let mut world = World::new(3);
    let mut common = Common::RIGHT;
    let _ = common.run(&mut world, 1, 20_000);
    // 1 ppm: 20 µs in twenty seconds.
    common.growth = 1.0;
    let (output, errors) = common.run(&mut world, 20_001, 20_000);
    assert!(output.is_contradicted(), "{output:?}");
    // No further than half of the round trip, and what both state.
    let largest = errors
        .iter()
        .fold(0.0_f64, |largest, error| largest.max(error.abs()));
    assert!(largest < 2_000.0, "{largest} ns");
}

#[test]
fn one_that_ends_or_is_no_longer_common_leaves_far_time_where_it_was() {
    for what in ["lost", "another grandmaster", "the ways, too"] {
        let mut world = World::new(4);
        world.unequal = 3_000.0;
        let mut common = Common::RIGHT;
        let _ = common.run(&mut world, 1, 20_000);
        let errors = match what {
            "another grandmaster" => {
                common.grandmasters = [1, 2];
                let (output, errors) = common.run(&mut world, 20_001, 10_000);
                assert_eq!(output.lack, CommonTimeLack::OtherGrandmaster);
                assert_eq!(output.timing.state, TimingState::Held);
                errors
            }
            _ => {
                world.beacons = what == "lost";
                let (output, errors) = world.run(20_001, 10_000);
                let common_time = output.common_time.unwrap();
                assert_eq!(common_time.timing.state, TimingState::Held, "{what}");
                errors
            }
        };
        assert!(
            largest_step(&errors) < 2.0 * SMOOTH,
            "{what}: {}",
            largest_step(&errors)
        );
        let by_messages = if what == "the ways, too" {
            6_000.0
        } else {
            300.0
        };
        assert!(
            rms(&errors[..4_000]) < by_messages,
            "{what}: {}",
            rms(&errors[..4_000])
        );
    }
}

#[test]
fn seconds_apart_are_named_and_nothing_follows_them() {
    let mut world = World::new(5);
    let mut common = Common {
        off: 37e9,
        ..Common::RIGHT
    };
    let (output, errors) = common.run(&mut world, 1, 20_000);
    assert_eq!(output.lack, CommonTimeLack::SecondsApart);
    assert!(output.is_contradicted());
    assert_eq!(output.timing.state, TimingState::Waiting);
    assert!(rms(&errors[10_000..]) < 60.0, "{}", rms(&errors[10_000..]));
}
