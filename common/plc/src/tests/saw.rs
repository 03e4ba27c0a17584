//! The flying saw in a PLC program.

use coaxle_axis::CommandState;
use coaxle_saw::{GearInPos, Ratio, SawCommand, SyncLimits, SyncMask, SyncMode};

use super::*;
use crate::{
    CommandBlock, FlyingSawBlock, FlyingSawOutputs, Outputs, ReadFlyingSawCharacteristicsBlock,
};

/// Makes an axis with power, and a master at a velocity.
fn beside(parameters: &SlaveParameters, velocity: f64) -> (SlaveAxis, Master) {
    let mut axis = powered(parameters);
    let mut master = Master::at(0.0, velocity);
    master.lead(&mut axis, 1);
    (axis, master)
}

fn to_position(sync: (f64, f64), mask: SyncMask) -> GearInPos {
    GearInPos {
        ratio: Ratio::of(1.0),
        master_sync_position: sync.0,
        slave_sync_position: sync.1,
        master_start_distance: None,
        strategy: None,
        sync_mode: SyncMode::position_based(mask),
        limits: SyncLimits::default(),
    }
}

#[test]
fn a_program_couples_reads_and_uncouples() {
    let (mut axis, mut master) = beside(&PARAMETERS, 100.0);
    let (mut gear_in, mut gear_out) = (FlyingSawBlock::default(), CommandBlock::default());
    let mut read = ReadFlyingSawCharacteristicsBlock::default();
    let out = Command::GearOut {};
    let command = SawCommand::GearInPos(to_position((100.0, 80.0), SyncMask::empty()));

    // Without a plan there are no values.
    assert_eq!(read.scan(true, 2, &axis).0.error_id, 0x4216);
    let refused = gear_out.scan(true, &out, &mut axis, &mut Tables::new(0));
    assert_eq!(Outputs::of(&refused, JobError::code).error_id, 0x424d);
    assert_eq!(
        gear_out.scan(false, &out, &mut axis, &mut Tables::new(0)),
        CommandState::Idle
    );
    read.scan(false, 2, &axis);

    let outputs = gear_in.scan(true, command, &mut axis, &mut Tables::new(0));
    assert!(outputs.start_sync && outputs.common.busy && !outputs.common.in_sync);
    let (outputs, values) = read.scan(true, 2, &axis);
    assert!(outputs.done);
    let values = values.unwrap();
    assert_eq!(
        (
            values.table.id,
            values.end.master,
            values.end.slave.position
        ),
        (254, 100.0, 80.0)
    );
    assert_eq!(read.scan(false, 256, &axis).1, None);
    assert_eq!(read.scan(true, 256, &axis).0.error_id, 0x4a00);

    // The sync position 100 is reached after 1 s.
    master.lead(&mut axis, 1_500);
    let outputs = gear_in.scan(true, command, &mut axis, &mut Tables::new(0));
    assert!(outputs.common.in_sync && outputs.common.busy);
    assert_eq!(
        gear_out.scan(true, &out, &mut axis, &mut Tables::new(0)),
        CommandState::Done
    );
    let outputs = gear_in.scan(true, command, &mut axis, &mut Tables::new(0));
    assert!(outputs.common.command_aborted && !outputs.start_sync);
    let outputs = gear_in.scan(false, command, &mut axis, &mut Tables::new(0));
    assert_eq!(outputs, FlyingSawOutputs::default());
}

#[test]
fn a_refused_block_leaves_the_running_one() {
    let (mut axis, _) = beside(&PARAMETERS, 100.0);
    let (mut first, mut second) = (FlyingSawBlock::default(), FlyingSawBlock::default());
    let good = to_position((100.0, 80.0), SyncMask::empty());
    let bad = GearInPos {
        // The simplest refusal: a ratio of 0 moves nothing.
        ratio: Ratio::of(0.0),
        ..good
    };
    let (good, bad) = (SawCommand::GearInPos(good), SawCommand::GearInPos(bad));
    first.scan(true, good, &mut axis, &mut Tables::new(0));
    assert_eq!(
        second
            .scan(true, bad, &mut axis, &mut Tables::new(0))
            .common
            .error_id,
        0x421b
    );
    assert!(
        first
            .scan(true, good, &mut axis, &mut Tables::new(0))
            .common
            .busy
    );
    second.scan(false, bad, &mut axis, &mut Tables::new(0));
    second.scan(true, good, &mut axis, &mut Tables::new(0));
    assert!(
        first
            .scan(true, good, &mut axis, &mut Tables::new(0))
            .common
            .command_aborted
    );
}
