//! Output of a far clock.

use crate::common_time::CommonTimeLack;
use crate::delay::DelayOutput;
use crate::instant::Seconds;
use crate::observer::{FarTime, ObserverOutput};
use crate::timing::{TimingOutput, TimingState};

/// Output of one cycle of a [`FarClock`](super::FarClock).
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FarClockOutput {
    /// Far time, and the state of the observer.
    pub observer: ObserverOutput,
    /// Delay, and the state of its measurement.
    pub delay: DelayOutput,
    /// State of the timing channel.
    pub timing: TimingOutput,
    /// State of the common time; none before both nodes exchanged readings.
    pub common_time: Option<CommonTimeOutput>,
    /// True if far time is sure, or was and goes on as it did: leaving it would be a step.
    pub is_sure: bool,
}

impl FarClockOutput {
    /// Reports whether the corrections of messages have nothing to do with those of the cycle before: the sender
    /// stood still and its counts mean other instants now. Far time itself goes on.
    #[must_use]
    pub const fn is_mapped_anew(&self) -> bool {
        self.is_sure && self.observer.rebased
    }
}

/// State and quality of the [common time](crate::common_time) of both nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommonTimeOutput {
    /// Reason why there is none now.
    pub lack: CommonTimeLack,
    /// Channel of its exchanges. [Contradicted](TimingState::Contradicted): the clocks disagree with what the ways of messages leave open.
    pub timing: TimingOutput,
}

impl CommonTimeOutput {
    /// Reports whether the clocks that the nodes have in common are not what they state.
    #[must_use]
    pub const fn is_contradicted(&self) -> bool {
        matches!(self.timing.state, TimingState::Contradicted)
            || matches!(self.lack, CommonTimeLack::SecondsApart)
    }
}

/// Far time at a local instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarReading {
    /// Time of the far clock.
    pub time: FarTime,
    /// Greatest error of that, as far as is known: three standard deviations of what was observed, what is still to
    /// be slewed, and where the delay is measured, half of the least round trip. A delay that is neither measured nor
    /// configured is not in it.
    pub uncertainty: Seconds,
}
