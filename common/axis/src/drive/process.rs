//! A drive in another process: its presence, heartbeat and faults.

use core::fmt;

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use super::{Actual, Attachment, Drive, DriveFault, DriveKind, DriveState, WrongDriveParameter};
use crate::window_monitor::WindowMonitor;

/// Link that carries values between a node and the process of a drive. Called in the cycle: it must
/// not wait.
pub trait DriveLink: fmt::Debug + Send {
    /// Hands a cycle over to the process.
    fn write(&mut self, command: &DriveCommand);

    /// Reads the current reply of the process; none if it is not attached, or the reply is just
    /// being written. Then the previous reply remains valid, and its heartbeat ages.
    fn read(&mut self) -> Option<DriveReply>;
}

/// Command of a node to a drive process in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveCommand {
    /// Incremented in each cycle: the heartbeat of the node.
    pub counter: u64,
    /// True if the drive shall have power and follow.
    pub enable: bool,
    /// A changed number means: acknowledge errors.
    pub resets: u64,
    /// State of the drive as seen by the node.
    pub state: DriveState,
    /// The set values.
    pub set: Kinematics,
}

/// Reply of a drive process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveReply {
    /// Changes as long as the process lives.
    pub heartbeat: u64,
    /// Counter of the command that was read.
    pub counter: u64,
    /// Resets that were carried out.
    pub resets: u64,
    /// State of the drive.
    pub state: ProcessState,
    /// Error code of the drive, 0 without an error.
    pub error: u32,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
}

/// State of a drive as reported by its process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProcessState {
    /// No power, or not yet.
    #[default]
    Off,
    /// Following.
    Following,
    /// Error, until acknowledged.
    Error,
    /// Unknown state.
    Unknown(u64),
}

impl ProcessState {
    /// The state with a number.
    #[must_use]
    pub const fn of(number: u64) -> Self {
        match number {
            0 => Self::Off,
            1 => Self::Following,
            2 => Self::Error,
            unknown => Self::Unknown(unknown),
        }
    }

    /// Number of the state.
    #[must_use]
    pub const fn number(self) -> u64 {
        match self {
            Self::Off => 0,
            Self::Following => 1,
            Self::Error => 2,
            Self::Unknown(number) => number,
        }
    }
}

/// Monitoring parameters of a drive process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessDriveParameters {
    /// Cycles that may pass without a change of its heartbeat, at least 1.
    pub max_silent_cycles: u32,
    /// Greatest number of cycles from the power command until it follows, at least 1.
    pub switch_on_cycles: u32,
    /// Largest following error, u, above 0. The set values are those of the previous cycle, so it
    /// must exceed the distance that the axis travels in the cycles that the process takes to
    /// respond.
    pub following_error_window: f64,
    /// Time for which the following error may exceed its window, s.
    pub following_error_time: f64,
}

impl ProcessDriveParameters {
    fn check(&self) -> Result<(), WrongDriveParameter> {
        // The age saturates at `u32::MAX`, which so is above every limit.
        let most = f64::from(u32::MAX - 1);
        let cycles = (1.0..=most, "1 to 4294967294");
        let window = (
            // 0 would switch the monitor off: a process that no longer moves would go unnoticed.
            f64::MIN_POSITIVE..=Actual::LARGEST,
            "a number above 0, at most 1e12",
        );
        let time = (0.0..=1e6, "a number from 0 to 1e6");
        for (parameter, received, (range, expected)) in [
            (
                "max-silent-cycles",
                f64::from(self.max_silent_cycles),
                cycles.clone(),
            ),
            ("switch-on-time-s", f64::from(self.switch_on_cycles), cycles),
            (
                "following-error-window",
                self.following_error_window,
                window,
            ),
            ("following-error-time-s", self.following_error_time, time),
        ] {
            if !range.contains(&received) {
                return Err(WrongDriveParameter {
                    parameter,
                    received,
                    expected,
                });
            }
        }
        Ok(())
    }
}

/// A drive in another process, over a link.
///
/// After power on it is [`SwitchingOn`](DriveState::SwitchingOn) until the process reports that it
/// follows. It trips if the process is absent or does not follow in time; if the heartbeat stops;
/// if the process reports an error or stops following; and if the following error exceeds its
/// window for too long. While it is tripped the process gets no power.
#[derive(Debug)]
pub struct ProcessDrive<L> {
    link: L,
    kind: DriveKind,
    parameters: ProcessDriveParameters,
    monitor: WindowMonitor,
    state: DriveState,
    fault: Option<DriveFault>,
    /// Last reply of the process.
    reply: Option<DriveReply>,
    /// Cycles since its heartbeat changed; none before the first change.
    age: Option<u32>,
    /// Cycles since the power command.
    waited: u32,
    counter: u64,
    resets: u64,
    last_set: f64,
}

impl<L: DriveLink> ProcessDrive<L> {
    /// Creates a drive without power, whose process may attach later.
    ///
    /// # Errors
    /// [`WrongDriveParameter`] names the parameter that is out of range.
    pub fn new(
        link: L,
        kind: DriveKind,
        parameters: ProcessDriveParameters,
    ) -> Result<Self, WrongDriveParameter> {
        parameters.check()?;
        let ProcessDriveParameters {
            following_error_window: window,
            following_error_time: time,
            ..
        } = parameters;
        Ok(Self {
            link,
            kind,
            parameters,
            monitor: WindowMonitor::new(window, time),
            state: DriveState::Off,
            fault: None,
            reply: None,
            age: None,
            waited: 0,
            counter: 0,
            resets: 0,
            last_set: 0.0,
        })
    }

