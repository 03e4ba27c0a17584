"""Scenarios and sweeps are the tool's."""

import json

import numpy as np
import pytest

import coaxle


def test_a_run_has_the_tools_figures_and_its_rows(tmp_path):
    run = coaxle.run("beat", set={"duration-s": 40}, out=tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text()) == run.summary
    assert set(run.figures) == set(run.trace.tables), "an axis each"
    raw = run.table("bypass")
    velocity = raw["truth.set_velocity"]
    nominal = np.nanmedian(velocity)
    beats = int(np.sum(np.abs(velocity - nominal) > nominal / 2))
    assert beats > 0, "the beat is to be seen where nothing cures it"
    cured = run.table("sync")["truth.set_velocity"][raw.time_s > 30]
    assert np.nanmax(np.abs(cured - nominal)) < nominal / 100


def test_the_same_seed_gives_the_same_rows():
    first, again, other = (
        coaxle.run("observer", seed=seed, set={"duration-s": 5}) for seed in (3, 3, 4)
    )
    name = next(iter(first.trace.tables))
    assert first.table(name).to_pandas().equals(again.table(name).to_pandas())
    assert not first.table(name).to_pandas().equals(other.table(name).to_pandas())


def test_frames_of_pandas_and_polars_are_the_same():
    run = coaxle.run("beat", set={"duration-s": 2}, receivers=["sync"])
    pandas, polars = run.frame("sync"), run.frame("sync", polars=True)
    assert list(pandas.columns) == polars.columns
    assert len(pandas) == len(polars) > 1000
    for name in pandas.columns:
        one, other = pandas[name].isna().to_numpy(), polars[name].is_null().to_numpy()
        if pandas[name].dtype == float:
            other = other | polars[name].is_nan().fill_null(True).to_numpy()
        assert (one == other).all(), name


def test_a_sweep_is_a_frame_and_goes_on_where_it_was(tmp_path):
    axes = {"network.jitter.exponential-us": [5, 100]}
    first = coaxle.sweep("observer-sweep", axes, seeds=2, set={"duration-s": 5}, out=tmp_path)
    assert first.runs == (4, 4)
    frame = first.frame()
    assert sorted(frame["network.jitter.exponential-us"].unique()) == [5, 100]
    assert len(frame) == 4
    assert len(first.frame(polars=True)) == 4
    again = coaxle.sweep("observer-sweep", axes, seeds=2, set={"duration-s": 5}, out=tmp_path)
    assert again.frame().equals(frame)


@pytest.mark.parametrize(
    ("what", "named"),
    [
        (lambda: coaxle.run("bet"), "did you mean"),
        (lambda: coaxle.run("beat", set={"duration-s": -1}), "duration-s"),
        (lambda: coaxle.run("beat", receivers=["nobody"]), "nobody"),
        (lambda: coaxle.sweep("beat", {"nothing": [1]}), "nothing"),
        (lambda: coaxle.sweep("beat", seeds=0), "seeds"),
        (lambda: coaxle.Recording("nothing.mcap"), "nothing.mcap"),
        (lambda: coaxle.Recording(__file__), "received no recording"),
    ],
)
def test_what_is_wrong_is_named(what, named):
    with pytest.raises(coaxle.CoaxleError, match=named):
        what()


def test_a_recording_that_is_cut_off_gives_what_is_whole(tmp_path):
    run = coaxle.run("beat", set={"duration-s": 5}, receivers=["sync"])
    whole = (run.out / "trace.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    read = coaxle.Recording(cut)
    assert read.damage and 0 < len(read["sync"]) < len(run.table("sync"))
    with pytest.raises(coaxle.CoaxleError, match="truth.set_velocity"):
        read["sync"]["set_veloc"]


def test_the_scenarios_have_titles():
    titles = coaxle.scenarios()
    assert "beat" in titles and all(titles.values())
