//! What a command would come to, without giving it.

use core::mem;

use super::{Accepted, SlaveAxis};
use crate::command::Command;
use crate::refusal::Refusal;
use coaxle_cam::Cams;

impl SlaveAxis {
    /// What [`command`](Self::command) would say now; nothing changes by it. None for a command to
    /// cam plates: a change to them cannot be taken back.
    pub fn dry_run(&mut self, command: &Command) -> Option<Result<Accepted, Refusal>> {
        if command.is_of_cams() {
            return None;
        }
        // Whoever adds a field has to say here whether a command can change it.
        let Self {
            guard,
            on_master_loss: _,
            cycle_time,
            drive,
            drive_zero,
            state,
            powered,
            homed,
            stop_held,
            set,
            motion,
            cams,
            master_traits: _,
            last_saw,
            saw_table_in_use: _,
            job,
            master: _,
            error,
        } = self;
        // Any other command ends the coupling by plates at most; without plates it has none to end.
        let cams = mem::replace(cams, Cams::none(guard.limits().velocity() * *cycle_time));
        let axis = (*drive, *drive_zero, *state, *powered, *homed, *stop_held);
        let course = (*set, motion.clone(), *last_saw, *job, *error);
        let answer = self.command(command);
        (
            self.drive,
            self.drive_zero,
            self.state,
            self.powered,
            self.homed,
            self.stop_held,
        ) = axis;
        (self.set, self.motion, self.last_saw, self.job, self.error) = course;
        self.cams = cams;
        Some(answer)
    }
}
