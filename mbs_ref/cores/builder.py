"""What the planar and the spatial build share: places of bodies, rows and signals while a scene is compiled."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.cores.contact_shapes import contact_balls, contact_pairs, granules
from mbs_ref.cores.events import contact_laws, contact_modes, springs, watches
from mbs_ref.cores.joint_graph import graph_of, row_count
from mbs_ref.cores.loops import Closure, loops_of_closures
from mbs_ref.kernels.border.groups import absent, empty, floats, ints, members
from mbs_ref.kernels.rigid.model import Bodies, Forces, Loops, Slots, TorsionSprings, World
from mbs_ref.kernels.rigid.outputs import JointRows
from mbs_ref.kernels.signals import SignalArrays
from mbs_ref.scene import GROUND, Force, PointMass, Scene, Torque, TorqueVector, TorsionSpring
from mbs_ref.scene.base.rows import Row
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.joints import Drive
from mbs_ref.scene.signals import DEGREE, Segment, motion_segments

UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # Euler parameters


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
    slot: int
    first: int  # of its places in the slot
    side: int  # of body a


class Reporting(NamedTuple):
    """What each joint's reaction is read from, joint after joint."""

    names: tuple[str, ...]
    rows: JointRows
    sign: np.ndarray  # (n_joints, 1)
    body: np.ndarray  # (n_joints,) scene index
    arm: np.ndarray  # (n_joints, dimension) m, from the body's centre of mass to the joint's point, body axes


