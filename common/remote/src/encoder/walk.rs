//! A short way from rest to rest, slow and jerk-limited.

use coaxle_curve::profile::Kinematics;

/// Two ramps of the velocity, with the largest jerk, and a constant velocity between them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    from: f64,
    to: f64,
    jerk: f64,
    /// Half of a ramp, s.
    half: f64,
    duration: f64,
    passed: f64,
}

impl Walk {
    /// Creates the fastest walk that speed, acceleration and jerk allow.
    pub(super) fn new(from: f64, to: f64, limits: (f64, f64, f64)) -> Self {
        let (speed, acceleration, jerk) = limits;
        let way = (to - from).abs();
        // Top speed j·h², top acceleration j·h, and the shortest way 2·j·h³ of two ramps without anything between.
        let half = libm::sqrt(speed / jerk)
            .min(acceleration / jerk)
            .min(libm::cbrt(0.5 * way / jerk));
        Self {
            from,
            to,
            jerk: jerk.copysign(to - from),
            half,
            // A trapezoid of the velocity: way over top speed, and one ramp of 2h.
            duration: way / (jerk * half * half) + 2.0 * half,
            passed: 0.0,
        }
    }

    pub(super) const fn target(&self) -> f64 {
        self.to
    }

    pub(super) fn is_done(&self) -> bool {
        self.passed >= self.duration
    }

    /// State some seconds later.
    pub(super) fn advance(&mut self, time: f64) -> Kinematics {
        self.passed += time;
        let left = self.duration - self.passed;
        if left <= 0.0 {
            Kinematics::at_rest(self.to)
        } else if left < self.passed {
            // The second half is the first one backward.
            let mirrored = self.since_start(left);
            Kinematics {
                position: self.to - mirrored.position,
                velocity: mirrored.velocity,
                acceleration: -mirrored.acceleration,
            }
        } else {
            let way = self.since_start(self.passed);
            Kinematics {
                position: self.from + way.position,
                ..way
            }
        }
    }

    fn since_start(&self, t: f64) -> Kinematics {
        let (jerk, half) = (self.jerk, self.half);
        let speed = jerk * half * half;
        // After the ramp both terms of `left` vanish, and the motion goes on at top speed.
        let left = (2.0 * half - t).max(0.0);
        if t < half {
            Kinematics {
                position: jerk * t * t * t / 6.0,
                velocity: jerk * t * t / 2.0,
                acceleration: jerk * t,
            }
        } else {
            Kinematics {
                position: speed * (t - half) + jerk * left * left * left / 6.0,
                velocity: speed - jerk * left * left / 2.0,
                acceleration: jerk * left,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_keeps_its_limits_and_ends_where_it_should() {
        for way in [-0.2, 0.003, 5.0] {
            let (start, limits) = (10.0, (5.0, 5_000.0, 1e5));
            let mut walk = Walk::new(start, start + way, limits);
            let (mut last, mut peak) = (Kinematics::at_rest(start), Kinematics::default());
            let time = 1e-4;
            while !walk.is_done() {
                let now = walk.advance(time);
                peak.velocity = peak
                    .velocity
                    .max((now.position - last.position).abs() / time);
                peak.acceleration = peak.acceleration.max(now.acceleration.abs());
                let jerk = (now.acceleration - last.acceleration).abs() / time;
                assert!(jerk <= 1.001e5, "{jerk}");
                last = now;
            }
            assert_eq!(last, Kinematics::at_rest(start + way));
            assert!(
                peak.velocity <= 5.001 && peak.acceleration <= 5_001.0,
                "{peak:?}"
            );
        }
    }
}
