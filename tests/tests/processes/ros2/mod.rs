//! `coaxle ros2`: third-party Zenoh and a third-party decoder, in Python, see our axes as joint states, and move a slave by
//! a trajectory. Without Python with both there is nothing to test with.

#![expect(
    clippy::print_stdout,
    reason = "how long a trajectory took is a figure"
)]

mod world;

use coaxle_test_process::until;
use coaxle_tests::ports::free_endpoint;
use serde_json::{Value, json};
use world::World;

/// The position and the velocity of a joint in a message, m and m/s, and its stamp, s.
fn joint(heard: &Value, name: &str) -> Option<(f64, f64, f64)> {
    let names = heard["state"].as_array()?;
    let at = names.iter().position(|joint| joint == name)?;
    let stamp = heard["stamp"].as_i64()?;
    let value = |list: &str| heard[list][at].as_f64();
    Some((value("position")?, value("velocity")?, stamp as f64 * 1e-9))
}

/// Every state of a joint so far.
fn track(world: &World, name: &str) -> Vec<(f64, f64, f64)> {
    let heard = world.received();
    heard
        .iter()
        .filter_map(|heard| joint(heard, name))
        .collect()
}

#[test]
fn somebody_elses_ros_sees_the_axes_and_moves_a_slave() {
    let Some(mut world) = World::start(&["--namespace", "line1", "--domain", "7", "--commands"])
    else {
        return;
    };
    tokens_are_there(&world);
    states_are_whole(&world);
    a_trajectory_moves_the_slave(&mut world);
    what_is_no_trajectory_is_refused(&mut world);
    // Exit in order: its tokens go first.
    assert_eq!(world.interrupt(), Some(0), "{}", world.log());
    world.until("its tokens are gone", |heard| {
        let gone = |heard: &&Value| heard["alive"] == false;
        // Node, publisher and subscription.
        heard.iter().filter(gone).count() == 3
    });
}

fn tokens_are_there(world: &World) {
    for (kind, rest) in [
        ("/0/0/NN/%/%line1/coaxle", ""),
        (
            "/0/1/MP/%/%line1/coaxle/%line1%joint_states/sensor_msgs::msg::dds_::JointState_/RIHS01_",
            "/::,10:,:,:,,",
        ),
        (
            "/0/2/MS/%/%line1/coaxle/%line1%joint_trajectory/trajectory_msgs::msg::dds_::JointTrajectory_/RIHS01_",
            "/::,10:,:,:,,",
        ),
    ] {
        world.until(kind, |heard| {
            let tokens = heard.iter().filter_map(|heard| heard["token"].as_str());
            let fits = |token: &&str| {
                token.starts_with("@ros2_lv/7/") && token.contains(kind) && token.ends_with(rest)
            };
            tokens.filter(fits).count() == 1
        });
    }
}

fn states_are_whole(world: &World) {
    for name in ["conveyor/belt", "saw/far/belt", "saw/carriage"] {
        world.until(name, |heard| {
            let of_joint = heard.iter().filter(|heard| joint(heard, name).is_some());
            // Enough for a speed over two seconds below.
            of_joint.count() > 400
        });
    }
    let heard = world.received();
    let states: Vec<_> = heard
        .iter()
        .filter(|heard| heard["state"].is_array())
        .collect();
    assert!(
        states
            .iter()
            // Encoded again by the other library, the bytes are the same.
            .all(|heard| heard["same"] == true && heard["effort"] == 0)
    );
    let mut gids: Vec<_> = states.iter().map(|heard| &heard["attachment"][2]).collect();
    gids.dedup();
    assert_eq!(gids.len(), 1, "one publisher");
    let sequence: Vec<_> = states
        .iter()
        .filter_map(|heard| heard["attachment"][0].as_i64())
        .collect();
    let first = sequence[0];
    let expected: Vec<_> = (first..first + states.len() as i64).collect();
    assert_eq!(sequence, expected, "none is lost, none is twice");
    for heard in &states {
        let (stamp, published) = (heard["stamp"].as_i64(), heard["attachment"][1].as_i64());
        let age = published
            .zip(stamp)
            .map(|(published, stamp)| published - stamp);
        let age = age.expect("two stamps") as f64 * 1e-9;
        // Published after its cycle began; a clock still being learned may date it a little late.
        assert!((-0.01..2.0).contains(&age), "{age} s: {heard}");
    }
    // 500 mm/s: positions and stamps agree, though the machine is busy.
    let belt = track(world, "conveyor/belt");
    let newest = &belt[belt.len() - 200..];
    let (first, last) = (newest[0], newest[newest.len() - 1]);
    let speed = (last.0 - first.0) / (last.2 - first.2);
    assert!((speed - 0.5).abs() < 0.005 && last.1 == 0.5, "{speed} m/s");
}

