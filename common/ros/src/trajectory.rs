//! Plan of a trajectory: the positions of its joints over time. Requirements that a slave cannot fulfil
//! are refused before anything moves.

use std::fmt;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::Span;
use coaxle_wire::command::SlaveName;
use coaxle_wire::keys::NodeName;
use coaxle_wire::one_line;

use crate::message::{JointTrajectory, JointTrajectoryPoint, Time};
use crate::unit::UnitScale;

/// A joint that takes orders.
#[derive(Clone, Debug, PartialEq)]
pub struct Address {
    /// Name of the joint.
    pub joint: String,
    /// The receiver.
    pub node: NodeName,
    /// Slave of the receiver.
    pub slave: SlaveName,
    /// The axis id of the slave in the frames of the receiver.
    pub axis_id: u32,
    /// Scale of its unit.
    pub scale: UnitScale,
}

/// A trajectory that can be executed.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryPlan {
    /// Joints of the trajectory.
    pub joints: Vec<Address>,
    /// Start, from now on.
    pub begins: Span,
    /// Consecutive segments; none: the joints halt.
    pub segments: Vec<TrajectorySegment>,
}

/// The motion to a point.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectorySegment {
    /// Begin, since the start of the trajectory.
    pub begins: Span,
    /// Duration; zero: within the limits of the slave.
    pub lasts: Span,
    /// End position of each joint, u.
    pub positions: Vec<f64>,
}

/// Reason why a trajectory is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: received {received}, expected {expected}")]
pub struct TrajectoryRefusal {
    /// The field of the message.
    pub field: String,
    /// Value received.
    pub received: String,
    /// Permitted values.
    pub expected: String,
}

impl TrajectoryRefusal {
    fn new(
        field: impl Into<String>,
        received: impl fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            field: field.into(),
            received: received.to_string(),
            expected: expected.into(),
        }
    }
}

/// Greatest number of joints of a trajectory, and of names listed in a refusal.
const MOST_JOINTS: usize = 128;
const MAX_LISTED: usize = 10;
/// Greatest age of a stamp, s: that of a node that meant now.
const OLDEST_S: i64 = 1;
/// Greatest time ahead of a trajectory, s.
const FARTHEST_S: i64 = 3_600;
/// The longest trajectory, s.
const LONGEST_S: i64 = 86_400;
const NANOS: i64 = 1_000_000_000;

/// Plans a trajectory. `unix_now` is CLOCK_REALTIME, ns; `known` are the joints that take orders.
///
/// # Errors
/// [`TrajectoryRefusal`], the first reason that applies: nothing of the trajectory is executed.
pub fn plan(
    trajectory: &JointTrajectory,
    unix_now: i64,
    known: &[Address],
) -> Result<TrajectoryPlan, TrajectoryRefusal> {
    // Joints first: every further check needs their number and scales.
    let joints = joints(&trajectory.joint_names, known)?;
    let begins = begins(trajectory.stamp, unix_now)?;
    let mut before = Span::ZERO;
    let mut segments = Vec::with_capacity(trajectory.points.len());
    for (k, point) in trajectory.points.iter().enumerate() {
        let end = time_from_start(k, point.time_from_start, before)?;
        segments.push(TrajectorySegment {
            begins: before,
            lasts: end - before,
            positions: positions(k, point, &joints)?,
        });
        before = end;
    }
    Ok(TrajectoryPlan {
        joints,
        begins,
        segments,
    })
}

fn joints(names: &[String], known: &[Address]) -> Result<Vec<Address>, TrajectoryRefusal> {
    if !(1..=MOST_JOINTS).contains(&names.len()) {
        let expected = format!("1 to {MOST_JOINTS}");
        return Err(TrajectoryRefusal::new("joint_names", names.len(), expected));
    }
    // Bounded above before this allocates by a number from outside.
    let mut found: Vec<Address> = Vec::with_capacity(names.len());
    for (k, name) in names.iter().enumerate() {
        let field = format!("joint_names[{k}]");
        let received = one_line(&format!("{name:?}"));
        // Two positions for one joint at one time contradict each other.
        if found.iter().any(|address| address.joint == *name) {
            return Err(TrajectoryRefusal::new(
                field,
                format!("{received} again"),
                "each joint once",
            ));
        }
        match known.iter().find(|address| address.joint == *name) {
            Some(address) => found.push(address.clone()),
            None => return Err(TrajectoryRefusal::new(field, received, list_joints(known))),
        }
    }
    Ok(found)
}

