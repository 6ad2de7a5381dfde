"""What a column may be counted in, and how much of the SI unit that is."""

from __future__ import annotations

import math

UNITS = {
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048, "in": 0.0254, "au": 149597870700.0},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0, "day": 86400.0},
}  # the foot and the inch of 1959, the astronomical unit of IAU 2012 resolution B2
RATES = {"velocity": "length", "angular velocity": "angle"}  # per time


def allowed(kind: str) -> list[str]:
    """Return every unit of a length, angle, time, velocity or angular velocity."""
    if kind in RATES:
        return [f"{above}/{below}" for above in UNITS[RATES[kind]] for below in UNITS["time"]]
    return list(UNITS[kind])


def factor(kind: str, unit: str) -> float:
    """Return how many SI units one `unit` is; ValueError names what is allowed."""
    if unit not in allowed(kind):
        shown = ", ".join(UNITS[RATES.get(kind, kind)])
        per = ", each per s, ms, us, min, h or day, such as deg/s" if kind in RATES else ""
        raise ValueError(f"unit = {unit!r} is no unit of {kind}; allowed: {shown}{per}")
    above, _, below = unit.partition("/")
    return UNITS[RATES.get(kind, kind)][above] / (UNITS["time"][below] if below else 1.0)
