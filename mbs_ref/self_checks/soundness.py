"""Is the start of a run sound? Numbers, clock and branch, looked at before the first step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from pydantic import ValidationError

from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.messages import sentences
from mbs_ref.scene.signals import HalfSine, Signal, Table

FEWEST_TICKS = 1000  # of the clock in the shortest piece of a signal: it is then met to a thousandth
NUDGE = 1e-3  # m, rad: how far along the free motions a neighbouring pose is looked at
TRIALS = 4  # neighbouring poses


class UnsoundScene(ValueError):
    """A scene that was not checked when it was made, or whose numbers a run cannot hold."""


def require_sound(scene: Scene) -> None:
    """Check every part again: copies with changed fields are not checked by themselves. UnsoundScene lists all."""
    complaints = [text for kind in ("bodies", "joints", "loads", "contacts") for text in _part_troubles(kind, scene)]
    complaints += [] if all(map(math.isfinite, scene.gravity)) else [f"gravity = {scene.gravity} is not finite"]
    complaints += clock_troubles(scene)
    if complaints:
        raise UnsoundScene("; ".join(complaints[:8]))


def _part_troubles(kind: str, scene: Scene) -> Iterator[str]:
    for part in getattr(scene, kind):
        try:
            type(part)(**vars(part))
        except ValidationError as error:
            yield f"{kind} {part.name!r}: {sentences(error, type(part), dict(part))}"


def clock_troubles(scene: Scene) -> list[str]:
    """Return a sentence for every signal with a piece so short and late that the clock has no room for it."""
    return [
        f"{part.type} {part.name!r}: its piece of {length:.3g} s at t = {at:.6g} s has fewer than {FEWEST_TICKS} "
        f"ticks of the clock, which are {math.ulp(at):.2g} s there"
        for part in (*scene.joints, *scene.loads)
        for signal in part.signals
        for at, length in _pieces(signal)
        if length < FEWEST_TICKS * math.ulp(at)
    ]


def _pieces(signal: Signal) -> list[tuple[float, float]]:
    """Return end (s) and length (s) of what lies between two declared times."""
    if isinstance(signal, HalfSine):
        return [(abs(signal.start) + signal.duration, signal.duration)]
    if isinstance(signal, Table):
        return [(max(abs(a), abs(b)), b - a) for a, b in pairwise(signal.times) if b > a]
    return []


def ambiguous_start(system: System, y: np.ndarray, rank: int) -> str:
    """Return why the motion from a start at rest is not determined, or nothing; `rank` is that of C_q there.

    A pose is singular where C_q has a lower rank than at neighbouring poses on the constraints. Moving through it,
    the velocity chooses the branch; at rest nothing does.
    """
    half = system.n_positions
    if np.any(y[half:]):
        return ""
    random = np.random.default_rng(0)
    for _ in range(TRIALS):
        near = _neighbour(system, y, random)
        if near is not None and system.rank(0.0, near) > rank:
            return (
                f"the start is a singular pose at rest: C_q has rank {rank} there and more next to it, so that "
                "several motions are possible; move it, give it a speed, or ask to go on (ambiguous = 'continue')"
            )
    return ""


def _neighbour(system: System, y: np.ndarray, random: np.random.Generator) -> np.ndarray | None:
    """Return a pose on the constraints at about NUDGE from y; None where projection fails."""
    near = y.copy()
    half = system.n_positions
    near[:half] += system.free_direction(0.0, y, random)[:half] * NUDGE
    left = system.project(0.0, near)
    moved = float(np.abs(near - y)[:half].max())
    return near if left <= 1e-10 and moved > 0.1 * NUDGE else None
