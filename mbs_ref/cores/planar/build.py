"""Scene -> PlanarGroups: the arrays of the groups a planar scene uses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mbs_ref.cores.contact_arrays import contact_laws
from mbs_ref.cores.joint_graph import Edge, Layout, layout, row_count
from mbs_ref.cores.planar.shapes import contact_balls, contact_pairs, planar_modes, tension_only, watches
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.kernels.signals import SignalArrays
from mbs_ref.scene import (
    CoordinateDrive,
    Force,
    PlanarBody,
    PointBushing,
    PointDrive,
    PointMass,
    Scene,
    SpringDamper,
    Torque,
    TorsionSpring,
)
from mbs_ref.scene.contact import ConstraintLaw
from mbs_ref.scene.signals import DEGREE, Segment, motion_segments
from mbs_ref.scene.traits import joint_ends

_HELD_INERTIA = 1.0  # kg m^2 in the idle third slot of a point mass: nothing ever turns it


def _rotation(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


class _Builder:
    """Places of bodies, slots and signals while a scene is compiled."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.layout: Layout = layout(scene)
        self.n = len(scene.bodies)
        self.number = {body: k for k, body in enumerate(self.layout.order)} | {-1: self.n}
        self.segments: list[list[Segment]] = []
        self.place: dict[int, tuple[int, int, int]] = {}  # joint index -> slot, row, side of its first end
        self.slot_bodies: list[tuple[int, int]] = []
        self.slot_rows: list[int] = []
        for child, edge in enumerate(self.layout.tree_edge):
            self._add_slot(edge, child, self.layout.parent[child])
        for edge in self.layout.closures:
            self._add_slot(edge, self.number[edge.a], self.number[edge.b])
        self.contact_slot = {
            k: self._add_contact(contact)
            for k, contact in enumerate(scene.contacts)
            if isinstance(contact.law, ConstraintLaw)
        }

    def _add_contact(self, contact: Any) -> int:
        """Give a constraint contact a slot of one row, as if it closed a loop."""
        self.slot_bodies.append((self.body(contact.body_a), self.body(contact.body_b)))
        self.slot_rows.append(1)
        return len(self.slot_rows) - 1

    def _add_slot(self, edge: Edge | None, side0: int, side1: int) -> None:
        slot, row = len(self.slot_bodies), 0
        self.slot_bodies.append((side0, side1))
        for k in edge.joints if edge else []:
            first = self.number[self.scene.body_index(joint_ends(self.scene.joints[k])[0])]
            self.place[k] = (slot, row, 0 if first == side0 else 1)
            row += row_count(self.scene.joints[k])
        self.slot_rows.append(row)

    def local(self, name: str, point: tuple[float, ...]) -> np.ndarray:
        """Return a world point at t = 0 in body axes."""
        index = self.scene.body_index(name)
        if index < 0:
            return np.array(point, dtype=float)
        body: Any = self.scene.bodies[index]
        offset = np.array(point) - np.array(body.position)
        return offset if isinstance(body, PointMass) else _rotation(body.angle).T @ offset

    def angle(self, name: str) -> float:
        body: Any = self.scene.bodies[self.scene.body_index(name)] if name != "ground" else None
        return body.angle if isinstance(body, PlanarBody) else 0.0

    def body(self, name: str) -> int:
        return self.number[self.scene.body_index(name)]

    def signal(self, segments: list[Segment]) -> int:
        self.segments.append(segments)
        return len(self.segments) - 1


def ints(values: list[int]) -> np.ndarray:
    return np.array(values, dtype=np.int64)


def table(rows: list, width: int) -> np.ndarray:
    return np.array(rows, dtype=float).reshape(len(rows), width)


def _pair_joints(build: _Builder, kind: str) -> arrays.PairJoints:
    chosen = [(k, j) for k, j in enumerate(build.scene.joints) if j.type == kind]
    joints: list[Any] = [j for _, j in chosen]
    places = [build.place[k] for k, _ in chosen]
    return arrays.PairJoints(
        slot=ints([p[0] for p in places]),
        row=ints([p[1] for p in places]),
        side_a=ints([p[2] for p in places]),
        point_a=table([build.local(j.body_a, _mark_a(j)) for j in joints], 2),
        point_b=table([build.local(j.body_b, _mark_b(j)) for j in joints], 2),
        normal=table([_normal(build, j) for j in joints], 2),
        value=np.array([_kept_value(build, j) for j in joints], dtype=float),
    )


