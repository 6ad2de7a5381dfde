"""Check a run before its first step: the numbers of its parts and its start, the clock, the branch of the motion."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from pydantic import ValidationError

from mbs_ref.cores.system import Poses, System
from mbs_ref.scene import Scene
from mbs_ref.scene.bodies import LARGEST_NORM_GAP
from mbs_ref.scene.messages import sentences
from mbs_ref.scene.scene import of_last_scene
from mbs_ref.scene.signals import HalfSine, Signal, Table
from mbs_ref.trajectory import pose_shapes

MIN_TICKS = 1000  # spacings of floats in the shortest piece of a signal: its ends are then exact to a thousandth
NUDGE = 1e-3  # m, rad: distance of a neighbouring pose along the free motions
TRIALS = 4  # neighbouring poses


class UnsoundScene(ValueError):
    """A scene with parts that were not validated, or whose numbers a run cannot represent."""


@of_last_scene
def require_sound(scene: Scene) -> None:
    """Validate every part again, since copies with changed fields are not; UnsoundScene lists what is invalid."""
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
    """Return a sentence for every signal with a piece too short for the resolution of the time then."""
    return [
        f"{part.type} {part.name!r}: its piece of {length:.3g} s at t = {at:.6g} s spans fewer than {MIN_TICKS} "
        f"floating-point times, whose spacing is {math.ulp(at):.2g} s there"
        for part in (*scene.joints, *scene.loads)
        for signal in part.signals
        for at, length in _pieces(signal)
        if length < MIN_TICKS * math.ulp(at)
    ]


def _pieces(signal: Signal) -> list[tuple[float, float]]:
    """Return end (s) and length (s) of the pieces between two declared times."""
    if isinstance(signal, HalfSine):
        return [(abs(signal.start) + signal.duration, signal.duration)]
    if isinstance(signal, Table):
        return [(max(abs(a), abs(b)), b - a) for a, b in pairwise(signal.times) if b > a]
    return []


def ambiguous_start(system: System, y: np.ndarray, rank: int) -> str:
    """Return why the motion from a start at rest is not unique, or nothing; `rank` is that of C_q there.

    A pose is singular where C_q has a lower rank than at neighbouring poses on the constraints. A motion through it
    follows the branch of its velocity; at rest the branch is undetermined.
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
                "several motions are possible; move the start or give it a speed"
            )
    return ""


def _neighbour(system: System, y: np.ndarray, random: np.random.Generator) -> np.ndarray | None:
    """Return a pose on the constraints at about NUDGE from y; None if the projection fails."""
    near = y.copy()
    half = system.n_positions
    near[:half] += system.free_direction(0.0, y, random)[:half] * NUDGE
    residual = system.project(0.0, near)
    moved = float(np.abs(near - y)[:half].max())
    return near if residual <= 1e-10 and moved > 0.1 * NUDGE else None


def check_starts(scene: Scene, starts: Poses, count: int | None = None) -> None:
    """Raise ValueError unless starts are `count` poses and rates of all bodies, finite, of unit Euler parameters.

    Any number of them is allowed unless `count` is given.
    """
    count = len(starts.position) if count is None else count
    for name, given, shape in zip(Poses._fields, starts, pose_shapes(len(scene.bodies), scene.dimension), strict=True):
        wanted = (count, *shape)
        if np.shape(given) != wanted:
            raise ValueError(f"starts.{name} has the shape {np.shape(given)}; allowed: {wanted}")
        if not np.all(np.isfinite(given)):
            raise ValueError(f"starts.{name} holds an infinite number or NaN; allowed: finite ones")
    orientation = np.asarray(starts.orientation)
    gaps = np.abs(np.sum(orientation**2, axis=-1) - 1.0) if orientation.ndim == 3 else np.zeros((1, 1))
    if np.any(gaps > LARGEST_NORM_GAP):
        start, body = np.unravel_index(np.argmax(gaps), gaps.shape)
        theta = orientation[start, body]
        raise ValueError(
            f"starts.orientation[{start}] of body {scene.bodies[body].name!r} = {theta.tolist()} has the norm "
            f"{np.linalg.norm(theta):.12g}; Euler parameters have 1"
        )
