//! The virtual axes: the receiver's own, without a clock to estimate.

use coaxle_axis::{AxisState, NcToPlcAxis, StateWord};
use coaxle_clock::{Instant, Local, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::Wrong;
use coaxle_source::config::AxisConfig;
use coaxle_source::{SourceAxis, SourceSample};

use crate::signals::VirtualAxisSignals;
use crate::slaves::Master;

/// Error code of an axis with implausible set values: the code with which the guard of the set
/// values refuses such a master.
const OUT_OF_RANGE: u32 = 0x42d5;

/// The virtual axes of a receiver.
#[derive(Debug)]
pub(crate) struct VirtualAxes {
    /// Start of the receiver in its own clock, the origin of the axes' time.
    start: Instant<Local>,
    sources: Box<[SourceAxis]>,
    /// Times by which they are shown later.
    delays: Box<[Span]>,
    /// Axis structures in the newest cycle.
    axes: Box<[NcToPlcAxis]>,
    /// Masters of the newest cycle, for the slaves.
    masters: Box<[Master]>,
}

impl VirtualAxes {
    /// Opens the axes of a receiver whose first cycle is due at `start`. Reads the files of
    /// replayed ones.
    ///
    /// # Errors
    /// [`Wrong`] names the axis, and the reason why its file cannot be replayed.
    pub(crate) fn open(configs: &[AxisConfig], start: Instant<Local>) -> Result<Self, Wrong> {
        let source = |(n, config)| {
            let field = || format!("virtual-axis[{n}].replay.file");
            SourceAxis::open(config).map_err(|error| Wrong::with_reason(field(), error))
        };
        let sources = configs.iter().enumerate().map(source);
        let axes: Box<[_]> = configs.iter().map(|_| NcToPlcAxis::default()).collect();
        Ok(Self {
            start,
            sources: sources.collect::<Result<_, _>>()?,
            delays: configs.iter().map(delay).collect(),
            masters: axes.iter().map(master).collect(),
            axes,
        })
    }

    /// Runs one cycle, which ideally began at `at`; returns the axes as masters. Slaves are held back by `hold_back`: an
    /// axis that is shown later by more lags by the rest.
    pub(crate) fn cycle(
        &mut self,
        at: Instant<Local>,
        hold_back: Span,
        signals: &mut [VirtualAxisSignals],
    ) -> &[Master] {
        // By the ideal start: a scan that wakes late must not move the axes on.
        let since_start = at - self.start;
        let places = self.axes.iter_mut().zip(&mut self.masters);
        let sources = self.sources.iter_mut().zip(&self.delays);
        for (((source, delay), (axis, place)), signals) in sources.zip(places).zip(signals) {
            let lag = (*delay - hold_back).max(Span::ZERO);
            // Before the source writes its values in place.
            let last = *axis;
            let sample = source.at((since_start - lag).max(Span::ZERO), axis);
            // A receiver elsewhere would refuse the whole frame for one such axis.
            if axis.implausible_field().is_some() {
                *axis = in_error(&last, source.id());
            }
            *place = master(axis);
            *signals = show(axis, &sample);
        }
        &self.masters
    }

    /// Axis structures in the newest cycle.
    pub(crate) fn axes(&self) -> &[NcToPlcAxis] {
        &self.axes
    }
}

fn delay(config: &AxisConfig) -> Span {
    // A figure: nobody reports to a receiver what would do.
    (config.present_after()).map_or(Span::ZERO, |range| range.least)
}

/// Puts an axis with implausible values in error at its last position; a frame with such values
/// would be rejected. It recovers as soon as its values do.
fn in_error(last: &NcToPlcAxis, axis_id: u32) -> NcToPlcAxis {
    NcToPlcAxis {
        axis_id,
        state_word: StateWord::HOMED | StateWord::NOT_MOVING | StateWord::ERROR,
        error_code: OUT_OF_RANGE,
        axis_state: AxisState::Inactive,
        actual_velocity: 0.0,
        set_velocity: 0.0,
        set_acceleration: 0.0,
        // Its motion ends here.
        target_position: last.set_position,
        ..*last
    }
}

/// The axis as a master. It belongs to this cycle and this clock, so it is ready unless in error.
fn master(axis: &NcToPlcAxis) -> Master {
    let is_sound = axis.error_code == 0;
    Master {
        set: Kinematics {
            position: axis.set_position,
            velocity: axis.set_velocity,
            acceleration: axis.set_acceleration,
        },
        travel: None,
        is_sound,
        is_ready: is_sound,
        error_code: axis.error_code,
    }
}

fn show(axis: &NcToPlcAxis, sample: &SourceSample) -> VirtualAxisSignals {
    VirtualAxisSignals {
        position: axis.set_position,
        velocity: axis.set_velocity,
        acceleration: axis.set_acceleration,
        target_position: axis.target_position,
        activity: sample.activity,
        operational: axis.state_word.contains(StateWord::OPERATIONAL),
        error: axis.error_code,
        true_position: sample.motion.position,
        true_velocity: sample.motion.velocity,
        true_acceleration: sample.motion.acceleration,
    }
}
