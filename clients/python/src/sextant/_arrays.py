"""Numbers as numpy arrays where numpy is installed, as tuples otherwise."""

from __future__ import annotations

from typing import Any, Sequence

try:
    import numpy
except ImportError:
    numpy = None  # type: ignore[assignment]


def vector(values: Sequence[float]) -> Any:
    """Shape (n,)."""
    return tuple(values) if numpy is None else numpy.array(values, dtype=float)


def matrix(values: Sequence[float], columns: int) -> Any:
    """Shape (rows, columns), from numbers row by row."""
    if numpy is not None:
        return numpy.array(values, dtype=float).reshape(-1, columns)
    rows = range(0, len(values), columns)
    return tuple(tuple(values[row : row + columns]) for row in rows)
