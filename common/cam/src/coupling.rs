//! Coupling of one slave to its master by up to four superposed plates.

use super::change_moment::MasterStep;
use super::error::CouplingError;
use super::layer::{Layer, Queue};
use super::limits::CamLimits;
use super::placement::Path;
use super::ramp::GapRamp;
use super::request::CamRequest;
use super::tables::Tables;
use coaxle_axis::{CommandState, Job, MasterDemands, Origin, StateWord};
use coaxle_curve::profile::Kinematics;

/// Greatest number of plates of a slave.
// Limit of the NC for a multi cam (0x425E).
pub const MOST_PLATES: usize = 4;

/// Number of finished commands whose states are remembered: more than can end in a cycle.
// As many as `unreported` has bits. The orders of a cycle, at most 16, may all be for one coupling, and the last of
// them may end it with all that its places hold.
const FINISHED: usize = u64::BITS as usize;

/// Greatest number of commands that a place holds: a plate and a scaling that wait, a change for one
/// cycle, and the plate to which it returns or that it scales.
const MOST_COMMANDS_OF_A_PLACE: usize = 4;

const _: () = assert!(FINISHED > 16 + MOST_COMMANDS_OF_A_PLACE * MOST_PLATES);

/// Ids of the axes of a coupling, and limits of the slave.
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
    /// Limits of the slave.
    pub limits: CamLimits,
}

/// State of a coupling or a command: [`CamCoupling::state`] and [`CamCoupling::state_of`].
pub type CouplingState = CommandState<CouplingError>;

/// The coupling of one slave by cam plates, single (`MC_CamIn`) or superposed (`MC_CamIn_V2`).
///
/// Call [`plan`](Self::plan) and [`apply`](Self::apply) for a command and [`update`](Self::update) once per cycle, always
/// with the same store of [`Tables`]. A coupling uses its tables until it is ended by
/// [`CamOut`](super::CamOut); do that before dropping it.
///
/// Changes take effect exactly at the master position they wait for, which mostly is between two cycles.
/// Of several in one cycle, online changes come first, then scalings, plates and the end of a change for
/// one cycle.
#[derive(Clone, Debug)]
pub struct CamCoupling {
    pub(super) parameters: CouplingParameters,
    pub(super) kind: Option<CouplingKind>,
    pub(super) layers: [Option<Layer>; MOST_PLATES],
    pub(super) queues: [Queue; MOST_PLATES],
    /// True if one of the queues is not empty.
    pub(super) has_queue: bool,
    /// True if written points wait for this slave, as of `writes_seen` writes.
    data_waits: bool,
    writes_seen: u32,
    /// Reason why written points did not take effect when they were due, if it has not been taken yet,
    /// and the number of writes at which it was last reported.
    pub(super) rejected_points: Option<CouplingError>,
    pub(super) rejected_points_writes: Option<u32>,
    pub(super) ramp: Option<GapRamp>,
    /// Set values of the last cycle.
    pub(super) master: Kinematics,
    pub(super) slave: Kinematics,
    pub(super) error: Option<CouplingError>,
    /// The job that began the coupling, or was to begin it.
    pub(super) first: Option<Job>,
    /// Number of jobs it has started by itself.
    jobs: u32,
    finished: [Option<(Job, CouplingState)>; FINISHED],
    next_finished: usize,
    /// Finished jobs that have not been reported yet, a bit for each place.
    unreported: u64,
}

/// The two kinds of coupling, which exclude each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CouplingKind {
    Single,
    Multi,
}

