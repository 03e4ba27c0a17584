//! A slave on its way onto the line of its gear, whatever its master does meanwhile.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Profile};

use crate::chase::Chase;
use crate::task::NEGLIGIBLE;

/// What is left of the master's ripple after a cycle without any.
const FADING: f64 = 0.9;
/// The part of what the limits let the slave do in a cycle that a ripple has to stay below, for the slave to come onto
/// the line by itself.
const CORRECTED: f64 = 1.0 / 64.0;

/// A profile over time onto the line, planned anew from the slave as it is wherever the line is not where
/// it was expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pursuit {
    chase: Chase,
    profile: Profile,
    since: f64,
    /// Whether the profile ends on the line; otherwise it leads towards it for as long as it is too fast.
    arrives: bool,
    /// The line as it was in the cycle before.
    line: Kinematics,
    /// How far the line has been from where it was expected lately, u.
    ripple: f64,
}

impl Pursuit {
    /// Along a profile that was planned with this line.
    pub(super) const fn new(chase: Chase, profile: Profile, line: Kinematics) -> Self {
        Self {
            chase,
            profile,
            since: 0.0,
            arrives: true,
            line,
            ripple: 0.0,
        }
    }

    /// The slave, which was at `before`, in the next cycle; none if it is on the line.
    pub(super) fn update(
        &mut self,
        before: &Kinematics,
        line: &Kinematics,
        dt: f64,
    ) -> Option<Kinematics> {
        if !self.is_expected(line, dt) {
            self.plan(before, &line.after(-dt, 0.0));
        }
        self.line = *line;
        self.since += dt;
        let next = self.profile.at(Seconds(self.since));
        let arrived = self.arrives && self.since >= self.profile.duration().0;
        (!arrived && !self.is_within_ripple(&next, line, dt)).then_some(next)
    }

    fn is_expected(&mut self, line: &Kinematics, dt: f64) -> bool {
        let expected = self.line.after(dt, 0.0);
        let surprise = (line.position - expected.position).abs();
        self.ripple = surprise.max(self.ripple * FADING);
        let near = |a: f64, b: f64| (a - b).abs() <= NEGLIGIBLE * a.abs().max(b.abs());
        let digits = 4.0 * f64::EPSILON * line.position.abs();
        surprise <= NEGLIGIBLE * (line.velocity * dt).abs() + digits
            && near(line.velocity, expected.velocity)
            && near(line.acceleration, expected.acceleration)
    }

    fn plan(&mut self, slave: &Kinematics, line: &Kinematics) {
        let steady = Kinematics {
            acceleration: 0.0,
            ..*line
        };
        let caught = self
            .chase
            .onto(slave, line)
            .or_else(|| self.chase.onto(slave, &steady));
        self.arrives = caught.is_some();
        self.profile = caught.unwrap_or_else(|| self.chase.towards(slave, line));
        self.since = 0.0;
    }

    /// A line that ripples by more than the slave can follow is never reached; there the slave comes along
    /// when it is no farther away than the line moves about.
    fn is_within_ripple(&self, next: &Kinematics, line: &Kinematics, dt: f64) -> bool {
        let jerk = self.chase.limits.binding_in_cycles(dt).jerk();
        let corrected = CORRECTED * jerk * dt * dt * dt;
        self.ripple > corrected
            && (line.position - next.position).abs() <= self.ripple
            && (line.velocity - next.velocity).abs() * dt <= self.ripple
            && (line.acceleration - next.acceleration).abs() * dt * dt <= self.ripple
    }
}
