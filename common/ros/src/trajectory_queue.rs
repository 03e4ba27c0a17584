//! Trajectories in progress: the schedule of their orders.

use coaxle_axis::Dynamics;
use coaxle_clock::{Instant, Local, Span};
use coaxle_slave::Command;
use coaxle_wire::command::SlaveOrder;
use coaxle_wire::keys::NodeName;

use crate::source::SlaveMotion;
use crate::trajectory::{Address, TrajectoryPlan};

/// The trajectories in progress. Each joint is in one of them at most.
#[derive(Clone, Debug, Default)]
pub struct TrajectoryQueue {
    running: Vec<RunningTrajectory>,
    begun: u64,
}

#[derive(Clone, Debug)]
struct RunningTrajectory {
    number: u64,
    started_at: Instant<Local>,
    plan: TrajectoryPlan,
    /// Number of segments already ordered.
    ordered: usize,
}

/// An order that is due.
#[derive(Clone, Debug, PartialEq)]
pub struct DueOrder {
    /// The number of its trajectory.
    pub trajectory: u64,
    /// Name of the joint.
    pub joint: String,
    /// Node that takes it.
    pub node: NodeName,
    /// The order.
    pub order: SlaveOrder,
}

/// A trajectory that ended before its time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("trajectory {trajectory}: {joint} is not heard any more, so the rest is dropped")]
pub struct LostTrajectory {
    /// Number of the trajectory.
    pub trajectory: u64,
    /// The joint whose motion is not received.
    pub joint: String,
}

impl TrajectoryQueue {
    /// Begins a trajectory, which replaces all that have a joint in common with it. Returns its number,
    /// from 1 on.
    pub fn begin(&mut self, plan: TrajectoryPlan, now: Instant<Local>) -> u64 {
        let is_shared = |other: &Address| plan.joints.iter().any(|own| own.joint == other.joint);
        // A joint in two trajectories would get orders of both, each undoing the other.
        self.running
            .retain(|running| !running.plan.joints.iter().any(is_shared));
        self.begun += 1;
        self.running.push(RunningTrajectory {
            number: self.begun,
            started_at: now + plan.begins,
            plan,
            ordered: 0,
        });
        self.begun
    }

    /// Returns the orders that are due. `motion` returns the motion of a slave; none if it is not
    /// received.
    pub fn due(
        &mut self,
        now: Instant<Local>,
        motion: impl Fn(&Address) -> Option<SlaveMotion>,
    ) -> (Vec<DueOrder>, Vec<LostTrajectory>) {
        let (mut due, mut lost) = (Vec::new(), Vec::new());
        self.running.retain_mut(|running| {
            // A thread that was late finds several segments due; the last order wins at the slave.
            while running.next_at().is_some_and(|at| at <= now) {
                match running.orders(&motion) {
                    Ok(orders) => due.extend(orders),
                    Err(gone) => {
                        lost.push(gone);
                        return false;
                    }
                }
            }
            running.next_at().is_some()
        });
        (due, lost)
    }

    /// Returns the time of the next order, if there is one.
    #[must_use]
    pub fn next_at(&self) -> Option<Instant<Local>> {
        self.running
            .iter()
            .filter_map(RunningTrajectory::next_at)
            .min()
    }

    /// Drops the rest of a trajectory.
    pub fn drop_rest(&mut self, trajectory: u64) {
        self.running.retain(|running| running.number != trajectory);
    }
}

impl RunningTrajectory {
    /// Returns the time of its next orders; none if all have been returned.
    fn next_at(&self) -> Option<Instant<Local>> {
        let next = match self.plan.segments.as_slice() {
            // A trajectory without points is one halt, at once.
            [] if self.ordered == 0 => Some(Span::ZERO),
            segments => segments.get(self.ordered).map(|segment| segment.begins),
        };
        next.map(|next| self.started_at + next)
    }

