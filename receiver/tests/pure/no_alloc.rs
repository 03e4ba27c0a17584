//! Absence of allocations in a receiver, between two cycles and in one, for any input.

mod whole_life;

use crate::bench::{Clock, MILLISECOND, SECOND};
use crate::nodes;
use assert_no_alloc::assert_no_alloc;
use coaxle_axis::AxisStatus;
use coaxle_axis::drive::{
    DriveCommand, DriveKind, DriveLink, DriveReply, ProcessDrive, ProcessDriveParameters,
    ProcessState,
};
use coaxle_clock::Instant;
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_node::config::parse;
use coaxle_node::{Channel, Node};
use coaxle_receiver::{Drives, HealthName, Receiver, ReceiverConfig};
use coaxle_slave::{Command, CouplingPhase, Dynamics};

/// Synchronises, pauses for 3 s with a backlog, loses its master, finds a new run of it.
#[test]
fn receiving_cycling_transmitting_and_showing_do_not_allocate() {
    for mode in ["sync", "observer"] {
        whole_life::goes_through_its_life_without_allocating(mode);
    }
}

/// A standby takes over, and back, with the smoothing of its axis's increments.
#[test]
fn taking_over_does_not_allocate() {
    let text = "[[far]]\nnode = 'a'\nstandby = ['b']\naxes = [{ id = 1, encoder = { increment = 0.05 } }]\n\
                [[slave]]\nmaster = 'a.1'\n";
    let mut receiver = nodes::receiver(text);
    let mut lines = [0, 1].map(|n| nodes::Far::new(n, 1_000_000, &[300.0]));
    for (until, silent) in [
        (4_000, None),
        (8_000, Some(0)),
        (12_000, None),
        (16_000, Some(1)),
    ] {
        for (n, line) in lines.iter_mut().enumerate() {
            line.silent = silent == Some(n);
        }
        assert_no_alloc(|| {
            nodes::run(&mut receiver, &mut lines, until * MILLISECOND, |_, _| {});
        });
    }
    // In a debug build, an allocation ends the test at once.
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert_eq!(receiver.snapshot().signals.far[0].take_overs, 2);
}

/// A plate is coupled, scaled, edited and replaced repeatedly, without allocation.
#[test]
fn cams_and_programs_do_not_allocate() {
    let config: ReceiverConfig = parse("r.toml", CAMS).expect("a config");
    let clock = Clock { ppm: 0 };
    let mut receiver = Receiver::new(&config, clock.read(MILLISECOND / 2), 7).expect("a receiver");
    let halt = Command::Halt {
        dynamics: Dynamics::default(),
    };
    let wheel = receiver.slave_number("wheel").expect("a slave");
    let (mut in_sync, mut frames, mut refused) = (0, 0, 0);
    assert_no_alloc(|| {
        while receiver.next_cycle() < clock.read(8_000 * MILLISECOND) {
            let _ = receiver.cycle(receiver.next_cycle());
            while let Some(outgoing) = receiver.transmit() {
                frames += usize::from(outgoing.channel == Channel::Slaves);
            }
            let cam = &receiver.snapshot().signals.slaves[1];
            in_sync += u32::from(cam.phase == Some(CouplingPhase::InSync));
        }
        refused += u32::from(receiver.command(wheel, &Command::GearOut {}).is_err());
        refused += u32::from(receiver.command(wheel, &halt).is_err());
    });
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    let snapshot = receiver.snapshot();
    assert_eq!(snapshot.faults[1].error, None);
    let knife = &snapshot.faults[2];
    assert_eq!((knife.error, knife.refusal), (None, None));
    let cuts = snapshot.signals.slaves[2].cuts;
    // 720°/s are two turns per second: 16 cuts in 8 s, less the ramp-in.
    assert!(cuts >= 12, "{cuts}");
    assert_eq!(snapshot.health.name(), HealthName::WaitingForMaster);
    assert!(in_sync > 6_000, "{in_sync}");
    // 8 s are 8 000 cycles, with a frame in each.
    assert!(frames > 7_990);
    // Only GearOut is refused: the wheel is coupled to nothing.
    assert_eq!(refused, 1);
}

