//! Restarts of an axis: with its node's clock, with another run of its node, with another node, by a command.

use coaxle_clock::CycleTime;

use super::{Axis, Encoder};

impl Axis {
    /// Restarts with its node's clock, for cycles of this length.
    pub(in crate::far) fn restart(&mut self, data: CycleTime) {
        self.block.restart();
        if let Some(encoder) = &mut self.encoder {
            encoder.restart(data);
        }
        self.forget_frames();
        self.rejoin();
    }

    /// Notes a jump of its node's clock: the axis is brought to the next set values.
    pub(in crate::far) const fn rejoin(&mut self) {
        self.continuity.rejoin();
        self.course.forget();
        self.steps.forget();
    }

    /// Restarts for another run of its node: the previous state gives no information on the present
    /// position.
    pub(in crate::far) fn forget(&mut self) {
        self.sample = None;
        self.begin_run();
        self.forget_frames();
        self.begin_anew();
        self.rejoin();
    }

    /// Restarts for another node that takes over: the axis is brought to the position given by that
    /// node. `encoder` is the smoothing of the new node's increments on entry, and of the old
    /// node's on return.
    pub(in crate::far) fn take_over(&mut self, encoder: &mut Option<Box<Encoder>>) {
        self.sample = None;
        self.begin_run();
        self.forget_frames();
        self.block.begin_anew();
        // Exchanged and not restarted: the smoothing of the other node has run on standby.
        std::mem::swap(&mut self.encoder, encoder);
        self.rejoin();
    }

    fn begin_run(&mut self) {
        if let Some(turns) = &mut self.turns {
            turns.begin_run();
        }
    }

    pub(super) fn begin_anew(&mut self) {
        self.block.begin_anew();
        if let Some(encoder) = &mut self.encoder {
            encoder.forget();
        }
    }

    /// Restarts with its node's clock by a command; the set values continue from their current state.
    pub(in crate::far) const fn re_initialise(&mut self) {
        self.block.re_initialise();
        // The set values go on, but their far time may not: against the old one it would count as a jump.
        self.course.forget();
    }

    /// Continues the set values from their current state after a command.
    pub(in crate::far) const fn carry_on(&mut self) {
        self.block.carry_on();
        self.course.forget();
    }
}
