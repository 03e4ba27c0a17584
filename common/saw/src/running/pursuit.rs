//! A slave on its path onto the line of its gear, for any motion of its master.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Profile, ProfileExtremes};

use crate::path_limits::PathLimits;
use crate::task::NEGLIGIBLE;

/// Decay of the master's ripple per cycle without ripple.
// A tenth is left after 22 cycles.
const FADING: f64 = 0.9;
/// Part of the slave's greatest change per cycle that a ripple has to stay below, for the slave to reach
/// the line by itself.
const CORRECTED: f64 = 1.0 / 64.0;
/// Rounding error of a position, relative.
const ROUNDING: f64 = 1e-12;

/// Range of positions of a slave on its path, u. A slave outside of it returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PositionRange {
    /// The limits, infinite where there is none.
    pub(super) low: f64,
    pub(super) high: f64,
    /// Start of the path.
    pub(super) start: f64,
    /// True if it goes no lower than its start and its end; `no_overshoot`: no higher.
    pub(super) no_undershoot: bool,
    pub(super) no_overshoot: bool,
}

impl PositionRange {
    /// True if a path from the slave's position keeps the range.
    fn keeps(&self, profile: &Profile, here: f64) -> bool {
        let (extremes, end) = (ProfileExtremes::of(profile), profile.end().position);
        // Profiles end on the limit exactly, but for the rounding of their positions.
        let slack = ROUNDING * extremes.low.abs().max(extremes.high.abs());
        let low = if self.no_undershoot {
            self.low.max(self.start.min(end))
        } else {
            self.low
        };
        let high = if self.no_overshoot {
            self.high.min(self.start.max(end))
        } else {
            self.high
        };
        // A slave outside may return, but go no farther out.
        extremes.low >= low.min(here) - slack && extremes.high <= high.max(here) + slack
    }
}

/// A profile over time onto the line, planned again from the slave's state whenever the line deviates
/// from its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LinePursuit {
    chase: PathLimits,
    range: PositionRange,
    profile: Profile,
    since: f64,
    /// True if the profile ends on the line. Otherwise it leads towards a line that is too fast, or stops
    /// the slave while no path onto the line keeps the range.
    arrives: bool,
    /// The line in the previous cycle.
    line: Kinematics,
    /// Recent deviation of the line from its prediction, u.
    ripple: f64,
}

impl LinePursuit {
    /// Follows a profile that was planned with this line.
    pub(super) const fn new(
        chase: PathLimits,
        range: PositionRange,
        profile: Profile,
        line: Kinematics,
    ) -> Self {
        Self {
            chase,
            range,
            profile,
            since: 0.0,
            arrives: true,
            line,
            ripple: 0.0,
        }
    }

    /// Plans again in the next cycle, since the slave has left its profile.
    pub(super) const fn plan_again(&mut self) {
        self.arrives = false;
    }

    /// Returns the slave, which was at `before`, in the next cycle; none if it is on the line.
    pub(super) fn update(
        &mut self,
        before: &Kinematics,
        line: &Kinematics,
        dt: f64,
    ) -> Option<Kinematics> {
        // A steady line is planned for once: planning again
        // would only add rounding, and cost a cycle's time.
        if !self.is_expected(line, dt) || !self.arrives {
            // Slave and line of the same instant: the slave's last set values are a cycle old.
            self.plan(before, &line.after(-dt, 0.0));
        }
        self.line = *line;
        // Without this check a slave whose path turns just before
        // a software limit runs into it when the line moves.
        if !self.can_stop_after(before, dt) {
            self.stop(before);
        }
        self.since += dt;
        let next = self.profile.at(Seconds(self.since));
        let arrived = self.arrives && self.since >= self.profile.duration().0;
        (!arrived && !self.is_within_ripple(&next, line, dt)).then_some(next)
    }

    fn is_expected(&mut self, line: &Kinematics, dt: f64) -> bool {
        let expected = self.line.after(dt, 0.0);
        // Positions, not velocities: they decide where the slave has to be.
        let surprise = (line.position - expected.position).abs();
        self.ripple = surprise.max(self.ripple * FADING);
        let near = |a: f64, b: f64| (a - b).abs() <= NEGLIGIBLE * a.abs().max(b.abs());
        // Far from zero the position itself is rounded by more than its step per cycle times 1e-9.
        let digits = 4.0 * f64::EPSILON * line.position.abs();
        surprise <= NEGLIGIBLE * (line.velocity * dt).abs() + digits
            && near(line.velocity, expected.velocity)
            && near(line.acceleration, expected.acceleration)
    }

    /// True if the slave, which is at `before`, can still stop within the range after another cycle. On
    /// its path onto the line it may reverse at a limit faster than it could stop there, and its axis
    /// goes no farther than it can stop.
    fn can_stop_after(&self, before: &Kinematics, dt: f64) -> bool {
        let next = self.profile.at(Seconds(self.since + dt));
        self.range
            .keeps(&self.chase.stopping(&next), before.position)
    }

    fn stop(&mut self, slave: &Kinematics) {
        self.profile = self.chase.stopping(slave);
        self.since = 0.0;
        self.arrives = false;
    }

    /// Plans the fastest path onto the line that keeps the range. Without one, the slave moves towards a
    /// line that is too fast for it, and stops otherwise to wait there.
    fn plan(&mut self, slave: &Kinematics, line: &Kinematics) {
        let steady = Kinematics {
            acceleration: 0.0,
            ..*line
        };
        // A line that accelerates harder than the slave can is
        // not met while it does. As a steady one it may be.
        let (found, is_out_of_reach) = match self.onto(slave, line) {
            Some(Ok(profile)) => (Some(profile), false),
            planned => {
                let is_out_of_reach = planned.is_none();
                let steady = self.onto(slave, &steady);
                let found = steady.and_then(Result::ok);
                (found, is_out_of_reach && steady.is_none())
            }
        };
        self.arrives = found.is_some();
        self.since = 0.0;
        self.profile = found.unwrap_or_else(|| {
            if is_out_of_reach {
                self.chase.towards(slave, line)
            } else {
                self.chase.stopping(slave)
            }
        });
    }

    /// Plans a path onto the line. None if no path leads onto it, and an error if none does within the
    /// range.
    fn onto(&self, slave: &Kinematics, line: &Kinematics) -> Option<Result<Profile, OutsideRange>> {
        let check = |profile: &Profile| {
            let keeps = self.range.keeps(profile, slave.position);
            keeps.then_some(()).ok_or(OutsideRange)
        };
        self.chase.fastest((slave, line), 1.0, check)
    }

    /// True if the line is within its ripple. A line that ripples by more than the slave can follow is
    /// never reached. The slave then joins it when it is no farther away than the ripple.
    fn is_within_ripple(&self, next: &Kinematics, line: &Kinematics, dt: f64) -> bool {
        let jerk = self.chase.limits.binding_in_cycles(dt).jerk();
        let corrected = CORRECTED * jerk * dt * dt * dt;
        // Smaller ripples are left to the path itself, which arrives with its exact motion.
        self.ripple > corrected
            && (line.position - next.position).abs() <= self.ripple
            // All three as positions in a cycle. Crossing the line at full speed is no arrival.
            && (line.velocity - next.velocity).abs() * dt <= self.ripple
            && (line.acceleration - next.acceleration).abs() * dt * dt <= self.ripple
    }
}

/// A path that leaves the range.
#[derive(Clone, Copy, Debug)]
struct OutsideRange;
