"""Scene -> the joints of a tree in relative coordinates: which there are, and where each has its coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from mbs_ref.cores.joint_graph import joint_rows, layout
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.kernels.border.groups import floats, ints
from mbs_ref.kernels.relative import model as arrays
from mbs_ref.scene import PointMass, Prismatic, Revolute, Scene, Spherical, Weld
from mbs_ref.scene.base.directions import unit
from mbs_ref.scene.traits import deflecting, joined

KINDS = {
    Revolute: arrays.REVOLUTE, Prismatic: arrays.PRISMATIC, Weld: arrays.WELD, Spherical: arrays.SPHERICAL,
}  # fmt: skip
FREEDOMS = {arrays.REVOLUTE: 1, arrays.PRISMATIC: 1, arrays.WELD: 0, arrays.SPHERICAL: 3, arrays.HELD: 0}
PARAMETERS = 4  # of an orientation in space, in place of three angles


def no_tree(scene: Scene) -> Iterator[str]:
    """Yield why a scene is no tree of the joints that relative coordinates know."""
    for joint in scene.joints:
        if type(joint) not in KINDS:
            yield f"joint {joint.name!r} is a {joint.type}; allowed: {', '.join(k.__name__.lower() for k in KINDS)}"
        elif getattr(joint, "point_b", None) is not None:
            yield f"joint {joint.name!r} starts open (point_b)"
    if deflecting(scene):
        yield f"contacts {', '.join(deflecting(scene)[:4])} stick in space, and their deflections are states"
    if any(contact.holds for contact in scene.contacts):
        yield "a contact stands for a constraint, which closes a loop"
    for k in joined(scene)[0]:
        yield f"joint {scene.joints[k].name!r} closes a loop"


def layout_of(scene: Scene) -> Layout:
    """Return the layout of a tree; ValueError says all that keeps the scene from being one."""
    reasons = list(no_tree(scene))
    if reasons:
        raise ValueError(f"coordinates = 'relative' needs a tree of known joints: {'; '.join(reasons[:8])}")
    return Layout(scene)


class Layout:
    """Where each body's joint has its coordinates q and rates u in the state [q, u]."""

    def __init__(self, scene: Scene) -> None:
        graph = layout(scene, joint_rows(scene))
        self.scene, self.order, self.parent = scene, graph.order, graph.parent
        self.joint = {i: edge.joints[0] for i, edge in enumerate(graph.tree_edge) if edge}  # by elimination number
        self.kind = [self._kind(i) for i in range(len(self.order))]
        self.freedoms = [self._freedoms(i) for i in range(len(self.order))]
        widths = [self.freedoms[i] + self._surplus(i) for i in range(len(self.order))]
        self.q = np.concatenate(([0], np.cumsum(widths))).astype(int)
        self.v = self.q[-1] + np.concatenate(([0], np.cumsum(self.freedoms))).astype(int)
        self.n_positions, self.n_state = int(self.q[-1]), int(self.v[-1])

    def body(self, i: int) -> Any:
        return self.scene.bodies[self.order[i]]

    def _kind(self, i: int) -> int:
        if i not in self.joint:
            return arrays.FREE
        joint = self.scene.joints[self.joint[i]]
        shares_point = isinstance(joint, Revolute | Spherical)
        return arrays.HELD if shares_point and isinstance(self.body(i), PointMass) else KINDS[type(joint)]  # type: ignore[index]

    def _freedoms(self, i: int) -> int:
        if self.kind[i] != arrays.FREE:
            return FREEDOMS[self.kind[i]]
        return self.scene.dimension if isinstance(self.body(i), PointMass) else 3 * self.scene.dimension - 3

    def _surplus(self, i: int) -> int:
        """Return how many coordinates more than rates a body's joint has: one where Euler parameters are."""
        return int(self.kind[i] == arrays.SPHERICAL or self.freedoms[i] == 6)

    def ends(self, i: int) -> tuple[str, str]:
        """Return the fields of the joint that name the body and its parent."""
        joint: Any = self.scene.joints[self.joint[i]]
        return ("body_a", "body_b") if joint.body_a == self.body(i).name else ("body_b", "body_a")

    def arrays(self, system: JointedSystem, offset: np.ndarray, axis: np.ndarray) -> arrays.Joints:
        """Return the joints' arrays, their orientations at t = 0 (n, 1 or 4) and axes (n, dimension) given."""
        arms = np.zeros((2, len(self.order), self.scene.dimension))
        for i, k in self.joint.items():
            for side, end in enumerate(self.ends(i)):
                arms[side, i] = system.arm_of(self.scene.joints[k], end)
        return arrays.Joints(
            kind=ints(self.kind),
            parent=ints(self.parent),
            q=ints(self.q[:-1].tolist()),
            v=ints(self.v[:-1].tolist()),
            freedoms=ints(self.freedoms),
            arm=arms[0],
            arm_of_parent=arms[1],
            axis=axis,
            offset=offset,
        )

    def world_axis(self, i: int) -> np.ndarray:
        """Return the world direction of a joint's axis at t = 0; zero where it has none."""
        axis = getattr(self.scene.joints[self.joint[i]], "axis", None) if i in self.joint else None
        return np.zeros(self.scene.dimension) if axis is None else unit(axis)

    def units(self, length: float, time: float) -> np.ndarray:
        """Return what each entry of the state counts in: a length, one, and the same over the time."""
        q, u = [], []
        for i, kind in enumerate(self.kind):
            lengths = {arrays.FREE: self.scene.dimension, arrays.PRISMATIC: 1}.get(kind, 0)
            rest = self.freedoms[i] - lengths
            q += lengths * [length] + (PARAMETERS if rest and self._surplus(i) else rest) * [1.0]
            u += lengths * [length] + rest * [1.0]
        return np.concatenate((floats(q), floats(u) / time))
