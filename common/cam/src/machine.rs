//! One slave's coupling to its master by up to four superposed plates.

use super::error::CouplingError;
use super::layer::{Layer, Queue};
use super::limits::CamLimits;
use super::moment::Step;
use super::placement::Path;
use super::ramp::Ramp;
use super::request::CamRequest;
use super::tables::Tables;
use coaxle_axis::{CommandState, Job, Origin, StateWord};
use coaxle_curve::profile::Kinematics;

/// How many plates a slave can have at once.
pub const MOST_PLATES: usize = 4;

/// How many finished commands can still be asked about.
const FINISHED: usize = u16::BITS as usize;

/// What a coupling knows of its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CouplingParameters {
    /// Id of the master axis, for [`CamInfo`](super::CamInfo).
    pub master_axis_id: u32,
    /// Id of the slave axis, for [`CamInfo`](super::CamInfo).
    pub slave_axis_id: u32,
    /// What the slave can do.
    pub limits: CamLimits,
}

/// What [`CamCoupling::state`] and [`CamCoupling::state_of`] answer with.
pub type CouplingState = CommandState<CouplingError>;

/// The coupling of one slave by cam plates, single (`MC_CamIn`) or superposed (`MC_CamIn_V2`).
///
/// Call [`plan`](Self::plan) and [`apply`](Self::apply) for a command and [`update`](Self::update) once per cycle, always
/// with the same store of [`Tables`]. A coupling uses its tables until it is ended by
/// [`CamOut`](super::CamOut); do that before dropping it.
///
/// Changes take effect exactly where the master is on the position they wait for, which mostly is
/// between two cycles. Of several in one cycle, online changes come first, then scalings, plates and
/// the end of a change for one cycle.
#[derive(Clone, Debug)]
pub struct CamCoupling {
    pub(super) parameters: CouplingParameters,
    pub(super) kind: Option<Kind>,
    pub(super) layers: [Option<Layer>; MOST_PLATES],
    pub(super) queues: [Queue; MOST_PLATES],
    /// Whether any of them holds something.
    pub(super) has_queue: bool,
    /// Whether written points wait for this slave, as of so many writes.
    data_waits: bool,
    writes_seen: u32,
    /// Why written points were not taken when they were due, which nobody has been told of, and as of how many writes somebody
    /// was.
    pub(super) held_back: Option<CouplingError>,
    pub(super) held_back_writes: Option<u32>,
    pub(super) ramp: Option<Ramp>,
    /// Set values of the last cycle.
    pub(super) master: Kinematics,
    pub(super) slave: Kinematics,
    pub(super) error: Option<CouplingError>,
    /// The job that began the coupling, or was to.
    pub(super) first: Option<Job>,
    /// How many jobs it has started by itself.
    jobs: u32,
    finished: [Option<(Job, CouplingState)>; FINISHED],
    next_finished: usize,
    /// Which of them nobody has been told of, a bit for each place.
    untold: u16,
}

/// The two worlds, which exclude each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Single,
    Multi,
}

impl CamCoupling {
    /// A slave that is not coupled.
    ///
    /// # Errors
    /// 0x4A1C unless the limits are finite numbers above 0.
    pub fn new(parameters: CouplingParameters) -> Result<Self, CouplingError> {
        parameters.limits.check()?;
        Ok(Self {
            parameters,
            kind: None,
            layers: [None; MOST_PLATES],
            queues: [Queue::default(); MOST_PLATES],
            has_queue: false,
            data_waits: false,
            writes_seen: 0,
            held_back: None,
            held_back_writes: None,
            ramp: None,
            master: Kinematics::default(),
            slave: Kinematics::default(),
            error: None,
            first: None,
            jobs: 0,
            finished: [None; FINISHED],
            next_finished: 0,
            untold: 0,
        })
    }

    /// Plans a command and carries it out, for somebody who numbers no jobs.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); then everything is as it was.
    pub fn start(
        &mut self,
        tables: &mut Tables,
        request: &CamRequest,
        master: &Kinematics,
        slave: &Kinematics,
    ) -> Result<Job, CouplingError> {
        let change = self.plan(tables, request, master, slave)?;
        self.jobs = self.jobs.wrapping_add(1);
        let job = Job {
            number: self.jobs,
            command: request.name(),
            origin: Origin::Program,
        };
        self.apply(tables, &change, job);
        Ok(job)
    }

    /// Why points that were written were not taken when they were due, once for each write: they wait for the next time, at
    /// which nothing may be different.
    pub const fn take_held_back(&mut self) -> Option<CouplingError> {
        self.held_back.take()
    }

    /// One cycle: what is due takes effect, and the slave's set values for the master's.
    ///
    /// While a first coupling waits for its activation they hold the slave where it is. Without a
    /// coupling, and after an error, they stay what they were: the axis has to go on by itself.
    pub fn update(&mut self, tables: &mut Tables, master: &Kinematics) -> Kinematics {
        if self.kind.is_some()
            && self.error.is_none()
            && let Err(error) = self.advance(tables, master)
        {
            self.fail(tables, error);
        }
        self.slave
    }

    /// Breaks the coupling off because one of the axes has an error, by its NC code. What it was
    /// can still be asked by [`info`](Self::info) until [`CamOut`](super::CamOut).
    pub fn axis_error(&mut self, tables: &mut Tables, code: u32) {
        if self.kind.is_some() && self.error.is_none() {
            self.fail(tables, CouplingError::AxisError { code });
        }
    }

    /// What it knows of its axes.
    #[must_use]
    pub const fn parameters(&self) -> &CouplingParameters {
        &self.parameters
    }