def _mark_a(joint: Any) -> tuple[float, ...]:
    return joint.point_a if joint.type == "distance" else joint.point


def _mark_b(joint: Any) -> tuple[float, ...]:
    if joint.type == "prismatic" or joint.point_b is None:
        return joint.point
    return joint.point_b


def _normal(build: _Builder, joint: Any) -> np.ndarray:
    if joint.type != "prismatic":
        return np.zeros(2)
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    return _rotation(build.angle(joint.body_a)).T @ np.array([-axis[1], axis[0]])


def _kept_value(build: _Builder, joint: Any) -> float:
    if joint.type == "distance":
        return joint.length if joint.length is not None else math.dist(joint.point_a, joint.point_b)
    return build.angle(joint.body_b) - build.angle(joint.body_a)


def _drives(build: _Builder) -> arrays.Drives:
    chosen = [(k, j) for k, j in enumerate(build.scene.joints) if isinstance(j, CoordinateDrive | PointDrive)]
    rows = [_drive_row(build, joint) for _, joint in chosen]
    places = [build.place[k] for k, _ in chosen]
    return arrays.Drives(
        slot=ints([p[0] for p in places]),
        row=ints([p[1] for p in places]),
        side=ints([1 - p[2] for p in places]),  # a drive's first end is ground
        point=table([r[0] for r in rows], 2),
        direction=table([r[1] for r in rows], 2),
        turn=np.array([r[2] for r in rows], dtype=float),
        start=np.array([r[3] for r in rows], dtype=float),
        signal=ints([build.signal(motion_segments(j.motion, j.level)) for _, j in chosen]),
    )


