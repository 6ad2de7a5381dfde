"""Scene -> SpatialGroups: the arrays of the groups a spatial scene uses."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.cores.contact_arrays import contact_laws, contact_modes
from mbs_ref.cores.joint_graph import Edge
from mbs_ref.cores.planar.build import contiguous, ints, signal_arrays, table
from mbs_ref.cores.spatial.elements import (
    Element,
    OnPlane,
    Prescribed,
    Product,
    Rod,
    SharedPoint,
    Turn,
    elements,
    normals,
    row_count,
    spatial_layout,
    unit,
)
from mbs_ref.cores.spatial.shapes import contact_balls, contact_pairs
from mbs_ref.kernels.spatial import model as arrays
from mbs_ref.scene import Bushing, Force, PointMass, Scene, SpatialBody, SpringDamper, TorqueVector, TorsionSpring
from mbs_ref.scene.celestial import CELESTIAL_TYPES, Epoch, Newton
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.signals import Segment, motion_segments
from mbs_ref.scene.traits import joint_ends

_HELD_INERTIA = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)  # kg m^2 in the idle block of a point mass: nothing ever turns it


class Place(NamedTuple):
    """Where a joint's rows are."""

    slot: int
    row: int
    side: int  # of its first end


class _Row(NamedTuple):
    """An elementary row with its place and its joint."""

    element: Any
    joint: Any
    a: str
    b: str
    slot: int
    row: int
    side: int


def world_axes(body: Any) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a body at t = 0; one for ground (None) and point masses."""
    return rotation_matrices(body.orientation) if isinstance(body, SpatialBody) else np.eye(3)


class _Builder:
    """Places of bodies, slots and signals while a scene is compiled."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.layout = spatial_layout(scene)
        self.n = len(scene.bodies)
        self.number = {body: k for k, body in enumerate(self.layout.order)} | {-1: self.n}
        self.axes = {body.name: world_axes(body) for body in scene.bodies}
        self.centre = {body.name: np.array(body.position) for body in scene.bodies}
        self.index = {body.name: k for k, body in enumerate(scene.bodies)} | {"ground": -1}
        self.segments: list[list[Segment]] = []
        self.place: dict[int, Place] = {}
        self.slot_bodies: list[tuple[int, int]] = []
        self.slot_rows: list[int] = []
        for child, edge in enumerate(self.layout.tree_edge):
            self._add_slot(edge, child, self.layout.parent[child])
        for edge in self.layout.closures:
            self._add_slot(edge, self.number[edge.a], self.number[edge.b])
        self.rows = [row for k in sorted(self.place) for row in self._rows(k)]

    def _add_slot(self, edge: Edge | None, side0: int, side1: int) -> None:
        slot, row = len(self.slot_bodies), 0
        self.slot_bodies.append((side0, side1))
        for k in edge.joints if edge else []:
            first = self.number[self.scene.body_index(joint_ends(self.scene.joints[k])[0])]
            self.place[k] = Place(slot, row, 0 if first == side0 else 1)
            row += row_count(self.scene.joints[k])
        self.slot_rows.append(row)

    def _rows(self, k: int) -> list[_Row]:
        joint, (slot, row, side) = self.scene.joints[k], self.place[k]
        a, b = joint_ends(joint)
        found = []
        for element in elements(joint, self.scene):
            found.append(_Row(element, joint, a, b, slot, row, side))
            row += element.rows
        return found

    def of(self, kind: type[Element]) -> list[_Row]:
        return [row for row in self.rows if isinstance(row.element, kind)]

    def point(self, name: str, world: Any) -> np.ndarray:
        """Return a world point at t = 0 in body axes."""
        if name == "ground":
            return np.array(world, dtype=float)
        return self.axes[name].T @ (np.array(world) - self.centre[name])

    def direction(self, name: str, world: Any) -> np.ndarray:
        """Return a world direction at t = 0 in body axes."""
        return np.array(world, dtype=float) if name == "ground" else self.axes[name].T @ world

    def body(self, name: str) -> int:
        return self.number[self.index[name]]

    def signal(self, segments: list[Segment]) -> int:
        self.segments.append(segments)
        return len(self.segments) - 1


