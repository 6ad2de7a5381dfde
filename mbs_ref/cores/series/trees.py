"""Planar trees of revolute joints compiled for Taylor series."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from mbs_ref.cores.relative import RelativePlanarSystem, no_tree
from mbs_ref.kernels.algebra.lanes import WIDTH, in_one_room
from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.border.handles import make_handle
from mbs_ref.kernels.relative.model import REVOLUTE, WELD
from mbs_ref.kernels.relative.series import Expanded, Series, SeriesGroups
from mbs_ref.kernels.series import MAX_ORDER
from mbs_ref.scene import PointMass, Revolute, Scene, TorsionSpring, Weld
from mbs_ref.scene.traits import joined


def no_tree_series(scene: Scene) -> Iterator[str]:
    """Yield why Taylor series of a scene's motion are not available."""
    if scene.dimension == 3:
        yield "bodies move in space"
        return
    yield from no_tree(scene)
    if not joined(scene)[1]:
        yield "a body has no chain of joints to ground"
    particles = {body.name for body in scene.bodies if isinstance(body, PointMass)}
    for part in (*scene.joints, *scene.loads, *scene.contacts):
        if isinstance(part, Weld) and not particles.isdisjoint(part.ends):
            yield f"weld {part.name!r} holds a point mass"
        elif not isinstance(part, Revolute | Weld | TorsionSpring):
            yield f"{part.name!r} is a {getattr(part, 'type', 'contact')}"


class TreeSeries:
    """The tree of a system in relative coordinates, and the arrays of its series."""

    def __init__(self, system: Any) -> None:
        scene = system.scene
        self.system: Any = system if isinstance(system, RelativePlanarSystem) else RelativePlanarSystem(scene, system)
        plan = self.system.layout
        bodies, turned = plan.bodies, np.flatnonzero(np.array(plan.kind) == REVOLUTE)
        n, m = len(bodies), len(turned)
        place, inertia = np.array([*(complex(*body.position) for body in bodies), 0.0]), np.zeros(m + 1)
        turn, lever = np.full(n + 1, m), np.zeros((n + 1, m + 1), dtype=complex)  # by m angles, and by none
        turn[turned] = np.arange(m)
        for i, parent in enumerate(plan.parent):
            is_welded, joint = plan.kind[i] == WELD, scene.joints[plan.joint[i]]
            turn[i] = turn[parent] if is_welded else turn[i]
            point = place[i] if is_welded else complex(*joint.mark("body_a"))
            lever[i] = lever[parent]
            lever[i, turn[parent]] += point - place[parent]
            lever[i, turn[i]] += place[i] - point
            inertia[turn[i]] += getattr(bodies[i], "inertia", 0.0)
        lever = lever[:n, :m]
        pushed = lever.conj().T * np.array([body.mass for body in bodies])  # (m, n)
        coupling, weight = pushed @ lever, pushed.sum(axis=1) * complex(*scene.gravity)
        own = 3 * np.array(plan.order)[turned] + 2
        lengths = {"m": m, "w": -(-m // WIDTH), "WIDTH": WIDTH, "orders": MAX_ORDER + 2}
        given = empty(Series, **lengths)._replace(
            parent=turn[np.array(plan.parent, dtype=int)[turned]],
            tolerance=np.arange(2 * m).reshape(2, m) if self.system is system else np.array([own, own + 3 * n]),
            coupling=_rows(np.stack((np.real(coupling.T), np.imag(coupling.T)), axis=1)),
            inertia=_rows(inertia[:m]),
            weight=_rows(np.array([np.real(weight), np.imag(weight)])),
            **_springs(self.system.redundant, turn, [getattr(body, "angle", 0.0) for body in bodies]),
        )
        self.series = in_one_room(given)
        self._groups = SeriesGroups(self.series)
        self._handle = make_handle(self._groups)
        self.handle = Expanded(self._handle.ctypes.data)


def _rows(values: np.ndarray) -> np.ndarray:
    """Return values (..., m) as rows of lanes (..., w, WIDTH), padded with zeros."""
    *outer, m = values.shape
    words = -(-m // WIDTH)
    room = np.zeros((*outer, words * WIDTH))
    room[..., :m] = values
    return room.reshape(*outer, words, WIDTH)


def _springs(system: Any, turn: np.ndarray, angles: list[float]) -> dict[str, np.ndarray]:
    """Return the torques of torsion springs, linear in the angles and rates; `turn` (n + 1,) is ground's at last."""
    springs, angle, m = system.groups.torsion_springs, np.append(angles, 0.0), turn[-1]
    along = np.eye(m + 1)[turn[springs.b]] - np.eye(m + 1)[turn[springs.a]]
    strain = angle[springs.b] - angle[springs.a] - springs.rest_angle
    linear = (along[:, :m].T * factor @ along[:, :m] for factor in (springs.stiffness, springs.damping))
    stiffness, damping = (_rows(matrix if len(strain) else matrix[:0]) for matrix in linear)
    torque = _rows(-(springs.stiffness * strain) @ along[:, :m])
    return {"stiffness": stiffness, "damping": damping, "torque": torque}
