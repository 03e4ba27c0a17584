"""Python and a receiver in a process of its own: orders to its slave, and an axis of Python's that its slave follows."""

import csv
import subprocess
import threading
import time

import numpy as np
import pytest

import coaxle

CYCLE_S = 0.002
#: Velocity, acceleration and jerk of the slave, u/s, u/s², u/s³.
LIMITS = (200.0, 2000.0, 40000.0)
SLAVE = f"""
[[slave]]
name = "carriage"
limits = {{ velocity = {LIMITS[0]}, acceleration = {LIMITS[1]}, jerk = {LIMITS[2]}, on-master-loss = "stop" }}
"""
ALONE = f"""
name = "saw"
cycle-time-us = {CYCLE_S * 1e6:.0f}
[[virtual-axis]]
id = 1
name = "shaft"
[virtual-axis.program]
limits = {{ velocity = 100, acceleration = 1000, jerk = 10000 }}
steps = [{{ enable = true }}, {{ velocity = {{ value = 100 }} }}]
{SLAVE}couple = "off"
"""
FOLLOWING = f"""
name = "saw"
cycle-time-us = {CYCLE_S * 1e6:.0f}
master = {{ node = "arm", axis = 7 }}
{SLAVE}couple = "off"
"""
#: The machine may be very busy.
PATIENCE_S = 60.0


class Receiver:
    """A receiver, and who commands it."""

    def __init__(self, tool, folder, endpoint, config):
        (folder / "saw.toml").write_text(config)
        self.trace = folder / "trace.csv"
        self.process = subprocess.Popen(
            [tool, "receiver", folder / "saw.toml", "--listen", endpoint, "--trace", self.trace, "--quiet"]
        )

    def stop(self):
        self.process.terminate()
        return self.process.wait(PATIENCE_S)

    def check_trace(self):
        """The differences of the set positions keep the limits all along; where they were set anew nothing is compared."""
        with open(self.trace, newline="") as file:
            rows = list(csv.DictReader(file))
        cycles = np.array([int(row["cycle"]) for row in rows])
        positions = np.array([float(row["carriage.position"]) for row in rows])
        anew = np.array([int(row["carriage.set_anew"]) for row in rows])
        assert len(rows) > 100
        difference = positions
        for order, limit in enumerate(LIMITS, 1):
            difference = np.diff(difference) / CYCLE_S
            # Only over cycles that were executed one after the other, and in which nothing was set anew.
            whole = cycles[order:] - cycles[:-order] == order
            same = anew[order:] == anew[:-order]
            found = np.abs(difference[whole & same])
            rounding = 8 * np.finfo(float).eps * np.max(np.abs(positions)) * 2**order / CYCLE_S**order
            assert np.max(found) <= limit * (1 + 1e-6) + rounding, order
        return positions


@pytest.fixture
def receiver(tool, tmp_path, endpoint):
    started = []

    def start(config):
        started.append(Receiver(tool, tmp_path, endpoint, config))
        return started[-1]

    yield start
    for one in started:
        one.process.kill()
        one.process.wait()


def until(what, is_so):
    end = time.monotonic() + PATIENCE_S
    while not (found := is_so()):
        assert time.monotonic() < end, what
        time.sleep(0.02)
    return found


def carriage(network):
    return reported(network)["slaves"]["carriage"]


def knows_the_clock(network):
    return reported(network)["far"]["arm"]["synced"]


def reported(network):
    """Its newest status, once it has one of a cycle: the first may be older, and has neither slaves nor far axes."""
    return until("a cycle is reported", lambda: of_a_cycle(network.status("saw", within_s=PATIENCE_S)))


def of_a_cycle(status):
    return status if "slaves" in status and "far" in status else None


def accepted(answer):
    assert answer["outcome"] == "accepted", answer
    return answer