/// Three far nodes, one of which falls silent and returns as another run; a slave of two of them,
/// and of another slave, is stopped, reset and coupled again. Two virtual axes have slaves, too.
#[test]
fn several_far_nodes_and_a_slave_of_several_masters_do_not_allocate() {
    let mut receiver = nodes::receiver(LINE);
    let mut far = [
        nodes::Far::new(0, 1_000_020, &[100.0, 200.0]),
        nodes::Far::new(1, 999_985, &[300.0]),
        nodes::Far::new(2, 1_001_000, &[10.0, 20.0, 30.0]),
    ];
    let sum = receiver.slave_number("sum").expect("a slave");
    let (mut in_sync, mut stopped) = (0, 0);
    assert_no_alloc(|| {
        for (until_s, silent, epoch) in [(4, false, 1), (6, true, 1), (19, false, 2)] {
            (far[1].silent, far[1].epoch) = (silent, epoch);
            nodes::run(&mut receiver, &mut far, until_s * SECOND, |row, _| {
                let slave = &row.slaves[1];
                in_sync += u32::from(slave.phase == Some(CouplingPhase::InSync));
                stopped += u32::from(slave.state == AxisStatus::ErrorStop);
            });
        }
        let _ = receiver.command(sum, &Command::Reset {});
        let _ = receiver.command(sum, &gear(2.0));
        for n in 0..1_000 {
            let until = 20 * SECOND + n * MILLISECOND;
            nodes::run(&mut receiver, &mut far, until, |_, _| {});
            // Another ratio in every cycle.
            let _ = receiver.command(sum, &gear(2.0 + 1e-4 * n as f64));
        }
    });
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert!(in_sync > 1_000 && stopped > 4_000, "{in_sync} {stopped}");
    let row = &receiver.snapshot().signals;
    assert_eq!((row.slaves[1].error, row.slaves[1].refusal), (0, 0));
    assert_eq!(row.slaves[1].phase, Some(CouplingPhase::InSync));
    // Ratios 2.1, 1 and −0.5 of 100, 300 and 10 u/s.
    let expected = 100.0 * 2.1 + 300.0 - 5.0;
    let velocity = row.slaves[1].velocity.expect("an axis");
    assert!((velocity - expected).abs() < 1.0, "{velocity}");
    assert_eq!(row.slaves[2].phase, Some(CouplingPhase::InSync));
    assert!(row.virtual_axes[0].position > 1_000.0);
    assert_eq!(row.slaves[3].position, Some(row.virtual_axes[1].position));
    assert_eq!(receiver.snapshot().health.name(), HealthName::Ok);
}

/// A drive process that responds in the next cycle, and is absent for a while in each second.
#[derive(Debug, Default)]
struct Loop(DriveCommand);

impl DriveLink for Loop {
    fn write(&mut self, command: &DriveCommand) {
        self.0 = *command;
    }

    fn read(&mut self) -> Option<DriveReply> {
        let DriveCommand {
            counter,
            enable,
            resets,
            set,
            ..
        } = self.0;
        // 99 cycles are far beyond the 5 that it may be silent.
        let gone = counter % 1_000 > 900;
        (!gone).then_some(DriveReply {
            heartbeat: counter,
            counter,
            resets,
            state: ProcessState::of(enable.into()),
            error: 0,
            position: set.position,
            velocity: set.velocity,
        })
    }
}

/// A drive in another process is switched on, followed, lost, and reset, again and again.
#[test]
fn a_drive_in_another_process_does_not_allocate() {
    let text = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'm' }\n
        [[slave]]\nname = 'carriage'\ncouple = 'off'\n
        limits = { velocity = 200, acceleration = 5000, jerk = 1e6 }";
    let config: ReceiverConfig = parse("r.toml", text).expect("a config");
    let parameters = ProcessDriveParameters {
        max_silent_cycles: 5,
        switch_on_cycles: 100,
        following_error_window: 10.0,
        following_error_time: 0.02,
    };
    let drive = ProcessDrive::new(Loop::default(), DriveKind::Own, parameters).expect("in range");
    let drives = Drives::new().with("carriage", drive);
    let mut receiver =
        Receiver::with_drives(&config, drives, Instant::EPOCH, 1).expect("a receiver");
    let carriage = receiver.slave_number("carriage").expect("a slave");
    let (mut stopped, mut moved) = (0, 0);
    assert_no_alloc(|| {
        let _ = receiver.command(carriage, &Command::Power(true));
        for _ in 0..10_000 {
            let _ = receiver.cycle(receiver.next_cycle());
            while receiver.transmit().is_some() {}
            let slave = receiver.snapshot().signals.slaves[0];
            match slave.state {
                AxisStatus::Standstill => {
                    let dynamics = Dynamics::default();
                    let velocity = 100.0;
                    let go = Command::MoveVelocity { velocity, dynamics };
                    moved += u32::from(receiver.command(carriage, &go).is_ok());
                }
                AxisStatus::ErrorStop if slave.velocity == Some(0.0) => {
                    stopped += u32::from(receiver.command(carriage, &Command::Reset {}).is_ok());
                }
                _ => {}
            }
        }
    });
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    // Once a second, for 10 s.
    assert!(moved >= 9 && stopped >= 9, "{moved} {stopped}");
}

fn gear(ratio: f64) -> Command {
    Command::GearInMultiMaster(GearInMultiMaster {
        ratios: Ratios::new(&[ratio, 1.0, -0.5]).expect("ratios"),
        dynamics: Dynamics::default(),
        sync_mode: MultiMasterSync::default(),
    })
}

