//! A plan laid out from its start to its end.

use coaxle_clock::Seconds;
use coaxle_curve::law::Motion;
use coaxle_report::inspect::name;
use coaxle_saw::SawPlan;

/// The slave's course along its variable: the master's position, or the time since the
/// coupling moment.
pub(super) struct SlaveCourse<'a> {
    plan: &'a SawPlan,
    /// Successive phases; none if the slave is synchronous already.
    pub(super) phases: Vec<CoursePhase>,
}

/// A stretch of one law, from and to places along the course.
pub(super) struct CoursePhase {
    pub(super) law: String,
    pub(super) begin: f64,
    pub(super) end: f64,
}

impl<'a> SlaveCourse<'a> {
    pub(super) fn of(plan: &'a SawPlan) -> Self {
        let phases = match plan.time_profile() {
            Some(profile) => {
                let begins: Vec<f64> = profile.phase_begins().map(|begin| begin.0).collect();
                let ends = begins.iter().skip(1).copied();
                // A phase ends where the next one begins, the last one with the profile.
                let ends = ends.chain([profile.duration().0]);
                let phase = |(&begin, end)| CoursePhase {
                    law: "constant jerk".to_owned(),
                    begin,
                    end,
                };
                begins.iter().zip(ends).map(phase).collect()
            }
            None => phases_over_master(plan),
        };
        Self { plan, phases }
    }

    /// True if the course depends on time, not on the master.
    pub(super) fn is_over_time(&self) -> bool {
        self.plan.time_profile().is_some()
    }

    /// Beginning of the course.
    pub(super) fn start(&self) -> f64 {
        if self.is_over_time() {
            0.0
        } else {
            self.plan.master_start()
        }
    }

    /// End of the course.
    pub(super) fn end(&self) -> f64 {
        if self.is_over_time() {
            self.plan.duration().0
        } else {
            self.plan.master_end()
        }
    }

    /// The time at a place, s; not finite where the master stands.
    pub(super) fn time_at(&self, along: f64) -> f64 {
        if self.is_over_time() {
            along
        } else {
            // The master runs at a constant velocity while it is planned.
            (along - self.plan.master_start()) / self.plan.master_velocity()
        }
    }

    /// The master's position at a place.
    pub(super) fn master_at(&self, along: f64) -> f64 {
        if self.is_over_time() {
            self.plan.master_start() + self.plan.master_velocity() * along
        } else {
            along
        }
    }

    /// The slave at a place, its derivatives over time. Beyond the end it is synchronous.
    pub(super) fn slave_at(&self, along: f64) -> Motion {
        if let Some(motion) = self.plan.over_master_at(along) {
            let velocity = self.plan.master_velocity();
            return Motion {
                position: motion.position,
                // The chain rule at a constant master velocity V: v = s'·V, a = s''·V², j = s'''·V³.
                velocity: motion.velocity * velocity,
                acceleration: motion.acceleration * velocity.powi(2),
                jerk: motion.jerk * velocity.powi(3),
            };
        }
        let slave = self.plan.at(Seconds(along));
        let profile = self.plan.time_profile();
        Motion {
            position: slave.position,
            velocity: slave.velocity,
            acceleration: slave.acceleration,
            // Without a profile the slave is synchronous with a master of constant velocity.
            jerk: profile.map_or(0.0, |profile| profile.jerk_at(Seconds(along))),
        }
    }
}

/// In the order in which the master passes them.
fn phases_over_master(plan: &SawPlan) -> Vec<CoursePhase> {
    let points = plan.motion_points();
    let mut phases: Vec<CoursePhase> = points
        .windows(2)
        .map(|pair| CoursePhase {
            law: name(&pair[0].function),
            begin: pair[0].master,
            end: pair[1].master,
        })
        .collect();
    // Points of a plate have increasing masters; a master that runs backwards passes them from the last one.
    if plan.master_end() < plan.master_start() {
        phases.reverse();
        for phase in &mut phases {
            std::mem::swap(&mut phase.begin, &mut phase.end);
        }
    }
    phases
}