def _drive_row(build: _Builder, drive: Any) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return body-fixed point, direction, turn and starting value."""
    body: Any = build.scene.bodies[build.scene.body_index(drive.body)]
    if isinstance(drive, CoordinateDrive):
        if drive.coordinate == "angle":
            return np.zeros(2), np.zeros(2), 1.0, body.angle
        direction = np.array([1.0, 0.0] if drive.coordinate == "x" else [0.0, 1.0])
        return np.zeros(2), direction, 0.0, float(direction @ body.position)
    direction = np.array(drive.direction) / np.linalg.norm(drive.direction)
    return build.local(drive.body, drive.point), direction, 0.0, float(direction @ drive.point)


def _forces(build: _Builder) -> arrays.Forces:
    loads: list[Any] = [x for x in build.scene.loads if isinstance(x, Force | Torque)]
    forces = [isinstance(x, Force) for x in loads]
    follows = [f and x.frame == "body" for f, x in zip(forces, loads, strict=True)]
    vectors = [
        _rotation(build.angle(x.body)).T @ x.vector if body_axes else (x.vector if f else (0.0, 0.0))
        for f, body_axes, x in zip(forces, follows, loads, strict=True)
    ]
    return arrays.Forces(
        body=ints([build.body(x.body) for x in loads]),
        point=table([build.local(x.body, x.point) if f else (0, 0) for f, x in zip(forces, loads, strict=True)], 2),
        vector=table(vectors, 2),
        follows=ints([int(f) for f in follows]),
        torque=np.array([0.0 if f else x.torque for f, x in zip(forces, loads, strict=True)], dtype=float),
        signal=ints([build.signal(x.factor.segments()) for x in loads]),
    )


def _springs(build: _Builder) -> arrays.Springs:
    loads = [x for x in build.scene.loads if isinstance(x, SpringDamper | PointBushing)]
    places = {x.name: len(build.scene.contacts) + k for k, x in enumerate(tension_only(build.scene))}
    marks = [(x.point, x.point) if isinstance(x, PointBushing) else (x.point_a, x.point_b) for x in loads]
    return arrays.Springs(
        a=ints([build.body(x.body_a) for x in loads]),
        b=ints([build.body(x.body_b) for x in loads]),
        point_a=table([build.local(x.body_a, a) for x, (a, _) in zip(loads, marks, strict=True)], 2),
        point_b=table([build.local(x.body_b, b) for x, (_, b) in zip(loads, marks, strict=True)], 2),
        stiffness=np.array([x.stiffness for x in loads], dtype=float),
        damping=np.array([x.damping for x in loads], dtype=float),
        rest_length=np.array([_rest_length(x) for x in loads], dtype=float),
        tension_only=ints([int(isinstance(x, SpringDamper) and x.tension_only) for x in loads]),
        isotropic=ints([int(isinstance(x, PointBushing)) for x in loads]),
        place=ints([places.get(x.name, -1) for x in loads]),
    )


def _rest_length(load: SpringDamper | PointBushing) -> float:
    if isinstance(load, PointBushing):
        return 0.0
    return math.dist(load.point_a, load.point_b) if load.rest_length is None else load.rest_length


def _torsion_springs(build: _Builder) -> arrays.TorsionSprings:
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    initial = [build.angle(x.body_b) - build.angle(x.body_a) for x in loads]
    rest = [i if x.rest_angle is None else x.rest_angle for i, x in zip(initial, loads, strict=True)]
    return arrays.TorsionSprings(
        a=ints([build.body(x.body_a) for x in loads]),
        b=ints([build.body(x.body_b) for x in loads]),
        stiffness=np.array([x.stiffness for x in loads], dtype=float),
        damping=np.array([x.damping for x in loads], dtype=float),
        rest_angle=np.array(rest, dtype=float),
    )


def signal_arrays(signals: list[list[Segment]]) -> SignalArrays:
    """Flatten the segments of every signal."""
    flat = [segment for signal in signals for segment in signal]
    coefficients = np.zeros((len(flat), DEGREE + 1))
    for k, segment in enumerate(flat):
        coefficients[k, : len(segment.coefficients)] = segment.coefficients
    return SignalArrays(
        first=ints([0, *np.cumsum([len(s) for s in signals], dtype=int).tolist()]),
        start=np.array([s.start if math.isfinite(s.start) else 0.0 for s in flat], dtype=float),
        coefficients=coefficients,
        amplitude=np.array([s.amplitude for s in flat], dtype=float),
        omega=np.array([s.omega for s in flat], dtype=float),
        phase=np.array([s.phase for s in flat], dtype=float),
    )


def contiguous(group: Any) -> Any:
    return type(group)(*map(np.ascontiguousarray, group))


def build_planar(scene: Scene) -> tuple[arrays.PlanarGroups, dict[int, tuple[int, int, int]]]:
    """Compile a planar scene; also return where each joint's rows are: slot, row, side of its first end."""
    build = _Builder(scene)
    ordered: list[Any] = [scene.bodies[i] for i in build.layout.order]
    closures = [(slot, row) for slot in range(build.n, len(build.slot_rows)) for row in range(build.slot_rows[slot])]
    joints = {kind: _pair_joints(build, kind) for kind in ("revolute", "prismatic", "weld", "distance")}
    drives, forces = _drives(build), _forces(build)
    pairs = contact_pairs(scene, build)
    groups = arrays.PlanarGroups(
        bodies=arrays.Bodies(
            mass=np.array([b.mass for b in ordered], dtype=float),
            inertia=np.array([_HELD_INERTIA if isinstance(b, PointMass) else b.inertia for b in ordered], dtype=float),
            scene_index=ints(build.layout.order),
            parent=ints(build.layout.parent),
        ),
        slots=arrays.Slots(
            body=np.array(build.slot_bodies, dtype=np.int64).reshape(-1, 2),
            padding=np.array([[float(r >= rows) for r in range(3)] for rows in build.slot_rows]).reshape(-1, 3),
            closure_slot=ints([slot for slot, _ in closures]),
            closure_row=ints([row for _, row in closures]),
        ),
        **joints,
        drives=drives,
        forces=forces,
        springs=_springs(build),
        torsion_springs=_torsion_springs(build),
        contact_pairs=pairs,
        contact_laws=contact_laws(scene, build.contact_slot),
        contact_modes=planar_modes(scene),
        near_pairs=contact_balls(pairs),
        watches=watches(scene, build),
        signals=signal_arrays(build.segments),
        world=arrays.World(np.array(scene.gravity, dtype=float), np.zeros(1, dtype=np.int64), np.zeros(3)),
    )
    return arrays.PlanarGroups(*map(contiguous, groups)), build.place
