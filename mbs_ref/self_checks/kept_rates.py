"""Consistent initial velocities that keep chosen ones: the crank's speed stays, the rest follows from the joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.scene import with_rates
from mbs_ref.self_checks.consistent_start import InconsistentScene

RATES = ("velocity", "angular_velocity")


def keeping(scene: Scene, kept: Sequence[str], tolerance: float) -> Scene:
    """Return the scene with initial velocities that the joints allow and that keep what `kept` names.

    `kept` holds BODY.velocity or BODY.angular_velocity. The others change least, angular velocities counted over the
    scene's length. ValueError where a name is unknown; InconsistentScene where the joints do not allow what is kept,
    or the poses themselves break a joint by more than `tolerance` (m or rad), which velocities cannot mend.
    """
    system = compile_scene(scene)
    if not isinstance(system, JointedSystem):
        raise ValueError(f"{scene.name} has no joints that its velocities could break")
    y = system.initial_state()
    gaps = system.residuals(0.0, y)
    broken = [name for name, (gap, _) in gaps.items() if not np.abs(gap).max(initial=0.0) <= tolerance]
    if broken:
        raise InconsistentScene(f"the initial poses break joint(s) {', '.join(broken)}; no velocity mends that")
    rates = np.concatenate([_rates(body) for body in scene.bodies])
    rows, found = system.jacobian(0.0, y), np.concatenate([rate for _, rate in gaps.values()])
    picked = np.eye(len(rates))[_columns(scene, kept)]
    weights = np.tile(_weights(scene), len(scene.bodies))
    wanted = np.concatenate((-found, np.zeros(len(picked))))
    change = np.linalg.lstsq(np.vstack((rows, picked)) / weights, wanted, rcond=None)[0] / weights
    mended = with_rates(scene, rates + change)
    _check(compile_scene(mended), mended, kept, tolerance)
    return mended


def _rates(body: Any) -> np.ndarray:
    """Return a body's velocity and angular velocity, (3,) in the plane and (6,) in space; a particle does not turn."""
    still = np.zeros(1 if len(body.velocity) == 2 else 3)
    return np.concatenate((body.velocity, np.atleast_1d(getattr(body, "angular_velocity", still))))


def _weights(scene: Scene) -> np.ndarray:
    """Return by what a body's rates are multiplied to compare: angular ones by the scene's length."""
    turning = 1 if scene.dimension == 2 else 3
    return np.concatenate((np.ones(2 if scene.dimension == 2 else 3), np.full(turning, scales_of(scene).length)))


def _columns(scene: Scene, kept: Sequence[str]) -> list[int]:
    """Return the columns of C_q that the names stand for."""
    straight = 2 if scene.dimension == 2 else 3
    each = len(_weights(scene))
    places = {"velocity": range(straight), "angular_velocity": range(straight, each)}
    columns: list[int] = []
    for name in kept:
        body, _, rate = name.rpartition(".")
        if body not in scene.body_names or rate not in places:
            allowed = f"BODY.{' or BODY.'.join(RATES)}, where BODY is one of {', '.join(scene.body_names)}"
            raise ValueError(f"keep = {name!r} is unknown; allowed: {allowed}")
        columns += [each * scene.body_index(body) + k for k in places[rate]]
    return columns


def _check(system: System, scene: Scene, kept: Sequence[str], tolerance: float) -> None:
    """Raise where a joint still gapes in velocity: what is kept contradicts it."""
    residuals = system.residuals(0.0, system.initial_state())
    left = {name: float(np.abs(rate).max(initial=0.0)) for name, (_, rate) in residuals.items()}
    broken = [f"{name} by {gap:.3g}" for name, gap in left.items() if not gap <= tolerance]
    if broken:
        raise InconsistentScene(f"with {', '.join(kept)} kept, no velocities of the others close {'; '.join(broken)}")
