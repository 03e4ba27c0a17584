//! The way of the data: far axis in, set values of the slaves out. One scan, top to bottom.

use coaxle_clock::cycle::Turn;
use coaxle_clock::delay::{Answer, DelayOutput};
use coaxle_clock::observer::ObserverOutput;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{CycleTime, Instant, Local, Remote, Seconds, Span};
use coaxle_motion::axis::NcToPlcAxis;
use coaxle_motion::profile::Kinematics;
use coaxle_motion::remote::{AxisSyncOutput, FilterState};
use coaxle_motion::slave::{Accepted, Command, Refusal};
use coaxle_node::{Arrival, CommandOrder, CommandOutcome, Message, Sample};

use crate::arrivals::Arrivals;
use crate::config::{MOST_SLAVES, Mode};
use crate::far_clock::{Far, FarClock, FarClockSetup};
use crate::inbox::Inbox;
use crate::slaves::{Master, SlaveNumber, Slaves};
use crate::snapshot::{Counters, Health, MasterSnapshot, SlaveSnapshot};

/// Everything between the mailbox and the drives.
#[derive(Debug)]
pub(crate) struct Pipeline {
    cycle_time: CycleTime,
    mode: Mode,
    inbox: Inbox,
    far_clock: FarClock,
    arrivals: Arrivals,
    slaves: Slaves,
    master: Option<MasterSnapshot>,
    observer: Option<ObserverOutput>,
    delay: Option<DelayOutput>,
    /// The newest message that was used, and own cycles since.
    last: Option<(u64, u64)>,
    age_cycles: u32,
}

impl Pipeline {
    pub(crate) fn new(setup: FarClockSetup, slaves: Slaves) -> Result<Self, WrongParameter> {
        let cycle_time = setup.cycle_time;
        let age_limit = match setup.sync.time_sync.age_of_data_limit {
            0 => None,
            cycles => Some(cycle_time.span() * i64::from(cycles)),
        };
        Ok(Self {
            cycle_time,
            mode: setup.mode,
            inbox: Inbox::new(age_limit),
            far_clock: FarClock::new(setup)?,
            arrivals: Arrivals::new(),
            slaves,
            master: None,
            observer: None,
            delay: None,
            last: None,
            age_cycles: 0,
        })
    }

    pub(crate) fn store(&mut self, at: Instant<Local>, message: &Message) {
        self.inbox.store(at, message);
    }

    pub(crate) fn store_answer(&mut self, at: Instant<Local>, answer: &Answer) {
        self.far_clock.hear_answer(at, answer);
    }

    /// What the newest cycle took in and nobody fetched yet.
    pub(crate) fn arrival(&mut self) -> Option<Arrival> {
        self.arrivals.next()
    }

    /// The number of the question that is due, if one is.
    pub(crate) fn ask(&mut self, turn: &Turn) -> Option<u32> {
        self.far_clock.ask(turn.ideal_start)
    }

    /// One scan.
    pub(crate) fn scan(&mut self, turn: &Turn) {
        let far = self.far_axis(turn);
        let elapsed = self.cycle_time.as_secs_f64() * f64::from(turn.elapsed);
        self.slaves.update(far.as_ref(), Seconds(elapsed));
    }

    /// The far axis, local and smooth; none as long as nothing has come, or nothing that fits.
    fn far_axis(&mut self, turn: &Turn) -> Option<Master> {
        let (far_clock, arrivals) = (&mut self.far_clock, &mut self.arrivals);
        arrivals.begin();
        let image = self.inbox.image(turn.ideal_start, |at, sample| {
            arrivals.message(at, &sample.header);
            far_clock.hear(at, sample);
        });
        let sample = image?;
        self.count_age(&sample, turn.elapsed);
        let arrivals = &mut self.arrivals;
        let heard = |at, answer: &Answer| arrivals.exchange(at, answer);
        let Some(far) = self.far_clock.update(&sample, turn, heard) else {
            self.master = None;
            return None;
        };
        self.master = Some(self.master_snapshot(&sample, &far));
        self.observer = far.observer;
        self.delay = far.delay;
        Some(self.as_master(&sample, &far.axis))
    }

    /// The far axis as the master of slaves.
    fn as_master(&self, sample: &Sample, far: &AxisSyncOutput) -> Master {
        let error_code = far
            .error
            .map_or(sample.axis.error_code, |error| error.code().into());
        let is_sound = error_code == 0 && self.silence() <= SILENCE;
        Master {
            set: kinematics(&far.axis),
            is_sound,
            is_ready: is_sound && (far.synced || !self.mode.synchronises()),
            error_code: far.error.map_or(0, |error| error.code().into()),
        }
    }

    /// A command to a slave that does not come from its program.
    pub(crate) fn command(
        &mut self,
        slave: SlaveNumber,
        command: &Command,
    ) -> Result<Accepted, Refusal> {
        self.slaves.command(slave, command)
    }

    /// An order of somebody in the network.
    pub(crate) fn execute(&mut self, slave: SlaveNumber, order: &CommandOrder) -> CommandOutcome {
        self.slaves.execute(slave, order)
    }

    fn count_age(&mut self, sample: &Sample, elapsed: u32) {
        let this = (sample.header.epoch, sample.header.count);
        if self.last.replace(this) == Some(this) {
            self.age_cycles = self.age_cycles.saturating_add(elapsed);
        } else {
            self.age_cycles = 0;
        }
    }

    fn master_snapshot(&self, sample: &Sample, far: &Far) -> MasterSnapshot {
        let observed = far.observer.map(|observer| observer.drift_ppm);
        let far = &far.axis;
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
            drift_ppm: observed.unwrap_or(far.diagnostic.time_sync.drift_ppm),
        }
    }

    pub(crate) fn health(&self) -> Health {
        if let Some(fault) = self.slaves.fault() {
            return fault;
        }
        if self.far_clock.is_refused() {
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
        self.far_clock.data_cycle_time()
    }

    pub(crate) fn counters(&self) -> Counters {
        self.inbox.counters()
    }

    pub(crate) const fn master(&self) -> Option<MasterSnapshot> {
        self.master
    }

    pub(crate) const fn observer(&self) -> Option<ObserverOutput> {
        self.observer
    }

    pub(crate) const fn delay(&self) -> Option<DelayOutput> {
        self.delay
    }

    pub(crate) fn slaves(&self) -> [Option<SlaveSnapshot>; MOST_SLAVES] {
        self.slaves.snapshots()
    }

    /// What is published of the slaves, by axis id.
    pub(crate) fn slave_axes(&mut self) -> &[NcToPlcAxis] {
        self.slaves.axes()
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
        FilterState::Sync | FilterState::Time | FilterState::Observer => {
            let correction = far.diagnostic.correction_time?;
            Some(sent + correction.to_span())
        }
    }
}
