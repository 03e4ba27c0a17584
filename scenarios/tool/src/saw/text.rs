//! Units and commands in words.

use coaxle_files::saw::SawFile;
use coaxle_report::inspect::QUANTITIES;
use coaxle_saw::{GearInSyncMode, SawCommand, SyncMode};

/// Unit of one of the [`QUANTITIES`].
pub(super) fn unit(saw: &SawFile, quantity: usize) -> String {
    format!("{}{}", saw.slave_unit, ["", "/s", "/s²", "/s³"][quantity])
}

/// Name of one of the [`QUANTITIES`] with its unit.
pub(super) fn heading(saw: &SawFile, quantity: usize) -> String {
    format!("{} ({})", QUANTITIES[quantity], unit(saw, quantity))
}

/// The name of the command in files.
pub(super) const fn command_name(command: &SawCommand) -> &'static str {
    match command {
        SawCommand::GearInPos(_) => "gear-in-pos",
        SawCommand::GearInVelo(_) => "gear-in-velo",
    }
}

/// Sync mode of the command.
pub(super) const fn sync_mode(command: &SawCommand) -> SyncMode {
    match command {
        SawCommand::GearInPos(command) => command.sync_mode,
        SawCommand::GearInVelo(command) => command.sync_mode,
    }
}

/// The command and the variable of its profile.
pub(super) fn description(saw: &SawFile) -> String {
    let command = command_name(&saw.command);
    match sync_mode(&saw.command).base {
        GearInSyncMode::PositionBased => format!("{command}, position-based"),
        GearInSyncMode::TimeBased => format!("{command}, time-based"),
    }
}