/// Lists the known joints, for a message.
fn list_joints(known: &[Address]) -> String {
    let names: Vec<_> = known.iter().map(|address| address.joint.as_str()).collect();
    match names.as_slice() {
        [] => "a slave of a receiver, and none is there".to_owned(),
        names if names.len() <= MAX_LISTED => {
            format!("a slave that is there: {}", names.join(", "))
        }
        names => {
            let (first, rest) = names.split_at(MAX_LISTED);
            let first = first.join(", ");
            format!("a slave that is there: {first} and {} more", rest.len())
        }
    }
}

fn begins(stamp: Time, unix_now: i64) -> Result<Span, TrajectoryRefusal> {
    let nanos = stamp.as_nanos();
    // An empty stamp means now in ROS, not 1970.
    if nanos == 0 {
        return Ok(Span::ZERO);
    }
    let ahead = nanos.saturating_sub(unix_now);
    if (-OLDEST_S * NANOS..=FARTHEST_S * NANOS).contains(&ahead) {
        // A stamp of `now` is some milliseconds old on arrival.
        return Ok(Span::from_nanos(ahead.max(0)));
    }
    let received = match ahead {
        ..0 => format!("an instant {:.3} s ago", -ahead as f64 * 1e-9),
        _ => format!("an instant {:.3} s ahead", ahead as f64 * 1e-9),
    };
    let expected = format!("0 for now, or from {OLDEST_S} s ago to {FARTHEST_S} s ahead");
    Err(TrajectoryRefusal::new("header.stamp", received, expected))
}

/// Returns the time of the `k`-th point; that of the first one may be zero.
fn time_from_start(k: usize, time: Time, before: Span) -> Result<Span, TrajectoryRefusal> {
    let span = Span::from_nanos(time.as_nanos());
    // Only the first point may have no time of its own: then it is reached as fast as limits allow.
    let is_later = span > before || (k == 0 && span == before);
    if is_later && span <= Span::from_secs(LONGEST_S) {
        return Ok(span);
    }
    let field = format!("points[{k}].time_from_start");
    let least = match k {
        0 => "0".to_owned(),
        _ => format!(
            "more than {} s, that of the point before,",
            before.as_secs_f64()
        ),
    };
    let received = format!("{} s", span.as_secs_f64());
    Err(TrajectoryRefusal::new(
        field,
        received,
        format!("{least} to {LONGEST_S} s"),
    ))
}

/// Returns the positions of the joints at the `k`-th point, in their own units.
fn positions(
    k: usize,
    point: &JointTrajectoryPoint,
    joints: &[Address],
) -> Result<Vec<f64>, TrajectoryRefusal> {
    let received = point.positions.len();
    if received != joints.len() {
        let field = format!("points[{k}].positions");
        let expected = format!("{}, one for each joint", joints.len());
        return Err(TrajectoryRefusal::new(
            field,
            format!("{received} numbers"),
            expected,
        ));
    }
    for (name, values) in [
        ("velocities", &point.velocities),
        ("accelerations", &point.accelerations),
    ] {
        check_standstill(&format!("points[{k}].{name}"), values)?;
    }
    if !point.effort.is_empty() {
        // An effort that is ignored might be one on which somebody relies: refused like every field without a meaning
        // here.
        let received = format!("{} numbers", point.effort.len());
        let expected = "none: a slave is ordered to a position";
        return Err(TrajectoryRefusal::new(
            format!("points[{k}].effort"),
            received,
            expected,
        ));
    }
    let each = point.positions.iter().zip(joints).enumerate();
    let position = |(n, (ros, joint)): (usize, (&f64, &Address))| {
        let position = joint.scale.from_ros(*ros);
        // Larger ones are refused by receivers of axes as implausible; NaN fails as well.
        if position.abs() <= NcToPlcAxis::LARGEST {
            return Ok(position);
        }
        let expected = "a number that is -1e15 to 1e15 in the unit of the axis";
        Err(TrajectoryRefusal::new(
            format!("points[{k}].positions[{n}]"),
            ros,
            expected,
        ))
    };
    each.map(position).collect()
}

