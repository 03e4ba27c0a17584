//! The stages of a count: gate, estimate, extrapolation, tracker.

use coaxle_axis::TravelDirection;
use coaxle_curve::profile::Kinematics;

use super::estimate::Estimator;
use super::gate::{Edge, Gate, Passage};
use super::parameters::CheckedEncoder;
use super::tracker::{Tracker, moved};
use super::uncertainty::Uncertainty;

/// State from the first sample on. Positions count from the lower border of the first increment.
#[derive(Clone, Debug)]
pub(super) struct Following {
    gate: Gate,
    estimator: Estimator,
    tracker: Tracker,
    /// Position of the axis while no motion is certain.
    held: f64,
    /// Seconds until the estimate has settled.
    acquiring: f64,
}

/// Time constants until an estimate has settled.
const ACQUISITION: f64 = 12.0;
/// Time without a sample after which the estimate is void, s.
const SAMPLES_LOST_AFTER: f64 = 0.25;
/// Time after the last sample for which its acceleration is used, s.
const ACCELERATION_LASTS: f64 = 0.02;
/// Time over which the acceleration then fades, s.
const ACCELERATION_FADES: f64 = 0.1;

impl Following {
    pub(super) fn new(checked: &CheckedEncoder, first: i64) -> Self {
        let estimator = Estimator::new(checked, first);
        let held = estimator.state().position;
        Self {
            gate: Gate::new(checked.hysteresis, first),
            tracker: Tracker::new(checked, held),
            estimator,
            held,
            // The slowest pole decays as e^(-ωt/2): after 12/ω an initial error is at e⁻⁶, a quarter of a percent.
            acquiring: ACQUISITION / checked.bandwidth,
        }
    }

    /// The set values.
    pub(super) const fn set(&self) -> &Kinematics {
        self.tracker.state()
    }

    /// Estimated velocity of the axis.
    pub(super) const fn velocity(&self) -> f64 {
        self.estimator.state().velocity
    }

    pub(super) const fn direction(&self) -> Option<TravelDirection> {
        self.gate.direction()
    }

    pub(super) const fn is_standstill(&self) -> bool {
        !self.gate.is_released()
    }

    pub(super) const fn is_trimming(&self) -> bool {
        self.tracker.is_walking()
    }

    pub(super) fn is_acquired(&self) -> bool {
        self.acquiring <= 0.0
    }

    /// Standard deviations of position and velocity.
    pub(super) fn sigmas(&self, uncertainty: &Uncertainty, horizon: f64) -> (f64, f64) {
        if self.is_standstill() {
            uncertainty.standing(self.estimator.since_edge())
        } else {
            uncertainty.moving(horizon)
        }
    }

    /// Takes a count some seconds after the last one.
    pub(super) fn take(&mut self, count: i64, gap: f64) {
        match self.gate.update(count) {
            Passage::Edge(edge) if self.starts_anew(&edge, gap) => {
                self.estimator.restart(&edge, gap);
            }
            passage => self.estimator.update(count, passage, gap),
        }
        // The gate closes again at rest, so that the next motion has to prove its direction as the first did.
        if self.estimator.is_standstill() && self.gate.is_released() {
            self.gate.rest(count);
            self.held = self.estimator.state().position;
        }
        // Until the first settling the set values jump to the estimate anyway. Later they hold where the axis
        // stopped.
        if !self.gate.is_released() && !self.is_acquired() {
            self.held = self.estimator.state().position;
        }
    }

    /// True if the previous motion of the axis gives no information on the present one: samples
    /// were missing for long, or it already moved at the first one.
    fn starts_anew(&self, edge: &Edge, gap: f64) -> bool {
        // A first step of several counts is that of an axis in motion when it was first seen.
        let moved_before = !self.is_acquired() && self.estimator.is_standstill() && edge.counts > 1;
        gap > SAMPLES_LOST_AFTER || moved_before
    }

    /// Moves the set values for this number of cycles, to the instant `horizon` seconds after the
    /// newest count.
    pub(super) fn advance(&mut self, horizon: f64, elapsed: u32, cycle: f64) {
        let direction = self.gate.direction();
        match self.goal(horizon) {
            None => self.tracker.stop(direction, elapsed),
            Some(goal) if self.is_acquired() => self.tracker.follow(&goal, direction, elapsed),
            Some(goal) => {
                self.acquiring -= f64::from(elapsed) * cycle;
                self.tracker.jump(&goal);
            }
        }
    }

    /// Position of the axis at that time; none once it is unknown.
    fn goal(&self, horizon: f64) -> Option<Kinematics> {
        if !self.gate.is_released() {
            return Some(Kinematics::at_rest(self.held));
        }
        // Order of the checks: an axis at rest stays there without samples too, and needs no stop.
        if horizon >= SAMPLES_LOST_AFTER {
            return None;
        }
        let last = self.estimator.state();
        let then = extrapolated(last, horizon);
        let sign = self.gate.direction().map_or(0.0, TravelDirection::sign);
        if then.velocity * sign < 0.0 {
            // The axis moves this way or stands: an estimate of the opposite is noise.
            return Some(Kinematics::at_rest(last.position));
        }
        Some(then)
    }
}

/// Continues a motion for this number of seconds.
fn extrapolated(last: &Kinematics, horizon: f64) -> Kinematics {
    let accelerated = moved(last, horizon.min(ACCELERATION_LASTS));
    if horizon <= ACCELERATION_LASTS {
        return accelerated;
    }
    let later = horizon - ACCELERATION_LASTS;
    let fading = later.min(ACCELERATION_FADES);
    // Acceleration for 20 ms, then falling to 0 over 100 ms: the velocity departs by 20 + 100/2 = 70 ms of it, as the
    // prediction of a set value does.
    let jerk = -last.acceleration / ACCELERATION_FADES;
    let faded = moved(&accelerated, fading);
    let faded = Kinematics {
        // `moved` keeps the acceleration constant; the constant jerk adds j·t³/6, j·t²/2 and j·t to it.
        position: faded.position + jerk * fading * fading * fading / 6.0,
        velocity: faded.velocity + 0.5 * jerk * fading * fading,
        acceleration: faded.acceleration + jerk * fading,
    };
    if later < ACCELERATION_FADES {
        return faded;
    }
    let coasting = Kinematics {
        // Both parts add up to 0 but for rounding, which the rest of the time would integrate twice.
        acceleration: 0.0,
        ..faded
    };
    moved(&coasting, later - fading)
}
