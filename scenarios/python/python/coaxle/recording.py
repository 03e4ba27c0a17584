"""Recordings and traces, column by column."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _coaxle
from ._coaxle import CoaxleError
from ._numbers import back

_KINDS = {"number": np.float64, "integer": np.int64, "flag": np.bool_, "text": np.int32}


@dataclass(frozen=True)
class Column:
    """A signal of a table, a value for each row."""

    #: The values; of a text its place among :attr:`words`, -1 for none.
    values: npt.NDArray[Any]
    #: Whether there was a value.
    known: npt.NDArray[np.bool_]
    #: The unit, empty where there is none.
    unit: str
    #: The texts that there are, where the signal is a text.
    words: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Table:
    """The rows of a node, or of one axis of a run."""

    name: str
    role: str
    #: When each cycle ideally began, ns of the clock of the rows.
    at_ns: npt.NDArray[np.int64]
    #: When it really did.
    woke_ns: npt.NDArray[np.int64]
    #: The signals by their names, ``instance.signal``.
    columns: dict[str, Column]

    def __len__(self) -> int:
        return len(self.at_ns)

    @property
    def time_s(self) -> npt.NDArray[np.float64]:
        """Since the first row, s."""
        passed: npt.NDArray[np.float64] = np.multiply(self.at_ns - self.at_ns[:1], 1e-9, dtype=np.float64)
        return passed

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """The values of a signal: numbers, with NaN where there was none; texts as objects."""
        if name not in self.columns:
            near = [other for other in self.columns if name in other][:5]
            raise CoaxleError(
                f"{self.name}: received column {name!r}, expected one of .columns"
                + (f", such as {', '.join(near)}" if near else "")
            )
        column = self.columns[name]
        if column.words is not None:
            words = np.array([*column.words, None], dtype=object)
            texts: npt.NDArray[Any] = words[column.values]
            return texts
        if column.known.all():
            return column.values
        values = column.values.astype(np.float64)
        values[~column.known] = np.nan
        return values

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with ``t_s`` in front; what may be missing has a nullable type."""
        import pandas as pd

        data: dict[str, Any] = {"t_s": self.time_s}
        for name, column in self.columns.items():
            missing = not column.known.all()
            if column.words is not None:
                data[name] = pd.Categorical.from_codes(column.values, categories=list(column.words))
            elif missing and column.values.dtype == np.int64:
                data[name] = pd.arrays.IntegerArray(column.values, ~column.known)
            elif missing and column.values.dtype == np.bool_:
                data[name] = pd.arrays.BooleanArray(column.values, ~column.known)
            else:
                data[name] = column.values
        return pd.DataFrame(data)

    def to_polars(self) -> Any:
        """A ``polars.DataFrame`` with ``t_s`` in front; what is missing is null."""
        import polars as pl

        data = [pl.Series("t_s", self.time_s)]
        for name, column in self.columns.items():
            if column.words is not None:
                series = pl.Series(name, list(self[name]), dtype=pl.String)
            else:
                series = pl.Series(name, column.values)
                if not column.known.all():
                    known = pl.Series(column.known)
                    nothing = pl.Series(name, [None], dtype=series.dtype)
                    series = series.zip_with(known, nothing.extend_constant(None, len(series) - 1))
            data.append(series)
        return pl.DataFrame(data)


class Recording:
    """A recording, read whole: of a node, of ``coaxle record``, or the ``trace.mcap`` of a run.

    Of a damaged or unfinished file what is whole is there, and :attr:`damage` says where it is not.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        read = _coaxle.read_recording(os.fspath(path))
        #: What is known of it: who wrote it, from which config.
        self.facts: dict[str, str] = read["facts"]
        #: What is damaged, in words.
        self.damage: list[str] = read["damage"]
        #: Rows that are left out because not all of them is there.
        self.incomplete_rows: int = read["incomplete_rows"]
        #: The tables by their names.
        self.tables: dict[str, Table] = {table["name"]: _table(table) for table in read["tables"]}

    def __getitem__(self, name: str) -> Table:
        if name not in self.tables:
            raise CoaxleError(f"received table {name!r}, expected one of: {', '.join(self.tables)}")
        return self.tables[name]

    def frame(self, name: str | None = None, *, polars: bool = False) -> Any:
        """A table as a frame of pandas or polars; without a name the only one."""
        if name is None and len(self.tables) != 1:
            raise CoaxleError(f"received no table, expected one of: {', '.join(self.tables)}")
        table = self[name if name is not None else next(iter(self.tables))]
        return table.to_polars() if polars else table.to_pandas()


def _table(table: dict[str, Any]) -> Table:
    return Table(
        name=table["name"],
        role=table["role"],
        at_ns=back(table["at_ns"], np.int64),
        woke_ns=back(table["woke_ns"], np.int64),
        columns={name: _column(column) for name, column in table["columns"].items()},
    )


def _column(column: dict[str, Any]) -> Column:
    return Column(
        values=back(column["values"], _KINDS[column["kind"]]),
        known=back(column["known"], np.bool_),
        unit=column["unit"],
        words=tuple(column["words"]) if "words" in column else None,
    )
