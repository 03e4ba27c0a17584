"""Scenarios and sweeps, in virtual time."""

from __future__ import annotations

import csv
import json
import os
import tempfile
from pathlib import Path
from typing import Any, Iterable, Mapping

from . import _coaxle
from ._coaxle import CoaxleError
from .recording import Recording, Table


def scenarios() -> dict[str, str]:
    """The scenarios that come with Coaxle: their titles by their names."""
    return dict(_coaxle.scenarios())


class _Folder:
    """Where results are: a folder of the caller's, or one that goes with the object."""

    def __init__(self, out: str | os.PathLike[str] | None) -> None:
        self._kept = tempfile.TemporaryDirectory(prefix="coaxle-") if out is None else None
        #: The folder with everything that the tool leaves.
        self.out = Path(self._kept.name if self._kept else os.fspath(out or ""))


class Run(_Folder):
    """What a run came to."""

    #: The figures, as in ``summary.json``.
    summary: dict[str, Any]

    @property
    def passed(self) -> bool:
        """Whether everything was as the scenario expects."""
        return all(verdict["met"] for verdict in self.summary["expectations"])

    @property
    def failures(self) -> list[dict[str, Any]]:
        """What was not."""
        return [verdict for verdict in self.summary["expectations"] if not verdict["met"]]

    @property
    def figures(self) -> dict[str, dict[str, Any]]:
        """The figures of each receiver, by its name."""
        receivers: dict[str, dict[str, Any]] = self.summary["receivers"]
        return receivers

    @property
    def trace(self) -> Recording:
        """Every receiver cycle, judged: a table for each far or virtual axis of each receiver."""
        if not hasattr(self, "_trace"):
            self._trace = Recording(self.out / "trace.mcap")
        return self._trace

    def table(self, name: str | None = None) -> Table:
        """A table of the trace; without a name the only one."""
        return self.trace[name if name is not None else next(iter(self.trace.tables))]

    def frame(self, name: str | None = None, *, polars: bool = False) -> Any:
        """A table of the trace as a frame; without a name the only one."""
        return self.trace.frame(name, polars=polars)


def run(
    scenario: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,
    seed: int | None = None,
    receivers: Iterable[str] = (),
    out: str | os.PathLike[str] | None = None,
    trace: bool = True,
) -> Run:
    """Runs a scenario, by its name or its path, as ``coaxle run`` does.

    ``set`` sets fields, ``{"duration-s": 20, "receivers.sync.mode": "observer"}``. Of ``receivers`` only those run, if there
    are any. Without ``out`` the results go with the object. Expectations that are not met are no error: see
    :attr:`Run.passed`.
    """
    done = Run(out)
    summary = _coaxle.run(
        os.fspath(scenario),
        str(done.out),
        seed=seed,
        overrides=[f"{field}={_toml(value)}" for field, value in (set or {}).items()],
        receivers=list(receivers),
        trace=trace,
    )
    done.summary = json.loads(summary)
    return done


class Sweep(_Folder):
    """What a sweep came to."""

    #: Runs that are over, and all that there are.
    runs: tuple[int, int]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """``points.csv``: a row for each point, seed and receiver. Numbers are numbers, and what is missing is None."""
        with open(self.out / "points.csv", newline="", encoding="utf-8") as file:
            return [{name: _value(text) for name, text in row.items()} for row in csv.DictReader(file)]

    def frame(self, *, polars: bool = False) -> Any:
        """The same as a frame of pandas or polars."""
        if polars:
            import polars as pl

            return pl.DataFrame(self.rows, infer_schema_length=None)
        import pandas as pd

        return pd.DataFrame(self.rows)


def sweep(
    scenario: str | os.PathLike[str],
    axes: Mapping[str, Iterable[Any]] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    seeds: int = 1,
    receivers: Iterable[str] = (),
    out: str | os.PathLike[str] | None = None,
    fresh: bool = False,
) -> Sweep:
    """Runs a scenario over a grid, on all cores, as ``coaxle sweep`` does.

    ``axes`` has the values of each field, ``{"links.jitter-us": [10, 100]}``; without any it is the scenario's own grid.
    A sweep into the same folder goes on where it was, unless ``fresh``.
    """
    if seeds < 1:
        raise CoaxleError(f"seeds: received {seeds}, expected at least 1")
    done = Sweep(out)
    done.runs = _coaxle.sweep(
        os.fspath(scenario),
        str(done.out),
        axes=[
            f"{field}={','.join(_toml(value) for value in values)}" for field, values in (axes or {}).items()
        ],
        overrides=[f"{field}={_toml(value)}" for field, value in (set or {}).items()],
        receivers=list(receivers),
        seeds=seeds,
        fresh=fresh,
    )
    return done


def _toml(value: Any) -> str:
    """A value as TOML has it. A text stays as it is: ``coaxle run --set`` takes ``mode=observer``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(json.dumps(v) if isinstance(v, str) else _toml(v) for v in value) + "]"
    if isinstance(value, Mapping):
        parts = (f"{key} = {json.dumps(v) if isinstance(v, str) else _toml(v)}" for key, v in value.items())
        return "{ " + ", ".join(parts) + " }"
    if hasattr(value, "item"):
        return _toml(value.item())
    return repr(value)


def _value(text: str | None) -> Any:
    if not text:
        return None
    if text in ("true", "false"):
        return text == "true"
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return text
