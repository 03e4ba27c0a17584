//! The way of a master through a flying gear: past the engagement, and on or back past the release.

use coaxle_curve::law::Motion;
use coaxle_curve::profile::Kinematics;
use coaxle_files::gear::GearFile;
use coaxle_gear::{FlyingGear, FlyingGearPhase, FlyingGearRange};

/// Places on each leg of the way.
// More than a screen has pixels, so that short stretches show as well.
const SAMPLES: usize = 2_000;

/// Ends of the master's way, with its turning point between them if it has one.
pub(super) struct MasterPath {
    pub(super) ends: Vec<f64>,
}

impl MasterPath {
    /// From somewhat before the engagement to somewhat behind the release.
    pub(super) fn of(gear: &FlyingGear, stretches: &[FlyingGearRange; 2]) -> Self {
        let [engaging, releasing] = stretches;
        let places = [
            engaging.master_free,
            engaging.master_coupled,
            releasing.master_free,
            releasing.master_coupled,
        ];
        // Mirrored, so that the working direction is upwards for either sign; twice mirrored is unchanged, as it is ±1.
        let ahead = |place: f64| place * gear.master_direction();
        let first = places.into_iter().map(ahead).fold(f64::INFINITY, f64::min);
        let last = places
            .into_iter()
            .map(ahead)
            .fold(f64::NEG_INFINITY, f64::max);
        // About a ninth of the picture on either side shows the slave before and after.
        let room = ((last - first) * 0.15).max(f64::MIN_POSITIVE);
        let at = |ahead: f64| ahead * gear.master_direction();
        let ends = match gear.returns() {
            // Past the coupled stretch there is only a straight line.
            true => vec![at(first - room), at(last + 3.0 * room), at(first - room)],
            false => vec![at(first - room), at(last + room)],
        };
        Self { ends }
    }
}

/// Every place of the way, with the slave there over time; where a stretch begins or ends, both sides.
pub(super) fn course(
    file: &GearFile,
    gear: &FlyingGear,
    stretches: &[FlyingGearRange; 2],
) -> Vec<(f64, Motion)> {
    // A copy: the drawing runs the gear through its phases.
    let mut gear = *gear;
    let path = MasterPath::of(&gear, stretches);
    let speed = file.master.velocity.abs();
    let mut places = Vec::new();
    for leg in path.ends.windows(2) {
        // The course over the master is the same at any speed; derivatives over time are those at the file's.
        let velocity = speed.copysign(leg[1] - leg[0]);
        for n in 0..=SAMPLES {
            let position = leg[0] + (leg[1] - leg[0]) * (n as f64 / SAMPLES as f64);
            let master = Kinematics {
                position,
                velocity,
                // The master runs at a constant velocity, and turns round at once.
                acceleration: 0.0,
            };
            let slave = gear.update(&master);
            let jerk = jerk(&gear, stretches, position, slave.velocity);
            places.push((
                position,
                Motion {
                    position: slave.position,
                    velocity: slave.velocity,
                    acceleration: slave.acceleration,
                    jerk,
                },
            ));
        }
    }
    places
}

/// Along a stretch the jerk is a straight line, from its highest value to the opposite one.
fn jerk(gear: &FlyingGear, stretches: &[FlyingGearRange; 2], master: f64, velocity: f64) -> f64 {
    let (stretch, forwards) = match gear.phase() {
        FlyingGearPhase::Engaging => (&stretches[0], 1.0),
        FlyingGearPhase::Releasing => (&stretches[1], -1.0),
        _ => return 0.0,
    };
    // The ratio goes as 3x² − 2x³ over the stretch, and the jerk as its second derivative, 6·(1 − 2x).
    let share = (master - stretch.master_free) / (stretch.master_coupled - stretch.master_free);
    // A release is passed from its coupled end.
    let share = if forwards > 0.0 { share } else { 1.0 - share };
    // `stretch.jerk` is the magnitude at the ends; the sign is that of the motion.
    velocity.signum() * forwards * stretch.jerk * (1.0 - 2.0 * share)
}
