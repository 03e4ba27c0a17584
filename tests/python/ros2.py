"""Another side of `coaxle ros2`: what rmw_zenoh does with a topic, by eclipse-zenoh and rosbags.

python3 ros2.py tcp/127.0.0.1:7447 DOMAIN NAMESPACE

It listens there, prints what it hears, a line of JSON each, and publishes what it is told, a line of JSON each:
{"joints": ["saw/carriage"], "points": [[[0.1], 2.0], ...], "velocities": [[0.5], ...]}
"""
import json, struct, sys, time, zenoh
from rosbags.typesys import Stores, get_typestore

TYPES = get_typestore(Stores.ROS2_JAZZY)
STATE, TRAJECTORY = "sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"


def key(domain, namespace, topic, kind):
    """The key of a topic, its type with the hash that rosbags calculates from the definition."""
    package, _, name = kind.split("/")
    return f"{domain}{namespace}/{topic}/{package}::msg::dds_::{name}_/{TYPES.hash_rihs01(kind)}"


def say(**fields):
    print(json.dumps(fields), flush=True)


def attachment_of(sample):
    """Sequence, ns since 1970 and gid: as zenoh-ext writes two numbers and an array of bytes."""
    data = sample.attachment.to_bytes() if sample.attachment else b""
    if len(data) != 33 or data[16] != 16:
        return None
    return [*struct.unpack("<qq", data[:16]), data[17:].hex()]


def on_state(sample):
    data = sample.payload.to_bytes()
    state = TYPES.deserialize_cdr(data, STATE)
    stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
    say(state=list(state.name), position=list(state.position), velocity=list(state.velocity), effort=len(state.effort),
        stamp=stamp, attachment=attachment_of(sample), same=bytes(TYPES.serialize_cdr(state, STATE)) == data)


def trajectory(joints, points, velocities=()):
    import numpy
    made = TYPES.types
    time_of = lambda kind, seconds: made[f"builtin_interfaces/msg/{kind}"](int(seconds), round(seconds % 1 * 1e9))
    array = lambda values: numpy.array(values, dtype=numpy.float64)
    header = made["std_msgs/msg/Header"](time_of("Time", 0), "")
    point = made["trajectory_msgs/msg/JointTrajectoryPoint"]
    points = [point(array(positions), array(velocities[k] if velocities else []), array([]), array([]), time_of("Duration", after))
              for k, (positions, after) in enumerate(points)]
    return bytes(TYPES.serialize_cdr(made[TRAJECTORY](header, joints, points), TRAJECTORY))


def main(endpoint, domain, namespace):
    config = zenoh.Config.from_json5(json.dumps({"listen": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}))
    session = zenoh.open(config)
    on_token = lambda sample: say(token=str(sample.key_expr), alive=sample.kind == zenoh.SampleKind.PUT)
    tokens = session.liveliness().declare_subscriber("@ros2_lv/**", on_token, history=True)
    states = session.declare_subscriber(key(domain, namespace, "joint_states", STATE), on_state)
    publisher = session.declare_publisher(key(domain, namespace, "joint_trajectory", TRAJECTORY))
    for sequence, line in enumerate(sys.stdin, 1):
        told = json.loads(line)
        data = bytes.fromhex(told["bytes"]) if "bytes" in told else trajectory(**told)
        publisher.put(data, attachment=struct.pack("<qqB", sequence, time.time_ns(), 16) + bytes(range(16)))


if __name__ == "__main__":
    main(*sys.argv[1:])
