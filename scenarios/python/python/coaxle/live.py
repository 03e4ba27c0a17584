"""Running nodes: watched, commanded, followed; and axes that Python publishes as one."""

from __future__ import annotations

import json
import os
from types import TracebackType
from typing import Any, Iterable, Iterator, NamedTuple, Sequence, TypeVar

from . import _coaxle
from ._coaxle import CoaxleError
from ._numbers import out

#: Where the nodes of the examples listen.
DEFAULT = ("tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448")

_Self = TypeVar("_Self", bound="_Opened")


class _Opened:
    """A context manager: what is open is closed at its end."""

    def close(self) -> None:
        raise NotImplementedError

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class Axis(NamedTuple):
    """An axis now."""

    #: u
    position: float
    #: u/s
    velocity: float
    #: u/s²
    acceleration: float
    #: ``nStateDWord``
    state_word: int
    #: 0 without an error
    error_code: int


class Arrival(NamedTuple):
    """When an axis will be at a position."""

    #: Time until it is there, s; None if it is not within the promise.
    in_s: float | None
    #: Its position then, u: of a modulo axis with its turns.
    position: float | None
    #: Its velocity then, u/s.
    velocity: float | None
    #: Time until the end of the promise, s; None if nothing is promised.
    promised_s: float | None


class Reading(NamedTuple):
    """Axes of a node that is followed, now."""

    #: By their ids; None of one that did not come.
    axes: dict[int, Axis | None]
    #: Whether the clock of the node is known well enough to move by.
    is_sure: bool
    #: How old the newest frame is, by the clock of the node: the axes are moved on by this, s.
    age_s: float
    #: By how much that may be wrong, s; None before it is known.
    uncertainty_s: float | None
    #: Since the newest frame came, s. Nothing is known of what happened since: judge it before you move anything.
    silent_s: float
    #: The cycle of the newest frame, in its run.
    cycle: int
    #: The run of the node.
    epoch: str
    #: Frames that were taken, and that were refused.
    frames: int
    rejected: int


class Network(_Opened):
    """A place in the network. A context manager: at its end it leaves.

    ``connect`` are endpoints of nodes, by default those of this machine; ``listen`` own ones. ``secure`` is the folder of an
    operator of the secure profile (docs/SECURE.md), which knows where the nodes are: orders bear that name.
    """

    def __init__(
        self,
        connect: Iterable[str] | None = None,
        *,
        listen: Iterable[str] = (),
        secure: str | os.PathLike[str] | None = None,
    ) -> None:
        listen = list(listen)
        if connect is None:
            connect = () if secure is not None or listen else DEFAULT
        self._network = _coaxle.Network(
            connect=list(connect), listen=listen, secure=None if secure is None else os.fspath(secure)
        )

    def nodes(self, within_s: float = 1.0) -> dict[str, dict[str, Any] | None]:
        """Who is seen within this time: the newest status of each, None of one that has said nothing."""
        nodes: dict[str, dict[str, Any] | None] = json.loads(self._network.nodes(within_s))
        return nodes

    def status(self, node: str, within_s: float = 5.0) -> dict[str, Any]:
        """The newest status of a node (docs/STATUS.md)."""
        status = self._network.status(node, within_s)
        if status is None:
            raise CoaxleError(f"node {node}: received no status within {within_s} s")
        found: dict[str, Any] = json.loads(status)
        return found

    def send(
        self, node: str, slave: str, command: str, given: Any = None, *, dry_run: bool = False, **fields: Any
    ) -> dict[str, Any]:
        """Sends an order to a slave of a node, and waits for the answer: ``send("saw", "carriage", "halt")``.

        The commands and their fields are those of docs/WIRE.md, with ``_`` for ``-``; ``given`` is for the one that has no fields:
        ``send("saw", "carriage", "power", True)``. A refusal is no error, the answer says so.
        """
        named = {name.replace("_", "-"): value for name, value in fields.items()}
        if given is not None and named:
            raise CoaxleError(f"{command}: received {given!r} and {', '.join(named)}, expected one or the other")
        order = {
            "version": 1,
            "slave": slave,
            "command": {command: named if given is None else given},
            "dry-run": dry_run,
        }
        return self.order(node, order)

    def order(self, node: str, order: dict[str, Any]) -> dict[str, Any]:
        """Sends any order, whole, as docs/WIRE.md has it; the answer."""
        answer: dict[str, Any] = json.loads(self._network.send(node, json.dumps(order)))
        return answer

    def publish(self, node: str, cycle_time_s: float, axes: Sequence[int] = (1,)) -> Publisher:
        """Publishes axes with these ids as the node of this name. Nothing comes out before the first cycle."""
        return Publisher(self._network.publish(node, cycle_time_s, list(axes)), len(axes))

    def follow(self, node: str, axes: Sequence[int] = (1,), *, name: str = "python") -> Follower:
        """Follows axes of a node. ``name`` is what its time requests bear: another one for each who follows."""
        return Follower(self._network.follow(node, list(axes), name))

    def close(self) -> None:
        """Leaves the network."""
        self._network.close()


class Publisher(_Opened):
    """A node that Python moves: ``for t in node.cycles(5.0): node.publish(position=..., velocity=...)``."""

    def __init__(self, native: _coaxle.Publisher, axes: int) -> None:
        self._native = native
        self._axes = axes

    def cycles(self, for_s: float | None = None) -> Iterator[float]:
        """Sleeps until each cycle begins; when that is, s since the start. Cycles that were missed are skipped."""
        while True:
            _, time_s = self._native.wait()
            if for_s is not None and time_s > for_s:
                return
            yield time_s

    def publish(
        self,
        position: float | Sequence[float],
        velocity: float | Sequence[float] = 0.0,
        acceleration: float | Sequence[float] = 0.0,
        *,
        error_code: int = 0,
    ) -> None:
        """Publishes where the axes are in this cycle, once: a number for one axis, or one for each; u, u/s, u/s²."""
        self._native.publish(
            self._each(position), self._each(velocity), self._each(acceleration), error_code
        )

    @property
    def published(self) -> int:
        """How many frames were published."""
        return self._native.published()

    def close(self) -> None:
        """Nobody sees the node any more."""
        self._native.close()

    def _each(self, value: float | Sequence[float]) -> bytes:
        return out([float(value)] * self._axes if isinstance(value, (int, float)) else value)


class Follower(_Opened):
    """Axes of a node, in the clock of this machine, moved on to now."""

    def __init__(self, native: _coaxle.Follower) -> None:
        self._native = native

    def wait(self, frames: int = 1, within_s: float = 5.0) -> bool:
        """Waits for so many frames more; whether they came in time."""
        return self._native.wait(frames, within_s)

    def read(self) -> Reading | None:
        """Where the axes are now; None before a frame has come."""
        read = self._native.read()
        if read is None:
            return None
        axes = {id: None if axis is None else Axis(*axis) for id, axis in read.pop("axes").items()}
        return Reading(axes=axes, **read)

    def when(
        self, axis: int, position: float, *, direction: str | None = None, modulo: float | None = None
    ) -> Arrival:
        """When an axis will first be at a position from now on, as its node has promised (docs/PRESENTATION.md).

        ``direction`` is ``"forward"`` or ``"backward"``, any by default. With ``modulo``, the length of a turn, the position is one
        in each turn. The time is as exact as ``read().uncertainty_s``.
        """
        arrival, promised_s = self._native.when(axis, position, direction, modulo)
        in_s, at, velocity = (None, None, None) if arrival is None else arrival
        return Arrival(in_s, at, velocity, promised_s)

    def close(self) -> None:
        """Hears nothing any more."""
        self._native.close()
