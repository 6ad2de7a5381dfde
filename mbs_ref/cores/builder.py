"""What the planar and the spatial build share: places of bodies, rows and signals while a scene is compiled."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.cores.contact_shapes import contact_balls, contact_pairs, granules
from mbs_ref.cores.events import contact_laws, contact_modes, springs, watches
from mbs_ref.cores.joint_graph import Edge, graph_of, row_count
from mbs_ref.cores.loops import Closure, loops_of_closures
from mbs_ref.kernels.border.groups import declared, empty, floats, ints, members
from mbs_ref.kernels.rigid.model import Bodies, Forces, Loops, Slots, TorsionSprings, World
from mbs_ref.kernels.signals import SignalArrays
from mbs_ref.scene import GROUND, Force, PointMass, Scene, SpatialBody, Torque, TorqueVector, TorsionSpring
from mbs_ref.scene.base.rows import Row
from mbs_ref.scene.contact import Contact
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.joints import Drive
from mbs_ref.scene.signals import DEGREE, Segment, motion_segments


class Place(NamedTuple):
    """Where a joint's rows are."""

    slot: int
    row: int
    side: int  # of its first end
    n_rows: int


class PlacedRow(NamedTuple):
    """An elementary row, where it is and whose."""

    row: Any  # one of mbs_ref.scene.base.rows
    joint: Any
    a: str
    b: str
    at: Place


class Builder(ABC):
    """Bodies' places and axes at t = 0, and slots of a scene's joints; `signal` collects the functions of time."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.joint_rows, self.layout = graph_of(scene)
        self.n = len(scene.bodies)
        self.axes = {body.name: _axes(body) for body in scene.bodies}
        self.centre = {body.name: np.array(body.position) for body in scene.bodies}
        self.scene_index = {body.name: k for k, body in enumerate(scene.bodies)} | {GROUND: -1}
        self.number = {body: k for k, body in enumerate(self.layout.order)} | {-1: self.n}
        self.segments: list[list[Segment]] = []
        self.place: dict[int, Place] = {}  # by the joint's index
        self.slot_bodies: list[tuple[int, int]] = []
        self.slot_rows: list[int] = []
        for child, edge in enumerate(self.layout.tree_edge):
            self._add_slot(edge, child, self.layout.parent[child])
        for edge in self.layout.closures:
            self._add_slot(edge, self.number[edge.a], self.number[edge.b])
        held = [k for k, contact in enumerate(scene.contacts) if contact.holds]
        self.contact_slot = {k: self._add_contact(scene.contacts[k]) for k in held}
        self.rows = [row for k in sorted(self.place) for row in self._placed_rows(k)]

    def _add_slot(self, edge: Edge | None, side0: int, side1: int) -> None:
        slot, row = len(self.slot_bodies), 0
        self.slot_bodies.append((side0, side1))
        for k in edge.joints if edge else []:
            side, count = int(self.body(self.scene.joints[k].ends[0]) != side0), row_count(self.joint_rows[k])
            self.place[k] = Place(slot, row, side, count)
            row += count
        self.slot_rows.append(row)

    def _add_contact(self, contact: Contact) -> int:
        """Give a constraint contact a slot of one row, as if it closed a loop."""
        self.slot_bodies.append((self.body(contact.body_a), self.body(contact.body_b)))
        self.slot_rows.append(1)
        return len(self.slot_rows) - 1

    def _placed_rows(self, k: int) -> list[PlacedRow]:
        joint, at = self.scene.joints[k], self.place[k]
        result = []
        for row in self.joint_rows[k]:
            result.append(PlacedRow(row, joint, *joint.ends, at._replace(n_rows=row.count)))
            at = at._replace(row=at.row + row.count)
        return result

    def loops(self) -> Loops:
        """Return the closures of loops: the slots beyond the tree's that have rows."""
        slots = [k for k in range(self.n, len(self.slot_rows)) if self.slot_rows[k]]
        closures = [Closure(k, self.slot_bodies[k], self.slot_rows[k]) for k in slots]
        return loops_of_closures(self.layout.parent, closures)

    def body(self, name: str) -> int:
        """Return a body's elimination number; that of ground is the number of bodies."""
        return self.number[self.scene_index[name]]

    def point(self, name: str, world: Any) -> np.ndarray:
        """Return a world point at t = 0 in the axes of a body of this name, or of ground."""
        return np.array(world, float) if name == GROUND else self.direction(name, np.array(world) - self.centre[name])

    def direction(self, name: str, world: Any) -> np.ndarray:
        """Return a world direction at t = 0 in the axes of a body of this name, or of ground."""
        return np.array(world, dtype=float) if name == GROUND else self.axes[name].T @ world

    @abstractmethod
    def groups(self) -> Any:
        """Return the arrays of the scene."""

    def angle(self, name: str) -> float:
        """Return a planar body's angle at t = 0, rad; 0 of what has none."""
        return 0.0 if name == GROUND else getattr(self.scene.bodies[self.scene_index[name]], "angle", 0.0)

    def signal(self, segments: list[Segment]) -> int:
        self.segments.append(segments)
        return len(self.segments) - 1

    def motion(self, drive: Drive) -> int:
        """Return the signal of what a drive prescribes."""
        return self.signal(motion_segments(drive.motion, drive.level))