impl CamCoupling {
    /// Makes a slave that is not coupled.
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
            rejected_points: None,
            rejected_points_writes: None,
            ramp: None,
            master: Kinematics::default(),
            slave: Kinematics::default(),
            error: None,
            first: None,
            jobs: 0,
            finished: [None; FINISHED],
            next_finished: 0,
            unreported: 0,
        })
    }

    /// Plans a command and applies it, for callers that number no jobs.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); then everything is unchanged.
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

    /// Takes the reason why written points did not take effect when they were due, once for each write.
    /// They wait for the next time, which may fail in the same way.
    pub const fn take_rejected_points(&mut self) -> Option<CouplingError> {
        self.rejected_points.take()
    }

    /// Computes one cycle: executes what is due, and returns the slave's set values for the master's.
    ///
    /// While a first coupling waits for its activation, the set values hold the slave where it is.
    /// Without a coupling, and after an error, they stay unchanged: the axis has to continue by itself.
    pub fn update(&mut self, tables: &mut Tables, master: &Kinematics) -> Kinematics {
        if self.kind.is_some()
            && self.error.is_none()
            && let Err(error) = self.advance(tables, master)
        {
            self.fail(tables, error);
        }
        self.slave
    }

    /// Ends the coupling because one of the axes has an error, by its NC code. Its last state is
    /// available from [`info`](Self::info) until [`CamOut`](super::CamOut).
    pub fn axis_error(&mut self, tables: &mut Tables, code: u32) {
        if self.kind.is_some() && self.error.is_none() {
            self.fail(tables, CouplingError::AxisError { code });
        }
    }

    /// Returns the ids of the axes and limits of the slave.
    #[must_use]
    pub const fn parameters(&self) -> &CouplingParameters {
        &self.parameters
    }

    /// Returns the job that began the coupling, or was to begin it.
    pub(super) const fn first(&self) -> Option<Job> {
        self.first
    }

    /// Returns the slave's set values of the last cycle.
    #[must_use]
    pub const fn slave(&self) -> &Kinematics {
        &self.slave
    }

    /// Returns the greatest demands of its plates on the slave, in sum; none of one that waits.
    pub(super) fn demands(&self, tables: &Tables) -> MasterDemands {
        // Backwards or forwards, the slave's acceleration is bounded by the curvature of either side.
        let placed = self
            .layers
            .iter()
            .flatten()
            .map(|layer| layer.placed(tables));
        placed
            .filter_map(Result::ok)
            .map(|placed| placed.placement.bound(placed.plate.greatest_demands()))
            .fold(MasterDemands::default(), |sum, plate| MasterDemands {
                slope: sum.slope + plate.slope,
                curvature: sum.curvature + plate.curvature,
            })
    }

    /// Returns the state of the coupling as a whole.
    #[must_use]
    pub fn state(&self) -> CouplingState {
        match (self.kind, self.error) {
            (None, _) => CommandState::Idle,
            (Some(_), Some(error)) => CommandState::Failed(error),
            _ if !self.is_coupled() => CommandState::Waiting,
            // On a ramp the slave is beside the sum of its plates.
            _ if self.ramp.is_some() => CommandState::Active,
            _ => CommandState::InSync,
        }
    }

    /// Returns the state of a command: of those that couple a plate, `InSync` as long as the plate is
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

    /// Returns the bits 21 to 23 of `nStateDWord`: the queued changes.
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
        // Mostly nothing waits, and a cycle costs only the evaluation.
        if self.has_queue || self.data_waits || self.writes_seen != tables.writes() {
            let step = MasterStep {
                from: self.master.position,
                to: master.position,
            };
            self.carry_out(tables, step)?;
            // After the changes: a plate that came just now may have points that wait.
            self.data_waits = self.data_queued(tables);
            self.writes_seen = tables.writes();
            if self.kind.is_none() {
                return Ok(());
            }
        }
        let slave = self.evaluate(tables, master)?;
        // Before they are stored: the last valid values stay for the axis and for `info`.
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
            // A first plate waits only for a slave at standstill.
            return Ok(Kinematics::at_rest(self.slave.position));
        }
        let mut path = Path::default();
        for layer in self.layers.iter_mut().flatten() {
            path += layer.path_along(tables, master.position)?;
        }
        if let Some(ramp) = &self.ramp {
            match ramp.at(master.position) {
                Some(gap) => path += gap,
                // Dropped at its end, so that a master that comes back does not run into it again.
                None => self.ramp = None,
            }
        }
        Ok(path.slave_of(master))
    }

    /// Aborts everything that waits. The plates stay for `info`: they cannot be removed, but changes of
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

    /// Notes the end of a job, once: a change for one cycle also owns the plate in its place.
    pub(super) fn finish(&mut self, job: Job, state: CouplingState) {
        if self
            .finished
            .iter()
            .flatten()
            .any(|(known, _)| *known == job)
        {
            return;
        }
        let place = self.next_finished;
        self.finished[place] = Some((job, state));
        self.next_finished = (place + 1) % FINISHED;
        // The owner of the coupling's first job sees its end by itself.
        let is_unreported = Some(job) != self.first;
        self.unreported = self.unreported & !(1 << place) | u64::from(is_unreported) << place;
    }

    /// Returns the next finished job, of those that did not begin the coupling.
    pub(super) fn next_ended(&mut self) -> Option<Job> {
        if self.unreported == 0 {
            return None;
        }
        let oldest = self.next_finished;
        // The list is a ring: the place to be written next holds the oldest entry.
        let from_oldest = self.unreported.rotate_right(oldest as u32);
        let place = (oldest + from_oldest.trailing_zeros() as usize) % FINISHED;
        self.unreported &= !(1 << place);
        self.finished[place].map(|(job, _)| job)
    }
}

pub(super) const fn is_finite(kinematics: &Kinematics) -> bool {
    kinematics.position.is_finite()
        && kinematics.velocity.is_finite()
        && kinematics.acceleration.is_finite()
}
