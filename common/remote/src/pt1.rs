//! A first-order low pass on position and velocity.

/// The PT1 filter of the set values; exact for inputs that are held over a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pt1 {
    factor_position: f64,
    factor_velocity: f64,
    value: Option<(f64, f64)>,
}

impl Pt1 {
    /// Time constants of position and velocity, in cycles; 0: no filter.
    pub(super) const fn new(factor_position: f64, factor_velocity: f64) -> Self {
        Self {
            factor_position,
            factor_velocity,
            value: None,
        }
    }

    /// One step of `elapsed` cycles; starts at its first input. Gives position and velocity.
    pub(super) fn update(&mut self, position: f64, velocity: f64, elapsed: u32) -> (f64, f64) {
        let (old_position, old_velocity) = self.value.unwrap_or((position, velocity));
        let value = (
            old_position + share(self.factor_position, elapsed) * (position - old_position),
            old_velocity + share(self.factor_velocity, elapsed) * (velocity - old_velocity),
        );
        self.value = Some(value);
        value
    }
}

/// How much of a step is made in `elapsed` cycles with a time constant of `factor` cycles.
fn share(factor: f64, elapsed: u32) -> f64 {
    if factor > 0.0 {
        -libm::expm1(-f64::from(elapsed) / factor)
    } else {
        1.0
    }
}
