"""A tree compiled in relative coordinates: joint angles, lengths and balls' orientations in place of six a body."""

from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, Self

import numpy as np

from mbs_ref.cores.joint_graph import graph_of
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.planar import PlanarSystem
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.cores.system import Poses, System
from mbs_ref.kernels.border.groups import empty, floats, ints
from mbs_ref.kernels.relative import model as arrays
from mbs_ref.kernels.relative.events import expand_over, take_velocities_over
from mbs_ref.scene import PlanarBody, PointMass, Prismatic, Revolute, Scene, Spherical, Weld
from mbs_ref.scene.base.part import dot, unit
from mbs_ref.scene.euler_parameters import conjugate, product
from mbs_ref.scene.scales import Scales
from mbs_ref.scene.scene import of_last_scene
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


@of_last_scene
def layout_of(scene: Scene) -> "Layout":
    """Return the layout of a tree; ValueError lists why a scene is none."""
    reasons = list(no_tree(scene))
    if reasons:
        raise ValueError(f"coordinates = 'relative' needs a tree of known joints: {'; '.join(reasons[:8])}")
    return Layout(scene)


class Layout:
    """Where each body's joint has its coordinates q and rates u in the state [q, u]."""

    def __init__(self, scene: Scene) -> None:
        _, graph = graph_of(scene)
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
            kind=ints(self.kind), parent=ints(self.parent), q=ints(self.q[:-1].tolist()),
            v=ints(self.v[:-1].tolist()), freedoms=ints(self.freedoms), arm=arms[0], arm_of_parent=arms[1], axis=axis,
            offset=offset,
        )  # fmt: skip

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


UNTURNED = (arrays.FREE, arrays.SPHERICAL, arrays.HELD)  # bodies that their parent does not turn


def _at_full(name: str) -> Any:
    """Return the method of a relative system that calls the redundant one's of this name at its own state."""
    return lambda self, t, y, *given: getattr(self.redundant, name)(t, self.full(y), *given)


def _over_full(name: str) -> Any:
    """Return the same of a method of many times and states."""
    return lambda self, times, states: getattr(self.redundant, name)(times, self.all_full(states))


def _of_redundant(name: str) -> Any:
    """Return the method of a relative system that calls the redundant one's of this name."""
    return lambda self, *given: getattr(self.redundant, name)(*given)


class RelativeSystem(System):
    """A tree of revolute, prismatic, ball and weld joints and free bodies; `redundant` knows all the rest of it.

    State y = [q, u], joint after joint in elimination order (mbs_ref.kernels.relative). Raises ValueError where the
    scene is no such tree.
    """

    REDUNDANT: ClassVar[type[PlanarSystem] | type[SpatialSystem]]

    def __init__(self, scene: Scene, redundant: JointedSystem | None = None) -> None:
        self.scene = scene
        self.layout = layout_of(scene)
        self._redundant: JointedSystem = redundant or self.REDUNDANT(scene)
        self._allocate(self.layout.arrays(self.redundant, *self._frames()))

    def _allocate(self, joints: arrays.Joints) -> None:
        """Make the handles of the redundant system known, and room for a run."""
        inner = np.array([self.redundant.model.address, self.redundant.work.address], dtype=np.int64)
        self.groups = arrays.RelativeGroups(joints, arrays.Redundant(inner))
        self.scratch = self._empty_scratch()

    @property
    def redundant(self) -> JointedSystem:
        return self._redundant

    def _empty_scratch(self) -> arrays.RelativeScratch:
        n, rates = len(self.layout.kind), self.redundant.RATES
        lengths = {"n": n, "n + 1": n + 1, "rates": rates, "d": self.scene.dimension}
        links = empty(arrays.Links, **lengths)
        links.turns[:] = [kind not in UNTURNED for kind in self.layout.kind]
        full = empty(arrays.Full, n_state=len(self.redundant.initial_state()))
        return arrays.RelativeScratch(links, empty(arrays.Recursion, **lengths), full)

    def twin(self) -> Self:
        other = self._unconnected()
        other._redundant = self.redundant.twin()
        other._allocate(self.groups.joints)
        return other

    @abstractmethod
    def _frames(self) -> tuple[np.ndarray, np.ndarray]:
        """Return each body's orientation in its parent at t = 0, and the joints' axes as `Joints` has them."""

    @abstractmethod
    def _places(self, full: np.ndarray) -> Any:
        """Return the bodies' poses at redundant states (m, n_full), as `_coordinate` reads them."""

    @abstractmethod
    def _coordinate(self, i: int, places: Any) -> np.ndarray:
        """Return a joint's coordinates (m, ...) at such poses."""

    def full(self, y: np.ndarray) -> np.ndarray:
        """Return the redundant state of y."""
        return self.all_full(y[None])[0]

    def initial_state(self) -> np.ndarray:
        return self.reduced(self.redundant.initial_state())

    @property
    def n_positions(self) -> int:
        return self.layout.n_positions

    @classmethod
    def state_units(cls, scene: Scene, scales: Scales) -> np.ndarray:  # type: ignore[override]
        """Return L for lengths, 1 for angles and Euler parameters, and the same over T (n_state,)."""
        return layout_of(scene).units(scales.length, scales.time)

    def poses(self, states: np.ndarray) -> Poses:
        return self.redundant.poses(self.all_full(states))

    def states_of(self, poses: Poses) -> np.ndarray:
        return self.all_reduced(self.redundant.states_of(poses))

    def all_reduced(self, full: np.ndarray) -> np.ndarray:
        """Return the states of redundant ones that keep the joints."""
        y, places = np.zeros((len(full), self.layout.n_state)), self._places(full)
        for i, first in enumerate(self.layout.q[:-1]):
            found = self._coordinate(i, places)
            y[:, first : first + found.shape[1]] = found
        take_velocities_over(*self.own_handles, np.ascontiguousarray(full), y)
        return y

    def all_full(self, states: np.ndarray) -> np.ndarray:
        """Return the redundant states (n, n_full) of states (n, n_state)."""
        full = np.empty((len(states), len(self.scratch.full.state)))
        expand_over(*self.own_handles, np.ascontiguousarray(states), full)
        return full

    # each as the redundant system has it, at its own state
    residuals, accelerations, start_contacts, contact_oscillators = map(
        _at_full, ("residuals", "accelerations", "start_contacts", "contact_oscillators")
    )
    reactions_over, contact_forces = _over_full("reactions_over"), _over_full("contact_forces")

    # and in any state; of a Baumgarte gain only the redundant one's reactions depend, as nothing drifts here
    set_mode_time, recall_modes, spread_events = map(_of_redundant, ("set_mode_time", "recall_modes", "spread_events"))
    set_baumgarte, taut_strings, contact_events = map(
        _of_redundant, ("set_baumgarte", "taut_strings", "contact_events")
    )
    event_sources = property(lambda self: self.redundant.event_sources)


