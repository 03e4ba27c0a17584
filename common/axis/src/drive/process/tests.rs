//! The life of a drive in another process.

use super::*;
use std::string::ToString;
use std::sync::{Arc, Mutex};

use proptest::prelude::*;

const CYCLE: Seconds = Seconds(1e-3);

const PARAMETERS: ProcessDriveParameters = ProcessDriveParameters {
    max_silent_cycles: 5,
    switch_on_cycles: 20,
    following_error_window: 1.0,
    following_error_time: 0.003,
};

/// A process in a test: the last command, and its reply.
#[derive(Debug, Default)]
struct Process {
    told: DriveCommand,
    says: Option<DriveReply>,
}

#[derive(Clone, Debug, Default)]
struct Link(Arc<Mutex<Process>>);

impl DriveLink for Link {
    fn write(&mut self, command: &DriveCommand) {
        self.0.lock().unwrap().told = *command;
    }

    fn read(&mut self) -> Option<DriveReply> {
        self.0.lock().unwrap().says
    }
}

impl Link {
    /// Replies like a process that obeys the command.
    fn obeys(&self) {
        let mut process = self.0.lock().unwrap();
        let told = process.told;
        process.says = Some(DriveReply {
            // A new number in each cycle in which the process runs.
            heartbeat: told.counter,
            counter: told.counter,
            resets: told.resets,
            state: if told.enable {
                ProcessState::Following
            } else {
                ProcessState::Off
            },
            error: 0,
            position: told.set.position,
            velocity: told.set.velocity,
        });
    }

    fn told(&self) -> DriveCommand {
        self.0.lock().unwrap().told
    }

    fn says(&self, state: ProcessState, error: u32) {
        let mut process = self.0.lock().unwrap();
        let reply = process.says.as_mut().unwrap();
        (reply.state, reply.error) = (state, error);
        // Alive, so that only the state or the error can trip the drive.
        reply.heartbeat += 1;
    }
}

fn drive() -> (ProcessDrive<Link>, Link) {
    let link = Link::default();
    let drive = ProcessDrive::new(link.clone(), DriveKind::Own, PARAMETERS).unwrap();
    (drive, link)
}

fn step(drive: &mut ProcessDrive<Link>, position: f64) {
    drive.step(&Kinematics::at_rest(position), CYCLE);
}

/// A drive that follows.
fn following() -> (ProcessDrive<Link>, Link) {
    let (mut drive, link) = drive();
    for _ in 0..4 {
        step(&mut drive, 3.0);
        link.obeys();
    }
    drive.power_on(3.0, 0.0);
    for _ in 0..4 {
        step(&mut drive, 3.0);
        link.obeys();
    }
    assert_eq!(drive.actual().state, DriveState::Following);
    (drive, link)
}

fn trips(drive: &ProcessDrive<Link>) -> Option<DriveFault> {
    let actual = drive.actual();
    assert_eq!(actual.state == DriveState::Tripped, actual.fault.is_some());
    actual.fault
}

#[test]
fn it_switches_on_when_the_process_follows() {
    let (mut drive, link) = drive();
    step(&mut drive, 3.0);
    assert!(!link.told().enable);
    assert_eq!(drive.actual().attachment, Some(Attachment::default()));
    link.obeys();
    step(&mut drive, 3.0);
    assert!(
        !drive.actual().attachment.unwrap().attached,
        "it may be an old one"
    );
    link.obeys();
    step(&mut drive, 3.0);
    assert!(drive.actual().attachment.unwrap().attached);
    drive.power_on(3.0, 0.0);
    step(&mut drive, 3.0);
    assert!(link.told().enable);
    assert_eq!(drive.actual().state, DriveState::SwitchingOn);
    link.obeys();
    step(&mut drive, 3.0);
    assert_eq!(drive.actual().state, DriveState::Following);
    assert_eq!(drive.actual().attachment.unwrap().heartbeat_age, Some(0));
}

#[test]
fn without_a_process_it_is_not_ready() {
    let (mut drive, link) = drive();
    drive.power_on(0.0, 0.0);
    for _ in 0..19 {
        step(&mut drive, 0.0);
        assert_eq!(drive.actual().state, DriveState::SwitchingOn);
    }
    step(&mut drive, 0.0);
    assert_eq!(trips(&drive), Some(DriveFault::NotAttached));
    assert!(!link.told().enable);
}

#[test]
fn a_process_that_does_not_follow_is_not_ready() {
    let (mut drive, link) = drive();
    drive.power_on(0.0, 0.0);
    for _ in 0..20 {
        step(&mut drive, 0.0);
        link.obeys();
        link.says(ProcessState::Off, 0);
    }
    assert_eq!(trips(&drive), Some(DriveFault::NotReady { cycles: 20 }));
}

