"""Numbers on their way to the extension and back."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def out(values: npt.ArrayLike) -> bytes:
    """Any numbers, in any layout and precision, as the extension takes them."""
    return np.ascontiguousarray(values, dtype=np.float64).tobytes()


def back(data: bytes, kind: Any = np.float64) -> Any:
    """What the extension gave, as an array that may be changed."""
    return np.frombuffer(data, dtype=kind).copy()