    /// The job that began the coupling, or was to.
    pub(super) const fn first(&self) -> Option<Job> {
        self.first
    }

    /// The slave's set values of the last cycle.
    #[must_use]
    pub const fn slave(&self) -> &Kinematics {
        &self.slave
    }

    /// The state of the coupling as a whole.
    #[must_use]
    pub fn state(&self) -> CouplingState {
        match (self.kind, self.error) {
            (None, _) => CommandState::Idle,
            (Some(_), Some(error)) => CommandState::Failed(error),
            _ if !self.is_coupled() => CommandState::Waiting,
            _ if self.ramp.is_some() => CommandState::Active,
            _ => CommandState::InSync,
        }
    }

    /// The state of a command: of those that couple a plate, `InSync` as long as the plate is
    /// active; of the others `Done`. The last finished ones are remembered, older ones are `Idle`.
    #[must_use]
    pub fn state_of(&self, job: Job) -> CouplingState {
        let known = |entry: &&(Job, CouplingState)| entry.0 == job;
        if let Some((_, state)) = self.finished.iter().flatten().find(known) {
            return *state;
        }
        if self.layers.iter().flatten().any(|l| l.owner == job) {
            return self.state();
        }
        let waits = |queue: &Queue| {
            let pending = queue.table.iter().chain(&queue.scaling);
            let undo = queue.undo.iter();
            pending.into_iter().any(|p| p.job == job)
                || undo
                    .clone()
                    .flat_map(|undo| &undo.before)
                    .any(|layer| layer.owner == job)
                || undo.into_iter().any(|undo| undo.job == job)
        };
        match self.queues.iter().any(waits) {
            true if self.is_coupled() => CommandState::Active,
            true => CommandState::Waiting,
            false => CommandState::Idle,
        }
    }

    /// The bits of `nStateDWord` that tell what is queued, 21 to 23.
    #[must_use]
    pub fn state_word(&self, tables: &Tables) -> StateWord {
        let mut word = StateWord::empty();
        if self.kind.is_none() {
            return word;
        }
        let queued = |has: fn(&Queue) -> bool| self.queues.iter().any(has);
        word.set(
            StateWord::CAM_TABLE_QUEUED,
            queued(|queue| queue.table.is_some()),
        );
        word.set(StateWord::CAM_DATA_QUEUED, self.data_queued(tables));
        word.set(
            StateWord::CAM_SCALING_PENDING,
            queued(|queue| queue.scaling.is_some()),
        );
        word
    }

    fn advance(&mut self, tables: &mut Tables, master: &Kinematics) -> Result<(), CouplingError> {
        if !is_finite(master) {
            return Err(CouplingError::AxisError { code: 0 });
        }
        if self.has_queue || self.data_waits || self.writes_seen != tables.writes() {
            let step = Step {
                from: self.master.position,
                to: master.position,
            };
            self.carry_out(tables, step)?;
            self.data_waits = self.data_queued(tables);
            self.writes_seen = tables.writes();
            if self.kind.is_none() {
                return Ok(());
            }
        }
        let slave = self.evaluate(tables, master)?;
        if !is_finite(&slave) {
            return Err(CouplingError::NotFinite);
        }
        self.master = *master;
        self.slave = slave;
        Ok(())
    }

    fn evaluate(
        &mut self,
        tables: &Tables,
        master: &Kinematics,
    ) -> Result<Kinematics, CouplingError> {
        if !self.is_coupled() {
            return Ok(Kinematics::at_rest(self.slave.position));
        }
        let mut path = Path::default();
        for layer in self.layers.iter_mut().flatten() {
            path += layer.path_along(tables, master.position)?;
        }
        if let Some(ramp) = &self.ramp {
            match ramp.at(master.position) {
                Some(gap) => path += gap,
                None => self.ramp = None,
            }
        }
        Ok(path.slave_of(master))
    }

    /// Everything that waits is aborted. The plates stay, to be asked about: nobody can take them out, but changes of
    /// their points do not wait for this slave any longer.
    fn fail(&mut self, tables: &mut Tables, error: CouplingError) {
        for index in 0..MOST_PLATES {
            self.abort_queue(tables, index);
        }
        for layer in self.layers.iter().flatten() {
            tables.leave(&layer.table, &layer.lease);
        }
        self.error = Some(error);
    }

    #[inline]
    pub(super) fn is_coupled(&self) -> bool {
        self.layers.iter().any(Option::is_some)
    }

    fn data_queued(&self, tables: &Tables) -> bool {
        self.layers.iter().flatten().any(|layer| {
            tables
                .versions(&layer.table)
                .is_ok_and(|versions| versions.queued().is_some())
        })
    }

    pub(super) fn finish(&mut self, job: Job, state: CouplingState) {
        let place = self.next_finished;
        self.finished[place] = Some((job, state));
        self.next_finished = (place + 1) % FINISHED;
        // Whoever began the coupling sees its end by itself.
        let is_untold = Some(job) != self.first;
        self.untold = self.untold & !(1 << place) | u16::from(is_untold) << place;
    }

    /// The next job that has come to its end, of those that did not begin the coupling.
    pub(super) fn next_ended(&mut self) -> Option<Job> {
        if self.untold == 0 {
            return None;
        }
        let oldest = self.next_finished;
        let from_oldest = self.untold.rotate_right(oldest as u32);
        let place = (oldest + from_oldest.trailing_zeros() as usize) % FINISHED;
        self.untold &= !(1 << place);
        self.finished[place].map(|(job, _)| job)
    }
}

pub(super) const fn is_finite(kinematics: &Kinematics) -> bool {
    kinematics.position.is_finite()
        && kinematics.velocity.is_finite()
        && kinematics.acceleration.is_finite()
}