def _where(rows: list[_Row]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return ints([r.slot for r in rows]), ints([r.row for r in rows]), ints([r.side for r in rows])


def _floats(values: Any) -> np.ndarray:
    return np.array(list(values), dtype=float)


def _points(build: _Builder) -> arrays.Points:
    rows = build.of(SharedPoint)
    return arrays.Points(
        *_where(rows),
        table([build.point(r.a, r.element.point_a) for r in rows], 3),
        table([build.point(r.b, r.element.point_b) for r in rows], 3),
    )


def _products(build: _Builder) -> arrays.Products:
    rows = build.of(Product)
    along_a = [build.direction(r.a, r.element.along_a) for r in rows]
    along_b = [build.direction(r.b, r.element.along_b) for r in rows]
    return arrays.Products(*_where(rows), table(along_a, 3), table(along_b, 3), np.zeros(len(rows)))


def _planes(build: _Builder) -> arrays.Planes:
    rows = build.of(OnPlane)
    return arrays.Planes(
        *_where(rows),
        table([build.point(r.a, r.element.point) for r in rows], 3),
        table([build.point(r.b, r.element.point) for r in rows], 3),
        table([build.direction(r.a, r.element.normal) for r in rows], 3),
    )


def _distances(build: _Builder) -> arrays.Distances:
    rows = build.of(Rod)
    return arrays.Distances(
        *_where(rows),
        table([build.point(r.a, r.element.point_a) for r in rows], 3),
        table([build.point(r.b, r.element.point_b) for r in rows], 3),
        _floats(r.element.length for r in rows),
    )


def _turns(build: _Builder) -> arrays.Turns:
    rows = build.of(Turn)
    return arrays.Turns(
        *_where(rows),
        table([build.direction(r.a, r.element.zero) for r in rows], 3),
        table([build.direction(r.a, r.element.quarter) for r in rows], 3),
        table([build.direction(r.b, r.element.zero) for r in rows], 3),
        ints([build.signal(motion_segments(r.joint.motion, r.joint.level)) for r in rows]),
    )


def _drives(build: _Builder) -> arrays.Drives:
    rows = build.of(Prescribed)
    slot, row, first = _where(rows)
    return arrays.Drives(
        slot, row, 1 - first,  # a drive's first end is ground
        table([build.point(r.b, r.element.point) for r in rows], 3),
        table([r.element.direction for r in rows], 3),
        _floats(float(r.element.direction @ r.element.point) for r in rows),
        ints([build.signal(motion_segments(r.joint.motion, r.joint.level)) for r in rows]),
    )  # fmt: skip


def _forces(build: _Builder) -> arrays.Forces:
    loads: list[Any] = [x for x in build.scene.loads if isinstance(x, Force | TorqueVector)]
    turned = [build.axes[x.body].T @ x.vector if x.frame == "body" else np.array(x.vector) for x in loads]
    pushes = [isinstance(x, Force) for x in loads]
    zero = np.zeros(3)
    return arrays.Forces(
        body=ints([build.body(x.body) for x in loads]),
        point=table([build.point(x.body, x.point) if f else zero for x, f in zip(loads, pushes, strict=True)], 3),
        force=table([v if f else zero for v, f in zip(turned, pushes, strict=True)], 3),
        torque=table([zero if f else v for v, f in zip(turned, pushes, strict=True)], 3),
        follows=ints([int(x.frame == "body") for x in loads]),
        signal=ints([build.signal(x.factor.segments()) for x in loads]),
    )


def _ends(build: _Builder, loads: list[Any]) -> tuple[np.ndarray, np.ndarray]:
    return ints([build.body(x.body_a) for x in loads]), ints([build.body(x.body_b) for x in loads])


def _springs(build: _Builder) -> arrays.Springs:
    loads = [x for x in build.scene.loads if isinstance(x, SpringDamper)]
    rest = [math.dist(x.point_a, x.point_b) if x.rest_length is None else x.rest_length for x in loads]
    return arrays.Springs(
        *_ends(build, loads),
        table([build.point(x.body_a, x.point_a) for x in loads], 3),
        table([build.point(x.body_b, x.point_b) for x in loads], 3),
        _floats(x.stiffness for x in loads),
        _floats(x.damping for x in loads),
        _floats(rest),
        ints([int(x.tension_only) for x in loads]),
    )


def _torsion_springs(build: _Builder) -> arrays.TorsionSprings:
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    frames = [normals(x.axis) for x in loads]
    return arrays.TorsionSprings(
        *_ends(build, loads),
        table([build.direction(x.body_a, f[0]) for x, f in zip(loads, frames, strict=True)], 3),
        table([build.direction(x.body_a, f[1]) for x, f in zip(loads, frames, strict=True)], 3),
        table([build.direction(x.body_b, f[0]) for x, f in zip(loads, frames, strict=True)], 3),
        _floats(x.stiffness for x in loads),
        _floats(x.damping for x in loads),
        _floats(x.rest_angle or 0.0 for x in loads),
    )


def _bushings(build: _Builder) -> arrays.Bushings:
    loads = [x for x in build.scene.loads if isinstance(x, Bushing)]
    directions = [(unit(x.x_axis), unit(x.y_axis)) for x in loads]
    frames = [np.column_stack((x, y, np.cross(x, y))) for x, y in directions]
    pairs = list(zip(loads, frames, strict=True))
    return arrays.Bushings(
        *_ends(build, loads),
        table([build.point(x.body_a, x.point) for x in loads], 3),
        table([build.point(x.body_b, x.point) for x in loads], 3),
        np.array([build.direction(x.body_a, f) for x, f in pairs]).reshape(-1, 3, 3),
        np.array([build.direction(x.body_b, f) for x, f in pairs]).reshape(-1, 3, 3),
        table([x.stiffness for x in loads], 6),
        table([x.damping for x in loads], 6),
    )


def _attraction(build: _Builder) -> arrays.Attraction:
    """Return Newton's gm in elimination order; ValueError where a load acts on scenes of particles alone."""
    others = [x.name for x in build.scene.loads if x.type in CELESTIAL_TYPES and not isinstance(x, Newton | Epoch)]
    found = [x for x in build.scene.loads if isinstance(x, Newton)]
    if others:
        raise ValueError(
            f"loads {', '.join(others)} act in scenes of free point masses alone; rigid bodies know newton"
        )
    if len(found) > 1:
        raise ValueError(f"loads {', '.join(x.name for x in found)} are all of type newton; give one")
    if found and len(found[0].gm) != build.n:
        raise ValueError(f"load {found[0].name!r}: gm needs {build.n} entries, one a body; got {len(found[0].gm)}")
    return arrays.Attraction(_floats(found[0].gm[i] for i in build.layout.order) if found else np.zeros(0))


def _bodies(build: _Builder) -> arrays.Bodies:
    ordered: list[Any] = [build.scene.bodies[i] for i in build.layout.order]
    rigid = np.array([int(isinstance(b, SpatialBody)) for b in build.scene.bodies], dtype=np.int64)
    q = np.concatenate(([0], np.cumsum(3 + 4 * rigid)))
    v = q[-1] + np.concatenate(([0], np.cumsum(3 + 3 * rigid)))
    held = {end for sides, rows in zip(build.slot_bodies, build.slot_rows, strict=True) if rows for end in sides}
    return arrays.Bodies(
        mass=_floats(b.mass for b in ordered),
        inertia=table([_HELD_INERTIA if isinstance(b, PointMass) else b.inertia for b in ordered], 6),
        rigid=rigid[build.layout.order],
        alone=ints([int(k not in held) for k in range(build.n)]),
        scene_index=ints(build.layout.order),
        q=q[build.layout.order].astype(np.int64),
        v=v[build.layout.order].astype(np.int64),
        parent=ints(build.layout.parent),
    )


def build_spatial(scene: Scene) -> tuple[arrays.SpatialGroups, dict[int, Place]]:
    """Compile a spatial scene; also return where each joint's rows are."""
    build = _Builder(scene)
    closures = [(slot, row) for slot in range(build.n, len(build.slot_rows)) for row in range(build.slot_rows[slot])]
    turns, drives, forces = _turns(build), _drives(build), _forces(build)
    pairs = contact_pairs(scene, build)
    groups = arrays.SpatialGroups(
        bodies=_bodies(build),
        slots=arrays.Slots(
            body=np.array(build.slot_bodies, dtype=np.int64).reshape(-1, 2),
            count=ints(build.slot_rows),
            closure_slot=ints([slot for slot, _ in closures]),
            closure_row=ints([row for _, row in closures]),
            closure_rank=ints([len(closures)]),
        ),
        points=_points(build),
        products=_products(build),
        planes=_planes(build),
        distances=_distances(build),
        turns=turns,
        drives=drives,
        forces=forces,
        springs=_springs(build),
        torsion_springs=_torsion_springs(build),
        bushings=_bushings(build),
        contact_pairs=pairs,
        contact_laws=contact_laws(scene, {}),
        contact_modes=contact_modes(scene, len(scene.contacts)),
        near_pairs=contact_balls(pairs),
        attraction=_attraction(build),
        signals=signal_arrays(build.segments),
        world=arrays.World(np.array(scene.gravity, dtype=float), np.zeros(1, dtype=np.int64), np.zeros(3)),
    )
    return arrays.SpatialGroups(*map(contiguous, groups)), build.place
