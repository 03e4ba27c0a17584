"""Motion laws, cam plates and flying saws, calculated."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, NamedTuple, Sequence

import numpy.typing as npt

from . import _coaxle
from ._coaxle import CoaxleError
from ._numbers import Floats, back, out


class Motion(NamedTuple):
    """A slave and its derivatives by the master, a value for each master."""

    #: u
    position: Floats
    #: u/x
    velocity: Floats
    #: u/x²
    acceleration: Floats
    #: u/x³
    jerk: Floats


def _motion(columns: Sequence[bytes]) -> Motion:
    return Motion(*(back(column) for column in columns))


def laws() -> dict[str, int]:
    """The motion laws: the numbers of ``MC_MotionFunctionType`` (TF5050 8.9) by their names."""
    return dict(_coaxle.laws())


def _point(point: Sequence[float]) -> tuple[float, float, float, float]:
    if not 2 <= len(point) <= 4:
        raise CoaxleError(f"point: received {len(point)} numbers, expected master, position[, velocity[, acceleration]]")
    master, position, velocity, acceleration = (*map(float, point), 0.0, 0.0)[:4]
    return master, position, velocity, acceleration


class Law:
    """A motion law between two points, each master, position[, velocity[, acceleration]]."""

    def __init__(self, name: str, start: Sequence[float], end: Sequence[float]) -> None:
        self._law = _coaxle.Law(name, _point(start), _point(end))

    def __call__(self, master: npt.ArrayLike) -> Motion:
        """The slave at each of these masters."""
        return _motion(self._law.at(out(master)))

    def extremes(self) -> dict[str, tuple[tuple[float, float], tuple[float, float]]]:
        """The smallest and the largest value of each quantity, each with the master where it is taken."""
        return {name: (least, most) for name, (least, most) in zip(Motion._fields, self._law.extremes())}


def _read(path: str | os.PathLike[str]) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise CoaxleError(f"cannot read {os.fspath(path)}: {error}") from error


class Plate:
    """A cam plate, of a cam file (docs/CAMS.md): ``Plate("plate.toml")``, or ``Plate(text=...)``."""

    def __init__(self, path: str | os.PathLike[str] = "plate", *, text: str | None = None) -> None:
        self._plate = _coaxle.Plate(os.fspath(path), _read(path) if text is None else text)
        self.title, self.master_unit, self.slave_unit = self._plate.facts()

    @property
    def master_range(self) -> tuple[float, float]:
        """Where it begins and ends on the master, x."""
        return self._plate.master_range()

    def __call__(self, master: npt.ArrayLike) -> Motion:
        """The slave at each of these masters, which may lie beyond the plate as its course says."""
        return _motion(self._plate.at(out(master)))

    def masters_at(self, position: float) -> list[float]:
        """The masters at which the slave is at a position, over one turn."""
        return self._plate.masters_at(position)

    def characteristics(self, master_velocity: float = 1.0) -> dict[str, Any]:
        """What it demands of the slave at a velocity of the master, x/s: ``MC_ReadCamTableCharacteristics``.

        The fields are those of an answer to the order (docs/WIRE.md), but that ``values`` has the 31 values of
        ``MC_TableCharacValues`` (TF5050 8.11) by their names.
        """
        figures: dict[str, Any] = json.loads(self._plate.characteristics(master_velocity))
        figures["values"] = {value["name"]: value["value"] for value in figures["values"]}
        return figures


class SawPlan:
    """The plan of a flying saw, of a saw file (docs/SAWS.md). A command that is refused is a :class:`CoaxleError`."""

    def __init__(self, path: str | os.PathLike[str] = "saw", *, text: str | None = None) -> None:
        self._plan = _coaxle.SawPlan(os.fspath(path), _read(path) if text is None else text)
        self.title, self.master_unit, self.slave_unit = self._plan.facts()
        outline: dict[str, Any] = self._plan.outline()
        #: What it is made of, such as ``QuinticLine``.
        self.form: str = outline["form"]
        self.duration_s: float = outline["duration_s"]
        self.master_start: float = outline["master_start"]
        self.master_end: float = outline["master_end"]
        self.master_velocity: float = outline["master_velocity"]

    def __call__(self, time_s: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration of the slave so long after the coupling moment."""
        position, velocity, acceleration = (back(column) for column in self._plan.at(out(time_s)))
        return position, velocity, acceleration
