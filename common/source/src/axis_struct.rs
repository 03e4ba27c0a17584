//! What an axis shows of itself: its axis structure.

use coaxle_axis::{AxisState, CoupleState, NcToPlcAxis, StateWord};
use coaxle_curve::profile::Kinematics;

use crate::source::{Activity, AxisSample};

/// The axis structure of an axis, in its units; `modulo` is the length of a turn in them.
#[must_use]
pub fn axis_struct(axis_id: u32, modulo: Option<f64>, sample: &AxisSample) -> NcToPlcAxis {
    let seen = &sample.seen;
    let (modulo_position, turns) = modulo_of(seen.position, modulo);
    NcToPlcAxis {
        state_word: state_word(sample),
        axis_state: axis_state(sample),
        couple_state: CoupleState::Master,
        axis_id,
        actual_position: seen.position,
        modulo_actual_position: modulo_position,
        modulo_actual_turns: turns,
        actual_velocity: seen.velocity,
        set_position: seen.position,
        set_velocity: seen.velocity,
        set_acceleration: seen.acceleration,
        target_position: sample.target_position,
        modulo_set_position: modulo_position,
        modulo_set_turns: turns,
        command_number: sample.command_number,
        ..NcToPlcAxis::default()
    }
}

/// The position within its turn, from 0 up to less than `modulo`, and the whole turns before it.
fn modulo_of(position: f64, modulo: Option<f64>) -> (f64, i32) {
    let Some(modulo) = modulo else {
        return (position, 0);
    };
    let within = position.rem_euclid(modulo);
    // A trifle below a turn's begin, the remainder is rounded up to a whole turn.
    let within = if within < modulo { within } else { 0.0 };
    let turns = ((position - within) / modulo).round();
    (within, turns as i32)
}

fn state_word(sample: &AxisSample) -> StateWord {
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

fn axis_state(sample: &AxisSample) -> AxisState {
    let Kinematics {
        velocity,
        acceleration,
        ..
    } = sample.seen;
    match sample.activity {
        Activity::Idle | Activity::InTarget | Activity::Halted => AxisState::Inactive,
        Activity::Measured if stands(&sample.seen) => AxisState::Inactive,
        Activity::Measured => AxisState::Running,
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

    fn sample(activity: Activity, velocity: f64, acceleration: f64) -> AxisSample {
        let seen = Kinematics {
            position: 1.0,
            velocity,
            acceleration,
        };
        AxisSample {
            motion: seen,
            seen,
            enabled: true,
            activity,
            command_number: 3,
            target_position: 4.0,
        }
    }

    #[test]
    fn positions_fall_into_turns() {
        for (position, within, turns) in [
            (0.0, 0.0, 0),
            (359.0, 359.0, 0),
            (360.0, 0.0, 1),
            (-1.0, 359.0, -1),
            (-720.0, 0.0, -2),
            (36_005.0, 5.0, 100),
        ] {
            assert_eq!(
                modulo_of(position, Some(360.0)),
                (within, turns),
                "{position}"
            );
        }
        assert_eq!(modulo_of(-1e-20, Some(360.0)), (0.0, 0));
        assert_eq!(modulo_of(400.0, None), (400.0, 0));
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
            let axis = axis_struct(9, None, &sample);
            assert_eq!(axis.state_word, word, "{sample:?}");
            assert_eq!(axis.axis_state, state, "{sample:?}");
            assert_eq!((axis.axis_id, axis.command_number), (9, 3));
        }
    }

    #[test]
    fn an_axis_that_is_not_enabled_is_not_operational() {
        let asleep = AxisSample {
            enabled: false,
            ..sample(Activity::Idle, 0.0, 0.0)
        };
        let word = axis_struct(1, None, &asleep).state_word;
        assert_eq!(word, StateWord::HOMED | StateWord::NOT_MOVING);
    }
}
