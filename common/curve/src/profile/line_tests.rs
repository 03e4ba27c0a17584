//! The path onto a moving line, compared with an independent generator and with itself.

use coaxle_clock::Seconds;
use proptest::prelude::*;
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory, daov_stack};

use super::{Band, Kinematics, Profile, to_line, towards};

// Relative to the largest quantity: 4e6 times the rounding of one number.
const SLACK: f64 = 1e-9;

fn decades(from: i32, to: i32) -> impl Strategy<Value = f64> {
    (f64::from(from)..f64::from(to)).prop_map(|exponent| libm::pow(10.0, exponent))
}

fn bands() -> impl Strategy<Value = Band> {
    let velocities = (decades(0, 4), 0.0..1.0_f64);
    (velocities, decades(1, 5), decades(1, 5), decades(2, 7)).prop_map(
        |((highest, lowest), up, down, jerk)| Band {
            lowest: -highest * lowest,
            highest,
            up,
            down,
            jerk,
        },
    )
}

/// A start from which the band can be kept, and a line within it.
fn chase() -> impl Strategy<Value = (Kinematics, Kinematics, Band)> {
    let shares = (0.05..0.95_f64, 0.05..0.95_f64, -1.0..1.0_f64);
    let distance = (decades(-3, 4), any::<bool>());
    (bands(), shares, distance, -1e3..1e3_f64).prop_map(|(band, (v, w, a), (far, ahead), at)| {
        let width = band.highest - band.lowest;
        let velocity = band.lowest + v * width;
        let room = (band.highest - velocity).min(velocity - band.lowest);
        // Half of the a² = 2·j·room that can still be led to zero within the band.
        let most = libm::sqrt(band.jerk * room).min(band.up).min(band.down);
        let start = Kinematics {
            position: at,
            velocity,
            acceleration: a * most,
        };
        let line = Kinematics {
            position: at + if ahead { far } else { -far },
            velocity: band.lowest + w * width,
            acceleration: 0.0,
        };
        (start, line, band)
    })
}

/// Seen from the line, the path is one to rest. For a few the result of the other generator is longer
/// than necessary.
fn independent(start: &Kinematics, line: &Kinematics, band: &Band) -> Option<f64> {
    let mut input = InputParameter::<1>::new(None);
    input.current_position[0] = start.position - line.position;
    input.current_velocity[0] = start.velocity - line.velocity;
    input.current_acceleration[0] = start.acceleration;
    input.target_position[0] = 0.0;
    input.max_velocity[0] = band.highest - line.velocity;
    input.min_velocity = Some(daov_stack![band.lowest - line.velocity]);
    input.max_acceleration[0] = band.up;
    input.min_acceleration = Some(daov_stack![-band.down]);
    input.max_jerk[0] = band.jerk;
    let mut ruckig = Ruckig::<1, ThrowErrorHandler>::new(None, 1e-3);
    let mut trajectory = Trajectory::<1>::new(None);
    ruckig.calculate(&input, &mut trajectory).ok()?;
    Some(trajectory.get_duration())
}

