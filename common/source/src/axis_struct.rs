//! The axis structure of an axis.

use coaxle_axis::{AxisState, CoupleState, Modulo, NcToPlcAxis, StateWord};
use coaxle_curve::profile::Kinematics;

use crate::source::{Activity, SourceSample};

/// Writes all fields of the axis structure of an axis, in its units, into the published structure.
pub fn write_axis_struct(
    axis_id: u32,
    modulo: Option<Modulo>,
    sample: &SourceSample,
    axis: &mut NcToPlcAxis,
) {
    let seen = &sample.seen;
    *axis = NcToPlcAxis {
        state_word: state_word(sample),
        axis_state: axis_state(sample),
        couple_state: CoupleState::Master,
        axis_id,
        // A source has no drive that could lag: its actual values are those of the controller.
        actual_position: seen.position,
        actual_velocity: seen.velocity,
        set_position: seen.position,
        set_velocity: seen.velocity,
        set_acceleration: seen.acceleration,
        target_position: sample.target_position,
        command_number: sample.command_number,
        // The whole structure is written, so that nothing of the cycle before remains in it.
        ..NcToPlcAxis::default()
    };
    // Last, from the set position of this cycle.
    axis.count_turns(modulo);
}

fn state_word(sample: &SourceSample) -> StateWord {
    // A source knows its position from the start, without a reference run.
    let mut word = StateWord::HOMED;
    word.set(
        StateWord::OPERATIONAL | StateWord::CONTROL_LOOP_CLOSED,
        sample.enabled,
    );
    let Kinematics {
        velocity,
        acceleration,
        ..
    } = sample.seen;
    word.set(StateWord::NOT_MOVING, stands(&sample.seen));
    word.set(StateWord::POSITIVE_DIRECTION, velocity > 0.0);
    word.set(StateWord::NEGATIVE_DIRECTION, velocity < 0.0);
    word.set(
        StateWord::CONSTANT_VELOCITY,
        // A measured velocity is constant between two increments only by the resolution of its encoder.
        velocity != 0.0 && acceleration == 0.0 && sample.activity != Activity::Measured,
    );
    word | match sample.activity {
        Activity::Idle | Activity::Measured => StateWord::empty(),
        Activity::Positioning => StateWord::HAS_JOB | StateWord::PTP_MODE,
        Activity::InTarget => {
            StateWord::IN_POSITION_AREA | StateWord::IN_TARGET_POSITION | StateWord::PTP_MODE
        }
        Activity::Continuous => StateWord::HAS_JOB | StateWord::CONTINUOUS_MOTION,
        Activity::Halting => StateWord::HAS_JOB,
        Activity::Halted => StateWord::HAS_BEEN_STOPPED,
        Activity::Following => StateWord::HAS_JOB | StateWord::EXT_SET_POINT_GEN_ENABLED,
    }
}

fn axis_state(sample: &SourceSample) -> AxisState {
    let Kinematics {
        velocity,
        acceleration,
        ..
    } = sample.seen;
    match sample.activity {
        Activity::Idle | Activity::InTarget | Activity::Halted => AxisState::Inactive,
        // Before the comparisons below, whose acceleration is noise for a measured axis.
        Activity::Measured if stands(&sample.seen) => AxisState::Inactive,
        Activity::Measured => AxisState::Running,
        // The sign of the product: an axis that runs backward faster and faster is accelerating as well.
        _ if velocity * acceleration > 0.0 => AxisState::Accelerating,
        _ if velocity * acceleration < 0.0 => AxisState::Decelerating,
        _ if velocity != 0.0 => AxisState::ConstantVelocity,
        _ => AxisState::Running,
    }
}

fn stands(seen: &Kinematics) -> bool {
    seen.velocity == 0.0 && seen.acceleration == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(activity: Activity, velocity: f64, acceleration: f64) -> SourceSample {
        let seen = Kinematics {
            position: 1.0,
            velocity,
            acceleration,
        };
        SourceSample {
            motion: seen,
            seen,
            enabled: true,
            activity,
            command_number: 3,
            target_position: 4.0,
        }
    }

    fn axis_struct(axis_id: u32, sample: &SourceSample) -> NcToPlcAxis {
        let mut axis = NcToPlcAxis::default();
        write_axis_struct(axis_id, None, sample, &mut axis);
        axis
    }

    #[test]
    fn the_state_word_says_what_the_axis_does() {
        use StateWord as W;
        let ready = W::HOMED | W::OPERATIONAL | W::CONTROL_LOOP_CLOSED;
        for (sample, word, state) in [
            (
                sample(Activity::Idle, 0.0, 0.0),
                ready | W::NOT_MOVING,
                AxisState::Inactive,
            ),
            (
                sample(Activity::Positioning, 2.0, 1.0),
                ready | W::HAS_JOB | W::PTP_MODE | W::POSITIVE_DIRECTION,
                AxisState::Accelerating,
            ),
            (
                sample(Activity::Positioning, -2.0, 1.0),
                ready | W::HAS_JOB | W::PTP_MODE | W::NEGATIVE_DIRECTION,
                AxisState::Decelerating,
            ),
            (
                sample(Activity::InTarget, 0.0, 0.0),
                ready | W::NOT_MOVING | W::IN_POSITION_AREA | W::IN_TARGET_POSITION | W::PTP_MODE,
                AxisState::Inactive,
            ),
            (
                sample(Activity::Continuous, -2.0, 0.0),
                ready
                    | W::HAS_JOB
                    | W::CONTINUOUS_MOTION
                    | W::CONSTANT_VELOCITY
                    | W::NEGATIVE_DIRECTION,
                AxisState::ConstantVelocity,
            ),
            (
                sample(Activity::Halted, 0.0, 0.0),
                ready | W::NOT_MOVING | W::HAS_BEEN_STOPPED,
                AxisState::Inactive,
            ),
            (
                sample(Activity::Following, 2.0, -1.0),
                ready | W::HAS_JOB | W::EXT_SET_POINT_GEN_ENABLED | W::POSITIVE_DIRECTION,
                AxisState::Decelerating,
            ),
            (
                sample(Activity::Measured, 2.0, 0.0),
                ready | W::POSITIVE_DIRECTION,
                AxisState::Running,
            ),
        ] {
            let axis = axis_struct(9, &sample);
            assert_eq!(axis.state_word, word, "{sample:?}");
            assert_eq!(axis.axis_state, state, "{sample:?}");
            assert_eq!((axis.axis_id, axis.command_number), (9, 3));
        }
    }

    #[test]
    fn an_axis_that_is_not_enabled_is_not_operational() {
        let asleep = SourceSample {
            enabled: false,
            ..sample(Activity::Idle, 0.0, 0.0)
        };
        let word = axis_struct(1, &asleep).state_word;
        assert_eq!(word, StateWord::HOMED | StateWord::NOT_MOVING);
    }
}
