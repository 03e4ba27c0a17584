//! Commands with master positions that count from a registration mark.

use coaxle_cam::{ActivationMode, CamIn};
use coaxle_gear::FlyingGearParameters;
use coaxle_plate::MotionPoint;
use coaxle_saw::GearInPos;
use coaxle_slave::{CamPoints, Command, SyncPosition};

use super::sensor::SensorMark;

/// Keys of the commands that have such positions.
pub(super) fn keys_with_positions() -> String {
    let rows = Command::ROWS.iter().filter(|row| row.traits.at_mark);
    rows.map(|row| row.key).collect::<Vec<_>>().join(", ")
}

/// True if a command has such positions.
pub(super) const fn has_positions(command: &Command) -> bool {
    command.row().traits.at_mark
}

/// Returns the command with its positions on the master's axis.
///
/// Positions on a plate count from the mark's position on a plate that begins at the mark used
/// before; `master_scaling` is that of the plate.
pub(super) fn placed(command: &Command, mark: &SensorMark, master_scaling: f64) -> Command {
    match *command {
        Command::GearInPos(saw) => Command::GearInPos(GearInPos {
            master_sync_position: from_mark(saw.master_sync_position, mark),
            ..saw
        }),
        Command::FlyingGear(gear) => Command::FlyingGear(FlyingGearParameters {
            master_sync_position: from_mark(gear.master_sync_position, mark),
            ..gear
        }),
        Command::CamIn(cam_in) => Command::CamIn(cam_in_at(cam_in, mark.position)),
        Command::WriteMotionFunction { table, points } => Command::WriteMotionFunction {
            table,
            points: shifted(points, mark.distance / master_scaling),
        },
        other => other,
    }
}

/// True if the master position of a command counts from another reference already.
pub(super) const fn counts_from_elsewhere(command: &Command) -> bool {
    let position = match command {
        Command::GearInPos(saw) => saw.master_sync_position,
        Command::FlyingGear(gear) => gear.master_sync_position,
        _ => return false,
    };
    position.as_position().is_none()
}

/// Shifts a plain position; others do not count from a mark.
fn from_mark(position: SyncPosition, mark: &SensorMark) -> SyncPosition {
    match position {
        SyncPosition::At(position) => SyncPosition::At(position + mark.position),
        elsewhere => elsewhere,
    }
}

/// Places the plate's master 0 at the mark, unless it counts from the master's position.
fn cam_in_at(mut cam_in: CamIn, mark: f64) -> CamIn {
    if !cam_in.start_mode.master_relative() {
        cam_in.master_offset -= mark;
    }
    let activation = &mut cam_in.activation;
    if matches!(
        activation.mode,
        ActivationMode::AtMasterAxisPos
            | ActivationMode::AtMasterAxisPosPositiveDirection
            | ActivationMode::AtMasterAxisPosNegativeDirection
    ) {
        activation.position += mark;
    }
    cam_in
}

fn shifted(points: CamPoints, distance: f64) -> CamPoints {
    let mut moved = [points[0]; CamPoints::MOST];
    for (to, from) in moved.iter_mut().zip(points.iter()) {
        *to = MotionPoint {
            master: from.master + distance,
            ..*from
        };
    }
    CamPoints::new(&moved[..points.len()]).expect("as many as there were")
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARK: SensorMark = SensorMark {
        position: 5_000.0,
        distance: 601.5,
    };

    fn command(text: &str) -> Command {
        #[derive(serde::Deserialize, schemars::JsonSchema)]
        struct File {
            command: Command,
        }
        let file: File = coaxle_node::config::parse("c", text).expect("a command");
        assert!(has_positions(&file.command));
        file.command
    }

    #[test]
    fn each_command_with_positions_counts_them_from_the_mark() {
        let commands = [
            "gear-in-pos = { ratio = { numerator = 1 }, master-sync-position = 250, slave-sync-position = 250 }",
            "flying-gear = { ratio = 1, master-sync-position = 30, slave-sync-position = 0, \
             slave-desync-position = 50, slave-stop-position = 60 }",
            "cam-in = { table = 1 }",
            "write-motion-function = { table = 1, points = [{ index = 4, law = 'polynom1', type = 'rest', master = 0, slave = 360 }] }",
        ];
        let commands = commands.map(|text| command(&format!("command.{text}")));
        for command in &commands {
            assert_ne!(placed(command, &MARK, 1.0), *command);
        }
        let mut keys: Vec<_> = commands.iter().map(Command::key).collect();
        keys.sort_unstable();
        let mut known: Vec<_> = keys_with_positions()
            .split(", ")
            .map(str::to_owned)
            .collect();
        known.sort_unstable();
        assert_eq!(keys, known);
    }

    #[test]
    fn the_plate_begins_at_the_mark() {
        let cam_in = command(
            "command.cam-in = { table = 1, master-offset = 7, master-scaling = 2, \
             activation = { mode = 'at-master-axis-pos', position = -20 } }",
        );
        let Command::CamIn(placed) = placed(&cam_in, &MARK, 1.0) else {
            panic!("still the same command");
        };
        assert_eq!(placed.master_offset, 7.0 - 5_000.0);
        assert_eq!(placed.activation.position, 4_980.0);
    }

    #[test]
    fn what_counts_from_the_master_or_from_the_plate_stays() {
        let cam_in = command(
            "command.cam-in = { table = 1, start-mode = 'relative', master-offset = 7, \
             activation = { mode = 'at-master-cam-pos', position = 20 } }",
        );
        assert_eq!(placed(&cam_in, &MARK, 1.0), cam_in);
    }

    #[test]
    fn points_end_the_plate_at_the_mark() {
        let write = command(
            "command.write-motion-function = { table = 1, points = [\
             { index = 3, type = 'motion', law = 'polynom1', master = -72, slave = 270 }, \
             { index = 4, type = 'motion', law = 'polynom1', master = 0, slave = 360 }] }",
        );
        let Command::WriteMotionFunction { points, .. } = placed(&write, &MARK, 600.0 / 360.0)
        else {
            panic!("still the same command");
        };
        let masters: Vec<f64> = points.iter().map(|point| point.master).collect();
        assert!((masters[0] - (360.9 - 72.0)).abs() < 1e-12, "{masters:?}");
        assert!((masters[1] - 360.9).abs() < 1e-12, "{masters:?}");
    }

    #[test]
    fn a_saw_is_synchronous_at_the_mark() {
        let saw = command(
            "command.gear-in-pos = { ratio = { numerator = 1 }, master-sync-position = 250, \
             slave-sync-position = 250 }",
        );
        let Command::GearInPos(placed) = placed(&saw, &MARK, 1.0) else {
            panic!("still the same command");
        };
        assert_eq!(placed.master_sync_position, SyncPosition::At(5_250.0));
        assert_eq!(placed.slave_sync_position, SyncPosition::At(250.0));
    }

    #[test]
    fn a_flying_gear_is_engaged_at_the_mark() {
        let gear = command(
            "command.flying-gear = { ratio = 1, master-sync-position = 30, slave-sync-position = 0, \
             slave-desync-position = 50, slave-stop-position = 60 }",
        );
        let Command::FlyingGear(placed) = placed(&gear, &MARK, 1.0) else {
            panic!("still the same command");
        };
        assert_eq!(placed.master_sync_position, SyncPosition::At(5_030.0));
    }
}