class Builder(ABC):
    """Bodies' places and axes at t = 0, and slots of a scene's joints; `signal` collects the functions of time.

    `centres` (n_bodies + 1, dimension; m), `angles` (rad, 0 of what has none) and `axes` have ground last.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.n, self.dimension = scene, len(scene.bodies), scene.dimension
        self.joint_rows, self.layout = graph_of(scene)
        self.angles = [*(vars(body).get("angle", 0.0) for body in scene.bodies), 0.0]
        self.axes = _axes(scene, self.angles)
        self.centres = np.array([*(body.position for body in scene.bodies), (0.0,) * self.dimension])
        self.scene_index = scene.places
        self.number = {body: k for k, body in enumerate(self.layout.order)} | {-1: self.n}
        self.segments: list[list[Segment]] = []
        self.place: dict[int, Place] = {}  # by the joint's index
        self.slot_bodies: list[tuple[int, int]] = []
        self.slot_rows: list[int] = []
        for edge, sides in zip(self.layout.tree_edge, enumerate(self.layout.parent), strict=True):
            self._add_slot(sides, edge.joints if edge else [])
        for edge in self.layout.closures:
            self._add_slot((self.number[edge.a], self.number[edge.b]), edge.joints)
        held = [(k, x) for k, x in enumerate(scene.contacts) if x.holds]  # as if they closed loops
        self.contact_slot = {k: self._add_slot((self.body(x.body_a), self.body(x.body_b)), [], 1) for k, x in held}
        self.rows: dict[str, list[PlacedRow]] = {}  # by the group of arrays that they fill
        for k, at in sorted(self.place.items()):
            joint, first = scene.joints[k], at.row
            for row in self.joint_rows[k]:
                placed = PlacedRow(row, joint, *joint.ends, at.slot, first, at.side)
                self.rows.setdefault(row.GROUP, []).append(placed)
                first += row.count

    def _add_slot(self, sides: tuple[int, int], joints: Sequence[int], n_rows: int = 0) -> int:
        """Add a slot of `n_rows` and the rows of joints between two bodies; return its place."""
        for k in joints:
            side, count = int(self.body(self.scene.joints[k].ends[0]) != sides[0]), row_count(self.joint_rows[k])
            self.place[k] = Place(len(self.slot_rows), n_rows, side, count)
            n_rows += count
        self.slot_bodies.append(sides)
        self.slot_rows.append(n_rows)
        return len(self.slot_rows) - 1

    def loops(self) -> Loops:
        """Return the closures of loops: the slots beyond the tree's that have rows."""
        slots = [k for k in range(self.n, len(self.slot_rows)) if self.slot_rows[k]]
        if not slots:
            return empty(Loops, **{"n + 1": self.n + 1, "n_closures + 1": 1})
        closures = [Closure(k, self.slot_bodies[k], self.slot_rows[k]) for k in slots]
        return loops_of_closures(self.layout.parent, closures)

    def body(self, name: str) -> int:
        """Return a body's elimination number; that of ground is the number of bodies."""
        return self.number[self.scene_index[name]]

    def points(self, names: Sequence[str], world: Any) -> np.ndarray:
        """Return world points (k, dimension) at t = 0 in the axes of k bodies of these names, or of ground, m."""
        return self.directions(names, world - self.centres[[self.scene_index[name] for name in names]])

    def directions(self, names: Sequence[str], world: Any) -> np.ndarray:
        """Return world directions (k, dimension) at t = 0 in the axes of k bodies of these names, or of ground."""
        return (self.turns(names) @ np.array(world)[..., None])[..., 0]

    def turns(self, names: Sequence[str]) -> np.ndarray:
        """Return what turns world axes into those of k bodies of these names (k, dimension, dimension)."""
        return self.axes[[self.scene_index[name] for name in names]].swapaxes(1, 2)

    def arms(self, joints: Sequence[Any], ends: Sequence[str]) -> np.ndarray:
        """Return where joints hold one end of each (k, dimension), m, body axes, from the centre of mass.

        It is counted from the origin on ground, and zero without a mark.
        """
        named = [(getattr(joint, end), joint.mark(end)) for joint, end in zip(joints, ends, strict=True)]
        world = [mark or self.centres[self.scene_index[name]] for name, mark in named]
        return self.points([name for name, _ in named], floats(world, self.dimension))

    @cached_property
    def reporting(self) -> Reporting:
        """The bodies whose forces give each joint's reaction: for ground, the opposite of the other body's."""
        parts: list[Any] = [self.scene.joints[k] for k in self.place]
        places = list(self.place.values())
        mirrored = np.array([part.ends[1] == GROUND for part in parts], dtype=bool)
        last = ["body_b" if "body_b" in vars(part) else "body" for part in parts]
        fields = np.where(mirrored, "body_a", last).tolist()
        bodies = [self.scene.body_index(getattr(part, name)) for part, name in zip(parts, fields, strict=True)]
        slot, first, side, count = np.array([(*at,) for at in places], dtype=np.int64).reshape(-1, 4).T.copy()
        return Reporting(
            names=tuple(part.name for part in parts),
            rows=JointRows(slot, np.where(mirrored, side, 1 - side), first, count),
            sign=np.where(mirrored, 1.0, -1.0)[:, None],
            body=np.array(bodies, dtype=int),
            arm=self.arms(parts, fields),
        )

    @abstractmethod
    def groups(self) -> Any:
        """Return the arrays of the scene."""

    def angle(self, name: str) -> float:
        """Return a planar body's angle at t = 0, rad; 0 of what has none."""
        return self.angles[self.scene_index[name]]

    def signal(self, segments: list[Segment]) -> int:
        """Return the number of a signal, which is new unless it equals the last one."""
        if self.segments[-1:] != [segments]:
            self.segments.append(segments)
        return len(self.segments) - 1

    def motion(self, drive: Drive) -> int:
        """Return the signal of what a drive prescribes."""
        return self.signal(motion_segments(drive.motion, drive.level))


def _axes(scene: Scene, angles: list[float]) -> np.ndarray:
    """Return the axes (n_bodies + 1, dimension, dimension) of bodies and ground as columns, world, at t = 0."""
    if scene.dimension == 3:
        return rotation_matrices([*(vars(body).get("orientation", UPRIGHT) for body in scene.bodies), UPRIGHT])
    return np.array([((c, -s), (s, c)) for c, s in zip(map(math.cos, angles), map(math.sin, angles), strict=True)])