    fn orders(
        &mut self,
        motion: &impl Fn(&Address) -> Option<SlaveMotion>,
    ) -> Result<Vec<DueOrder>, LostTrajectory> {
        let segment = self.plan.segments.get(self.ordered);
        self.ordered += 1;
        let mut orders = Vec::new();
        for (n, address) in self.plan.joints.iter().enumerate() {
            let command = match segment {
                None => Some(Command::Halt {
                    dynamics: Dynamics::default(),
                }),
                Some(segment) => {
                    // Without its position neither distance nor velocity of the move can be calculated.
                    let motion = motion(address).ok_or_else(|| LostTrajectory {
                        trajectory: self.number,
                        joint: address.joint.clone(),
                    })?;
                    move_to(segment.positions[n], motion, segment.lasts)
                }
            };
            orders.extend(command.map(|command| DueOrder {
                trajectory: self.number,
                joint: address.joint.clone(),
                node: address.node.clone(),
                order: SlaveOrder {
                    slave: address.slave,
                    command,
                    dry_run: false,
                },
            }));
        }
        Ok(orders)
    }
}

/// Relative distance at which a position is reached: numbers of this size have no more digits.
const REACHED: f64 = 1e-9;
/// Part of the peak velocity below which a slave counts as standing.
const STANDSTILL: f64 = 0.05;

