"""Planar trees of revolute joints compiled for Taylor series."""

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from mbs_ref.cores.relative import Layout, RelativePlanarSystem, no_tree
from mbs_ref.kernels.algebra.lanes import WIDTH, in_one_room
from mbs_ref.kernels.border.groups import empty, ints
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
        plan, build = self.system.layout, self.system.redundant.builder
        bodies, parents = self.system.redundant.groups.bodies, plan.parent
        n, turned = len(parents), np.flatnonzero(plan.kind == REVOLUTE)
        m, place = len(turned), build.centres[[*plan.order, -1]].view(complex)[:, 0]
        point = place[:n].copy()  # of a joint, or the place of a welded body
        point[turned] = [complex(*plan.joints[i].mark("body_a")) for i in turned]
        turn, lever = _levers(plan, (point - place[parents]).tolist(), (place[:n] - point).tolist())
        pushed = lever.conj().T * bodies.mass  # (m, n)
        coupling, weight = pushed @ lever, pushed.sum(axis=1) * complex(*scene.gravity)
        inertia = np.bincount(turn[:n], bodies.inertia[:, 0] * bodies.rigid, m + 1)
        places = 3 * plan.order[turned] + 2
        lengths = {"m": m, "w": -(-m // WIDTH), "WIDTH": WIDTH, "orders": MAX_ORDER + 2}
        given = empty(Series, **lengths)._replace(
            parent=turn[parents[turned]],
            tolerance=np.arange(2 * m).reshape(2, m) if self.system is system else np.array([places, places + 3 * n]),
            coupling=_rows(np.stack((np.real(coupling.T), np.imag(coupling.T)), axis=1)),
            inertia=_rows(inertia[:m]),
            weight=_rows(np.array([np.real(weight), np.imag(weight)])),
            **_springs(self.system.redundant.groups.torsion_springs, turn, np.array(build.angles)[[*plan.order, -1]]),
        )
        self.series = in_one_room(given)
        self._groups = SeriesGroups(self.series)
        self._handle = make_handle(self._groups)
        self.handle = Expanded(self._handle.ctypes.data)


def _levers(plan: Layout, reach: list[complex], own: list[complex]) -> tuple[np.ndarray, np.ndarray]:
    """Return the angle (n + 1,) of each body and ground, and d_ia (n, m), of levers to joints and from there (n,)."""
    n, m, count = len(own), int(np.sum(plan.kind == REVOLUTE)), itertools.count()
    turn, rows = [m] * (n + 1), [[0j] * (m + 1)] * (n + 1)  # m is no angle
    for i, (parent, kind) in enumerate(zip(plan.parent.tolist(), plan.kind.tolist(), strict=True)):
        turn[i], rows[i] = turn[parent] if kind == WELD else next(count), rows[parent].copy()
        rows[i][turn[parent]] += reach[i]
        rows[i][turn[i]] += own[i]
    return ints(turn), np.array(rows)[:n, :m]


def _rows(values: np.ndarray) -> np.ndarray:
    """Return values (..., m) as rows of lanes (..., w, WIDTH), padded with zeros."""
    *outer, m = values.shape
    words = -(-m // WIDTH)
    room = np.zeros((*outer, words * WIDTH))
    room[..., :m] = values
    return room.reshape(*outer, words, WIDTH)


def _springs(springs: Any, turn: np.ndarray, angle: np.ndarray) -> dict[str, np.ndarray]:
    """Return the torques of torsion springs, linear in angles and rates; ground ends `turn` and `angle` (n + 1,)."""
    if not len(springs.a):
        return {}
    m = turn[-1]
    along = np.eye(m + 1)[turn[springs.b]] - np.eye(m + 1)[turn[springs.a]]
    strain = angle[springs.b] - angle[springs.a] - springs.rest_angle
    stiffness, damping = (_rows(along[:, :m].T * k @ along[:, :m]) for k in (springs.stiffness, springs.damping))
    torque = _rows(-(springs.stiffness * strain) @ along[:, :m])
    return {"stiffness": stiffness, "damping": damping, "torque": torque}
