//! A first-order low pass on position and velocity.

/// The PT1 filter of the set values; exact for inputs that are held over a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pt1 {
    factor_position: f64,
    factor_velocity: f64,
    /// The shares of a step that are made in one cycle, as most take one.
    shares: (f64, f64),
    value: Option<(f64, f64)>,
    /// Seconds of a cycle, if its first input is taken for one of many of the same velocity.
    settled: Option<f64>,
}

impl Pt1 {
    /// Time constants of position and velocity, in cycles; 0: no filter.
    pub(super) fn new(factor_position: f64, factor_velocity: f64) -> Self {
        Self {
            factor_position,
            factor_velocity,
            shares: (share(factor_position, 1), share(factor_velocity, 1)),
            value: None,
            settled: None,
        }
    }

    /// Changes the time constants; the filter goes on from where it is.
    pub(super) fn set(&mut self, factor_position: f64, factor_velocity: f64) {
        *self = Self {
            value: self.value,
            settled: self.settled,
            ..Self::new(factor_position, factor_velocity)
        };
    }

    /// The next input is its first.
    pub(super) const fn restart(&mut self) {
        self.value = None;
        self.settled = None;
    }

    /// The next input is its first, but it lags behind as if it had had that velocity for long. A cycle takes so
    /// many seconds.
    pub(super) const fn restart_settled(&mut self, cycle_time: f64) {
        self.value = None;
        self.settled = Some(cycle_time);
    }

    /// One step of `elapsed` cycles; starts at its first input. Gives position and velocity.
    pub(super) fn update(&mut self, position: f64, velocity: f64, elapsed: u32) -> (f64, f64) {
        let (old_position, old_velocity) = self
            .value
            .unwrap_or_else(|| (self.first(position, velocity, elapsed), velocity));
        let (of_position, of_velocity) = match elapsed {
            1 => self.shares,
            _ => (
                share(self.factor_position, elapsed),
                share(self.factor_velocity, elapsed),
            ),
        };
        let value = (
            old_position + of_position * (position - old_position),
            old_velocity + of_velocity * (velocity - old_velocity),
        );
        self.value = Some(value);
        value
    }

    /// Where it was before its first input. Behind a ramp it is by a cycle's way over its share.
    fn first(&self, position: f64, velocity: f64, elapsed: u32) -> f64 {
        let Some(cycle_time) = self.settled else {
            return position;
        };
        let (share, _) = self.shares;
        let behind = cycle_time * velocity / share;
        position - behind - cycle_time * velocity * f64::from(elapsed.saturating_sub(1))
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
