"""What Python calculates is what the tool does, to the last digit: with COAXLE_TOOL, the tool of the same build."""

import csv
import json
import subprocess

import numpy as np
import pytest

import coaxle


@pytest.fixture
def told(tool):
    """What the tool prints."""

    def run(*words):
        done = subprocess.run([tool, *map(str, words)], capture_output=True, text=True)
        assert done.returncode in (0, 3), (words, done.stderr)
        return done.stdout

    return run


def test_it_is_of_the_same_version(told):
    assert told("--version").split()[1] == coaxle.__version__


@pytest.mark.parametrize("scenario", ["beat", "observer", "cam-tables", "rotary-knife"])
def test_a_run_has_the_same_figures(told, scenario, tmp_path):
    told("run", scenario, "--set", "duration-s=20", "--seed", "5", "--no-trace", "--out", tmp_path)
    run = coaxle.run(scenario, set={"duration-s": 20}, seed=5, trace=False)
    assert run.summary == json.loads((tmp_path / "summary.json").read_text())


def test_a_sweep_has_the_same_rows(told, tmp_path):
    jitter = "network.jitter.exponential-us"
    theirs, ours = tmp_path / "tool", tmp_path / "python"
    told("sweep", "observer-sweep", "--over", f"{jitter}=5,100", "--seeds", "2", "--set", "duration-s=5", "--out", theirs)
    coaxle.sweep("observer-sweep", {jitter: [5, 100]}, seeds=2, set={"duration-s": 5}, out=ours)
    assert (ours / "points.csv").read_bytes() == (theirs / "points.csv").read_bytes()


@pytest.mark.parametrize("name", ["lift", "harmonic", "splines", "equidistant"])
def test_a_plate_has_the_same_values(told, name, shipped):
    file = shipped / "cams" / f"{name}.toml"
    rows = list(csv.reader(told("cam", "values", file, "--csv").splitlines()))[1:]
    theirs = np.array([[float(cell) for cell in row] for row in rows if row])
    motion = coaxle.Plate(file)(theirs[:, 0])
    np.testing.assert_array_equal(np.column_stack(motion), theirs[:, 1:])