class RelativePlanarSystem(RelativeSystem):
    """A planar tree."""

    CORE, REDUNDANT = "relative_planar", PlanarSystem

    @property
    def keeps_itself(self) -> bool:
        """In the plane no coordinates of a tree depend on each other."""
        return True

    def _frames(self) -> tuple[np.ndarray, np.ndarray]:
        angles = np.array([body.angle if isinstance(body, PlanarBody) else 0.0 for body in self.scene.bodies])
        own = np.append(angles[self.layout.order], 0.0)
        parents = self.redundant.groups.bodies.parent
        axes = np.zeros((len(parents), 2))
        for i, parent in enumerate(parents):
            c, s = np.cos(own[parent]), np.sin(own[parent])
            axes[i] = np.array([[c, s], [-s, c]]) @ self.layout.world_axis(i)
        return (own[:-1] - own[parents])[:, None], axes

    def _places(self, full: np.ndarray) -> np.ndarray:
        """Return places and angles (n, 3, m) in the scene's order."""
        n = len(self.layout.kind)
        return full[:, : 3 * n].T.reshape(n, 3, len(full))

    def _coordinate(self, i: int, places: np.ndarray) -> np.ndarray:
        kind, joints, n, q = self.layout.kind[i], self.groups.joints, len(self.layout.kind), places
        own, parent = q[self.layout.order[i]], int(joints.parent[i])
        if kind == arrays.FREE:
            return own[: self.layout.freedoms[i]].T
        there = q[self.layout.order[parent]] if parent < n else np.zeros_like(own)
        if kind == arrays.REVOLUTE:
            return (own[2] - there[2] - joints.offset[i, 0])[:, None]
        if kind == arrays.PRISMATIC:
            gap = own[:2] - there[:2] + _turned(own[2], joints.arm[i]) - _turned(there[2], joints.arm_of_parent[i])
            axis = _turned(there[2], joints.axis[i])
            return (gap[0] * axis[0] + gap[1] * axis[1])[:, None]
        return own[:0].T


def _turned(angle: Any, arm: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])


class RelativeSpatialSystem(RelativeSystem):
    """A spatial tree."""

    CORE, REDUNDANT = "relative_spatial", SpatialSystem

    def _places(self, full: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return places (n + 1, m, 3) and Euler parameters (n + 1, m, 4) in elimination order, ground last."""
        poses, order, m = self.redundant.poses(full), self.layout.order, len(full)
        place = np.concatenate((poses.position[:, order], np.zeros((m, 1, 3))), axis=1)
        theta = np.concatenate((poses.orientation[:, order], np.tile([1.0, 0.0, 0.0, 0.0], (m, 1, 1))), axis=1)
        return place.swapaxes(0, 1), theta.swapaxes(0, 1)

    def _frames(self) -> tuple[np.ndarray, np.ndarray]:
        theta = self._places(self.redundant.initial_state()[None])[1][:, 0]
        parents = self.redundant.groups.bodies.parent
        offset = product(conjugate(theta[parents]), theta[:-1])
        axes = np.zeros((len(parents), 3))
        for i, parent in enumerate(parents):
            holder = parent if self.layout.kind[i] == arrays.PRISMATIC else i
            axes[i] = _rotated(conjugate(theta[holder]), self.layout.world_axis(i))
        return offset, axes

    def _coordinate(self, i: int, places: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        kind, joints = self.layout.kind[i], self.groups.joints
        place, theta = places
        parent = int(joints.parent[i])
        if kind == arrays.FREE:
            return place[i] if self.layout.freedoms[i] == 3 else np.concatenate((place[i], theta[i]), axis=1)
        if kind == arrays.SPHERICAL:
            return theta[i]
        if kind == arrays.REVOLUTE:
            turn = product(conjugate(product(theta[parent], joints.offset[i])), theta[i])
            return 2.0 * np.arctan2(dot(turn[:, 1:], joints.axis[i]), turn[:, 0])[:, None]
        if kind == arrays.PRISMATIC:
            reach = _rotated(theta[parent], joints.arm_of_parent[i]) - _rotated(theta[i], joints.arm[i])
            return dot(place[i] - place[parent] - reach, _rotated(theta[parent], joints.axis[i]))[:, None]
        return np.zeros((len(place[i]), 0))


def _rotated(theta: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return a vector turned by Euler parameters."""
    return product(product(theta, np.append(0.0, vector)), conjugate(theta))[..., 1:]
