//! The end of a coupling, and of the changes queued in it.

use super::coupling::{CamCoupling, MOST_PLATES};
use super::layer::{Queue, Undo};
use super::tables::Tables;
use coaxle_axis::{CommandState, Job};

impl CamCoupling {
    /// Discards the plate that is queued for a place.
    pub(super) fn delete_queued(&mut self, tables: &mut Tables, index: usize, job: Job) {
        self.abort_table(tables, index);
        match &mut self.layers[index] {
            // The command is in sync with the plate that stays.
            Some(layer) => {
                let before = core::mem::replace(&mut layer.owner, job);
                self.finish(before, CommandState::Aborted);
            }
            None => self.finish(job, CommandState::Done),
        }
        // With its only change discarded, a coupling would wait for ever.
        if self.layers.iter().all(Option::is_none) && self.queues.iter().all(Queue::is_empty) {
            self.end(tables);
        }
    }

    /// Ends the coupling. The slave keeps its velocity, without acceleration.
    pub(super) fn end(&mut self, tables: &mut Tables) {
        // Called again at the end of a coupling that has ended by itself.
        if self.kind.is_none() {
            return;
        }
        for index in 0..MOST_PLATES {
            self.abort_queue(tables, index);
            if let Some(layer) = self.layers[index].take() {
                // A coupling that ended with an error has left its plates already.
                if self.error.is_none() {
                    tables.leave(&layer.table, &layer.lease);
                }
                tables.release(&layer.table);
                let state = self
                    .error
                    .map_or(CommandState::Aborted, CommandState::Failed);
                self.finish(layer.owner, state);
            }
        }
        self.kind = None;
        self.error = None;
        self.ramp = None;
        // `MC_CamOut`: the axis goes on at constant velocity.
        self.slave.acceleration = 0.0;
    }

    /// Aborts what waits for the present plate of a place, since it does not apply to the next one.
    pub(super) fn clear_for_another(&mut self, tables: &mut Tables, index: usize) {
        self.abort_scaling(index);
        // Another plate replaces the return, too: it would bring back the plate before the last one.
        if let Some(undo) = self.queues[index].undo.take() {
            self.finish(undo.job, CommandState::Aborted);
            self.forget(tables, &undo);
        }
    }

    pub(super) fn abort_queue(&mut self, tables: &mut Tables, index: usize) {
        self.abort_table(tables, index);
        self.clear_for_another(tables, index);
        self.has_queue = self.queues.iter().any(|queue| !queue.is_empty());
    }

    pub(super) fn abort_scaling(&mut self, index: usize) {
        if let Some(pending) = self.queues[index].scaling.take() {
            self.finish(pending.job, CommandState::Aborted);
        }
    }

    fn abort_table(&mut self, tables: &mut Tables, index: usize) {
        if let Some(pending) = self.queues[index].table.take() {
            if let Some(table) = &pending.table {
                tables.release(table);
            }
            self.finish(pending.job, CommandState::Aborted);
        }
    }

    /// Releases the plate that was to return and does not.
    pub(super) fn forget(&mut self, tables: &mut Tables, undo: &Undo) {
        if let Some(layer) = &undo.before
            // A scaled plate is still in its place, and its layer releases it.
            && !undo.scaled_only
        {
            tables.release(&layer.table);
            self.finish(layer.owner, CommandState::Aborted);
        }
    }
}
