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
from mbs_ref.kernels.border.groups import empty, ints
from mbs_ref.kernels.relative import model as arrays
from mbs_ref.kernels.relative.events import expand_over, take_velocities_over
from mbs_ref.scene import PointMass, Prismatic, Revolute, Scene, Spherical, Weld
from mbs_ref.scene.base.part import dot, unit
from mbs_ref.scene.euler_parameters import conjugate, product
from mbs_ref.scene.scales import Scales
from mbs_ref.scene.scene import of_last_scene
from mbs_ref.scene.traits import deflecting, joined

KINDS = {  # kind, coordinates and rates of a joint between rigid bodies
    Revolute: (arrays.REVOLUTE, 1, 1), Prismatic: (arrays.PRISMATIC, 1, 1), Weld: (arrays.WELD, 0, 0),
    Spherical: (arrays.SPHERICAL, 4, 3),
}  # fmt: skip
TURNED = (arrays.REVOLUTE, arrays.PRISMATIC, arrays.WELD)  # the parent turns the body
SIDES = ("body_a", "body_b")


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
    if len(scene.joints) == len(scene.bodies) and all(isinstance(joint, Weld) for joint in scene.joints):
        yield "every body is welded to ground, which leaves no coordinates"


@of_last_scene
def layout_of(scene: Scene) -> "Layout":
    """Return the layout of a tree; ValueError lists why a scene is none."""
    reasons = list(no_tree(scene))
    if reasons:
        raise ValueError(f"coordinates = 'relative' needs a tree of known joints: {'; '.join(reasons[:8])}")
    return Layout(scene)


def _kind(joint: type, is_point: bool, dimension: int) -> tuple[int, int, int]:
    """Return the kind of a joint of a body, which may be a point, and how many coordinates and rates it has."""
    if is_point and joint in (Revolute, Spherical):
        return arrays.HELD, 0, 0
    free = (dimension, dimension) if is_point else {2: (3, 3), 3: (7, 6)}[dimension]
    return KINDS.get(joint, (arrays.FREE, *free))


class Layout:
    """Where each body's joint has its coordinates q and rates u in the state [q, u]; bodies in elimination order."""

    def __init__(self, scene: Scene) -> None:
        _, graph = graph_of(scene)
        self.scene, self.order, self.parent = scene, ints(graph.order), ints(graph.parent)
        self.joints: list[Any] = [edge and scene.joints[edge.joints[0]] for edge in graph.tree_edge]
        bodies, n = [scene.bodies[k] for k in graph.order], len(graph.order)
        pairs = zip(self.joints, bodies, strict=True)
        kinds = [_kind(type(joint), isinstance(body, PointMass), scene.dimension) for joint, body in pairs]
        self.kind, self.widths, self.freedoms = np.array(kinds, dtype=np.int64).T.copy()
        first = np.concatenate(([0], self.widths, self.freedoms)).cumsum()
        self.q, self.v = first[: n + 1], first[n:]
        self.n_positions, self.n_state = int(self.q[-1]), int(self.v[-1])
        self.alike = {  # places of the joints of each kind and number of coordinates
            one[:2]: np.flatnonzero([other == one for other in kinds]) for one in sorted({*kinds}) if one[1]
        }

    def arrays(self, system: JointedSystem, offset: np.ndarray, axis: np.ndarray) -> arrays.Joints:
        """Return the joints' arrays, their orientations at t = 0 (n, 1 or 4) and axes (n, dimension) given."""
        arms, jointed = np.zeros((2, len(self.order), self.scene.dimension)), np.flatnonzero(self.kind != arrays.FREE)
        joints = [self.joints[i] for i in jointed]
        other = [j.body_a != self.scene.bodies[k].name for j, k in zip(joints, self.order[jointed], strict=True)]
        ends = [SIDES[side ^ is_other] for side in range(2) for is_other in other]
        arms[:, jointed] = system.builder.arms(2 * joints, ends).reshape(2, len(joints), self.scene.dimension)
        return arrays.Joints(
            kind=self.kind, parent=self.parent, q=self.q[:-1], v=self.v[:-1], freedoms=self.freedoms, arm=arms[0],
            arm_of_parent=arms[1], axis=axis, offset=offset,
        )  # fmt: skip

    def world_axes(self) -> np.ndarray:
        """Return the world directions (n, dimension) of the joints' axes at t = 0; zero where there is none."""
        axes, none = [joint and vars(joint).get("axis") for joint in self.joints], np.zeros(self.scene.dimension)
        return np.array([none if axis is None else unit(axis) for axis in axes])

    def units(self, length: float, time: float) -> np.ndarray:
        """Return what each entry of the state counts in: a length, one, and the same over the time."""
        result, lengths = np.ones(self.n_state), {arrays.FREE: self.scene.dimension, arrays.PRISMATIC: 1}
        for (kind, _), i in self.alike.items():
            for c in range(lengths.get(kind, 0)):
                result[self.q[i] + c] = result[self.v[i] + c] = length
        result[self.n_positions :] /= time
        return result