/// Checks that a point requires a standstill: a slave stands at the end of a move.
fn check_standstill(field: &str, values: &[f64]) -> Result<(), TrajectoryRefusal> {
    // NaN differs from 0, too, and is refused.
    match values.iter().position(|value| *value != 0.0) {
        None => Ok(()),
        Some(n) => {
            let field = format!("{field}[{n}]");
            let expected = "0, or none: a slave stands at the end of a move";
            Err(TrajectoryRefusal::new(field, values[n], expected))
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn address(joint: &str) -> Address {
        let (node, slave) = joint.split_once('/').unwrap();
        Address {
            joint: joint.to_owned(),
            node: NodeName::new(node).unwrap(),
            slave: SlaveName::new(slave).unwrap(),
            axis_id: 1,
            scale: UnitScale::of("mm").unwrap(),
        }
    }

    pub(crate) fn point(positions: &[f64], millis: i64) -> JointTrajectoryPoint {
        JointTrajectoryPoint {
            positions: positions.to_vec(),
            time_from_start: Time::from_nanos(millis * 1_000_000),
            ..JointTrajectoryPoint::default()
        }
    }

    fn trajectory(points: Vec<JointTrajectoryPoint>) -> JointTrajectory {
        JointTrajectory {
            joint_names: vec!["saw/carriage".to_owned()],
            points,
            ..JointTrajectory::default()
        }
    }

    const NOW: i64 = 1_700_000_000 * NANOS;

    fn refused(trajectory: &JointTrajectory) -> String {
        let known = [address("saw/carriage"), address("saw/blade")];
        plan(trajectory, NOW, &known).unwrap_err().to_string()
    }

    #[test]
    fn points_are_reached_one_after_the_other() {
        let given = trajectory(vec![point(&[0.5], 2000), point(&[0.1], 3000)]);
        let planned = plan(&given, NOW, &[address("saw/carriage")]).unwrap();
        let segments = planned.segments.iter().map(|segment| {
            (
                segment.begins.as_secs_f64(),
                segment.lasts.as_secs_f64(),
                segment.positions[0],
            )
        });
        assert_eq!(
            segments.collect::<Vec<_>>(),
            [(0.0, 2.0, 500.0), (2.0, 1.0, 100.0)]
        );
        assert_eq!(planned.begins, Span::ZERO);
        let halt = plan(&trajectory(vec![]), NOW, &[address("saw/carriage")]).unwrap();
        assert!(halt.segments.is_empty());
    }

    #[test]
    fn a_stamp_says_when_it_begins() {
        let mut given = trajectory(vec![point(&[0.5], 2000)]);
        let begins =
            |given: &JointTrajectory| plan(given, NOW, &[address("saw/carriage")]).unwrap().begins;
        given.stamp = Time::from_nanos(NOW + 3 * NANOS);
        assert_eq!(begins(&given), Span::from_secs(3));
        given.stamp = Time::from_nanos(NOW - NANOS / 10);
        assert_eq!(begins(&given), Span::ZERO);
        given.stamp = Time::from_nanos(NOW - 5 * NANOS);
        assert_eq!(
            refused(&given),
            "header.stamp: received an instant 5.000 s ago, expected 0 for now, or from 1 s ago to 3600 s ahead"
        );
    }

    #[test]
    fn what_cannot_be_ordered_is_refused_with_its_field() {
        let mut moving = point(&[0.5], 1000);
        moving.velocities = vec![0.2];
        let mut pushed = point(&[0.5], 1000);
        pushed.effort = vec![1.0];
        let mut turning = point(&[0.5], 1000);
        turning.accelerations = vec![f64::NAN];
        for (given, expected) in [
            (
                vec![moving],
                "points[0].velocities[0]: received 0.2, expected 0, or none: a slave stands at the end of a move",
            ),
            (
                vec![turning],
                "points[0].accelerations[0]: received NaN, expected 0, or none: a slave stands at the end of a move",
            ),
            (
                vec![pushed],
                "points[0].effort: received 1 numbers, expected none: a slave is ordered to a position",
            ),
            (
                vec![point(&[], 1000)],
                "points[0].positions: received 0 numbers, expected 1, one for each joint",
            ),
            (
                vec![point(&[f64::INFINITY], 1000)],
                "points[0].positions[0]: received inf, expected a number that is -1e15 to 1e15 in the unit of the axis",
            ),
            (
                vec![point(&[0.5], -1)],
                "points[0].time_from_start: received -0.001 s, expected 0 to 86400 s",
            ),
            (
                vec![point(&[0.5], 1000), point(&[0.5], 1000)],
                "points[1].time_from_start: received 1 s, expected more than 1 s, that of the point before, to 86400 s",
            ),
        ] {
            assert_eq!(refused(&trajectory(given)), expected);
        }
    }

    #[test]
    fn joints_that_are_not_there_are_refused_with_those_that_are() {
        let of = |names: &[&str]| JointTrajectory {
            joint_names: names.iter().map(|&name| name.to_owned()).collect(),
            ..JointTrajectory::default()
        };
        assert_eq!(
            refused(&of(&["saw/blade", "arm"])),
            "joint_names[1]: received \"arm\", expected a slave that is there: saw/carriage, saw/blade"
        );
        assert_eq!(
            refused(&of(&["saw/blade", "saw/blade"])),
            "joint_names[1]: received \"saw/blade\" again, expected each joint once"
        );
        assert_eq!(
            refused(&of(&[])),
            "joint_names: received 0, expected 1 to 128"
        );
    }
}
