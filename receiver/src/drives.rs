//! Drives of a receiver's slaves: simulated ones, and those that the code that builds the receiver passes.

mod late;

use coaxle_axis::drive::{Drive, SimulatedDrive};
use coaxle_clock::Span;
use coaxle_node::config::Wrong;

use crate::config::{DriveConfig, ReceiverConfig, SlaveConfig};
use late::LateDrive;

/// Drives for the slaves of a receiver, by name. A slave without one here has the drive of its config.
///
/// ```
/// use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
/// use coaxle_receiver::Drives;
///
/// let mine = SimulatedDrive::new(DriveParameters::default())?; // or any type that implements `Drive`
/// let drives = Drives::new().with("carriage", mine);
/// # let _ = drives;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Drives {
    given: Vec<(String, Box<dyn Drive>)>,
    simulate_the_rest: bool,
}

impl Drives {
    /// Starts without drives: every slave has the drive of its config, which must be a simulated one.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            given: Vec::new(),
            simulate_the_rest: false,
        }
    }

    /// Starts without drives, with a simulated drive for each that the config has in another
    /// process: for virtual time, and to check a config.
    #[must_use]
    pub const fn simulated() -> Self {
        Self {
            given: Vec::new(),
            simulate_the_rest: true,
        }
    }

    /// Adds a drive for the slave of that name, which replaces the configured one.
    #[must_use]
    pub fn with(mut self, slave: &str, drive: impl Drive + 'static) -> Self {
        self.given.push((slave.to_owned(), Box::new(drive)));
        self
    }

    /// # Errors
    /// [`Wrong`]: a drive for an unknown slave, two for one slave, or a slave without limits.
    pub(crate) fn check(&self, config: &ReceiverConfig) -> Result<(), Wrong> {
        for (n, (name, _)) in self.given.iter().enumerate() {
            if self.given[..n].iter().any(|(other, _)| other == name) {
                let received = format!("two for {name:?}");
                return Err(Wrong::of("drives", received, "one"));
            }
            // A misspelt name would leave the slave with a simulated drive, and the drive of the caller unused.
            if !config.slaves.iter().any(|s| s.name.as_str() == name) {
                let names: Vec<_> = config.slaves.iter().map(|s| s.name.as_str()).collect();
                let expected = format!("one of: {}", names.join(", "));
                return Err(Wrong::of(
                    "drives",
                    format_args!("one for {name:?}"),
                    expected,
                ));
            }
        }
        Ok(())
    }

    /// True if this slave has a drive that is not simulated.
    pub(crate) fn has_real(&self, slave: &SlaveConfig) -> bool {
        // A drive of the caller counts as real, whatever it does: nothing is known of its limits.
        let is_given = (self.given.iter()).any(|(name, _)| name == slave.name.as_str());
        is_given || matches!(slave.drive, DriveConfig::SharedMemory(_))
    }

    /// Takes the drive of a slave, once.
    ///
    /// # Errors
    /// [`Wrong`]: the reason why there is none.
    pub(crate) fn take(&mut self, slave: &SlaveConfig) -> Result<Box<dyn Drive>, Wrong> {
        let place = (self.given.iter()).position(|(name, _)| name == slave.name.as_str());
        match (place, &slave.drive) {
            // Before the configured kind, which the caller replaces. The order of the rest does not matter.
            (Some(place), _) => Ok(self.given.swap_remove(place).1),
            (None, DriveConfig::SharedMemory(_)) if !self.simulate_the_rest => {
                let received = format!("kind = {:?} and no drive for it", slave.drive.kind());
                let expected = format!("one that was given for {:?}", slave.name.as_str());
                Err(Wrong::of("drive", received, expected))
            }
            (None, _) => simulated(slave),
        }
    }
}

/// Makes the simulated drive of a slave, or the one that stands for a drive in another process.
fn simulated(slave: &SlaveConfig) -> Result<Box<dyn Drive>, Wrong> {
    let drive = SimulatedDrive::new(slave.drive.simulated())
        .map_err(|error| Wrong::with_reason("drive", error))?;
    Ok(match slave.simulated_dead_time() {
        Span::ZERO => Box::new(drive),
        dead_time => Box::new(LateDrive::new(drive, dead_time)),
    })
}
