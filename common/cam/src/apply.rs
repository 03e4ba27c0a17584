//! Applying a planned command: changes that wait for their moment are queued. Nothing here can fail.

use super::layer::Pending;
use super::machine::CamCoupling;
use super::plan::{CamChange, Change};
use super::request::Terms;
use super::tables::{TableRef, Tables};
use coaxle_axis::{CommandState, Job};

impl CamCoupling {
    /// Applies what was [planned](Self::plan) against the same state. It takes effect from the next
    /// [`update`](Self::update).
    pub fn apply(&mut self, tables: &mut Tables, change: &CamChange, job: Job) {
        match change.0 {
            Change::End => {
                self.end(tables);
                self.finish(job, CommandState::Done);
            }
            Change::DeleteQueued { index } => self.delete_queued(tables, index, job),
            Change::Nothing => self.finish(job, CommandState::Done),
            Change::Plate {
                index,
                table,
                terms,
                first,
            } => {
                if let Some(first) = first {
                    self.kind = Some(first.kind);
                    self.master = first.master;
                    self.slave = first.slave;
                    self.first = Some(job);
                }
                if let Some(table) = &table {
                    tables.hold(table);
                }
                self.queues[index].table = Some(pending(job, table, terms));
                self.has_queue = true;
            }
            Change::Scaling { index, terms } => {
                self.queues[index].scaling = Some(pending(job, None, terms));
                self.has_queue = true;
            }
        }
    }
}

const fn pending(job: Job, table: Option<TableRef>, terms: Terms) -> Pending {
    Pending {
        job,
        table,
        activation: terms.activation,
        scaling: terms.scaling,
        jump: terms.jump,
        first: true,
    }
}
