//! Demands of a coupling on its slave per motion of a master, and what the master may do by them.

use coaxle_curve::profile::Limits;

/// Share of the slave's acceleration and jerk for the acceleration and jerk of its master, where its velocity takes the rest.
// A cam demands s·a + c·v² of its slave. Any share of each is right; half and half leaves the master √½ of the velocity that it could keep
// while it does not accelerate.
const SHARE: f64 = 0.5;

/// Range of an axis limit, which a limit of a master is kept within: [`guard::EXPECTED_LIMIT`](crate::guard::EXPECTED_LIMIT).
const LEAST: f64 = 1e-9;
const MOST: f64 = Limits::NONE.velocity();

/// Greatest demands of a coupling on its slave per motion of one of its masters, as magnitudes. Zero: it demands nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MasterDemands {
    /// Velocity of the slave per velocity of the master, u/u.
    pub slope: f64,
    /// Acceleration of the slave per square of the master's velocity, u/u².
    pub curvature: f64,
}

impl MasterDemands {
    /// Demands of a constant ratio.
    #[must_use]
    pub const fn of_ratio(ratio: f64) -> Self {
        Self {
            slope: ratio.abs(),
            curvature: 0.0,
        }
    }

    /// Returns limits within which the master leads the slave within its own ones; those of an axis without limits where it
    /// demands nothing.
    #[must_use]
    pub fn limits_of_master(&self, slave: &Limits) -> Limits {
        let Self { slope, curvature } = *self;
        let (least, share) = (slave.acceleration().min(slave.deceleration()), SHARE);
        let (share, fastest) = if curvature > 0.0 {
            // c·v² = (1 - share)·a
            (share, libm::sqrt((1.0 - share) * least / curvature))
        } else {
            (1.0, MOST)
        };
        let limit = |slave: f64| match slope > 0.0 {
            true => (slave / slope).clamp(LEAST, MOST),
            false => MOST,
        };
        Limits::new(
            limit(slave.velocity()).min(fastest.clamp(LEAST, MOST)),
            limit(share * slave.acceleration()),
            limit(share * slave.deceleration()),
            limit(share * slave.jerk()),
        )
        // NaN alone is beyond the range, and is no limit.
        .unwrap_or(*slave)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slave() -> Limits {
        Limits::new(1_000.0, 8_000.0, 6_000.0, 90_000.0).unwrap()
    }

    #[test]
    fn a_master_of_a_gear_is_as_much_slower_as_its_slave_is_faster() {
        let master = MasterDemands::of_ratio(-2.0).limits_of_master(&slave());
        assert_eq!(
            master,
            Limits::new(500.0, 4_000.0, 3_000.0, 45_000.0).unwrap()
        );
    }

    #[test]
    fn the_demands_of_a_cam_are_met_at_the_limits_of_its_master() {
        let demands = MasterDemands {
            slope: 1.5,
            curvature: 0.04,
        };
        let master = demands.limits_of_master(&slave());
        let velocity = master.velocity();
        for (limit, slave) in [
            (master.acceleration(), slave().acceleration()),
            (master.deceleration(), slave().deceleration()),
        ] {
            let demanded = demands.slope * limit + demands.curvature * velocity * velocity;
            assert!(demanded <= slave * (1.0 + 1e-12), "{demanded} of {slave}");
        }
        assert!(demands.slope * velocity <= slave().velocity());
    }

    #[test]
    fn a_slave_that_is_not_led_does_not_limit_its_master() {
        let master = MasterDemands::default().limits_of_master(&slave());
        assert_eq!(master, Limits::NONE);
    }
}
