"""Nodes in one process over real Zenoh."""

import subprocess
import threading

import pytest

import coaxle

VELOCITY = 50.0


@pytest.fixture
def network(endpoint):
    with coaxle.Network(listen=[endpoint]) as network:
        yield network


def turn(node, for_s, ended):
    for time_s in node.cycles(for_s):
        node.publish([VELOCITY * time_s, -VELOCITY * time_s], [VELOCITY, -VELOCITY])
        if ended.is_set():
            return


def test_axes_that_one_publishes_another_follows(network, endpoint):
    ended = threading.Event()
    with network.publish("arm", 0.002, axes=[1, 7]) as arm:
        mover = threading.Thread(target=turn, args=(arm, 60.0, ended))
        mover.start()
        try:
            with coaxle.Network([endpoint]) as other, other.follow("arm", axes=[7, 1, 9]) as follower:
                assert follower.wait(within_s=30.0)
                status = other.status("arm", within_s=30.0)
                assert (status["node"], status["role"], status["health"]) == ("arm", "sender", "ok")
                assert "arm" in other.nodes(0.1)
                read = wait_until_sure(follower)
                assert read.axes[9] is None
                assert read.axes[1].velocity == VELOCITY and read.axes[7].velocity == -VELOCITY
                assert read.axes[1].position == pytest.approx(-read.axes[7].position, rel=1e-9)
                # The own clock is the other's: what is wrong is the delay, which is measured, and the machine may be busy.
                assert read.uncertainty_s is not None and read.uncertainty_s < 0.1
                ended.set()
                mover.join()
                assert not follower.wait(1000, within_s=0.3)
                later = follower.read()
                assert later.silent_s > 0.2
        finally:
            ended.set()
            mover.join()
        assert arm.published > 100


def wait_until_sure(follower):
    for _ in range(600):
        assert follower.wait(50, within_s=30.0)
        read = follower.read()
        if read.is_sure:
            return read
    raise AssertionError(f"it is never sure: {read}")


def test_what_is_wrong_is_named(network):
    for what, named in [
        (lambda: network.publish("a b", 0.01), "node"),
        (lambda: network.publish("arm", 0.01, axes=[]), "axes: received 0"),
        (lambda: network.publish("arm", 0.01, axes=[1, 1]), "axes: received 1 twice"),
        (lambda: network.publish("arm", 10.0), "cycle_time_s"),
        (lambda: network.status("nobody", within_s=0.1), "nobody"),
        (lambda: network.send("nobody", "saw", "hat"), "hat"),
        (lambda: network.nodes(-1.0), "within_s"),
    ]:
        with pytest.raises(coaxle.CoaxleError, match=named):
            what()


def test_a_cycle_has_one_frame_with_numbers(network):
    with network.publish("arm", 0.01) as arm:
        with pytest.raises(coaxle.CoaxleError, match="wait"):
            arm.publish(1.0)
        next(arm.cycles())
        with pytest.raises(coaxle.CoaxleError, match="positions: received NaN"):
            arm.publish(float("nan"))
        with pytest.raises(coaxle.CoaxleError, match="velocities: received 2, expected 1"):
            arm.publish(1.0, [1.0, 2.0])
        arm.publish(1.0)
        with pytest.raises(coaxle.CoaxleError, match="twice"):
            arm.publish(1.0)
        assert arm.published == 1


SENDER = """
name = 'belt'
cycle-time-us = 2000
[transport]
listen = ['{endpoint}']
[[axis]]
id = 3
name = 'belt'
lead-ms = 2000
[axis.program]
start-velocity = {velocity}
limits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}
"""


def test_it_is_known_when_a_promised_axis_will_be_somewhere(tool, endpoint, tmp_path):
    config = tmp_path / "belt.toml"
    config.write_text(SENDER.format(endpoint=endpoint, velocity=VELOCITY))
    with subprocess.Popen([tool, "sender", config]) as sender:
        try:
            with coaxle.Network([endpoint]) as network, network.follow("belt", axes=[3]) as follower:
                assert follower.wait(within_s=30.0)
                wait_until_sure(follower)
                for _ in range(100):
                    before = follower.read()
                    ahead = before.axes[3].position + 0.5 * VELOCITY
                    arrival = follower.when(3, ahead)
                    if arrival.in_s is not None:
                        break
                    assert follower.wait(10, within_s=30.0)
                # Between both calls some time passes, more on a busy machine.
                assert 0.0 < arrival.in_s <= 0.5 + 1e-3 and arrival.velocity == VELOCITY
                assert arrival.position == pytest.approx(ahead) and arrival.in_s < arrival.promised_s <= 2.0
                turn = follower.when(3, ahead % 10.0, modulo=10.0, direction="forward")
                assert turn.in_s is not None and turn.in_s <= 0.2 + 1e-6
                assert follower.when(3, ahead, direction="backward").in_s is None
                assert follower.when(3, ahead + 3.0 * VELOCITY).in_s is None
        finally:
            sender.terminate()


def test_nothing_is_promised_by_a_node_that_publishes_frames_alone(network, endpoint):
    with network.publish("arm", 0.002) as arm, coaxle.Network([endpoint]) as other:
        with other.follow("arm") as follower:
            assert follower.when(1, 5.0) == coaxle.Arrival(None, None, None, None)
            for time_s in arm.cycles(60.0):
                arm.publish(VELOCITY * time_s, VELOCITY)
                if follower.read() is not None:
                    break
            assert follower.when(1, 5.0) == coaxle.Arrival(None, None, None, None)
            for wrong, named in [
                (lambda: follower.when(2, 5.0), "axis: received 2, expected one of"),
                (lambda: follower.when(1, float("nan")), "position: received NaN"),
                (lambda: follower.when(1, 5.0, modulo=0.0), "modulo: received 0"),
                (lambda: follower.when(1, 5.0, direction="up"), "direction: received"),
            ]:
                with pytest.raises(coaxle.CoaxleError, match=named):
                    wrong()
