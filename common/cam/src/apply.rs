//! Applying a planned command: changes that wait for their moment are queued. Nothing here can fail.

use super::coupling::CamCoupling;
use super::layer::Pending;
use super::plan::{CamChange, PlannedCamChange};
use super::request::CamInputs;
use super::tables::{TableRef, Tables};
use coaxle_axis::{CommandState, Job};

impl CamCoupling {
    /// Applies what was [planned](Self::plan) against the same state. It takes effect from the next
    /// [`update`](Self::update).
    pub fn apply(&mut self, tables: &mut Tables, change: &CamChange, job: Job) {
        match change.0 {
            PlannedCamChange::End => {
                self.end(tables);
                self.finish(job, CommandState::Done);
            }
            PlannedCamChange::DeleteQueued { index } => self.delete_queued(tables, index, job),
            PlannedCamChange::Nothing => self.finish(job, CommandState::Done),
            PlannedCamChange::Plate {
                index,
                table,
                inputs,
                first,
            } => {
                if let Some(first) = first {
                    self.kind = Some(first.kind);
                    self.master = first.master;
                    self.slave = first.slave;
                    // The axis follows this job to see whether its first coupling was refused.
                    self.first = Some(job);
                }
                if let Some(table) = &table {
                    // Held while it waits: a plate that is deleted meanwhile could not come when it is due.
                    tables.hold(table);
                }
                self.queues[index].table = Some(pending(job, table, inputs));
                self.has_queue = true;
            }
            PlannedCamChange::Scaling { index, inputs } => {
                self.queues[index].scaling = Some(pending(job, None, inputs));
                self.has_queue = true;
            }
        }
    }
}

const fn pending(job: Job, table: Option<TableRef>, inputs: CamInputs) -> Pending {
    Pending {
        job,
        table,
        activation: inputs.activation,
        scaling: inputs.scaling,
        jump: inputs.jump,
        first: true,
    }
}
