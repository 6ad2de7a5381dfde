"""Numbers as Python text that reads back as the same bits."""

from __future__ import annotations

import enum
from typing import Any

import numpy as np


def literal(value: Any) -> str:
    """Return Python text of plain data, arrays as lists; floats have all their digits."""
    if isinstance(value, np.ndarray):
        return literal(value.tolist())
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(literal, value)) + ("," if len(value) == 1 else "") + ")"
    if isinstance(value, np.generic):
        return literal(value.item())
    if value is not None and (isinstance(value, enum.Enum) or not isinstance(value, bool | int | float | str)):
        raise TypeError(f"{value!r} is no plain data")
    return repr(value)


def rows(values: Any) -> str:
    """Return Python text of a list, one entry a line."""
    lines = "".join(f"    {literal(value)},\n" for value in values)
    return f"[\n{lines}]" if lines else "[]"


def times_text(times: np.ndarray) -> str:
    """Return NumPy text of the output times, to the last bit."""
    end, count = float(times[-1]), len(times)
    if np.array_equal(np.linspace(0.0, end, count), times):
        return f"np.linspace(0.0, {end!r}, {count})"
    return f"np.array({literal(times)})"


def counts_text(counts: tuple[int, ...]) -> str:
    """Return Python text of the numbers of steps between outputs."""
    if len(set(counts)) == 1:
        return f"[{counts[0]}] * {len(counts)}"
    return literal(list(counts))
