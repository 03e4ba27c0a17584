//! The virtual axes: the receiver's own, which no clock has to be learnt for.

use coaxle_axis::{AxisState, NcToPlcAxis, StateWord};
use coaxle_clock::{Instant, Local};
use coaxle_curve::profile::Kinematics;
use coaxle_source::config::AxisConfig;
use coaxle_source::{AxisSample, ReplayError, SourceAxis};

use crate::signals::VirtualAxisSignals;
use crate::slaves::Master;

/// The error of an axis whose set values no axis can have: the code by which the guard of the set
/// values refuses such a master.
const OUT_OF_RANGE: u32 = 0x42d5;

/// All virtual axes.
#[derive(Debug)]
pub(crate) struct VirtualAxes {
    /// When the receiver started, by its own clock: their time counts from here.
    start: Instant<Local>,
    sources: Box<[SourceAxis]>,
    /// Their axis structures in the newest cycle.
    axes: Box<[NcToPlcAxis]>,
    /// What slaves follow in the newest cycle.
    masters: Box<[Master]>,
}

impl VirtualAxes {
    /// The axes of a receiver whose first cycle is due at `start`. Reads the files of replayed ones.
    ///
    /// # Errors
    /// The place of an axis in the config, and why its file cannot be replayed.
    pub(crate) fn open(
        configs: &[AxisConfig],
        start: Instant<Local>,
    ) -> Result<Self, (usize, ReplayError)> {
        let source = |(n, config)| SourceAxis::open(config).map_err(|error| (n, error));
        let sources = configs.iter().enumerate().map(source);
        let axes: Box<[_]> = configs.iter().map(|_| NcToPlcAxis::default()).collect();
        Ok(Self {
            start,
            sources: sources.collect::<Result<_, _>>()?,
            masters: axes.iter().map(master).collect(),
            axes,
        })
    }

    /// One cycle, which ideally began at `at`: where they are then, as masters.
    pub(crate) fn cycle(
        &mut self,
        at: Instant<Local>,
        signals: &mut [VirtualAxisSignals],
    ) -> &[Master] {
        let since_start = at - self.start;
        let places = self.axes.iter_mut().zip(&mut self.masters);
        for ((source, (axis, place)), signals) in self.sources.iter_mut().zip(places).zip(signals) {
            let last = *axis;
            let sample = source.at(since_start, axis);
            if axis.implausible_field().is_some() {
                *axis = in_error(&last, source.id());
            }
            *place = master(axis);
            *signals = show(axis, &sample);
        }
        &self.masters
    }

    /// Their axis structures in the newest cycle.
    pub(crate) fn axes(&self) -> &[NcToPlcAxis] {
        &self.axes
    }
}

/// An axis that comes with what nobody can believe stands in error where it was last; a frame with such
/// an axis would be refused. It is well again as soon as its values are.
fn in_error(last: &NcToPlcAxis, axis_id: u32) -> NcToPlcAxis {
    NcToPlcAxis {
        axis_id,
        state_word: StateWord::HOMED | StateWord::NOT_MOVING | StateWord::ERROR,
        error_code: OUT_OF_RANGE,
        axis_state: AxisState::Inactive,
        actual_velocity: 0.0,
        set_velocity: 0.0,
        set_acceleration: 0.0,
        target_position: last.set_position,
        ..*last
    }
}

/// It is of this very cycle, on this very clock: ready unless it is in error.
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

fn show(axis: &NcToPlcAxis, sample: &AxisSample) -> VirtualAxisSignals {
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
