//! A simulated drive behind a dead time: of its fieldbus, its interpolator and its controller.

use coaxle_axis::drive::{Actual, Drive, DriveKind, DriveState, SimulatedDrive};
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_slave::WaitingSets;

/// A drive that follows each set value a dead time after it was given it.
#[derive(Debug)]
pub(super) struct LateDrive {
    drive: SimulatedDrive,
    dead_time: Span,
    on_the_way: WaitingSets,
}

impl LateDrive {
    pub(super) fn new(drive: SimulatedDrive, dead_time: Span) -> Self {
        let cycles = dead_time.div_floor(CycleTime::MIN);
        Self {
            drive,
            dead_time,
            on_the_way: WaitingSets::new(cycles as u32),
        }
    }
}

impl Drive for LateDrive {
    fn power_on(&mut self, position: f64, velocity: f64) {
        if self.drive.actual().state == DriveState::Off {
            // It moves on with what it was given before, as its axis does.
            let start = Kinematics {
                position: position + velocity * self.dead_time.as_secs_f64(),
                velocity,
                acceleration: 0.0,
            };
            self.on_the_way.clear();
            self.on_the_way.push(&start, Span::ZERO, self.dead_time);
        }
        self.drive.power_on(position, velocity);
    }

    fn reset(&mut self) {
        self.drive.reset();
    }

    fn step(&mut self, set: &Kinematics, elapsed: Seconds) {
        let passed = elapsed.to_span();
        self.on_the_way.advance(passed);
        self.on_the_way.push(set, passed, self.dead_time);
        let due = self.on_the_way.due().unwrap_or(*set);
        self.drive.step(&due, elapsed);
    }

    fn actual(&self) -> Actual {
        self.drive.actual()
    }

    fn kind(&self) -> DriveKind {
        self.drive.kind()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_axis::drive::DriveParameters;

    const CYCLE: Seconds = Seconds(1e-3);

    fn stiff() -> SimulatedDrive {
        SimulatedDrive::new(DriveParameters {
            velocity_lag: 0.0,
            ..DriveParameters::default()
        })
        .expect("in range")
    }

    #[test]
    fn it_is_the_same_drive_a_dead_time_later() {
        let mut prompt = stiff();
        let mut late = LateDrive::new(stiff(), Span::from_millis(4));
        let motion =
            |cycle: i32| Kinematics::at_rest(3.0).after(f64::from(cycle.max(0)) * 1e-3, 2_000.0);
        prompt.power_on(3.0, 0.0);
        late.power_on(3.0, 0.0);
        let mut actual = Vec::new();
        for cycle in 0..200 {
            prompt.step(&motion(cycle), CYCLE);
            late.step(&motion(cycle), CYCLE);
            actual.push(prompt.actual());
            if cycle >= 4 {
                let (late, prompt) = (late.actual(), actual[cycle as usize - 4]);
                assert!((late.position - prompt.position).abs() < 1e-12, "{cycle}");
                assert!((late.following_error - prompt.following_error).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn switched_on_in_motion_it_moves_on_until_the_first_set_value_comes() {
        let mut late = LateDrive::new(stiff(), Span::from_micros(2_500));
        late.power_on(100.0, 50.0);
        for cycle in 1..=20 {
            // Given ahead by its dead time.
            let set = Kinematics {
                position: 100.0 + 0.05 * (f64::from(cycle) + 2.5),
                velocity: 50.0,
                acceleration: 0.0,
            };
            late.step(&set, CYCLE);
            let expected = 100.0 + 0.05 * f64::from(cycle);
            assert!((late.actual().position - expected).abs() < 1e-9, "{cycle}");
        }
        late.reset();
        late.power_on(0.0, 0.0);
        late.step(&Kinematics::at_rest(0.0), CYCLE);
        assert_eq!(late.actual().position, 0.0);
    }
}
