"""Masses on a line with one-sided linear spring-dampers or rigid impacts: exact between instants known to roundoff.

With the closed contacts fixed the motion is z' = A z + b, solved by the matrix exponential. A contact's row r and
offset give its gap r . x - offset; F = -k gap - c gap' pushes along r while it is closed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from cross_checks.truths.truth import ALIKE, NoConvergenceError, Pace
from mbs_ref import Scene
from mbs_ref.scene.contact import RigidLaw

OPEN, CLOSED, LIFTED = range(3)
MOST_EVENTS = 5_000
LOOKS = 6.0  # a radian of the fastest mode: how densely events are looked for while a contact is closed
TOGETHER = 64  # looks, in one go
LONGEST_LOOK = 1e-3  # s, where nothing swings
COARSER = 0.61  # of the looks, for the second run that gives the error bar
ROUNDOFF = 1e-13  # m
NOISE = 1e-14  # m: how far beyond its root a mode holds, or boxes that just touch would chatter


@dataclass(frozen=True)
class Unilateral:
    """A one-sided contact; with a restitution it is rigid."""

    row: tuple[float, ...]
    offset: float  # m
    stiffness: float = 0.0  # N/m
    damping: float = 0.0  # N s/m
    by_force: bool = False  # opens where F = 0, not where gap = 0
    restitution: float | None = None


@dataclass(frozen=True)
class Line:
    """The masses, what pulls them and where they start."""

    mass: np.ndarray  # (n,) kg
    force: np.ndarray  # (n,) N
    position: np.ndarray  # (n,) m
    velocity: np.ndarray  # (n,) m/s
    contacts: tuple[Unilateral, ...]


def one_sided(law: Any, row: tuple[float, ...], offset: float, parallel: float = 1.0) -> Unilateral:
    """Return the contact of a rigid or linear law; `parallel` equal spring-dampers act side by side."""
    if isinstance(law, RigidLaw):
        return Unilateral(row, offset, restitution=law.restitution)
    return Unilateral(row, offset, parallel * law.stiffness, parallel * law.damping, law.release == "force")


def line_of(scene: Scene, axis: int, contacts: Sequence[Unilateral]) -> Line:
    """Return the scene's bodies as masses that move along one axis."""
    mass, place, rate = (
        np.array([getattr(body, name) for body in scene.bodies]) for name in ("mass", "position", "velocity")
    )
    return Line(mass, mass * scene.gravity[axis], place[:, axis], rate[:, axis], tuple(contacts))


def line_motion(line: Line, times: np.ndarray) -> tuple[np.ndarray, float]:
    """Return x (n_t, n), m, and its uncertainty: ALIKE times the gap of two runs that look for events differently."""
    fine, coarse = (_Walk(line, looks).through(times) for looks in (LOOKS, COARSER * LOOKS))
    return fine, ALIKE * float(np.max(np.abs(fine - coarse))) + ROUNDOFF


def _crossing(gap: float, rate: float, a: float) -> float:
    """Return the first time at which gap + rate t + a t^2 / 2 falls through 0; inf where it never does."""
    if gap <= 0.0 and rate < 0.0:
        return 0.0
    square = rate * rate - 2.0 * a * gap
    if square < 0.0 or (a >= 0.0 and rate >= 0.0):
        return np.inf
    root = np.sqrt(square)
    return 2.0 * max(gap, 0.0) / (root - rate) if rate < 0.0 else (rate + root) / -a  # no cancellation