#[test]
fn a_heartbeat_that_stops_trips_it_and_a_reset_brings_it_back() {
    let (mut drive, link) = following();
    // The first of them still reads a new heartbeat, the other five are allowed.
    for _ in 0..6 {
        step(&mut drive, 3.0);
        assert_eq!(trips(&drive), None);
    }
    step(&mut drive, 3.0);
    assert_eq!(
        trips(&drive),
        Some(DriveFault::Silent { cycles: 6, most: 5 })
    );
    assert_eq!(link.told().state, DriveState::Tripped);
    // The process is alive again: that alone has no effect.
    for _ in 0..10 {
        link.obeys();
        step(&mut drive, 3.0);
    }
    assert!(drive.actual().attachment.unwrap().attached);
    assert!(trips(&drive).is_some());
    drive.reset();
    drive.power_on(3.0, 0.0);
    for _ in 0..3 {
        step(&mut drive, 3.0);
        link.obeys();
    }
    assert_eq!(drive.actual().state, DriveState::Following);
}

#[test]
fn an_error_of_the_process_counts_until_it_has_acknowledged_it() {
    let (mut drive, link) = following();
    link.says(ProcessState::Error, 0x8611);
    step(&mut drive, 3.0);
    assert_eq!(trips(&drive), Some(DriveFault::Reported { error: 0x8611 }));
    drive.reset();
    drive.power_on(3.0, 0.0);
    link.says(ProcessState::Error, 0x8611);
    step(&mut drive, 3.0);
    assert_eq!(
        drive.actual().state,
        DriveState::SwitchingOn,
        "that is the old one"
    );
    link.obeys();
    step(&mut drive, 3.0);
    assert_eq!(drive.actual().state, DriveState::Following);
    link.says(ProcessState::Off, 0);
    step(&mut drive, 3.0);
    assert_eq!(trips(&drive), Some(DriveFault::PowerLost));
    drive.reset();
    drive.power_on(3.0, 0.0);
    step(&mut drive, 3.0);
    link.obeys();
    link.says(ProcessState::Unknown(7), 0);
    step(&mut drive, 3.0);
    assert_eq!(
        trips(&drive),
        Some(DriveFault::UnknownState { received: 7 })
    );
}

#[test]
fn a_frozen_position_trips_it_though_the_heart_beats() {
    let (mut drive, link) = following();
    let mut cycles = 0;
    while trips(&drive).is_none() {
        cycles += 1;
        step(&mut drive, 3.0 + 0.5 * f64::from(cycles));
        link.says(ProcessState::Following, 0);
        assert!(cycles < 100);
    }
    assert!(matches!(
        trips(&drive),
        Some(DriveFault::FollowingError { .. })
    ));
    // 0.5 u a cycle: 1.5 behind from the fourth on, and then for more than 3 ms.
    assert!((6..=8).contains(&cycles), "{cycles}");
}

#[test]
fn one_that_is_not_where_it_is_told_to_be_does_not_begin() {
    let (mut drive, link) = drive();
    drive.power_on(3.0, 0.0);
    while trips(&drive).is_none() {
        step(&mut drive, 3.0);
        link.obeys();
        link.0.lock().unwrap().says.as_mut().unwrap().position = 5.0;
    }
    let elsewhere = DriveFault::PositionMismatch {
        received: 5.0,
        expected: 3.0,
        window: 1.0,
    };
    assert_eq!(trips(&drive), Some(elsewhere));
}

#[test]
fn parameters_out_of_range_are_named() {
    let link = Link::default();
    let wrong = |parameters| {
        ProcessDrive::new(link.clone(), DriveKind::Own, parameters)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        wrong(ProcessDriveParameters {
            max_silent_cycles: 0,
            ..PARAMETERS
        }),
        "max-silent-cycles is 0, expected 1 to 4294967294"
    );
    assert_eq!(
        wrong(ProcessDriveParameters {
            following_error_window: f64::NAN,
            ..PARAMETERS
        }),
        "following-error-window is NaN, expected a number above 0, at most 1e12"
    );
}

proptest! {
    /// For any reply of a process: no panic, power only while it is wanted, and a trip stays.
    #[test]
    fn whatever_the_process_says(
        says in proptest::collection::vec(
            (any::<bool>(), any::<u64>(), 0_u64..4, any::<f64>(), any::<f64>(), 0_u8..20),
            1..200,
        )
    ) {
        let (mut drive, link) = drive();
        for (there, heartbeat, state, position, velocity, act) in says {
            let resets = link.told().resets;
            link.0.lock().unwrap().says = there.then_some(DriveReply {
                heartbeat,
                counter: 0,
                resets,
                state: ProcessState::of(state),
                error: 1,
                position,
                velocity,
            });
            match act {
                0 => drive.reset(),
                1..4 => drive.power_on(0.0, 0.0),
                _ => {}
            }
            let before = drive.actual().state;
            step(&mut drive, 0.0);
            let after = drive.actual().state;
            prop_assert!(before != DriveState::Tripped || after == DriveState::Tripped);
            prop_assert!(before != DriveState::Off || after == DriveState::Off);
            let powered = matches!(after, DriveState::SwitchingOn | DriveState::Following);
            prop_assert_eq!(link.told().enable, powered);
        }
    }
}
