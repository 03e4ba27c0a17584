//! Input from ROS: a trajectory, up to the orders that it makes.

use coaxle_clock::Instant;
use coaxle_node::command::{CommandOrder, SlaveName};
use coaxle_ros::message::{JointTrajectory, JointTrajectoryPoint, Time};
use coaxle_ros::source::SlaveMotion;
use coaxle_ros::trajectory::{Address, plan};
use coaxle_ros::trajectory_queue::TrajectoryQueue;
use coaxle_ros::unit::UnitScale;

use crate::Outcome;
use crate::wire::near;

const JOINTS: [&str; 2] = ["saw/carriage", "saw/blade"];

/// A trajectory for two existing slaves; a node must be able to read each order that it makes.
pub(crate) fn trajectory(data: &[u8]) -> Outcome {
    let trajectory = JointTrajectory::from_bytes(data).map_err(|error| error.to_string())?;
    let known = JOINTS.map(address);
    let planned = plan(&trajectory, 0, &known).map_err(|refusal| refusal.to_string())?;
    let (mut moves, mut now) = (TrajectoryQueue::default(), Instant::EPOCH);
    moves.begin(planned, now);
    while let Some(at) = moves.next_at() {
        // An order before its predecessor would be sent at once and undo it.
        assert!(at >= now, "time goes back");
        now = at;
        let motion = |_: &Address| {
            Some(SlaveMotion {
                position: 1.0,
                velocity: 0.0,
            })
        };
        for due in moves.due(now, motion).0 {
            // Through its text, as it travels: a number without a notation in JSON is found here.
            let json = CommandOrder::Slave(due.order).to_json();
            CommandOrder::from_json(json.as_bytes()).map_err(|error| error.to_string())?;
        }
    }
    Ok(())
}

/// Good trajectories: positions with times, a halt, and a later start.
pub(crate) fn trajectories() -> Vec<(String, Vec<u8>)> {
    let point = |positions: &[f64], seconds: i32| JointTrajectoryPoint {
        positions: positions.to_vec(),
        velocities: vec![0.0; positions.len()],
        time_from_start: Time {
            sec: seconds,
            nanosec: 500_000_000,
        },
        ..JointTrajectoryPoint::default()
    };
    let of = |joints: &[&str], points: Vec<JointTrajectoryPoint>| JointTrajectory {
        joint_names: joints.iter().map(|&joint| joint.to_owned()).collect(),
        points,
        ..JointTrajectory::default()
    };
    let later = JointTrajectory {
        stamp: Time { sec: 3, nanosec: 0 },
        ..of(&JOINTS[..1], vec![point(&[0.5], 1)])
    };
    let places = vec![point(&[0.1, 0.2], 1), point(&[0.0, -0.2], 2)];
    [
        ("places", of(&JOINTS, places)),
        ("halt", of(&JOINTS[1..], Vec::new())),
        ("later", later),
    ]
    .map(|(name, trajectory)| (name.to_owned(), trajectory.to_bytes()))
    .into()
}

fn address(joint: &str) -> Address {
    let (_, slave) = joint.split_once('/').expect("node and slave");
    Address {
        joint: joint.to_owned(),
        node: near(),
        slave: SlaveName::new(slave).expect("a valid name"),
        axis_id: 1,
        scale: UnitScale::of("mm").unwrap_or(UnitScale::NONE),
    }
}