def test_a_slave_that_runs_takes_orders_from_python(receiver, endpoint):
    saw = receiver(ALONE)
    with coaxle.Network([endpoint]) as network:
        until("the node is there", lambda: network.nodes(0.2).get("saw"))
        accepted(network.send("saw", "carriage", "power", True))

        tried = network.send("saw", "carriage", "move-absolute", position=40.0, velocity=150.0, dry_run=True)
        assert accepted(tried)["dry-run"] and tried["job"] is None
        assert tried["axis"]["position"] == 0.0
        refused = network.send("saw", "carriage", "move-absolute", position=40.0, velocity=900.0)
        assert refused["outcome"] == "refused" and refused["field"] == "velocity", refused
        assert refused["would-pass"] == LIMITS[0]
        unknown = network.send("saw", "carrage", "halt")
        assert unknown["outcome"] == "not-taken" and "carriage" in unknown["text"], unknown

        # Interrupted on its way, then to where it was going.
        first = accepted(network.send("saw", "carriage", "move-absolute", position=40.0, velocity=20.0))
        assert first["axis"]["status"] == "discrete-motion"
        until("it is on its way", lambda: carriage(network)["position"] > 1.0)
        accepted(network.send("saw", "carriage", "halt", dynamics={"deceleration": 500.0}))
        until("it stands", lambda: carriage(network)["velocity"] == 0.0)
        assert 1.0 < carriage(network)["position"] < 40.0
        accepted(network.send("saw", "carriage", "move-absolute", position=40.0))
        until("it is there", lambda: carriage(network)["position"] == 40.0)

        # Coupled to the shaft that turns, and let go of.
        accepted(network.send("saw", "carriage", "gear-in", ratio=-0.5))
        until("it is in sync", lambda: carriage(network)["velocity"] == pytest.approx(-50.0))
        accepted(network.send("saw", "carriage", "gear-out"))
        stopped = accepted(network.send("saw", "carriage", "stop"))
        assert stopped["axis"]["status"] == "stopping", stopped
        until("it stands", lambda: carriage(network)["velocity"] == 0.0)
    assert saw.stop() == 0
    assert saw.check_trace()[-1] < 40.0


def follows_again(network):
    """Clears the error and couples, as often as a busy machine keeps Python from its cycles for longer than a master may be silent."""
    now = carriage(network)
    if now["error"] is not None:
        network.send("saw", "carriage", "reset")
        network.send("saw", "carriage", "power", True)
        network.send("saw", "carriage", "gear-in", ratio=1.0)
    return now["velocity"] == pytest.approx(30.0, rel=0.1)


def test_a_slave_stops_when_python_pauses_and_goes_on_when_it_is_told(receiver, endpoint):
    saw = receiver(FOLLOWING)
    ended, silent = threading.Event(), threading.Event()

    def turn(arm):
        for t in arm.cycles():
            if ended.is_set():
                return
            if not silent.is_set():
                arm.publish(30.0 * t, 30.0)

    with coaxle.Network([endpoint]) as network, network.publish("arm", 0.002, axes=[7]) as arm:
        mover = threading.Thread(target=turn, args=(arm,))
        mover.start()
        try:
            until("the node is there", lambda: network.nodes(0.2).get("saw"))
            until("the clock is known", lambda: knows_the_clock(network))
            accepted(network.send("saw", "carriage", "power", True))
            accepted(network.send("saw", "carriage", "gear-in", ratio=1.0))
            until("it follows", lambda: carriage(network)["velocity"] == pytest.approx(30.0, rel=0.1))
            silent.set()
            until("it is in error stop", lambda: carriage(network)["error"] is not None)
            until("it stands", lambda: carriage(network)["velocity"] == 0.0)
            where = carriage(network)["position"]
            silent.clear()
            until("the clock is known again", lambda: knows_the_clock(network))
            # By itself it goes nowhere.
            assert carriage(network)["position"] == where
            refused = network.send("saw", "carriage", "gear-in", ratio=1.0)
            assert refused["outcome"] == "refused", refused
            until("it follows again", lambda: follows_again(network))
        finally:
            ended.set()
            mover.join()
    assert saw.stop() == 0
    saw.check_trace()