fn a_trajectory_moves_the_slave(world: &mut World) {
    world.power("saw", "carriage");
    world.publish_trajectory(&json!({
        "joints": ["saw/carriage"], "points": [[[0.3], 2.0], [[0.1], 3.0]], "velocities": [[0.0], [0.0]],
    }));
    let at = |track: &[(f64, f64, f64)], place: f64| {
        let there = |(position, ..): &&(f64, f64, f64)| (position - place).abs() < 1e-6;
        track.iter().rfind(there).copied()
    };
    world.until("the slave is where the trajectory ends", |heard| {
        let track: Vec<_> = heard
            .iter()
            .filter_map(|heard| joint(heard, "saw/carriage"))
            .collect();
        let last = track.last().copied();
        at(&track, 0.3).is_some()
            && last.is_some_and(|(position, ..)| (position - 0.1).abs() < 1e-6)
    });
    let track = track(world, "saw/carriage");
    // From the first to the last sample that moves, both ends included: three seconds, and how late a busy machine is.
    let moving: Vec<_> = track
        .iter()
        .filter(|(_, velocity, _)| *velocity != 0.0)
        .collect();
    let took = moving[moving.len() - 1].2 - moving[0].2;
    println!("three seconds took {took:.3} s");
    assert!((2.5..4.0).contains(&took), "{took} s");
    let fastest = track
        .iter()
        .map(|(_, velocity, _)| *velocity)
        .fold(0.0, f64::max);
    // The peak is 3/2 of the mean over 0.3 m in 2 s.
    assert!((fastest - 1.5 * 0.3 / 2.0).abs() < 0.01, "{fastest} m/s");
}

fn what_is_no_trajectory_is_refused(world: &mut World) {
    for (told, expected) in [
        (
            json!({ "joints": ["saw/blade"], "points": [[[0.1], 1.0]] }),
            "joint_names[0]: received \"saw/blade\", expected a slave that is there: saw/carriage",
        ),
        (
            json!({ "joints": ["saw/carriage"], "points": [[[0.1], 1.0]], "velocities": [[0.5]] }),
            "points[0].velocities[0]: received 0.5, expected 0, or none: a slave stands at the end of a move",
        ),
        (
            json!({ "bytes": "00010000" }),
            "header.stamp: received 0 bytes, expected 4",
        ),
        (
            json!({ "joints": ["saw/carriage"], "points": [[[0.7], 0.5]] }),
            "saw/carriage: refused 0x42",
        ),
    ] {
        world.publish_trajectory(&told);
        until(expected, || world.log().contains(expected));
    }
}

#[test]
fn what_is_wrong_in_its_arguments_is_told_in_a_line() {
    let endpoint = free_endpoint();
    for (words, exit, expected) in [
        (
            &["--domain", "233"][..],
            2,
            "expected a whole number from 0 to 232",
        ),
        (
            &["--namespace", "a//b"],
            2,
            "expected names with a slash before each",
        ),
        (
            &["--node-name", "1st"],
            2,
            "expected letters, digits and underscores",
        ),
        (&["--rate", "0"], 2, "expected a number from 0.1 to 1000"),
        (
            &["--secure", "anna"],
            2,
            "expected that or --ros-listen besides",
        ),
        (&["--ros-connect", "nowhere"], 2, "nowhere"),
    ] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"))
            .arg("ros2")
            .args(words)
            .args(if words[0] == "--secure" {
                vec![]
            } else {
                vec!["--connect", &endpoint]
            })
            .output()
            .expect("it runs");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(exit), "{words:?}: {told}");
        assert!(told.contains(expected), "{words:?}: {told}");
    }
}