def _at_full(name: str) -> Any:
    """Return the method of a relative system that calls the redundant one's of this name at its own state or states."""
    return lambda self, t, y, *given: getattr(self.redundant, name)(t, self.full(y), *given)


def _of_redundant(name: str) -> Any:
    """Return the method of a relative system that calls the redundant one's of this name."""
    return lambda self, *given: getattr(self.redundant, name)(*given)


class RelativeSystem(System):
    """A tree of revolute, prismatic, ball and weld joints and free bodies; `redundant` knows all the rest of it.

    State y = [q, u], joint after joint in elimination order (mbs_ref.kernels.relative). Raises ValueError where the
    scene is no such tree.
    """

    changed = ("redundant",)
    REDUNDANT: ClassVar[type[PlanarSystem] | type[SpatialSystem]]
    GROUND: ClassVar[Any]  # its orientation

    def __init__(self, scene: Scene, redundant: JointedSystem | None = None) -> None:
        self.scene = scene
        self.layout = layout_of(scene)
        self._redundant: JointedSystem = redundant or self.REDUNDANT(scene)
        joints = self.layout.arrays(self.redundant, *self._frames())
        self._set_arrays(arrays.RelativeGroups(joints, arrays.Redundant(self._addresses())))

    def _addresses(self) -> np.ndarray:
        return np.array([self.redundant.model.address, self.redundant.work.address], dtype=np.int64)

    @property
    def redundant(self) -> JointedSystem:
        return self._redundant

    def _new_scratch(self) -> arrays.RelativeScratch:
        n, rates = len(self.layout.kind), self.redundant.RATES
        lengths = {"n": n, "n + 1": n + 1, "rates": rates, "d": self.scene.dimension}
        links = empty(arrays.Links, **lengths)
        links.turns[:] = [kind in TURNED for kind in self.layout.kind]
        full = empty(arrays.Full, n_state=len(self.redundant.scratch.solved.state))
        return arrays.RelativeScratch(links, empty(arrays.Recursion, **lengths), full)

    def twin(self) -> Self:
        other = super().twin()
        other._redundant = self.redundant.twin()
        other.groups.redundant.address[:] = other._addresses()
        return other

    @staticmethod
    @abstractmethod
    def _from(first: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """Return orientations as seen from others."""

    @abstractmethod
    def _angles(self, i: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """Return the angles (k, m) of revolute joints at their bodies' orientations (k, m, ...) as parents see them."""

    def _turns(self, full: np.ndarray) -> np.ndarray:
        """Return orientations (n + 1, m, ...) at redundant states (m, n_full), in elimination order, ground last."""
        ground = np.full((len(full), 1, *np.shape(self.GROUND)), self.GROUND)
        own = self.redundant.orientations(full)[:, self.layout.order]
        return np.concatenate((own, ground), axis=1).swapaxes(0, 1)

    def _places(self, full: np.ndarray) -> np.ndarray:
        """Return places (n + 1, m, dimension) as `_turns` returns orientations, m."""
        own = self.redundant.poses(full).position[:, self.layout.order]
        return np.concatenate((own, np.zeros((len(full), 1, self.scene.dimension))), axis=1).swapaxes(0, 1)

    def _frames(self) -> tuple[np.ndarray, np.ndarray]:
        """Return each body's orientation in its parent at t = 0, and the joints' axes as `Joints` has them."""
        turn, parents = self._turns(self.redundant.initial_state()[None])[:, 0], self.layout.parent
        kept = np.where(self.layout.kind == arrays.PRISMATIC, parents, np.arange(len(parents)))
        axes = self.REDUNDANT.turned(self._from(turn[kept], self.GROUND), self.layout.world_axes())
        return self._from(turn[parents], turn[:-1]).reshape(len(parents), -1), axes

    def _coordinates(self, kind: int, i: np.ndarray, full: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """Return the coordinates (k, m, ...) of k joints of a kind; of free particles, with orientations behind."""
        joints, turned = self.groups.joints, self.REDUNDANT.turned
        parent = joints.parent[i]
        if kind == arrays.SPHERICAL:
            return turn[i]
        if kind == arrays.REVOLUTE:
            return self._angles(i, self._from(turn[parent], turn[i]))[:, :, None]
        place = self._places(full)
        if kind == arrays.FREE:
            return np.concatenate((place[i], turn[i].reshape(*turn[i].shape[:2], -1)), axis=2)
        own, of_parent, axis = (arms[i, None] for arms in (joints.arm, joints.arm_of_parent, joints.axis))
        reach = turned(turn[parent], of_parent) - turned(turn[i], own)
        return dot(place[i] - place[parent] - reach, turned(turn[parent], axis))[:, :, None]

    def full(self, y: np.ndarray) -> np.ndarray:
        """Return the redundant state of y, or those of many (n, n_state)."""
        return self.all_full(y[None])[0] if y.ndim == 1 else self.all_full(y)

    def initial_state(self) -> np.ndarray:
        return self.reduced(self.redundant.initial_state())

    @property
    def n_positions(self) -> int:
        return self.layout.n_positions

    @classmethod
    def state_units(cls, scene: Scene, scales: Scales) -> np.ndarray:  # type: ignore[override]
        return layout_of(scene).units(scales.length, scales.time)

    def poses(self, states: np.ndarray) -> Poses:
        return self.redundant.poses(self.all_full(states))

    def states_of(self, poses: Poses) -> np.ndarray:
        return self.all_reduced(self.redundant.states_of(poses))

    def all_reduced(self, full: np.ndarray) -> np.ndarray:
        y, turn = np.zeros((len(full), self.layout.n_state)), self._turns(full)
        for (kind, width), i in self.layout.alike.items():
            found = self._coordinates(kind, i, full, turn)
            for c in range(width):
                y[:, self.layout.q[i] + c] = found[:, :, c].T
        take_velocities_over(*self.own_handles, np.ascontiguousarray(full), y)
        return y

    def all_full(self, states: np.ndarray) -> np.ndarray:
        """Return the redundant states (n, n_full) of states (n, n_state)."""
        full = np.empty((len(states), len(self.scratch.full.state)))
        expand_over(*self.own_handles, np.ascontiguousarray(states), full)
        return full

    # each as the redundant system has it, at its own state
    residuals, accelerations, start_contacts = map(_at_full, ("residuals", "accelerations", "start_contacts"))
    contact_oscillators, reactions_over = _at_full("contact_oscillators"), _at_full("reactions_over")
    contact_forces = _at_full("contact_forces")

    # and in any state; of a Baumgarte gain only the redundant one's reactions depend, as nothing drifts here
    set_mode_time, recall_modes, spread_events = map(_of_redundant, ("set_mode_time", "recall_modes", "spread_events"))
    set_baumgarte, taut_strings, contact_events = map(
        _of_redundant, ("set_baumgarte", "taut_strings", "contact_events")
    )
    event_sources = property(lambda self: self.redundant.event_sources)


class RelativePlanarSystem(RelativeSystem):
    """A planar tree."""

    CORE, REDUNDANT, GROUND = "relative_planar", PlanarSystem, 0.0
    keeps_itself = True  # in the plane no coordinates of a tree depend on each other

    @staticmethod
    def _from(first: np.ndarray, turn: np.ndarray) -> np.ndarray:
        return turn - first

    def _angles(self, i: np.ndarray, turn: np.ndarray) -> np.ndarray:
        return turn - self.groups.joints.offset[i]


class RelativeSpatialSystem(RelativeSystem):
    """A spatial tree."""

    CORE, REDUNDANT, GROUND = "relative_spatial", SpatialSystem, (1.0, 0.0, 0.0, 0.0)

    @staticmethod
    def _from(first: np.ndarray, turn: np.ndarray) -> np.ndarray:
        return product(conjugate(first), turn)

    def _angles(self, i: np.ndarray, turn: np.ndarray) -> np.ndarray:
        turned = product(conjugate(self.groups.joints.offset[i, None]), turn)
        return 2.0 * np.arctan2(dot(turned[..., 1:], self.groups.joints.axis[i, None]), turned[..., 0])
