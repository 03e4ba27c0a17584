"""Nodes in one process over real Zenoh."""

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
