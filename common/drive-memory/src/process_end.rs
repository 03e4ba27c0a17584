//! The drive process's end of the memory.

use std::fs::File;
use std::path::Path;
use std::sync::atomic::Ordering;

use coaxle_axis::drive::ProcessState;
use coaxle_clock::{Instant, Span};
use coaxle_os::machine::Machine;

use super::block;
use super::error::{Reason, SharedMemoryError};
use super::file;
use super::layout as at;
use super::mapping::Mapping;

/// The attachment of a drive process, which reads set values and writes actual values.
///
/// One process is attached at a time. When dropped, it signals to the node that no process is attached.
#[derive(Debug)]
pub struct DriveProcess {
    mapping: Mapping,
    /// Holds the lock.
    _file: File,
    run: u64,
    heartbeat: u64,
}

/// The set values of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetValues {
    /// Incremented in each cycle: the heartbeat of the node.
    pub counter: u64,
    /// Ideal start of the cycle.
    pub ideal_start: Instant<Machine>,
    /// True if the drive shall have power and follow.
    pub enable: bool,
    /// A changed number means: acknowledge errors.
    pub resets: u64,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
}

/// Actual values of a drive process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessValues {
    /// State of the drive.
    pub state: ProcessState,
    /// Error code of the drive, 0 without an error.
    pub error: u32,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
    /// Counter of the set values that were read.
    pub counter: u64,
    /// Resets that were carried out.
    pub resets: u64,
}

impl ProcessValues {
    /// Values of a drive without power.
    #[must_use]
    pub const fn off(position: f64) -> Self {
        Self::with(ProcessState::Off, position, 0.0)
    }

    /// Values of a drive that follows.
    #[must_use]
    pub const fn following(position: f64, velocity: f64) -> Self {
        Self::with(ProcessState::Following, position, velocity)
    }

    /// Values of a drive with an error.
    #[must_use]
    pub const fn failed(error: u32, position: f64) -> Self {
        Self {
            error,
            ..Self::with(ProcessState::Error, position, 0.0)
        }
    }

    const fn with(state: ProcessState, position: f64, velocity: f64) -> Self {
        Self {
            state,
            error: 0,
            position,
            velocity,
            counter: 0,
            resets: 0,
        }
    }

    /// Turns these values into the response to these set values, with their reset carried out.
    #[must_use]
    pub const fn of(self, set: &SetValues) -> Self {
        Self {
            counter: set.counter,
            resets: set.resets,
            ..self
        }
    }
}

impl DriveProcess {
    /// Attaches to the memory of a running node.
    ///
    /// # Errors
    /// [`SharedMemoryError`] names the file, the value found and the one expected: the file is
    /// missing, its node has ended, another drive process is attached, the file is of another
    /// format or version, or the system refuses it.
    pub fn attach(path: &Path) -> Result<Self, SharedMemoryError> {
        let file = file::open(path)?;
        let system = |source| {
            let what = "mapped";
            file::wrong(path, Reason::System { what, source })
        };
        let mapping = Mapping::of(&file).map_err(system)?;
        let words = mapping.words();
        let run = words[at::RUN.0].load(Ordering::Acquire);
        // Checked after mapping: the node may end at any time, and the mapping stays valid without it.
        if run == 0 {
            return Err(file::wrong(path, Reason::Ended));
        }
        words[at::ACTUAL_PID.0].store(std::process::id().into(), Ordering::Relaxed);
        // An earlier process may have left any heartbeat: this one continues from there.
        let heartbeat = words[at::ACTUAL_HEARTBEAT.0].load(Ordering::Relaxed);
        Ok(Self {
            mapping,
            _file: file,
            run,
            heartbeat,
        })
    }

    /// True if the attached run of the node is still active. After its end, or the start of another
    /// run, attach again.
    #[must_use]
    pub fn is_attached(&self) -> bool {
        // Another node may have taken the file over, with other axes.
        self.word(at::RUN) == self.run
    }

    /// Name and axis id of the slave of the set values.
    #[must_use]
    pub fn slave(&self) -> (String, u32) {
        // The length comes from another process: a greater one would read set values as a name.
        let length = self.word(at::NAME_LENGTH).min(at::NAME_BYTES as u64);
        let words = &self.mapping.words()[at::NAME.0..];
        let bytes = words
            .iter()
            .flat_map(|word| word.load(Ordering::Relaxed).to_ne_bytes());
        let name: Vec<u8> = bytes.take(length as usize).collect();
        let id = self.word(at::SLAVE_ID) as u32;
        (String::from_utf8_lossy(&name).into_owned(), id)
    }

    /// The nominal cycle time of the node.
    #[must_use]
    pub fn cycle_time(&self) -> Span {
        // A count beyond an i64 is no cycle time of a node.
        Span::from_nanos(i64::try_from(self.word(at::CYCLE_TIME)).unwrap_or(0))
    }

    /// Reads the newest set values; none while they are being written, or after the end of the node.
    #[must_use]
    pub fn set_values(&self) -> Option<SetValues> {
        let words = self.mapping.words();
        let [
            counter,
            ideal_start,
            position,
            velocity,
            acceleration,
            enable,
            resets,
        ] = block::read(&words[at::SET_SEQUENCE.0], &words[at::SET_COUNTER.0..])?;
        // Asked after the block was read: set values of a node that ended meanwhile are not handed out.
        self.is_attached().then(|| SetValues {
            counter,
            ideal_start: Instant::from_nanos(ideal_start as i64),
            // Any other number is no permission for power.
            enable: enable == 1,
            resets,
            position: f64::from_bits(position),
            velocity: f64::from_bits(velocity),
            acceleration: f64::from_bits(acceleration),
        })
    }

    /// Writes the actual values of the drive. Each call increments the process's heartbeat.
    pub fn answer(&mut self, values: &ProcessValues) {
        // Wrapping: the node compares with the last number only.
        self.heartbeat = self.heartbeat.wrapping_add(1);
        self.write(self.run, values);
    }

    fn write(&self, run: u64, values: &ProcessValues) {
        let words = self.mapping.words();
        block::write(
            &words[at::ACTUAL_SEQUENCE.0],
            &words[at::ACTUAL_RUN.0..],
            [
                run,
                self.heartbeat,
                values.counter,
                values.resets,
                values.state.number(),
                values.error.into(),
                values.position.to_bits(),
                values.velocity.to_bits(),
            ],
        );
    }

    fn word(&self, field: at::Field) -> u64 {
        self.mapping.words()[field.0].load(Ordering::Acquire)
    }
}

impl Drop for DriveProcess {
    fn drop(&mut self) {
        // Run 0: the node takes values of its own run only, so that these count as silence.
        self.write(0, &ProcessValues::off(0.0));
    }
}
