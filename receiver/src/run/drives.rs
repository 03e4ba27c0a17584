//! The drives of the slaves in the real world.

use coaxle_drive_memory::{DriveIdentity, SharedMemoryDrive};
use coaxle_node::config::Wrong;

use crate::config::{DriveConfig, ReceiverConfig};
use crate::drives::Drives;

/// The drives in other processes.
///
/// # Errors
/// [`Wrong`] names the slave, and the error of its shared memory.
pub(super) fn drives(config: &ReceiverConfig, run: u64) -> Result<Drives, Wrong> {
    let cycle_time = config.cycle_time_us.0;
    let mut drives = Drives::new();
    for (n, slave) in config.slaves.iter().enumerate() {
        // The receiver simulates all others itself.
        let DriveConfig::SharedMemory(shared) = &slave.drive else {
            continue;
        };
        let identity = DriveIdentity {
            run,
            slave_id: config.slave_id(n),
            slave: slave.name.as_str(),
            cycle_time,
        };
        let path = &shared.path;
        let parameters = shared.parameters(cycle_time);
        let drive = SharedMemoryDrive::create(path, &identity, parameters)
            .map_err(|error| Wrong::with_reason(format!("slave[{n}].drive.path"), error))?;
        if drive.is_on_disk() {
            tracing::warn!(
                node = %config.name,
                slave = %slave.name,
                "{}: is on a disk, which may hold up the cycle; expected a file system in memory, such as \
                 /dev/shm",
                path.display()
            );
        }
        drives = drives.with(slave.name.as_str(), drive);
    }
    Ok(drives)
}
