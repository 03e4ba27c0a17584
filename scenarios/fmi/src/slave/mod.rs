//! The unit *slave*: a slave axis with a saw, a gear or a cam plate.

mod commands;
mod drive;
mod file;
mod layout;

use std::path::Path;

use coaxle_axis::{CommandState, Job, Masters};
use coaxle_cam::Tables;
use coaxle_clock::{CycleTime, Seconds};
use coaxle_node::config::Wrong;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_slave::{SlaveAxis, SlaveParameters};

use crate::link::kinematics_of;
use crate::model::{CoSimulation, Model};
use crate::variable::{UnitValue, Variables};
use commands::Commands;
use drive::FollowingDrive;
use file::{SlaveCoupling, SlaveFile};
use layout::SlaveLayout;

/// A slave by its file.
#[derive(Debug)]
pub struct SlaveUnitModel {
    file: SlaveFile,
    layout: SlaveLayout,
    cycle: CycleTime,
}

impl SlaveUnitModel {
    /// The slave of a saw, gear or cam file. Files that it names are searched for in its folder.
    ///
    /// # Errors
    /// Names the file, the field, the value received and the one expected.
    pub fn new(file: &Path, text: &str, cycle: CycleTime) -> anyhow::Result<Self> {
        let read = SlaveFile::parse(file, text)?;
        let layout = SlaveLayout::new(&read)?;
        Ok(Self {
            file: read,
            layout,
            cycle,
        })
    }

    /// Limits with the parameters of an instance.
    fn limits(&self, values: &[UnitValue]) -> SlaveParameters {
        let number = |name| self.layout.number(values, name);
        let or = |name, own| number(name).unwrap_or(own);
        let own = &self.file.limits;
        SlaveParameters {
            velocity: or("limits.velocity", own.velocity),
            acceleration: or("limits.acceleration", own.acceleration),
            deceleration: number("limits.deceleration").or(own.deceleration),
            jerk: or("limits.jerk", own.jerk),
            min_position: number("limits.min_position").or(own.min_position),
            max_position: number("limits.max_position").or(own.max_position),
            ..*own
        }
    }
}

impl Model for SlaveUnitModel {
    fn title(&self) -> String {
        self.file.title.clone()
    }

    fn variables(&self) -> &Variables {
        &self.layout.variables
    }

    fn cycle_time(&self) -> CycleTime {
        self.cycle
    }

    fn start(&self, values: &[UnitValue]) -> anyhow::Result<Box<dyn CoSimulation>> {
        let number = |name| self.layout.number(values, name).unwrap_or_default();
        let drive = Box::new(FollowingDrive::at(number("start.position")));
        let axis = SlaveAxis::new(&self.limits(values), drive, self.cycle);
        let mut axis = axis.map_err(|wrong| {
            Wrong::of(
                format!("limits.{}", wrong.parameter),
                wrong.received,
                wrong.expected,
            )
        })?;
        let mut plates = Tables::new(0);
        if let SlaveCoupling::Cam(cam, plate) = &self.file.coupling {
            plates = Tables::new(1);
            plates.insert(cam.table, (**plate).clone())?;
            axis.prepare_cams(MASTER_ID, SLAVE_ID)?;
        }
        Ok(Box::new(SlaveUnit {
            layout: self.layout.clone(),
            commands: Commands::new(
                &self.file.coupling,
                number("start.position"),
                number("start.velocity"),
            ),
            elapsed: Seconds(self.cycle.as_secs_f64()),
            axis,
            plates,
            job: None,
            master_position: None,
            refusal: 0,
        }))
    }
}

/// Axis ids of master and slave on a plate.
const MASTER_ID: u32 = 1;
const SLAVE_ID: u32 = 2;

/// A slave under way.
struct SlaveUnit {
    layout: SlaveLayout,
    axis: SlaveAxis,
    plates: Tables,
    elapsed: Seconds,
    commands: Commands,
    /// The newest coupling as a command.
    job: Option<Job>,
    master_position: Option<f64>,
    /// NC code of the last refused command.
    refusal: u32,
}

impl CoSimulation for SlaveUnit {
    fn step(&mut self, values: &[UnitValue], cycles: u32) -> anyhow::Result<Option<String>> {
        let note = self.execute(values);
        let master = kinematics_of(values, self.layout.master());
        let is_there = self.layout.flag(values, "master.is_there");
        for cycle in 0..cycles {
            let master = master.after(f64::from(cycle) * self.elapsed.0, 0.0);
            self.master_position = is_there.then_some(master.position);
            let masters = Masters::from(is_there.then_some(&master));
            let _ = self.axis.update(&mut self.plates, masters, self.elapsed);
        }
        Ok(note)
    }

    fn show(&self, values: &mut [UnitValue]) {
        let set = self.axis.set();
        let sync = self.axis.sync_positions();
        let phase = self.axis.coupling_phase();
        let cam = phase.and_then(|_| self.axis.cam_state(&self.plates));
        let signals = SlaveSignals {
            position: Some(set.position),
            velocity: Some(set.velocity),
            acceleration: Some(set.acceleration),
            master_position: self.master_position,
            slave_sync_position: sync.map(|sync| sync.slave),
            master_sync_position: sync.map(|sync| sync.master),
            guard: self.axis.tracking(),
            distance: self.axis.distance(),
            set_anew: self.axis.preset_count(),
            state: self.axis.status(),
            phase,
            cam_table: cam.map(|cam| cam.table),
            cam_master_position: cam.map(|cam| cam.master_cam_position),
            cam_slave_position: cam.map(|cam| cam.slave_cam_position),
            error: self.axis.error().map_or(0, |error| error.code()),
            refusal: self.refusal,
            ..SlaveSignals::default()
        };
        self.layout.show(self.state_of_job(), &signals, values);
    }
}

impl SlaveUnit {
    /// Executes the commands whose inputs have changed. Returns the sentence of a refusal.
    fn execute(&mut self, values: &[UnitValue]) -> Option<String> {
        let mut note = None;
        for command in self.commands.due(&self.layout, values, &self.axis) {
            match self.axis.command(&mut self.plates, &command) {
                Ok(job) if self.commands.is_coupling(&command) => self.job = Some(job),
                Ok(_) => {}
                Err(refusal) => {
                    self.refusal = refusal.code();
                    note = Some(format!("refused: {refusal} ({:#06x})", refusal.code()));
                }
            }
        }
        note
    }

    fn state_of_job(&self) -> &'static str {
        match self.job.map(|job| self.axis.progress(job)) {
            None | Some(CommandState::Idle) => "idle",
            Some(CommandState::Waiting) => "waiting",
            Some(CommandState::Active) => "active",
            Some(CommandState::InSync) => "in-sync",
            Some(CommandState::Done) => "done",
            Some(CommandState::Aborted) => "aborted",
            Some(CommandState::Failed(_)) => "failed",
        }
    }
}
