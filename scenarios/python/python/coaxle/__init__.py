"""Coaxle for Python: distributed axes.

* :func:`run`, :func:`sweep`: scenarios in virtual time, as ``coaxle run`` and ``coaxle sweep`` run them.
* :class:`Recording`: what a node, a run or ``coaxle record`` wrote down, as columns.
* :class:`FarClock`: the clock of another PC, followed from arrivals.
* :class:`Law`, :class:`Plate`, :class:`SawPlan`: motion laws, cam plates and flying saws, calculated.
* :class:`Network`: watch, command and follow running nodes, and publish axes as one.

Positions are in user units, times in seconds unless a name ends in ``_ns``. Whatever is wrong is a :class:`CoaxleError`
that says what was received and what is expected.
"""

from ._coaxle import CoaxleError, FarClock, __version__
from .live import Arrival, Axis, Follower, Network, Publisher, Reading
from .motion import Law, Motion, Plate, SawPlan, laws
from .recording import Column, Recording, Table
from .runs import Run, Sweep, run, scenarios, sweep

__all__ = [
    "Arrival",
    "Axis",
    "CoaxleError",
    "Column",
    "FarClock",
    "Follower",
    "Law",
    "Motion",
    "Network",
    "Plate",
    "Publisher",
    "Reading",
    "Recording",
    "Run",
    "SawPlan",
    "Sweep",
    "Table",
    "__version__",
    "laws",
    "run",
    "scenarios",
    "sweep",
]