def ends(build: Builder, loads: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the bodies a and b of loads between two."""
    return ints([build.body(x.body_a) for x in loads]), ints([build.body(x.body_b) for x in loads])


def forces(build: Builder) -> Forces:
    """Return the forces and torques, each a vector times a signal, along body axes where they turn with the body."""
    loads = [x for x in build.scene.loads if isinstance(x, Force | Torque | TorqueVector)]
    if not loads:
        return absent(Forces)
    d, follows = build.dimension, [getattr(x, "frame", "world") == "body" for x in loads]
    vectors = [x.torque if isinstance(x, Torque) else build.directions([x.body], [x.vector])[0] if turns else x.vector
               for x, turns in zip(loads, follows, strict=True)]  # fmt: skip
    pairs, no_turn = list(zip(loads, vectors, strict=True)), np.zeros(d * (d - 1) // 2)
    return Forces(
        body=ints([build.body(x.body) for x in loads]),
        point=floats([build.points([x.body], [x.point])[0] if isinstance(x, Force) else np.zeros(d) for x in loads], d),
        force=floats([v if isinstance(x, Force) else np.zeros(d) for x, v in pairs], d),
        torque=floats([no_turn if isinstance(x, Force) else np.atleast_1d(v) for x, v in pairs], len(no_turn)),
        follows=ints(follows),
        signal=ints([build.signal(x.factor.segments()) for x in loads]),
    )


def torsion_springs(build: Builder, rest: Callable[[TorsionSpring], float], **marks: np.ndarray) -> TorsionSprings:
    """Return the torsion springs; `marks` are where their angle is read in space."""
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    if not loads:
        return absent(TorsionSprings)
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
    rows = build.rows.get(kind.GROUP)
    if not rows:
        return absent(group)
    each, joints, a, b, slots, firsts, sides = zip(*rows, strict=True)
    numbers = kind.numbers(build, lambda field: [getattr(row, field) for row in each], a, b)
    columns = {name: np.array(n, dtype=float) for name, n in zip(group._fields[3:], numbers, strict=False)}
    if "signal" in group._fields:
        columns["signal"] = ints([build.motion(joint) for joint in joints])
    own = sides if "side_a" in group._fields else [1 - side for side in sides]  # a drive's first end is ground
    return group(ints(slots), ints(firsts), ints(own), **columns)


def assembled(build: Builder, groups: Any, widths: np.ndarray, inertia: np.ndarray, **own: Any) -> Any:
    """Return a scene's groups: those of every core, and a core's `own`.

    `widths` (2, n_bodies) are how many coordinates and rates each body has in the state, and `inertia`
    (n_bodies, moments) what turns it, both in scene order.
    """
    scene, order = build.scene, ints(build.layout.order)
    first = np.concatenate(([0], np.cumsum(widths)))  # rates follow all coordinates
    held = {end for sides, rows in zip(build.slot_bodies, build.slot_rows, strict=True) if rows for end in sides}
    own_bodies = [scene.bodies[i] for i in build.layout.order]
    bodies = Bodies(
        mass=floats([body.mass for body in own_bodies]), inertia=inertia[order],
        rigid=ints([not isinstance(body, PointMass) for body in own_bodies]),
        alone=ints([k not in held for k in range(build.n)]), scene_index=order, q=first[order],
        v=first[build.n + order], start=first[[build.n]], parent=ints(build.layout.parent),
    )  # fmt: skip
    pairs = contact_pairs(scene, build)
    return groups(
        bodies=bodies, slots=Slots(np.array(build.slot_bodies, dtype=np.int64).reshape(-1, 2), ints(build.slot_rows)),
        loops=build.loops(), **row_groups(build, groups), springs=springs(scene, build), contact_pairs=pairs,
        contact_laws=contact_laws(scene, build.contact_slot), contact_modes=contact_modes(scene),
        near_pairs=contact_balls(pairs, scene.dimension), granules=granules(scene, build),
        watches=watches(scene, build), signals=signal_arrays(build.segments),
        world=World(np.array(scene.gravity, dtype=float), ints([0]), ints([0]), np.zeros(3)), **own,
    )  # fmt: skip


def signal_arrays(signals: list[list[Segment]]) -> SignalArrays:
    """Flatten the segments of every signal."""
    if not signals:
        return absent(SignalArrays)
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
