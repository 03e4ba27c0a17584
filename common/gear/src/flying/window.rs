//! The ranges over which a flying gear is engaged and released.

/// The slave's progress over the master's, and its first two derivatives.
pub(super) struct WindowCourse {
    pub(super) progress: f64,
    pub(super) slope: f64,
    pub(super) curvature: f64,
}

/// The range over which the slave changes between standstill and coupled motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GearWindow {
    /// The master's progress at the coupled end.
    pub(super) coupled_master: f64,
    /// The slave's progress at the end where it stands.
    free_slave: f64,
    pub(super) master_length: f64,
    /// +1: the slave stands ahead of the coupled end, −1: behind it.
    side: f64,
    /// Slope of the rigid gear.
    pub(super) slope: f64,
}

impl GearWindow {
    pub(super) fn between(coupled_slave: f64, free_slave: f64, slope: f64) -> Self {
        Self {
            coupled_master: coupled_slave / slope,
            free_slave,
            // The mean of 3x² − 2x³ over the window is ½, so the master takes twice
            // the distance of a rigid gear: 100 for 50 in sample 1 of the manual.
            master_length: 2.0 * (free_slave - coupled_slave).abs() / slope,
            side: if free_slave > coupled_slave {
                1.0
            } else {
                -1.0
            },
            slope,
        }
    }

    /// Returns the master's progress at the end where the slave stands.
    pub(super) fn free_master(&self) -> f64 {
        self.coupled_master + self.side * self.master_length
    }

    /// Returns the greatest velocity, acceleration and jerk of the slave while its master runs at this
    /// speed, u/s, with this cycle time, s. The slope runs along 3x² − 2x³: its acceleration is greatest
    /// half way, its jerk at both ends. For a length of zero it is a step, which takes a cycle.
    pub(super) fn demands(&self, speed: f64, cycle: f64) -> [f64; 3] {
        let velocity = self.slope * speed;
        if self.master_length > 0.0 {
            let rate = speed / self.master_length;
            [
                velocity,
                1.5 * velocity * rate,
                6.0 * velocity * rate * rate,
            ]
        } else {
            // No jerk: v/T² would refuse nearly every step, as 1 mm/s within 1 ms is 1e6 mm/s³.
            [velocity, velocity / cycle, 0.0]
        }
    }

    /// Returns the course inside the window: x runs from 0 where the slave stands to 1 where it is
    /// coupled.
    pub(super) fn at(&self, master: f64) -> WindowCourse {
        // A window of no length is never evaluated: `FlyingGear::engage` passes over it.
        let x = (self.free_master() - master) * self.side / self.master_length;
        WindowCourse {
            progress: self.free_slave
                // The integral of 3x² − 2x³ is x³ − x⁴/2.
                - self.side * self.slope * self.master_length * x * x * x * (1.0 - x / 2.0),
            slope: self.slope * x * x * (3.0 - 2.0 * x),
            // The derivative of 3x² − 2x³ is 6x(1 − x), and dx/dm = −side/L.
            curvature: -self.side * self.slope * 6.0 * x * (1.0 - x) / self.master_length,
        }
    }

    pub(super) const fn freed(&self) -> WindowCourse {
        WindowCourse {
            progress: self.free_slave,
            slope: 0.0,
            curvature: 0.0,
        }
    }

    /// Returns the course between the windows. Progress is relative to the sync positions, so there is no
    /// offset.
    pub(super) fn rigid(&self, master: f64) -> WindowCourse {
        WindowCourse {
            progress: self.slope * master,
            slope: self.slope,
            curvature: 0.0,
        }
    }
}
