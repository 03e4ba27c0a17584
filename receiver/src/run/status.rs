//! What a receiver adds to its status: `docs/WIRE.md` describes each field.

use coaxle_clock::delay::{DelayOutput, DelayState};
use coaxle_clock::observer::{ObserverLine, ObserverOutput, ObserverState};
use coaxle_clock::{CycleTime, Instant, Local, Seconds, Span};
use coaxle_motion::axis::AxisStatus;
use coaxle_motion::slave::CouplingPhase;
use coaxle_node::keys::NodeName;
use coaxle_node::{AnsweringCounters, RejectionCounters};
use serde::Serialize;

use super::fault::Fault;
use crate::config::{MasterConfig, Mode, ReceiverConfig, SlaveConfig};
use crate::program::{ProgramSnapshot, ProgramState};
use crate::record::{DriveStateName, HealthName, StateName};
use crate::snapshot::{Counters, MasterSnapshot, ReceiverSnapshot, SlaveSnapshot};

#[derive(Serialize)]
pub(super) struct Status<'a> {
    health: HealthName,
    cycle: u64,
    cycle_time_us: f64,
    overruns: u64,
    mode: Mode,
    state: Option<StateName>,
    synced: bool,
    error: Option<Fault>,
    warning: Option<Fault>,
    beats: u32,
    drift_ppm: Option<f64>,
    observer: Option<ObserverStatus>,
    delay: Option<DelayStatus>,
    questions: QuestionsStatus,
    correction_us: Option<f64>,
    index: Option<u16>,
    age_cycles: Option<u32>,
    counters: CountersStatus,
    master: MasterStatus<'a>,
    slaves: Vec<SlaveStatus<'a>>,
}

#[derive(Serialize)]
struct ObserverStatus {
    state: ObserverState,
    line: ObserverLine,
    drift_sigma_ppm: f64,
    offset_sigma_us: f64,
    normal_jitter_us: f64,
    exponential_jitter_us: f64,
    random_walk_ppm: f64,
    block_length: u16,
    shifts: u32,
    last_shift_s: Option<f64>,
    relocks: u32,
    last_relock_s: Option<f64>,
}

#[derive(Serialize)]
struct DelayStatus {
    state: DelayState,
    delay_us: Option<f64>,
    uncertainty_us: Option<f64>,
    jitter_us: Option<f64>,
    age_s: Option<f64>,
    exchanges: u64,
    refused: u64,
}

#[derive(Serialize)]
struct QuestionsStatus {
    answered: u64,
    dropped: u64,
}

#[derive(Serialize)]
struct CountersStatus {
    received: u64,
    lost: u64,
    duplicates: u64,
    late: u64,
    stale: u64,
    overflow: u64,
    restarts: u64,
    rejected: RejectionCounters,
}

#[derive(Serialize)]
struct MasterStatus<'a> {
    node: &'a NodeName,
    axis: u32,
    cycle_time_us: Option<f64>,
    received_position: Option<f64>,
    corrected_position: Option<f64>,
    corrected_velocity: Option<f64>,
}

#[derive(Serialize)]
struct SlaveStatus<'a> {
    name: &'a NodeName,
    id: u32,
    state: AxisStatus,
    coupling: Option<CouplingPhase>,
    error: Option<Fault>,
    refusal: Option<Fault>,
    program: Option<ProgramStatus<'a>>,
    cuts: u64,
    position: Option<f64>,
    velocity: Option<f64>,
    drive: DriveStatus,
}

#[derive(Serialize)]
struct ProgramStatus<'a> {
    state: ProgramState,
    step: u16,
    label: Option<&'a str>,
}

#[derive(Serialize)]
struct DriveStatus {
    state: DriveStateName,
    position: f64,
    velocity: f64,
    following_error: f64,
}

