//! The way of the data: far axis in, slave set values out. One scan, top to bottom.

use coaxle_clock::cycle::Turn;
use coaxle_clock::time_sync::{TimeSyncParameters, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Local, Remote, Seconds, Span};
use coaxle_motion::axis::NcToPlcAxis;
use coaxle_motion::drive::{Drive, DriveState};
use coaxle_motion::gear::LinearGear;
use coaxle_motion::profile::Kinematics;
use coaxle_motion::remote::{AxisSync, AxisSyncOutput, AxisSyncParameters, FilterState};
use coaxle_node::{Message, Sample};

use crate::config::Mode;
use crate::inbox::Inbox;
use crate::snapshot::{Counters, DriveSnapshot, Health, MasterSnapshot};

/// Everything between the mailbox and the drive.
#[derive(Debug)]
pub(crate) struct Pipeline {
    cycle_time: CycleTime,
    mode: Mode,
    parameters: AxisSyncParameters,
    inbox: Inbox,
    sync: Sync,
    gear: LinearGear,
    drive: Drive,
    master: Option<MasterSnapshot>,
    slave: Option<Kinematics>,
    /// The newest message that was used, and own cycles since.
    last: Option<(u64, u64)>,
    age_cycles: u32,
}

/// The synchronising block: it starts with the first message, which tells the sender's cycle time.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and boxing it would allocate in the cycle"
)]
enum Sync {
    Waiting,
    Running { block: AxisSync, data: CycleTime },
    Refused { data: CycleTime },
}

impl Pipeline {
    pub(crate) fn new(
        cycle_time: CycleTime,
        mode: Mode,
        parameters: AxisSyncParameters,
        gear: LinearGear,
        drive: Drive,
    ) -> Result<Self, WrongParameter> {
        // Wrong parameters are refused now, not when the first message comes.
        let _ = AxisSync::start(cycle_time.span(), parameters)?;
        let age_limit = match parameters.time_sync.age_of_data_limit {
            0 => None,
            cycles => Some(cycle_time.span() * i64::from(cycles)),
        };
        Ok(Self {
            cycle_time,
            mode,
            parameters,
            inbox: Inbox::new(age_limit),
            sync: Sync::Waiting,
            gear,
            drive,
            master: None,
            slave: None,
            last: None,
            age_cycles: 0,
        })
    }

    pub(crate) fn store(&mut self, at: Instant<Local>, message: &Message) {
        self.inbox.store(at, message);
    }

    /// One scan.
    pub(crate) fn scan(&mut self, turn: &Turn) {
        let Some(sample) = self.inbox.image(turn.ideal_start) else {
            return;
        };
        self.count_age(&sample, turn.elapsed);
        let Some(far) = self.synchronise(&sample, turn.elapsed) else {
            self.master = None;
            return;
        };
        let slave = self.gear.slave_of(&far.axis);
        self.move_drive(&slave, turn.elapsed);
        self.master = Some(self.master_snapshot(&sample, &far));
        self.slave = Some(slave);
    }

    fn count_age(&mut self, sample: &Sample, elapsed: u32) {
        let this = (sample.header.epoch, sample.header.count);
        if self.last.replace(this) == Some(this) {
            self.age_cycles = self.age_cycles.saturating_add(elapsed);
        } else {
            self.age_cycles = 0;
        }
    }

    /// The far axis, local and smooth; none when the cycle times do not fit.
    fn synchronise(&mut self, sample: &Sample, elapsed: u32) -> Option<AxisSyncOutput> {
        let data = sample.header.cycle_time;
        if self.data_cycle_time() != Some(data) {
            self.sync = self.start_sync(data);
        }
        match &mut self.sync {
            Sync::Running { block, .. } => {
                Some(block.update(sample.header.index, &sample.axis, self.mode.into(), elapsed))
            }
            Sync::Waiting | Sync::Refused { .. } => None,
        }
    }

