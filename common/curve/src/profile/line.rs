//! The path to a moving line: the position of a slave depends on that of its master.

use super::band::Band;
use super::bracket::bracket;
use super::phases::{Kinematics, Profile};
use super::velocity_change::VelocityChange;

/// Greatest number of doublings of the time for which the axis accelerates to its velocity limit: beyond,
/// the line cannot be caught.
const DOUBLINGS: usize = 40;

/// Plans the fastest path from a state onto a line that moves as `line`, given at the same moment as
/// `start`: at the end, position, velocity and acceleration are those of the line. None if the line is
/// too fast to be caught, or changes its velocity faster than the axis can.
///
/// As long as the line keeps its velocity, which has to lie within the band, no motion within the band
/// arrives earlier. A line that accelerates is assumed to do so until the end.
#[must_use]
pub fn to_line(start: &Kinematics, line: &Kinematics, band: &Band) -> Option<Profile> {
    // Distances, not positions: far from zero a position has few digits left.
    let here = Kinematics {
        position: start.position - line.position,
        ..*start
    };
    let chase = LineChase {
        line: at_zero(line),
        band: *band,
    };
    let profile = chase.fastest(&here)?;
    let mut profile = profile.shifted(line.position);
    let end = chase.line.after(profile.duration().0, 0.0);
    // The line's own position at that time: sums of rounded phases would leave the slave beside it.
    profile.settle_position(line.position + end.position);
    Some(profile)
}

/// Plans the fastest change to a velocity within a band, which is kept for ever.
#[must_use]
pub fn towards(start: &Kinematics, velocity: f64, band: &Band) -> Profile {
    let mut profile = Profile::starting_from(start);
    VelocityChange::directed(start, velocity, band).append_to(&mut profile);
    profile
}

const fn at_zero(line: &Kinematics) -> Kinematics {
    Kinematics {
        position: 0.0,
        ..*line
    }
}

/// A line that is at 0 now, and the limits of the axis.
struct LineChase {
    line: Kinematics,
    band: Band,
}

impl LineChase {
    fn mirrored(&self) -> Self {
        Self {
            line: self.line.mirrored(),
            band: self.band.mirrored(),
        }
    }

    fn fastest(&self, start: &Kinematics) -> Option<Profile> {
        // Its end decides the direction: ahead of the line
        // the slave has to lose distance, behind it to gain.
        let at_once = self.matched(Profile::starting_from(start))?;
        let ahead = self.ahead(&at_once);
        if ahead == 0.0 {
            Some(at_once)
        } else if ahead < 0.0 {
            self.upwards(start, ahead)
        } else {
            let seen = self.mirrored().upwards(&start.mirrored(), -ahead)?;
            Some(seen.mirrored())
        }
    }

    /// Accelerates to the velocity limit first, for as long as needed to cover the distance that is
    /// missing if the line's motion is taken up at once. The longer it takes, the farther the axis gets.
    fn upwards(&self, start: &Kinematics, ahead: f64) -> Option<Profile> {
        let heading = VelocityChange::directed(start, self.band.highest, &self.band);
        let lasting = |time: f64| {
            let mut profile = Profile::starting_from(start);
            heading.append_first(time, &mut profile);
            // At the velocity limit distance is gained at a constant rate, for as long as needed.
            if time > heading.duration() {
                profile.push(0.0, time - heading.duration(), 0.0);
            }
            self.matched(profile)
        };
        let gap = |time: f64| lasting(time).map_or(f64::NAN, |profile| self.ahead(&profile));

        let whole = heading.duration();
        let at_limit = gap(whole);
        // A steady line: the gap closes at a constant rate, so the time follows from a division.
        if at_limit < 0.0 && self.line.acceleration == 0.0 {
            let faster = self.band.highest - self.line.velocity;
            let cruise = -at_limit / faster;
            // A line at the velocity limit is never caught from behind, whatever the time.
            return (faster > 0.0 && cruise.is_finite())
                .then(|| lasting(whole + cruise))
                .flatten();
        }
        let mut far = (whole, at_limit);
        let mut near = (0.0, ahead);
        for _ in 0..DOUBLINGS {
            if far.1 >= 0.0 {
                break;
            }
            // Without the addition a time of 0, for a start at the velocity limit, would stay 0.
            let later = 2.0 * far.0 + f64::EPSILON;
            near = far;
            far = (later, gap(later));
        }
        (far.1 >= 0.0)
            // The lower end: the axis lies behind the line by no
            // more than rounding, and is put onto it afterwards.
            .then(|| lasting(bracket(near, far, gap).below))
            .flatten()
    }

    /// Takes up the line's motion from the end of a profile, at any place; none if the line is out of
    /// reach.
    fn matched(&self, mut profile: Profile) -> Option<Profile> {
        let (end, line) = (profile.end(), self.line_after(&profile));
        let relative = Kinematics {
            position: 0.0,
            velocity: end.velocity - line.velocity,
            acceleration: end.acceleration - line.acceleration,
        };
        let band = Band {
            // Limits seen from the line: its own acceleration is added to every motion relative to it.
            up: self.band.up - line.acceleration,
            down: self.band.down + line.acceleration,
            ..self.band
        };
        // A line that accelerates as hard as the axis can
        // leaves nothing to catch up with. NaN ends here, too.
        if !(band.up > 0.0 && band.down > 0.0) {
            return None;
        }
        let change = VelocityChange::directed(&relative, 0.0, &band);
        let end = line.after(change.duration(), 0.0);
        change.append_to_moving(&mut profile, &end);
        Some(profile)
    }

    /// Returns the distance of the end of a profile ahead of the line.
    fn ahead(&self, profile: &Profile) -> f64 {
        profile.end().position - self.line_after(profile).position
    }

    fn line_after(&self, profile: &Profile) -> Kinematics {
        self.line.after(profile.duration().0, 0.0)
    }
}