def _axes(body: Any) -> np.ndarray:
    """Return a body's axes (dimension, dimension) as columns, world, at t = 0."""
    if isinstance(body, SpatialBody):
        return rotation_matrices(body.orientation)
    angle = getattr(body, "angle", 0.0)
    c, s = math.cos(angle), math.sin(angle)
    return np.eye(3) if len(body.position) == 3 else np.array([[c, -s], [s, c]])


def ends(build: Builder, loads: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the bodies a and b of loads between two."""
    return ints([build.body(x.body_a) for x in loads]), ints([build.body(x.body_b) for x in loads])


def forces(build: Builder) -> Forces:
    """Return the forces and torques, each a vector times a signal, along body axes where they turn with the body."""
    d = build.scene.dimension
    loads = [x for x in build.scene.loads if isinstance(x, Force | Torque | TorqueVector)]
    follows = [getattr(x, "frame", "world") == "body" for x in loads]
    vectors = [x.torque if isinstance(x, Torque) else build.direction(x.body, x.vector) if turns else np.array(x.vector)
               for x, turns in zip(loads, follows, strict=True)]  # fmt: skip
    pairs, no_turn = list(zip(loads, vectors, strict=True)), np.zeros(d * (d - 1) // 2)
    return Forces(
        body=ints([build.body(x.body) for x in loads]),
        point=floats([build.point(x.body, x.point) if isinstance(x, Force) else np.zeros(d) for x in loads], d),
        force=floats([v if isinstance(x, Force) else np.zeros(d) for x, v in pairs], d),
        torque=floats([no_turn if isinstance(x, Force) else np.atleast_1d(v) for x, v in pairs], len(no_turn)),
        follows=ints(follows),
        signal=ints([build.signal(x.factor.segments()) for x in loads]),
    )


def torsion_springs(build: Builder, rest: Callable[[TorsionSpring], float], **marks: np.ndarray) -> TorsionSprings:
    """Return the torsion springs; `marks` are where their angle is read in space."""
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    a, b = ends(build, loads)
    return empty(TorsionSprings, k=len(loads))._replace(
        a=a, b=b, stiffness=floats(x.stiffness for x in loads), damping=floats(x.damping for x in loads),
        rest_angle=floats(map(rest, loads)), **marks,
    )  # fmt: skip


def row_groups(build: Builder, groups: type) -> dict[str, Any]:
    """Return the arrays of each kind of row that a core's groups have, by the name of the group."""
    hints = members(groups)
    kinds = [kind for kind in Row.__subclasses__() if kind.GROUP in hints]
    return {kind.GROUP: _row_group(build, kind, hints[kind.GROUP]) for kind in kinds}


def _row_group(build: Builder, kind: type[Row], group: Any) -> Any:
    """Return the arrays of one kind of row: where each is, its numbers, and the signal of a prescribed one."""
    rows = [placed for placed in build.rows if isinstance(placed.row, kind)]
    numbers = [r.row.numbers(build, r.a, r.b) for r in rows]
    own = list(declared(group).items())[3:]
    d = build.scene.dimension  # for which any word stands
    columns = {
        name: np.array([n[k] for n in numbers], dtype=float).reshape(
            len(rows), *(n if isinstance(n, int) else d for n in array.shape[1:])
        )
        for k, (name, array) in enumerate(own)
        if name != "signal"
    }
    if "signal" in group._fields:
        columns["signal"] = ints([build.motion(r.joint) for r in rows])
    side = [r.at.side if "side_a" in group._fields else 1 - r.at.side for r in rows]  # a drive's first end is ground
    return group(ints([r.at.slot for r in rows]), ints([r.at.row for r in rows]), ints(side), **columns)


def assembled(build: Builder, groups: Any, widths: np.ndarray, inertia: np.ndarray, **own: Any) -> Any:
    """Return a scene's groups: those of every core, and a core's `own`.

    `widths` (2, n_bodies) are how many coordinates and rates each body has in the state, and `inertia`
    (n_bodies, moments) what turns it, both in scene order.
    """
    scene, order = build.scene, build.layout.order
    first = np.concatenate(([0], np.cumsum(widths)))  # rates follow all coordinates
    held = {end for sides, rows in zip(build.slot_bodies, build.slot_rows, strict=True) if rows for end in sides}
    bodies = Bodies(
        mass=floats(scene.bodies[i].mass for i in order), inertia=inertia[order].astype(float),
        rigid=ints([not isinstance(scene.bodies[i], PointMass) for i in order]),
        alone=ints([k not in held for k in range(build.n)]), scene_index=ints(order), q=ints(first[order].tolist()),
        v=ints(first[build.n + np.array(order, dtype=int)].tolist()), start=ints([int(first[build.n])]),
        parent=ints(build.layout.parent),
    )  # fmt: skip
    pairs = contact_pairs(scene, build)
    every = groups(
        bodies=bodies, slots=Slots(np.array(build.slot_bodies, dtype=np.int64).reshape(-1, 2), ints(build.slot_rows)),
        loops=build.loops(), **row_groups(build, groups), springs=springs(scene, build), contact_pairs=pairs,
        contact_laws=contact_laws(scene, build.contact_slot), contact_modes=contact_modes(scene),
        near_pairs=contact_balls(pairs), granules=granules(scene, build), watches=watches(scene, build),
        signals=signal_arrays(build.segments),
        world=World(np.array(scene.gravity, dtype=float), ints([0]), ints([0]), np.zeros(3)), **own,
    )  # fmt: skip
    return groups(*map(contiguous, every))


def contiguous(group: Any) -> Any:
    return type(group)(*map(np.ascontiguousarray, group))


def signal_arrays(signals: list[list[Segment]]) -> SignalArrays:
    """Flatten the segments of every signal."""
    flat = [segment for signal in signals for segment in signal]
    coefficients = np.zeros((len(flat), DEGREE + 1))
    for k, segment in enumerate(flat):
        coefficients[k, : len(segment.coefficients)] = segment.coefficients
    return SignalArrays(
        first=ints([0, *np.cumsum([len(s) for s in signals], dtype=int).tolist()]),
        start=floats(s.start if math.isfinite(s.start) else 0.0 for s in flat),
        coefficients=coefficients,
        amplitude=floats(s.amplitude for s in flat),
        omega=floats(s.omega for s in flat),
        phase=floats(s.phase for s in flat),
    )