    /// The frame says how long the sender's cycle is. A config that says otherwise is wrong.
    fn start_sync(&self, data: CycleTime) -> Sync {
        let configured = self.parameters.time_sync.data_cycle_time;
        if configured != Seconds::ZERO && configured.to_span() != data.span() {
            return Sync::Refused { data };
        }
        let parameters = AxisSyncParameters {
            time_sync: TimeSyncParameters {
                data_cycle_time: data.span().into(),
                ..self.parameters.time_sync
            },
            ..self.parameters
        };
        match AxisSync::start(self.cycle_time.span(), parameters) {
            Ok(block) => Sync::Running { block, data },
            Err(_) => Sync::Refused { data },
        }
    }

    fn move_drive(&mut self, slave: &Kinematics, elapsed: u32) {
        if self.drive.state() == DriveState::Off {
            self.drive.power_on(slave.position, slave.velocity);
        } else {
            let dt = self.cycle_time.as_secs_f64() * f64::from(elapsed);
            self.drive.step(slave.position, dt);
        }
    }

    fn master_snapshot(&self, sample: &Sample, far: &AxisSyncOutput) -> MasterSnapshot {
        MasterSnapshot {
            epoch: sample.header.epoch,
            index: sample.header.index,
            count: sample.header.count,
            age_cycles: self.age_cycles,
            received: kinematics(&sample.axis),
            corrected: kinematics(&far.axis),
            far_time: far_time(sample, far),
            state: far.state,
            synced: far.synced,
            error: far.error,
            warning: far.warning,
            beats: far.beats,
            correction_time: far.diagnostic.correction_time,
            drift_ppm: far.diagnostic.time_sync.drift_ppm,
        }
    }

    pub(crate) fn health(&self) -> Health {
        if self.drive.state() == DriveState::Tripped {
            return Health::DriveTripped;
        }
        if let Sync::Refused { .. } = self.sync {
            return Health::CycleTimesDoNotFit;
        }
        let Some(master) = &self.master else {
            return Health::WaitingForMaster;
        };
        if let Some(error) = master.error {
            return Health::Error(error);
        }
        if self.silence() > SILENCE {
            return Health::MasterSilent;
        }
        if self.mode.synchronises() && !master.synced {
            return Health::StartingUp;
        }
        Health::Ok
    }

    fn silence(&self) -> Span {
        self.cycle_time.span() * i64::from(self.age_cycles)
    }

    /// The sender's cycle time that the synchronising block was started for.
    pub(crate) const fn data_cycle_time(&self) -> Option<CycleTime> {
        match &self.sync {
            Sync::Waiting => None,
            Sync::Running { data, .. } | Sync::Refused { data } => Some(*data),
        }
    }

    pub(crate) fn counters(&self) -> Counters {
        self.inbox.counters()
    }

    pub(crate) const fn master(&self) -> Option<MasterSnapshot> {
        self.master
    }

    pub(crate) const fn slave(&self) -> Option<Kinematics> {
        self.slave
    }

    pub(crate) fn drive(&self) -> DriveSnapshot {
        DriveSnapshot {
            state: self.drive.state(),
            position: self.drive.position(),
            velocity: self.drive.velocity(),
            following_error: self.drive.following_error(),
        }
    }
}

/// A master that says nothing for so long is never reported healthy, whatever the age limit.
const SILENCE: Span = Span::from_secs(1);

fn kinematics(axis: &NcToPlcAxis) -> Kinematics {
    Kinematics {
        position: axis.set_position,
        velocity: axis.set_velocity,
        acceleration: axis.set_acceleration,
    }
}

/// The sender's ideal time that the corrected set values stand for.
fn far_time(sample: &Sample, far: &AxisSyncOutput) -> Option<Instant<Remote>> {
    let sent = Instant::EPOCH + sample.header.cycle_time.span() * sample.header.count as i64;
    match far.state {
        FilterState::Bypass => Some(sent),
        FilterState::Pt1 => None,
        FilterState::Sync | FilterState::Time => {
            let correction = far.diagnostic.correction_time?;
            Some(sent + correction.to_span())
        }
    }
}
