"""Roots inside a step: the first is found, whatever the motion, and none is invented."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from mbs_ref.integrators.loop import exclusion
from mbs_ref.kernels.contact.laws import RATE, SPEED, TURN, UNKNOWN, VALUE

UNIT = 1e12  # roundoffs in a length


class Turning:
    """A point on a circle of radius 1 about the origin, turning at w from an angle: y = [angle, w]."""

    def __init__(
        self, w: float, angle: float, level: float, known: bool, bend: float = 1.0, loose: float = 1.0
    ) -> None:
        self.w, self.angle, self.level, self.known = w, angle, level, known
        self.bend, self.loose = bend, loose  # how many times too fast the rates change, and the bound on them is
        self.places = 0  # where the functions were evaluated

    def table(self, angle: float) -> np.ndarray:
        """Return the functions of its height above -level, in the second column, and of a constant in the first."""
        table = np.zeros((4, 2))
        table[VALUE] = 1.0, UNIT * (np.sin(angle) + self.level)
        table[RATE, 1] = UNIT * self.w * self.bend * np.cos(angle) if self.known else 0.0
        table[SPEED, 1] = UNIT * self.w * self.loose if self.known else UNKNOWN
        table[TURN, 1] = self.w
        return table

    def first(self, h: float) -> float:
        """Return the time (s) of the first root, inf where there is none in h."""
        turn = (np.pi + np.arcsin(self.level) - self.angle) % (2.0 * np.pi) if self.level <= 1.0 else np.inf
        return turn / self.w if turn <= self.w * h else np.inf


@pytest.fixture
def first_open(monkeypatch):
    """Return a function that looks inside a step of size h of a turning point."""

    def look(motion: Turning, h: float) -> float:
        def roots(model, work, t, y, duration, table):
            table[:] = motion.table(y[0])
            motion.places += 1

        def derivative(model, work, t, y, dy):
            dy[:] = motion.w, 0.0

        def position_rate(model, y, rate, out):
            out[:] = rate[:1]

        monkeypatch.setattr(exclusion, "roots", roots)
        monkeypatch.setattr(exclusion, "derivative", derivative)
        monkeypatch.setattr(exclusion, "position_rate", position_rate)
        monkeypatch.setattr(exclusion, "rate_from", lambda model, y, moved, out: position_rate(model, y, moved, out))
        monkeypatch.setattr(exclusion, "position_count", lambda model: 1)
        for name, function in vars(exclusion).items():
            if hasattr(function, "py_func"):
                monkeypatch.setattr(exclusion, name, function.py_func)
        y, y_new = np.array([motion.angle, motion.w]), np.array([motion.angle + motion.w * h, motion.w])
        ends = exclusion.step_ends(y, np.empty(2), y_new, np.empty(2))
        run = SimpleNamespace(rhs_calls=0)
        low, new = motion.table(y[0]), motion.table(y_new[0])
        return exclusion.first_open(None, None, 0.0, h, ends, run, low, new)

    return look


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("seed", range(12))
def test_the_first_root_of_a_turning_point_is_in_the_interval_that_is_returned(first_open, seed, known):
    """Turns of up to fifty radians in a step; the point touches its level by 1e-1 to 1e-8, or misses it by as much."""
    random = np.random.default_rng(seed)
    h, w = 10.0 ** random.uniform(-3.0, 0.0), 10.0 ** random.uniform(-1.0, 1.7)
    w /= h
    for side in (-1.0, 1.0):
        motion = Turning(w, random.uniform(0.0, 3.0), 1.0 + side * 10.0 ** random.uniform(-8.0, -1.0), known)
        end, first = first_open(motion, h), motion.first(h) / h
        if first == np.inf:
            assert end == exclusion.CLEAR
        else:
            inside = np.linspace(0.0, min(end, 1.0), 2001)
            below = np.sin(motion.angle + w * h * inside) + motion.level < 0.0
            assert first <= end
            assert np.count_nonzero(np.diff(below.astype(int)) == 1) <= 1  # no second root before its end


@pytest.mark.parametrize("bend", [-1.0, 0.1, 3.0, 10.0])
def test_rates_that_change_otherwise_than_the_values_cost_few_places(first_open, bend):
    """Interpolated velocities are not quite the derivative of the interpolated positions."""
    motion = Turning(1.0, 0.0, 3.0, True, bend, loose=1e9)
    assert first_open(motion, 1.5) == exclusion.CLEAR
    assert motion.places < 20
