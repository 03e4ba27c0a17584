//! A first-order low pass on position and velocity.

/// Rest of a step that is none any more, in any unit: a proton is 1e-12 mm wide.
// About 0 it would go on to the smallest number and stay there: in swarm schedule 50771 an axis at −1e−139 u was brought back to one at 0 for the
// rest of the run.
const NOTHING: f64 = 1e-30;

/// The PT1 filter of the set values; exact for inputs that are constant over a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pt1 {
    factor_position: f64,
    factor_velocity: f64,
    /// Shares of a step in one cycle, the most frequent `elapsed`.
    shares: (f64, f64),
    value: Option<(f64, f64)>,
    /// Seconds of a cycle, if its first input is taken for one of many with equal velocity.
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

    /// Changes the time constants; the filter continues from its current state.
    pub(super) fn set(&mut self, factor_position: f64, factor_velocity: f64) {
        *self = Self {
            value: self.value,
            settled: self.settled,
            ..Self::new(factor_position, factor_velocity)
        };
    }

    /// Takes the next input for the first.
    pub(super) const fn restart(&mut self) {
        self.value = None;
        self.settled = None;
    }

    /// Takes the next input for the first, but with the lag of a filter that has had its velocity
    /// for long. `cycle_time` is in seconds.
    pub(super) const fn restart_settled(&mut self, cycle_time: f64) {
        self.value = None;
        self.settled = Some(cycle_time);
    }

    /// Runs one step of `elapsed` cycles; starts at its first input. Returns position and velocity.
    pub(super) fn update(&mut self, position: f64, velocity: f64, elapsed: u32) -> (f64, f64) {
        let (old_position, old_velocity) = self
            .value
            .unwrap_or_else(|| (self.first(position, velocity, elapsed), velocity));
        // Two exponentials per axis and cycle are saved in all cycles but those after a stall.
        let (of_position, of_velocity) = match elapsed {
            1 => self.shares,
            _ => (
                share(self.factor_position, elapsed),
                share(self.factor_velocity, elapsed),
            ),
        };
        let value = (
            towards(old_position, position, of_position),
            towards(old_velocity, velocity, of_velocity),
        );
        self.value = Some(value);
        value
    }

    /// Position before its first input: behind a ramp by a cycle's way over its share.
    fn first(&self, position: f64, velocity: f64, elapsed: u32) -> f64 {
        let Some(cycle_time) = self.settled else {
            return position;
        };
        let (share, _) = self.shares;
        // On a ramp the lag L before an input satisfies (1 - share)·L + v·T = L: v·T/share.
        let behind = cycle_time * velocity / share;
        position - behind - cycle_time * velocity * f64::from(elapsed.saturating_sub(1))
    }
}

/// `old`, moved on by a share of the way to an input.
fn towards(old: f64, input: f64, share: f64) -> f64 {
    let value = old + share * (input - old);
    if (value - input).abs() <= NOTHING {
        input
    } else {
        value
    }
}

/// Share of a step that is passed in `elapsed` cycles with a time constant of `factor` cycles.
fn share(factor: f64, elapsed: u32) -> f64 {
    if factor > 0.0 {
        // Exact for an input held over the cycle; the usual T/(T + τ) is its first approximation. `expm1` keeps a
        // long time constant's digits.
        -libm::expm1(-f64::from(elapsed) / factor)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_to_zero_ends_there() {
        let mut filter = Pt1::new(4.0, 6.0);
        let _ = filter.update(-207.9, 367.0, 1);
        let mut value = (0.0, 0.0);
        for cycle in 1..600 {
            value = filter.update(0.0, 0.0, 1);
            let exact = -207.9 * libm::exp(-f64::from(cycle) / 4.0);
            assert!((value.0 - exact).abs() < 1e-12, "{cycle}");
        }
        assert_eq!(value, (0.0, 0.0));
    }
}
