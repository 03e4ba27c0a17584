//! Snapshot of a receiver of one far axis, in a form for tests.

use coaxle_axis::AxisStatus;
use coaxle_clock::CycleTime;
use coaxle_curve::profile::Kinematics;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, SlaveSignals};
use coaxle_receiver::{
    BlockedProgram, ContinuityState, DriveState, FilterState, GuardState, Health, ProgramSnapshot,
    ReceiverSnapshot, RefusedCommand, SlaveFaults,
};
use coaxle_slave::{CouplingPhase, SlaveError};

/// A cycle.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) cycle: u64,
    pub(crate) overruns: u64,
    pub(crate) health: Health,
    pub(crate) counters: FarNodeSignals,
    pub(crate) data_cycle_time: Option<CycleTime>,
    pub(crate) master: Option<MasterShown>,
    pub(crate) axis: FarAxisSignals,
    pub(crate) slaves: Vec<SlaveShown>,
}

/// The far axis, with values of its node's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MasterShown {
    pub(crate) epoch: u64,
    pub(crate) index: u16,
    pub(crate) count: u64,
    pub(crate) age_cycles: u32,
    pub(crate) received: Moving,
    pub(crate) corrected: Moving,
    pub(crate) state: FilterState,
    pub(crate) continuity: ContinuityState,
    pub(crate) synced: bool,
    pub(crate) drift_ppm: f64,
}

/// Position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moving {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
}

/// A slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SlaveShown {
    pub(crate) status: AxisStatus,
    pub(crate) phase: Option<CouplingPhase>,
    pub(crate) error: Option<SlaveError>,
    pub(crate) refusal: Option<RefusedCommand>,
    pub(crate) set: Option<Kinematics>,
    pub(crate) guard: GuardState,
    pub(crate) distance: f64,
    pub(crate) program: Option<ProgramSnapshot>,
    pub(crate) blocked: Option<BlockedProgram>,
    pub(crate) drive: DriveShown,
}

/// A drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DriveShown {
    pub(crate) state: DriveState,
    pub(crate) position: f64,
    pub(crate) velocity: f64,
}

impl Shown {
    pub(crate) fn of(snapshot: &ReceiverSnapshot) -> Self {
        let signals = &snapshot.signals;
        let slaves = signals.slaves.iter().zip(&snapshot.faults);
        Self {
            cycle: signals.node.cycle,
            overruns: signals.node.overruns,
            health: snapshot.health,
            counters: signals.far[0],
            data_cycle_time: snapshot.data_cycle_times[0],
            master: master(snapshot),
            axis: signals.axes[0],
            slaves: slaves
                .map(|(s, faults)| SlaveShown::of(s, faults))
                .collect(),
        }
    }

    /// The first slave's set values.
    pub(crate) fn slave(&self) -> Option<Kinematics> {
        self.slaves[0].set
    }

    /// The first slave's drive.
    pub(crate) fn drive(&self) -> DriveShown {
        self.slaves[0].drive
    }
}

fn master(snapshot: &ReceiverSnapshot) -> Option<MasterShown> {
    let (far, axis) = (&snapshot.signals.far[0], &snapshot.signals.axes[0]);
    let moving = |position: Option<f64>, velocity: Option<f64>| {
        Some(Moving {
            position: position?,
            velocity: velocity?,
        })
    };
    Some(MasterShown {
        epoch: far.epoch?,
        index: far.index?,
        count: far.count?,
        age_cycles: far.age_cycles,
        received: moving(axis.received_position, axis.received_velocity)?,
        corrected: moving(axis.corrected_position, axis.corrected_velocity)?,
        state: axis.state?,
        continuity: axis.continuity,
        synced: axis.synced,
        drift_ppm: far.drift_ppm.unwrap_or_default(),
    })
}

impl SlaveShown {
    fn of(signals: &SlaveSignals, faults: &SlaveFaults) -> Self {
        let set = |position| {
            Some(Kinematics {
                position,
                velocity: signals.velocity?,
                acceleration: signals.acceleration?,
            })
        };
        Self {
            status: signals.state,
            phase: signals.phase,
            error: faults.error,
            refusal: faults.refusal,
            set: signals.position.and_then(set),
            guard: signals.guard,
            distance: signals.distance,
            program: signals
                .program
                .zip(signals.program_step)
                .map(|(state, step)| ProgramSnapshot {
                    state,
                    step,
                    waits_for: signals.program_waits_for,
                    outcome: signals.program_outcome,
                }),
            blocked: faults.blocked,
            drive: DriveShown {
                state: signals.drive_state,
                position: signals.drive_position,
                velocity: signals.drive_velocity,
            },
        }
    }
}
