//! View settings of the page.

use coaxle_plate::{Course, Demand, LawCriteria, LawLimits, Plate};
use serde::Deserialize;
use serde_json::Value;

/// The page's choices; none of them is in the file.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ViewSettings {
    /// x/s, not 0.
    pub(super) master_velocity: f64,
    /// Over time, in seconds and derivatives over time; otherwise over the master.
    pub(super) over_time: bool,
    /// Number of turns drawn.
    pub(super) turns: u32,
    velocity: Option<f64>,
    acceleration: Option<f64>,
    jerk: Option<f64>,
    torque: Option<f64>,
    /// Quantity that the advised law minimises.
    least: Demand,
    /// The point that is selected, from 0; advice is about the segment that begins there.
    pub(super) selected: Option<usize>,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            // A master in degrees makes one turn a second with it.
            master_velocity: 360.0,
            over_time: false,
            turns: 1,
            velocity: None,
            acceleration: None,
            jerk: None,
            torque: None,
            least: Demand::default(),
            selected: None,
        }
    }
}

/// Most turns drawn: more are a stripe.
const MOST_TURNS: u32 = 20;

impl ViewSettings {
    /// # Errors
    /// The first field that is wrong.
    pub(super) fn of(json: &Value) -> Result<Self, String> {
        let settings = match json {
            Value::Null => Self::default(),
            json => Self::deserialize(json).map_err(|error| error.to_string())?,
        };
        let velocity = settings.master_velocity;
        // Places over time divide by it.
        if !(velocity.is_finite() && velocity != 0.0) {
            return Err(format!(
                "master velocity: received {velocity}, expected a finite number other than 0"
            ));
        }
        if !(1..=MOST_TURNS).contains(&settings.turns) {
            let received = settings.turns;
            return Err(format!(
                "turns: received {received}, expected 1 to {MOST_TURNS}"
            ));
        }
        Ok(settings)
    }

    pub(super) const fn limits(&self) -> LawLimits {
        LawLimits {
            velocity: self.velocity,
            acceleration: self.acceleration,
            jerk: self.jerk,
            torque: self.torque,
        }
    }

    pub(super) const fn question(&self) -> LawCriteria {
        LawCriteria {
            master_velocity: self.master_velocity,
            limits: self.limits(),
            least: self.least,
        }
    }

    /// Number of turns drawn of a plate: a linear one is passed once.
    pub(super) fn turns_of(&self, plate: &Plate) -> u32 {
        match plate.course() {
            // Behind its end a linear plate has no second turn.
            Course::Linear => 1,
            Course::Cyclic => self.turns,
        }
    }

    /// Factor from a derivative with respect to the master to the one shown.
    pub(super) fn factor(&self, quantity: usize) -> f64 {
        match self.over_time {
            // The chain rule at a constant velocity V: d^n s/dt^n = s^(n)·V^n.
            true => self.master_velocity.powi(quantity as i32),
            false => 1.0,
        }
    }

    /// Place of a master position on an axis that begins at `start`.
    pub(super) fn along(&self, start: f64, master: f64) -> f64 {
        match self.over_time {
            true => (master - start) / self.master_velocity,
            false => master,
        }
    }

    /// The master position at a place of the axis.
    pub(super) fn master(&self, start: f64, along: f64) -> f64 {
        match self.over_time {
            true => start + along * self.master_velocity,
            false => along,
        }
    }

    /// A limit over time as it is shown.
    pub(super) fn shown_limit(&self, quantity: usize, limit: f64) -> f64 {
        match self.over_time {
            true => limit,
            // The inverse of `factor`, without the sign: limits hold in both directions.
            false => limit / self.master_velocity.abs().powi(quantity as i32),
        }
    }
}
