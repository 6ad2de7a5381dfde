"""Checks of a run before its first step: its parts, its clock, the branch of its motion, and its initial conditions.

Initial conditions are checked against the constraints, projected on them, or their rates fitted to the joints.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import ValidationError

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import Poses, System
from mbs_ref.scene import Scene
from mbs_ref.scene.bodies import LARGEST_NORM_GAP
from mbs_ref.scene.messages import sentences
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.scene import of_last_scene, with_rates
from mbs_ref.scene.signals import HalfSine, Signal, Table
from mbs_ref.settings import Settings
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


RANK_CHECK_LIMIT = 600  # rows; a dense SVD of more takes seconds
RATES = ("velocity", "angular_velocity")


class InconsistentScene(ValueError):
    """Initial conditions violate a constraint; the message names the joints and the violations."""


def consistent_start(system: System, y: np.ndarray, settings: Settings) -> list[str]:
    """Check the initial conditions; project y if the settings allow it, and return notes on the correction."""
    tolerance = settings.initial_tolerance
    if max(system.compliance(0.0, y)) <= tolerance:
        return []
    gaps = [
        f"joint {name!r}: {what} gap {np.abs(values).max():.3g}"
        for name, pair in system.residuals(0.0, y).items()
        for what, values in zip(("position", "velocity"), pair, strict=True)
        if not np.abs(values).max() <= tolerance
    ]
    if not gaps:
        return []
    if not settings.project_initial:
        raise InconsistentScene(
            f"initial conditions break {len(gaps)} constraint(s) by more than {tolerance:g}: {'; '.join(gaps[:8])}. "
            "Correct the scene, let --project-initial (project_initial) change it as little as possible, or fix known "
            "velocities, such as a motor's, and compute the others: --keep BODY.angular_velocity or BODY.velocity"
        )
    before = y.copy()
    residual = system.project(0.0, y)
    if not residual <= tolerance:
        raise InconsistentScene(
            f"the initial positions cannot be projected: {residual:.3g} remains; {'; '.join(gaps[:8])}"
        )
    half = system.n_positions
    moved, kicked = np.abs(y - before)[:half].max(), np.abs(y - before)[half:].max()
    return [f"initial conditions were projected: largest correction {moved:.3g} m or rad, {kicked:.3g} m/s or rad/s"]


def rank_at_start(system: System, y: np.ndarray) -> int | None:
    """Return the rank of C_q at the start; None for open trees, and for more rows than RANK_CHECK_LIMIT."""
    if system.n_closure_rows == 0 or system.n_constraints > RANK_CHECK_LIMIT:
        return None
    return system.rank(0.0, y)


def redundancy(system: System, rank: int | None) -> list[str]:
    """Return a note on dependent constraint rows at the start, if there are any."""
    rows = system.n_constraints
    if rank is None or rank == rows:
        return []
    freedom = system.n_coordinates - rank
    return [
        f"{rows - rank} of {rows} constraint rows are redundant at t = 0 (rank {rank}, {freedom} degrees of freedom); "
        "multipliers are the minimum-norm ones"
    ]


def fitted_rates(scene: Scene, fixed: Sequence[str], tolerance: float) -> Scene:
    """Return the scene with initial velocities that satisfy the joints; those that `fixed` names do not change.

    `fixed` holds BODY.velocity or BODY.angular_velocity. The others change least, angular velocities counted over the
    scene's length. ValueError for an unknown name; InconsistentScene if the joints contradict the fixed velocities,
    or if the poses violate a joint by more than `tolerance` (m or rad), which velocities cannot correct.
    """
    system = compile_scene(scene)
    if not isinstance(system, JointedSystem):
        raise ValueError(f"{scene.name} has no joints that its velocities could break")
    y = system.initial_state()
    gaps = system.residuals(0.0, y)
    broken = [name for name, (gap, _) in gaps.items() if not np.abs(gap).max(initial=0.0) <= tolerance]
    if broken:
        raise InconsistentScene(f"the initial poses break joint(s) {', '.join(broken)}; no velocity corrects that")
    rates = np.concatenate([_rates(body) for body in scene.bodies])
    rows, violation = system.jacobian(0.0, y), np.concatenate([rate for _, rate in gaps.values()])
    picked = np.eye(len(rates))[_columns(scene, fixed)]
    weights = np.tile(_weights(scene), len(scene.bodies))
    wanted = np.concatenate((-violation, np.zeros(len(picked))))
    change = np.linalg.lstsq(np.vstack((rows, picked)) / weights, wanted, rcond=None)[0] / weights
    fitted = with_rates(scene, rates + change)
    _require_closed(compile_scene(fitted), fixed, tolerance)
    return fitted


def _rates(body: Any) -> np.ndarray:
    """Return a body's velocity and angular velocity, (3,) in the plane and (6,) in space; a particle does not turn."""
    still = np.zeros(1 if len(body.velocity) == 2 else 3)
    return np.concatenate((body.velocity, np.atleast_1d(getattr(body, "angular_velocity", still))))


def _weights(scene: Scene) -> np.ndarray:
    """Return the factors (3,) or (6,) that make a body's rates comparable: the scene's length for angular ones."""
    d = scene.dimension
    return np.repeat((1.0, scales_of(scene).length), (d, d * (d - 1) // 2))


def _columns(scene: Scene, fixed: Sequence[str]) -> list[int]:
    """Return the columns of C_q that the names stand for."""
    straight, each = scene.dimension, len(_weights(scene))
    places = {"velocity": range(straight), "angular_velocity": range(straight, each)}
    columns: list[int] = []
    for name in fixed:
        body, _, rate = name.rpartition(".")
        if body not in scene.body_names or rate not in places:
            allowed = f"BODY.{' or BODY.'.join(RATES)}, where BODY is one of {', '.join(scene.body_names)}"
            raise ValueError(f"keep = {name!r} is unknown; allowed: {allowed}")
        columns += [each * scene.body_index(body) + k for k in places[rate]]
    return columns


def _require_closed(system: System, fixed: Sequence[str], tolerance: float) -> None:
    """Raise InconsistentScene if the joints contradict the fixed velocities."""
    residuals = system.residuals(0.0, system.initial_state())
    gaps = {name: float(np.abs(rate).max(initial=0.0)) for name, (_, rate) in residuals.items()}
    broken = [f"{name} by {gap:.3g}" for name, gap in gaps.items() if not gap <= tolerance]
    if broken:
        raise InconsistentScene(f"with {', '.join(fixed)} fixed, no velocities of the others close {'; '.join(broken)}")
