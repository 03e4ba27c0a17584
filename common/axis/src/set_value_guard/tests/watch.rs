//! Check that positions keep limits, by the positions only.

use coaxle_curve::profile::{Kinematics, Limits};

/// The last four positions of an axis, and their times in cycles.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    limits: Limits,
    cycle_time: f64,
    times: [f64; 4],
    positions: [f64; 4],
}

/// Velocity, acceleration and jerk over their limits: above 1 is a violation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Used {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
}

impl Used {
    pub(super) fn most(&self) -> f64 {
        self.velocity.max(self.acceleration).max(self.jerk)
    }
}

impl Watch {
    /// Starts from standstill.
    pub(super) fn at_rest(position: f64, limits: &Limits, cycle_time: f64) -> Self {
        Self {
            limits: *limits,
            cycle_time,
            times: [-3.0, -2.0, -1.0, 0.0],
            positions: [position; 4],
        }
    }

    /// Restarts, from a motion of constant acceleration.
    pub(super) fn start(&mut self, here: &Kinematics) {
        self.times = [-3.0, -2.0, -1.0, 0.0];
        self.positions = self.times.map(|cycles| {
            let t = cycles * self.cycle_time;
            here.position + t * (here.velocity + t * here.acceleration / 2.0)
        });
    }

    /// The last position, u.
    pub(super) const fn position(&self) -> f64 {
        self.positions[3]
    }

    pub(super) fn set_limits(&mut self, limits: &Limits) {
        self.limits = *limits;
    }

    /// Takes the next position, this number of cycles later.
    pub(super) fn see(&mut self, position: f64, cycles: u32) -> Used {
        let now = self.times[3] + f64::from(cycles);
        self.times.rotate_left(1);
        self.positions.rotate_left(1);
        self.times[3] = now;
        self.positions[3] = position;
        self.used()
    }

    /// Differences, divided if cycles were skipped, over limits with rounding.
    fn used(&self) -> Used {
        let [p0, p1, p2, p3] = self.positions;
        let [t0, t1, t2, t3] = self.times;
        let first = |p: f64, q: f64, from: f64, to: f64| (q - p) / ((to - from) * self.cycle_time);
        let (v1, v2, v3) = (
            first(p0, p1, t0, t1),
            first(p1, p2, t1, t2),
            first(p2, p3, t2, t3),
        );
        let (a2, a3) = (2.0 * first(v1, v2, t0, t2), 2.0 * first(v2, v3, t1, t3));
        // Divided differences times 2 and 3: computed on their own here, so that no fault of the guard hides.
        let jerk = 3.0 * first(a2, a3, t0, t3);
        let rounding = self.rounding();
        let t = self.cycle_time;
        let of = |value: f64, limit: f64, slack: f64| value.abs() / (limit * (1.0 + 1e-9) + slack);
        let acceleration = self.limits.acceleration().max(self.limits.deceleration());
        Used {
            velocity: of(v3, self.limits.velocity(), rounding / t),
            acceleration: of(a3, acceleration, 2.0 * rounding / (t * t)),
            jerk: of(jerk, self.limits.jerk(), 4.0 * rounding / (t * t * t)),
        }
    }

    /// Velocity and acceleration of the last three positions; none if a cycle between them was skipped.
    pub(super) fn state_now(&self) -> Option<Kinematics> {
        let [_, p1, p2, p3] = self.positions;
        let t = self.cycle_time;
        let acceleration = (p3 - 2.0 * p2 + p1) / (t * t);
        (self.times[3] - self.times[0] <= 3.0).then(|| Kinematics {
            position: p3,
            velocity: (p3 - p2) / t + acceleration * t / 2.0,
            acceleration,
        })
    }

    /// True if the speed stays within its limit when the acceleration is led to zero.
    pub(super) fn can_keep_velocity(&self) -> bool {
        let [_, p1, p2, p3] = self.positions;
        let t = self.cycle_time;
        if self.times[3] - self.times[1] > 2.0 {
            // Over a gap this is unknown.
            return false;
        }
        let (v, a) = ((p3 - p2) / t, (p3 - 2.0 * p2 + p1) / (t * t));
        let gained = a * a.abs() / (2.0 * self.limits.jerk());
        let rounding = self.rounding() / t;
        (v + gained).abs().max(v.abs()) <= self.limits.velocity() * (1.0 + 1e-9) + rounding
    }

    fn rounding(&self) -> f64 {
        let largest = self
            .positions
            .iter()
            .fold(self.limits.velocity(), |most, p| most.max(p.abs()));
        // δ as the guard's documentation promises it.
        4.0 * f64::EPSILON * largest
    }
}
