//! A duplicate sender, and stray frames: the first run is followed as long as its frames arrive,
//! and no set position steps.

use crate::nodes::{Far, MILLISECOND, of, receiver, run};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node};
use coaxle_receiver::{HealthName, Receiver};

const VELOCITY: f64 = 300.0;

fn follower(mode: &str) -> Receiver {
    receiver(&format!(
        "master = {{ node = 'conveyor', axis = 1 }}\nmode = '{mode}'\ndelay = 'off'\n\
         sync.time-sync.automatic-re-init = true\n[[slave]]\nname = 'x'\n"
    ))
}

/// The set positions, and their distances from cycle to cycle.
#[derive(Default)]
struct Steps {
    last: Option<f64>,
    largest: f64,
    smallest: f64,
}

impl Steps {
    fn keep(&mut self, position: Option<f64>) {
        if let (Some(before), Some(now)) = (self.last, position) {
            assert!(now.is_finite());
            self.largest = self.largest.max(now - before);
            self.smallest = self.smallest.min(now - before);
        }
        self.last = position.or(self.last);
    }

    fn check(&self, mode: &str) {
        let cycle = VELOCITY * 1e-3;
        // A beat, or on the way to another run.
        assert!(self.largest < 2.6 * cycle, "{mode}: {}", self.largest);
        assert!(self.smallest > -0.6 * cycle, "{mode}: {}", self.smallest);
    }
}

#[test]
fn the_first_of_two_is_followed_and_named_until_it_is_silent() {
    for mode in ["bypass", "pt1", "sync", "time", "observer"] {
        let mut receiver = follower(mode);
        let mut first = Far::new(0, 1_000_100, &[VELOCITY]);
        let mut twin = Far::new(0, 999_900, &[VELOCITY]);
        twin.epoch = 99;
        twin.offsets = vec![5.0];
        let mut steps = Steps::default();
        let mut far = [first];
        run(&mut receiver, &mut far, 3_000 * MILLISECOND, |row, _| {
            steps.keep(row.slaves[0].position);
        });
        // The duplicate starts at this moment.
        twin.next = 3_000;
        [first] = far;
        let mut both = [first, twin];
        run(&mut receiver, &mut both, 8_000 * MILLISECOND, |row, at| {
            steps.keep(row.slaves[0].position);
            assert_eq!(row.far[0].epoch, Some(1), "{mode}");
            if at > 3_100 * MILLISECOND {
                assert_eq!(row.far[0].rival_epoch, Some(99), "{mode}");
                assert_eq!(row.far[0].health, HealthName::TwoSenders, "{mode}");
            }
        });
        let row = &receiver.snapshot().signals.far[0];
        // 5 s of the twin at 1 kHz, all refused.
        assert!(row.foreign_frames > 4_900 && row.restarts == 0, "{mode}");
        // The first one ends.
        both[0].silent = true;
        run(&mut receiver, &mut both, 30_000 * MILLISECOND, |row, _| {
            steps.keep(row.slaves[0].position);
        });
        let row = &receiver.snapshot().signals;
        assert_eq!((row.far[0].epoch, row.far[0].restarts), (Some(99), 1));
        assert_eq!(row.far[0].health, HealthName::Ok, "{mode}");
        // And returns as the same run, which is not followed any more.
        both[0].silent = false;
        run(&mut receiver, &mut both, 32_000 * MILLISECOND, |row, _| {
            steps.keep(row.slaves[0].position);
            assert_eq!(row.far[0].epoch, Some(99), "{mode}");
        });
        steps.check(mode);
    }
}

/// Sends an unexpected frame.
fn stray(
    receiver: &mut Receiver,
    at: Instant<coaxle_clock::Local>,
    epoch: u64,
    count: u64,
    ms: i64,
) {
    let header = FrameHeader {
        sender: 1,
        epoch,
        index: CycleIndex::of_count(count),
        count,
        cycle_time: CycleTime::new(Span::from_millis(ms)).expect("in range"),
        present_after: None,
        send_stamp: None,
    };
    let axes = [Some(AxisSample {
        set: Kinematics::at_rest(1e6),
        ..AxisSample::default()
    })];
    let axes = &axes;
    receiver.receive(at, of(0), &Message::Frame(Frame { header, axes }));
}

#[test]
fn stray_frames_move_nothing() {
    for mode in ["bypass", "pt1", "sync", "time", "observer"] {
        let mut receiver = follower(mode);
        let mut far = [Far::new(0, 1_001_000, &[VELOCITY])];
        let mut steps = Steps::default();
        // Another run, counts far ahead, other cycle times.
        let strays = [
            (5, 7, 1),
            (1, 1_000_000_000_000, 1),
            (1, u64::MAX, 1),
            (1, 4_000, 2),
            (0, 0, 100),
        ];
        run(&mut receiver, &mut far, 4_000 * MILLISECOND, |_, _| {});
        for (n, (epoch, count, ms)) in (0..).zip(strays) {
            let at = (4_100 + 200 * n) * MILLISECOND;
            run(&mut receiver, &mut far, at, |row, _| {
                steps.keep(row.slaves[0].position);
            });
            stray(&mut receiver, Instant::from_nanos(at), epoch, count, ms);
        }
        run(&mut receiver, &mut far, 8_000 * MILLISECOND, |row, _| {
            steps.keep(row.slaves[0].position);
        });
        let row = &receiver.snapshot().signals.far[0];
        assert_eq!((row.restarts, row.foreign_frames), (0, 5), "{mode}");
        assert_eq!(row.health, HealthName::Ok, "{mode}");
        let cycle = VELOCITY * 1e-3;
        // A beat is twice the way of a cycle.
        assert!(
            steps.smallest >= 0.0 && steps.largest < 2.1 * cycle,
            "{mode}"
        );
    }
}