/// Returns the move to a position in this time; none if the slave already stands there.
///
/// From standstill each third of the time is a phase: the velocity rises with a jerk that changes its
/// sign half way, is constant, and falls symmetrically. So its peak is 3/2 of the mean, v = 3/2·d/T, a =
/// 9·d/T², j = 54·d/T³. For a moving slave there is no such formula: it moves with that velocity, or its
/// present one if greater, within its limits.
fn move_to(position: f64, motion: SlaveMotion, lasts: Span) -> Option<Command> {
    let distance = (position - motion.position).abs();
    // A move of no distance would be refused for its velocity of 0.
    if motion.velocity == 0.0 && distance <= REACHED * position.abs().max(1.0) {
        return None;
    }
    let time = lasts.as_secs_f64();
    let mut velocity = None;
    let mut dynamics = Dynamics::default();
    if time > 0.0 {
        // The mean is 2/3 of the peak: all of it over the middle third, half of it over the other two.
        let peak = 1.5 * distance / time;
        // Below that the start differs too little from standstill for the time to be off by more than some percent.
        if motion.velocity.abs() <= STANDSTILL * peak {
            // Velocity v in a third of the time by a triangle of acceleration: a = 2·v/(T/3) = 9·d/T².
            let acceleration = 9.0 * distance / (time * time);
            velocity = Some(peak);
            dynamics = Dynamics {
                acceleration: Some(acceleration),
                deceleration: Some(acceleration),
                // The triangle rises within a sixth of the time.
                jerk: Some(6.0 * acceleration / time),
            };
        } else {
            // Less than the present velocity would brake first, and take longer still.
            velocity = Some(peak.max(motion.velocity.abs()));
        }
    }
    Some(Command::MoveAbsolute {
        position,
        velocity,
        dynamics,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{JointTrajectory, JointTrajectoryPoint};
    use crate::trajectory::plan;
    use crate::trajectory::tests::{address, point};

    fn planned(joints: &[&str], points: Vec<JointTrajectoryPoint>) -> TrajectoryPlan {
        let known: Vec<_> = joints.iter().map(|&joint| address(joint)).collect();
        let joint_names = joints.iter().map(|&joint| joint.to_owned()).collect();
        let trajectory = JointTrajectory {
            joint_names,
            points,
            ..JointTrajectory::default()
        };
        plan(&trajectory, 0, &known).unwrap()
    }

    fn at(millis: i64) -> Instant<Local> {
        Instant::from_nanos(millis * 1_000_000)
    }

    fn stands_at(position: f64) -> impl Fn(&Address) -> Option<SlaveMotion> {
        move |_| {
            Some(SlaveMotion {
                position,
                velocity: 0.0,
            })
        }
    }

    fn commands(queue: &mut TrajectoryQueue, now: Instant<Local>, position: f64) -> Vec<Command> {
        let (due, lost) = queue.due(now, stands_at(position));
        assert!(lost.is_empty());
        due.iter().map(|due| due.order.command).collect()
    }

    #[test]
    fn each_point_is_ordered_when_the_one_before_is_reached() {
        let mut queue = TrajectoryQueue::default();
        let points = vec![
            point(&[0.3], 3000),
            point(&[0.3], 4000),
            point(&[0.0], 6000),
        ];
        queue.begin(planned(&["saw/carriage"], points), at(1000));
        let first = commands(&mut queue, at(1000), 0.0);
        assert_eq!(
            first,
            [Command::MoveAbsolute {
                position: 300.0,
                // 0.3 m in 3 s, in mm: v = 1.5·300/3, a = 9·300/3², j = 54·300/3³.
                velocity: Some(150.0),
                dynamics: Dynamics {
                    acceleration: Some(300.0),
                    deceleration: Some(300.0),
                    jerk: Some(600.0),
                },
            }]
        );
        assert_eq!(queue.next_at(), Some(at(4000)));
        assert_eq!(commands(&mut queue, at(3999), 300.0), []);
        assert_eq!(commands(&mut queue, at(4000), 300.0), [], "it is there");
        // A second late, as a thread may be: the segment is sent once.
        assert_eq!(commands(&mut queue, at(5001), 300.0).len(), 1);
        assert_eq!(queue.next_at(), None);
    }

    #[test]
    fn a_later_trajectory_takes_the_place_of_one_with_the_same_joint() {
        let mut queue = TrajectoryQueue::default();
        let both = planned(
            &["saw/carriage", "saw/blade"],
            vec![point(&[0.3, 0.1], 1000), point(&[0.0, 0.0], 2000)],
        );
        queue.begin(both, at(0));
        assert_eq!(commands(&mut queue, at(0), 50.0).len(), 2);
        queue.begin(planned(&["saw/blade"], vec![]), at(500));
        assert_eq!(
            commands(&mut queue, at(500), 50.0),
            [Command::Halt {
                dynamics: Dynamics::default()
            }]
        );
        assert_eq!(queue.next_at(), None);
    }

    #[test]
    fn without_a_time_the_limits_of_the_slave_decide() {
        let mut queue = TrajectoryQueue::default();
        queue.begin(planned(&["saw/carriage"], vec![point(&[0.3], 0)]), at(0));
        let dynamics = Dynamics::default();
        assert_eq!(
            commands(&mut queue, at(0), 0.0),
            [Command::MoveAbsolute {
                position: 300.0,
                velocity: None,
                dynamics
            }]
        );
    }

    #[test]
    fn a_slave_that_moves_may_brake_as_its_limits_allow() {
        let motion = SlaveMotion {
            position: 299.0,
            velocity: -80.0,
        };
        assert_eq!(
            move_to(300.0, motion, Span::from_secs(3)),
            Some(Command::MoveAbsolute {
                position: 300.0,
                // Its own speed: 1.5·1/3 = 0.5 mm/s would brake it first.
                velocity: Some(80.0),
                dynamics: Dynamics::default()
            })
        );
    }

    #[test]
    fn of_a_slave_that_is_gone_the_rest_is_dropped() {
        let mut queue = TrajectoryQueue::default();
        queue.begin(
            planned(
                &["saw/carriage"],
                vec![point(&[0.3], 1000), point(&[0.0], 2000)],
            ),
            at(0),
        );
        let (due, lost) = queue.due(at(0), |_| None);
        assert!(due.is_empty());
        assert_eq!(
            lost[0].to_string(),
            "trajectory 1: saw/carriage is not heard any more, so the rest is dropped"
        );
        assert_eq!(queue.next_at(), None);
        let number = queue.begin(planned(&["saw/carriage"], vec![point(&[0.3], 1000)]), at(0));
        queue.drop_rest(number);
        assert_eq!(queue.next_at(), None);
    }
}