const LINE: &str = "
publish-far-axes = true
[[far]]
node = 'a'
axes = ['1-2']
delay = 'off'
[[far]]
node = 'b'
axes = [{ id = 1, name = 'belt', encoder = { increment = 0.01 } }]
delay = 'off'
[[far]]
node = 'c'
axes = ['1-3']
mode = 'sync'
sync.time-sync.automatic-re-init = true
[[virtual-axis]]
id = 1
name = 'shaft'
modulo = 360
[virtual-axis.program]
limits = { velocity = 500, acceleration = 2000, jerk = 20000 }
repeat = true
steps = [
    { enable = true },
    { loop = { count = 3, steps = [{ move-relative = { distance = 90 } }, { dwell = { for-s = 0.05 } }] } },
    { velocity = { value = 300, for-s = 0.5 } },
    { halt = {} },
]
[[virtual-axis]]
id = 2
name = 'wheel'
[virtual-axis.encoder]
resolution = 0.01
[virtual-axis.encoder.program]
start-velocity = 100
limits = { velocity = 500, acceleration = 2000, jerk = 20000 }
[[slave]]
name = 'roll'
master = 'c.1'
[[slave]]
name = 'sum'
master = 'a.1'
further-masters = ['belt', 'roll']
limits = { velocity = 2000, acceleration = 5000, jerk = 100000 }
[[slave.step]]
when = { master-ready = true }
do = { power = true }
[[slave.step]]
do = { gear-in-multi-master = { ratios = [1.0, 1.0, -0.5] } }
[[slave]]
name = 'press'
master = 'shaft'
further-masters = ['wheel']
couple = { cam = { table = 1 } }
limits = { velocity = 2000, acceleration = 100000, jerk = 1e8 }
[[slave.cams]]
table-id = 1
course = 'cyclic'
point = [
  { master = 0, slave = 0, law = 'polynom5' },
  { master = 180, slave = 40, law = 'polynom5' },
  { master = 360, slave = 0 },
]
[[slave]]
name = 'second'
master = 'wheel'
";

const CAMS: &str = "
name = 'press'
cycle-time-us = 1000
master.node = 'conveyor'

[[slave]]
name = 'wheel'
limits = { velocity = 1000, acceleration = 5000, jerk = 50000 }
[[slave.step]]
do = { power = true }
[[slave.step]]
do = { move-velocity = { velocity = 720 } }

[[slave]]
name = 'cam'
master = 'wheel'
limits = { velocity = 2000, acceleration = 60000, jerk = 1e7 }
[[slave.cams]]
table-id = 1
course = 'cyclic'
point = [
  { master = 0, slave = 0, law = 'polynom5' },
  { master = 180, slave = 50, law = 'polynom5' },
  { master = 360, slave = 0 },
]
[[slave.cams]]
table-id = 2
course = 'cyclic'
point = [
  { master = 0, slave = 0, law = 'bestehorn' },
  { master = 200, slave = 30, law = 'bestehorn' },
  { master = 360, slave = 0 },
]
[[slave.step]]
when = { master-ready = true }
do = { power = true }
[[slave.step]]
do = { cam-in = { table = 1 } }
[[slave.step]]
do = { set-cam-online-change-mode = { table = 1, mode.activation.mode = 'next-cycle' } }
[[slave.step]]
label = 'again'
when = { after-s = 0.6 }
do = { write-motion-function = { table = 1, points = [{ index = 2, law = 'polynom5', type = 'rest', master = 170, slave = 40 }] } }
[[slave.step]]
when = { after-s = 0.6 }
do = { cam-scaling = { activation.mode = 'next-cycle', scaling.slave.scaling = 1.5 } }
[[slave.step]]
when = { after-s = 0.6 }
do = { cam-in = { table = 2, activation.mode = 'next-cycle' } }
[[slave.step]]
when = { after-s = 0.6 }
do = { cam-in = { table = 1, activation.mode = 'next-cycle' } }
repeat-from = 'again'

[[slave]]
name = 'knife'
master = 'wheel'
limits = { velocity = 5000, acceleration = 200000, jerk = 1e8 }
tool.cuts-every = 360
marks = { first = 90, spacing = 360, spacing-swing = { amplitude = 2, marks = 7 }, sensor-distance = 400 }
[[slave.cams]]
table-id = 3
course = 'cyclic'
point = [
  { master = 0, slave = 0, velocity = 1, law = 'polynom5-mm' },
  { master = 360, slave = 360, velocity = 1 },
]
[[slave.step]]
when = { master-ready = true }
do = { power = true }
[[slave.step]]
do = { set-cam-online-change-mode = { table = 3, mode = { activation.mode = 'next-cycle', master-scaling-mode = 'auto-offset' } } }
[[slave.step]]
at-mark = true
do = { cam-in = { table = 3, jump = { ramp-in = { master-length = 300 } } } }
[[slave.step]]
label = 'next mark'
at-mark = true
do = { write-motion-function = { table = 3, points = [{ index = 2, law = 'polynom1', type = 'motion', master = 0, slave = 360, velocity = 1 }] } }
repeat-from = 'next mark'
";