impl<'a> Status<'a> {
    pub(super) fn of(config: &'a ReceiverConfig, snapshot: &ReceiverSnapshot) -> Self {
        let master = snapshot.master.as_ref();
        Self {
            health: snapshot.health.name(),
            cycle: snapshot.cycle,
            cycle_time_us: micros(config.cycle_time_us.0),
            overruns: snapshot.overruns,
            mode: config.mode,
            state: master.map(|m| m.state.into()),
            synced: master.is_some_and(|m| m.synced),
            error: Fault::of(snapshot),
            warning: master.and_then(|m| m.warning).map(Fault::from),
            beats: master.map_or(0, |m| m.beats),
            drift_ppm: master.map(|m| m.drift_ppm),
            observer: snapshot.observer.as_ref().map(ObserverStatus::of),
            delay: snapshot.delay.as_ref().map(DelayStatus::of),
            questions: QuestionsStatus::of(snapshot.questions),
            correction_us: master
                .and_then(|m| m.correction_time)
                .map(|time| time.as_micros()),
            index: master.map(|m| m.index.0),
            age_cycles: master.map(|m| m.age_cycles),
            counters: CountersStatus::of(&snapshot.counters),
            master: MasterStatus::of(&config.master, snapshot.data_cycle_time, master),
            slaves: config
                .slaves
                .iter()
                .zip(snapshot.slaves())
                .map(|(config, slave)| SlaveStatus::of(config, slave))
                .collect(),
        }
    }
}

impl<'a> SlaveStatus<'a> {
    fn of(config: &'a SlaveConfig, slave: &SlaveSnapshot) -> Self {
        Self {
            name: &config.name,
            id: slave.id,
            state: slave.status,
            coupling: slave.phase,
            error: Fault::of_slave(slave),
            refusal: Fault::of_refusal(slave),
            program: slave
                .program
                .map(|program| ProgramStatus::of(config, program)),
            cuts: slave.cuts,
            position: slave.set.map(|set| set.position),
            velocity: slave.set.map(|set| set.velocity),
            drive: DriveStatus {
                state: slave.drive.state.into(),
                position: slave.drive.position,
                velocity: slave.drive.velocity,
                following_error: slave.drive.following_error,
            },
        }
    }
}

impl<'a> ProgramStatus<'a> {
    fn of(config: &'a SlaveConfig, program: ProgramSnapshot) -> Self {
        let step = config.steps.get(usize::from(program.step).wrapping_sub(1));
        Self {
            state: program.state,
            step: program.step,
            label: step.and_then(|step| step.label.as_deref()),
        }
    }
}

impl ObserverStatus {
    fn of(observer: &ObserverOutput) -> Self {
        let seconds = |at: Instant<Local>| at.since_epoch().as_secs_f64();
        Self {
            state: observer.state,
            line: observer.line,
            drift_sigma_ppm: observer.drift_sigma_ppm,
            offset_sigma_us: observer.offset_sigma.as_micros(),
            normal_jitter_us: observer.normal_jitter.as_micros(),
            exponential_jitter_us: observer.exponential_jitter.as_micros(),
            random_walk_ppm: observer.random_walk_ppm,
            block_length: observer.block_length,
            shifts: observer.shifts,
            last_shift_s: observer.last_shift.map(seconds),
            relocks: observer.relocks,
            last_relock_s: observer.last_relock.map(seconds),
        }
    }
}

impl DelayStatus {
    fn of(delay: &DelayOutput) -> Self {
        Self {
            state: delay.state,
            delay_us: delay.delay.map(Seconds::as_micros),
            uncertainty_us: delay.uncertainty.map(Seconds::as_micros),
            jitter_us: delay.jitter.map(Seconds::as_micros),
            age_s: delay.age.map(Span::as_secs_f64),
            exchanges: delay.exchanges,
            refused: delay.refused,
        }
    }
}

impl QuestionsStatus {
    const fn of(counters: AnsweringCounters) -> Self {
        let AnsweringCounters { answered, dropped } = counters;
        Self { answered, dropped }
    }
}

impl CountersStatus {
    const fn of(counters: &Counters) -> Self {
        let Counters {
            received,
            lost,
            duplicates,
            late,
            stale,
            overflow,
            restarts,
            rejected,
        } = *counters;
        Self {
            received,
            lost,
            duplicates,
            late,
            stale,
            overflow,
            restarts,
            rejected,
        }
    }
}

impl<'a> MasterStatus<'a> {
    fn of(
        config: &'a MasterConfig,
        cycle_time: Option<CycleTime>,
        master: Option<&MasterSnapshot>,
    ) -> Self {
        Self {
            node: &config.node,
            axis: config.axis,
            cycle_time_us: cycle_time.map(micros),
            received_position: master.map(|m| m.received.position),
            corrected_position: master.map(|m| m.corrected.position),
            corrected_velocity: master.map(|m| m.corrected.velocity),
        }
    }
}

fn micros(cycle_time: CycleTime) -> f64 {
    cycle_time.span().as_micros_f64()
}
