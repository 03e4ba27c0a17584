"""Laws, plates, saws and clocks against closed forms and against each other."""

import numpy as np
import pytest

import coaxle


def test_the_laws_are_those_of_the_manual():
    laws = coaxle.laws()
    assert laws["polynom5"] == 5 and laws["bestehorn"] == 12
    assert len(laws) == 29


def test_the_3_4_5_polynomial_is_the_textbooks():
    law = coaxle.Law("polynom5", (0, 0), (2, 10))
    z = np.linspace(0, 1, 1001)
    motion = law(2 * z)
    np.testing.assert_allclose(motion.position, 10 * z**3 * (10 - 15 * z + 6 * z**2), atol=1e-12)
    np.testing.assert_allclose(motion.velocity, 10 / 2 * 30 * z**2 * (1 - z) ** 2, atol=1e-11)
    least, most = law.extremes()["velocity"]
    assert most == pytest.approx((9.375, 1.0)) and least[0] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("name", ["polynom5", "polynom7", "bestehorn", "modsinuslinie", "beschltrapez"])
def test_derivatives_are_those_of_the_position(name):
    motion = coaxle.Law(name, (0, 0), (1, 1))(np.linspace(0, 1, 20001))
    step = 1 / 20000
    for of, by in zip(motion, motion[1:]):
        middle = np.diff(of) / step
        known = (by[1:] + by[:-1]) / 2
        inside = np.abs(np.diff(by)) < np.max(np.abs(by)) / 100
        assert np.max(np.abs(middle - known)[inside]) < 1e-3 * np.max(np.abs(by))


def test_any_layout_of_numbers_is_taken():
    law = coaxle.Law("polynom5", (0, 0), (1, 1))
    masters = np.linspace(0, 1, 10, dtype=np.float32)[::3]
    np.testing.assert_array_equal(law(masters).position, law(list(map(float, masters))).position)


def test_a_plate_is_that_of_the_file(shipped):
    plate = coaxle.Plate(shipped / "cams" / "lift.toml")
    begin, end = plate.master_range
    motion = plate(np.linspace(begin, end, 2001))
    assert plate.title and np.isfinite(motion.position).all()
    middle = float(motion.position[700])
    for master in plate.masters_at(middle):
        assert plate([master]).position[0] == pytest.approx(middle, abs=1e-9)


def test_what_a_plate_demands_is_what_its_motion_shows(shipped):
    plate = coaxle.Plate(shipped / "cams" / "lift.toml")
    motion = plate(np.linspace(*plate.master_range, 200_001))
    speed = -3.0
    values = plate.characteristics(speed)["values"]
    assert len(values) == 31
    assert values["fSlavePosMax"] == pytest.approx(np.max(motion.position), rel=1e-6)
    assert values["fSlaveVeloMin"] == pytest.approx(np.min(motion.velocity * speed), rel=1e-6)
    assert values["fSlaveAccMax"] == pytest.approx(np.max(motion.acceleration * speed**2), rel=1e-4)
    with pytest.raises(coaxle.CoaxleError, match="master velocity: received 0"):
        plate.characteristics(0.0)


def test_a_saw_meets_its_master(shipped):
    plan = coaxle.SawPlan(shipped / "saws" / "saw-position-1.toml")
    times = np.linspace(0, plan.duration_s, 1001)
    position, velocity, _ = plan(times)
    assert np.isfinite(position).all()
    steps = np.diff(position) / np.diff(times)
    assert np.max(np.abs(steps - (velocity[1:] + velocity[:-1]) / 2)) < 1e-3 * np.max(np.abs(velocity))


@pytest.mark.parametrize(
    ("what", "named"),
    [
        (lambda: coaxle.Law("bestehor", (0, 0), (1, 1)), "did you mean .bestehorn"),
        (lambda: coaxle.Law("polynom5", (0, 0), (0, 1)), "."),
        (lambda: coaxle.Law("polynom5", (0,), (0, 1)), "point"),
        (lambda: coaxle.Plate("nothing.toml"), "nothing.toml"),
        (lambda: coaxle.Plate(text="x = 1"), "plate"),
        (lambda: coaxle.SawPlan(text=""), "saw"),
        (lambda: coaxle.FarClock(1.0), "cycle_time_s"),
        (lambda: coaxle.FarClock(0.001, delay_s=2.0), "delay_s"),
    ],
)
def test_what_is_wrong_is_named(what, named):
    with pytest.raises(coaxle.CoaxleError, match=named):
        what()


def test_a_saw_that_is_too_close_is_refused(shipped):
    with pytest.raises(coaxle.CoaxleError, match="refused, 0x"):
        coaxle.SawPlan(shipped / "saws" / "too-close.toml")


def test_a_far_clock_that_is_100_ppm_slow_is_followed():
    clock = coaxle.FarClock(0.001, delay_s=200e-6)
    for count in range(3000):
        at = count * 1_000_100 + 200_000
        clock.message(count, at)
        known = clock.cycle(at + 500_000)
    assert known["is_sure"] and known["drift_ppm"] == pytest.approx(-100, abs=0.1)
    at = 3000 * 1_000_100
    far, uncertainty = clock.far_time_at(at)
    assert abs(far - 3_000_000_000) < 1000 and uncertainty < 10e-6