    /// Link of its values.
    #[must_use]
    pub const fn link(&self) -> &L {
        &self.link
    }

    /// Takes the reply of the process.
    fn listen(&mut self) {
        // Before the reading: a reply that is just being written lets the heartbeat age.
        self.age = self.age.map(|age| age.saturating_add(1));
        let Some(reply) = self.link.read() else {
            return;
        };
        // A first heartbeat may be old and does not count.
        let beats = (self.reply).is_some_and(|before| before.heartbeat != reply.heartbeat);
        if beats {
            self.age = Some(0);
        }
        self.reply = Some(reply);
    }

    fn is_attached(&self) -> bool {
        self.age
            .is_some_and(|age| age <= self.parameters.max_silent_cycles)
    }

    /// Updates the state.
    fn judge(&mut self, elapsed: Seconds) -> Result<(), DriveFault> {
        match self.state {
            DriveState::Off | DriveState::Tripped => Ok(()),
            DriveState::SwitchingOn => self.switch_on(),
            DriveState::Following => self.watch(elapsed),
        }
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.waited = self.waited.saturating_add(1);
        // A reply from before a reset is ignored.
        let reply = self.reply.filter(|reply| reply.resets == self.resets);
        if let Some(reply) = reply.filter(|_| self.is_attached()) {
            match reply.state {
                ProcessState::Off => {}
                ProcessState::Following => return self.begin(),
                other => return Err(fault_of(other, reply.error)),
            }
        }
        // A process that starts after the request may still attach in time.
        if self.waited < self.parameters.switch_on_cycles {
            Ok(())
        } else if self.is_attached() {
            let cycles = self.waited;
            Err(DriveFault::NotReady { cycles })
        } else {
            Err(DriveFault::NotAttached)
        }
    }

    /// Starts following, if the drive is at its set position.
    fn begin(&mut self) -> Result<(), DriveFault> {
        // Without this check a drive that stands elsewhere would run to the axis's position at once.
        if self.monitor.is_beyond(self.following_error()) {
            return Err(DriveFault::PositionMismatch {
                received: self.position(),
                expected: self.last_set,
                window: self.parameters.following_error_window,
            });
        }
        self.state = DriveState::Following;
        self.monitor.forget();
        Ok(())
    }

    fn watch(&mut self, elapsed: Seconds) -> Result<(), DriveFault> {
        // First: of a process that is silent, state and position are old.
        if !self.is_attached() {
            return Err(DriveFault::Silent {
                cycles: self.age.unwrap_or(u32::MAX),
                most: self.parameters.max_silent_cycles,
            });
        }
        if let Some(reply) = self.reply
            && reply.state != ProcessState::Following
        {
            return Err(fault_of(reply.state, reply.error));
        }
        let following_error = self.following_error();
        if self.monitor.trips(following_error, elapsed) {
            return Err(DriveFault::FollowingError { following_error });
        }
        Ok(())
    }

    fn position(&self) -> f64 {
        self.reply.map_or(0.0, |reply| reply.position)
    }

    fn following_error(&self) -> f64 {
        match self.state {
            DriveState::Off => 0.0,
            _ => self.last_set - self.position(),
        }
    }
}

const fn fault_of(state: ProcessState, error: u32) -> DriveFault {
    match state {
        ProcessState::Error => DriveFault::Reported { error },
        ProcessState::Unknown(received) => DriveFault::UnknownState { received },
        // Only asked for states other than following.
        ProcessState::Off | ProcessState::Following => DriveFault::PowerLost,
    }
}

impl<L: DriveLink> Drive for ProcessDrive<L> {
    /// Commands power in the next cycle. The process keeps its own position, regardless of the axis's.
    fn power_on(&mut self, position: f64, _velocity: f64) {
        if self.state == DriveState::Off {
            self.state = DriveState::SwitchingOn;
            self.last_set = position;
            self.waited = 0;
        }
    }

    fn reset(&mut self) {
        if self.state == DriveState::Tripped {
            // Compared for equality only, so wrapping around is harmless.
            self.resets = self.resets.wrapping_add(1);
        }
        self.state = DriveState::Off;
        self.fault = None;
        self.monitor.forget();
    }

    fn step(&mut self, set: &Kinematics, elapsed: Seconds) {
        // Read, judge, write: a fault takes the power away in the same cycle.
        self.listen();
        if let Err(fault) = self.judge(elapsed) {
            self.state = DriveState::Tripped;
            self.fault = Some(fault);
        }
        // After the judgement, since the reply belongs to set values of earlier cycles.
        self.last_set = set.position;
        self.counter = self.counter.wrapping_add(1);
        self.link.write(&DriveCommand {
            counter: self.counter,
            enable: matches!(self.state, DriveState::SwitchingOn | DriveState::Following),
            resets: self.resets,
            state: self.state,
            set: *set,
        });
    }

    fn actual(&self) -> Actual {
        Actual {
            state: self.state,
            position: self.position(),
            velocity: self.reply.map_or(0.0, |reply| reply.velocity),
            following_error: self.following_error(),
            fault: self.fault,
            attachment: Some(Attachment {
                attached: self.is_attached(),
                heartbeat_age: self.age,
            }),
        }
    }

    fn kind(&self) -> DriveKind {
        self.kind
    }
}

#[cfg(test)]
mod tests;