class _Walk:
    def __init__(self, line: Line, looks: float) -> None:
        self.line, self.n = line, len(line.mass)
        self.rows = np.array([c.row for c in line.contacts])
        self.offset = np.array([c.offset for c in line.contacts])
        self.looks = looks
        self.modes: list[int] = []
        self.broken, self.which = 0, 0
        self.seen: tuple[float, float, np.ndarray] | None = None  # s: event looked from, how far beyond; state there

    def through(self, times: np.ndarray) -> np.ndarray:
        self.pace = Pace(times)
        t, z = 0.0, np.concatenate((self.line.position, self.line.velocity, [1.0]))
        self.modes = [OPEN] * len(self.rows)
        for k, contact in enumerate(self.line.contacts):
            if contact.restitution is None and self._gap(k, z) <= 0.0:
                self.modes[k] = CLOSED
        result, events = np.empty((len(times), self.n)), 0
        for place, goal in enumerate(times):
            while True:
                self.pace.check(t)
                instant, here = self._until(t, z, float(goal))
                if instant is None:
                    break
                t, z = instant, self._switch(here)
                events += 1
                if events > MOST_EVENTS:
                    raise NoConvergenceError(f"more than {MOST_EVENTS} contact events before t = {goal:g} s")
            result[place] = self._at(z, goal - t)[: self.n]
        return result

    def _generator(self) -> np.ndarray:
        n, line = self.n, self.line
        a = np.zeros((2 * n + 1, 2 * n + 1))
        a[:n, n : 2 * n] = np.eye(n)
        a[n : 2 * n, -1] = line.force / line.mass
        for contact, row, mode in zip(line.contacts, self.rows, self.modes, strict=True):
            if mode == CLOSED:
                push = row / line.mass
                a[n : 2 * n, :n] -= contact.stiffness * np.outer(push, row)
                a[n : 2 * n, n : 2 * n] -= contact.damping * np.outer(push, row)
                a[n : 2 * n, -1] += contact.stiffness * contact.offset * push
        return a

    def _at(self, z: np.ndarray, after: float) -> np.ndarray:
        if self._flies:
            n, fall, ahead = self.n, self.line.force / self.line.mass * after, z.copy()
            ahead[:n] += (z[n : 2 * n] + 0.5 * fall) * after
            ahead[n : 2 * n] += fall
            return ahead
        return scipy.linalg.expm(self._generator() * after) @ z

    @property
    def _flies(self) -> bool:
        return CLOSED not in self.modes and LIFTED not in self.modes

    def _gap(self, k: int, z: np.ndarray) -> float:
        return float(self.rows[k] @ z[: self.n] - self.offset[k])

    def _guards(self, states: np.ndarray) -> np.ndarray:
        """Return two functions a contact (n_states, n_contacts, 2) of states (n_states, 2 n + 1), positive while its
        mode holds."""
        gaps = states[:, : self.n] @ self.rows.T - self.offset
        rates = states[:, self.n : 2 * self.n] @ self.rows.T
        values = np.ones((*gaps.shape, 2))
        for k, (contact, mode) in enumerate(zip(self.line.contacts, self.modes, strict=True)):
            values[:, k, 0] = NOISE + (gaps[:, k] if mode == OPEN else -gaps[:, k])
            if mode != OPEN and contact.by_force:
                force = -contact.stiffness * gaps[:, k] - contact.damping * rates[:, k]
                slack = NOISE * (contact.stiffness + contact.damping)
                values[:, k, 1] = slack + force * (1.0 if mode == CLOSED else -1.0)
            if contact.restitution is not None:
                values[rates[:, k] >= 0.0, k, 0] = 1.0  # parting
        return values

    def _until(self, t: float, z: np.ndarray, end: float) -> tuple[float | None, np.ndarray]:
        """Return the first event in (t, end] and the state there, or None."""
        if end <= t:
            return None, z
        if self._flies:
            (after, self.broken), self.which = self._flight(z), 0
            return (t + after, self._at(z, after)) if t + after <= end else (None, z)
        fastest = float(np.max(np.abs(np.linalg.eigvals(self._generator()[:-1, :-1]))))
        look = 1.0 / (self.looks * fastest) if fastest > 0.0 else LONGEST_LOOK
        before, now = self.seen[1:] if self.seen and self.seen[0] == t else (0.0, z)
        step, ahead = scipy.linalg.expm(self._generator() * look), [now]
        while before < end - t:
            self.pace.check(t + before)
            for _ in range(TOGETHER):
                ahead.append(step @ ahead[-1])
            broken = self._guards(np.array(ahead[1:])) < 0.0
            if broken.any():
                k = int(np.argmax(broken.any(axis=(1, 2))))
                after = self._first(z, broken[k], before + k * look, before + (k + 1) * look)
                return (t + after, self._at(z, after)) if t + after <= end else (None, z)
            ahead, before = ahead[-1:], before + TOGETHER * look
            self.seen = (t, before, ahead[0])
        return None, z

    def _flight(self, z: np.ndarray) -> tuple[float, int]:
        """Return when the first gap of a free flight closes (inf: never), and which."""
        pull = self.line.force / self.line.mass
        crossings = [_crossing(self._gap(k, z), float(row @ z[self.n : 2 * self.n]), float(row @ pull))
                 for k, row in enumerate(self.rows)]  # fmt: skip
        return min(crossings), int(np.argmin(crossings))

    def _first(self, z: np.ndarray, broken: np.ndarray, low: float, high: float) -> float:
        """Return the earliest root between two looks, and note whose it is; `broken` marks who has one.

        Looks come from each other, roots from z: by roundoff a root may be at a look's other side.
        """
        start, stop = self._guards(np.array([self._at(z, low), self._at(z, high)]))
        times = []
        for place in zip(*np.nonzero(broken), strict=True):
            root = low if start[place] <= 0.0 else high
            if root == high and stop[place] < 0.0:
                root = scipy.optimize.root_scalar(
                    self._guard, (z, place), bracket=(low, high), xtol=1e-16, rtol=1e-15
                ).root
            times.append((float(root), int(place[0]), int(place[1])))
        after, self.broken, self.which = min(times)
        return after

    def _guard(self, after: float, z: np.ndarray, place: tuple[int, int]) -> float:
        return float(self._guards(self._at(z, after)[None])[0][place])

    def _switch(self, z: np.ndarray) -> np.ndarray:
        """Change the mode, or the speeds, of the contact whose event this is."""
        z, k, self.seen = z.copy(), self.broken, None
        restitution = self.line.contacts[k].restitution
        if restitution is not None:
            speed, push = self.rows[k] @ z[self.n : 2 * self.n], self.rows[k] / self.line.mass
            z[self.n : 2 * self.n] -= (1.0 + restitution) * min(speed, 0.0) / (self.rows[k] @ push) * push
        elif self.modes[k] == OPEN:
            self.modes[k] = CLOSED
        elif self.which == 0:
            self.modes[k] = OPEN
        else:
            self.modes[k] = LIFTED if self.modes[k] == CLOSED else CLOSED
        return z