/// Checks the profile by samples: within the band, without jumps, and on the line at its end.
fn assert_right(
    profile: &Profile,
    (start, line, band): (&Kinematics, &Kinematics, &Band),
) -> Result<(), TestCaseError> {
    let duration = profile.duration().0;
    let size = (band.highest - band.lowest) * duration + (start.position - line.position).abs();
    let steps = 400;
    let dt = duration / f64::from(steps);
    let mut before = *start;
    for k in 1..=steps {
        let state = profile.at(Seconds(duration * f64::from(k) / f64::from(steps)));
        let v = SLACK * (band.highest - band.lowest);
        prop_assert!(state.velocity <= band.highest + v && state.velocity >= band.lowest - v);
        prop_assert!(state.acceleration <= band.up * (1.0 + SLACK));
        prop_assert!(state.acceleration >= -band.down * (1.0 + SLACK));
        let jerked = (state.acceleration - before.acceleration).abs();
        // Between two samples the acceleration changes by at most j·dt.
        prop_assert!(jerked <= band.jerk * dt * (1.0 + 1e-6) + SLACK * (band.up + band.down));
        let step = state.position - before.position;
        let mean = (state.velocity + before.velocity) / 2.0 * dt;
        // The trapezoidal rule errs by at most j·dt³/12 under constant jerk, more across a change of it.
        prop_assert!((step - mean).abs() <= band.jerk * dt * dt * dt + SLACK * size);
        before = state;
    }
    let end = line.after(duration, 0.0);
    prop_assert!((before.position - end.position).abs() <= SLACK * size);
    prop_assert!((before.velocity - end.velocity).abs() <= SLACK * (band.highest - band.lowest));
    let missing = (before.acceleration - end.acceleration).abs();
    prop_assert!(missing <= 1e-6 * (band.up + band.down), "{missing}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn nothing_is_on_the_line_earlier((start, line, band) in chase()) {
        let profile = to_line(&start, &line, &band).expect("the line is within the band");
        assert_right(&profile, (&start, &line, &band))?;
        if let Some(expected) = independent(&start, &line, &band) {
            let found = profile.duration().0;
            prop_assert!(found <= expected * (1.0 + 1e-7), "{found} {expected}");
        }
    }

    #[test]
    fn a_line_that_accelerates_is_met_with_its_acceleration(
        (start, mut line, band) in chase(), share in -0.5..0.5_f64,
    ) {
        line.acceleration = share * band.up.min(band.down);
        if let Some(profile) = to_line(&start, &line, &band) {
            let duration = profile.duration().0;
            let end = line.after(duration, 0.0);
            let (found, size) = (profile.end(), 1.0 + end.position.abs() + line.position.abs());
            prop_assert!((found.position - end.position).abs() <= 1e-12 * size);
            prop_assert!((found.velocity - end.velocity).abs() <= SLACK * (1.0 + end.velocity.abs()));
            prop_assert!((found.acceleration - end.acceleration).abs() <= SLACK * band.up.max(band.down));
            // Values of the phases, and of the end.
            let last = profile.at(Seconds(duration * (1.0 - 1e-12)));
            let far = (last.position - end.position).abs();
            let fast = last.velocity.abs() + end.velocity.abs() + band.highest;
            let reached = fast * duration + size;
            prop_assert!(far <= 1e-8 * reached, "{far} {reached}");
        }
    }
}

#[test]
fn a_line_at_the_velocity_limit_is_not_caught() {
    let band = Band {
        lowest: -100.0,
        highest: 100.0,
        up: 500.0,
        down: 500.0,
        jerk: 5_000.0,
    };
    let line = Kinematics {
        position: 10.0,
        velocity: 100.0,
        acceleration: 0.0,
    };
    assert!(to_line(&Kinematics::at_rest(0.0), &line, &band).is_none());
    // From ahead of it there is a path.
    // Reaching 100 u/s takes 100/500 + 500/5000 = 0.3 s and 15 u. The line covers
    // 30 u meanwhile, so the axis is still 15 u ahead and may wait for it.
    assert!(to_line(&Kinematics::at_rest(40.0), &line, &band).is_some());
    let too_steep = Kinematics {
        velocity: 0.0,
        acceleration: 600.0,
        ..line
    };
    assert!(to_line(&Kinematics::at_rest(0.0), &too_steep, &band).is_none());
    let head = towards(&Kinematics::at_rest(0.0), 100.0, &band);
    assert_eq!((head.end().velocity, head.end().acceleration), (100.0, 0.0));
}

#[test]
fn who_is_on_the_line_stays_there() {
    let band = Band {
        lowest: -100.0,
        highest: 100.0,
        up: 500.0,
        down: 500.0,
        jerk: 5_000.0,
    };
    let line = Kinematics {
        position: 10.0,
        velocity: 50.0,
        acceleration: 0.0,
    };
    let profile = to_line(&line, &line, &band).expect("within the band");
    assert_eq!(profile.duration(), Seconds(0.0));
    assert_eq!(profile.end(), line);
}

#[test]
fn a_gentle_band_leads_to_the_line_as_well() {
    // Shares down to e^−20.7 = 1e-9, as a slow strategy of a flying saw tries them.
    for (k, lowest) in (0..=900).flat_map(|k| [(k, -990.0), (k, 0.0)]) {
        let share = libm::exp(-0.023 * f64::from(k));
        let band = Band {
            lowest,
            highest: 990.0,
            up: 5_000.0 * share,
            down: 4_000.0 * share,
            jerk: 100_000.0 * share,
        };
        let line = Kinematics {
            position: -49.6,
            velocity: 400.0,
            acceleration: 0.0,
        };
        let start = Kinematics {
            position: 250.4,
            ..line
        };
        let profile = to_line(&start, &line, &band).expect("within the band");
        let end = line.after(profile.duration().0, 0.0);
        let last = profile.at(Seconds(profile.duration().0 * (1.0 - 1e-15)));
        assert!(
            (last.position - end.position).abs() < 1e-6,
            "{share} {profile:?}"
        );
    }
}
