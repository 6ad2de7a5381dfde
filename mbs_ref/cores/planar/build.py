"""Scene -> PlanarGroups: the arrays of the groups a planar scene uses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mbs_ref.cores.builder import Builder, Place, PlacedRow, contiguous, floats, ints, signal_arrays, table, where
from mbs_ref.cores.event_arrays import contact_laws, contact_modes, springs, watches
from mbs_ref.cores.planar.shapes import contact_balls, contact_pairs
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.kernels.rigid.model import World
from mbs_ref.scene import Force, PlanarBody, PointMass, Scene, Torque, TorsionSpring
from mbs_ref.scene.base.rows import OnPlane, Prescribed, PrescribedAngle, Rod, Row, SameAngle, SharedPoint
from mbs_ref.scene.joints import Drive, UserConstraint

_HELD_INERTIA = 1.0  # kg m^2 in the idle third slot of a point mass: nothing ever turns it


def _rotation(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


class _Builder(Builder):
    """Planar bodies' places and angles."""

    def point(self, name: str, point: tuple[float, ...]) -> np.ndarray:
        """Return a world point at t = 0 in body axes."""
        index = self.scene_index[name]
        if index < 0:
            return np.array(point, dtype=float)
        body: Any = self.scene.bodies[index]
        offset = np.array(point) - np.array(body.position)
        return offset if isinstance(body, PointMass) else _rotation(body.angle).T @ offset

    def angle(self, name: str) -> float:
        body: Any = self.scene.bodies[self.scene_index[name]] if name != "ground" else None
        return body.angle if isinstance(body, PlanarBody) else 0.0


_PAIRS: dict[str, tuple[type[Row], ...]] = {
    "revolute": (SharedPoint,), "prismatic": (OnPlane, SameAngle), "weld": (SharedPoint, SameAngle), "distance": (Rod,),
}  # fmt: skip


def _pair_joints(build: _Builder, kinds: tuple[type[Row], ...]) -> arrays.PairJoints:
    """Return the joints that are made of these kinds of rows."""
    chosen = [k for k, rows in enumerate(build.joint_rows) if tuple(map(type, rows)) == kinds]
    heads: list[Any] = [build.joint_rows[k][0] for k in chosen]
    ends = [build.scene.joints[k].ends for k in chosen]
    return arrays.PairJoints(
        slot=ints([build.place[k].slot for k in chosen]),
        row=ints([build.place[k].row for k in chosen]),
        side_a=ints([build.place[k].side for k in chosen]),
        point_a=table([build.point(a, head.point_a) for head, (a, _) in zip(heads, ends, strict=True)], 2),
        point_b=table([build.point(b, head.point_b) for head, (_, b) in zip(heads, ends, strict=True)], 2),
        normal=table([_normal(build, head, a) for head, (a, _) in zip(heads, ends, strict=True)], 2),
        value=floats(_kept_value(build, head, *pair) for head, pair in zip(heads, ends, strict=True)),
    )


def _normal(build: _Builder, head: Row, a: str) -> np.ndarray:
    return _rotation(build.angle(a)).T @ head.normal if isinstance(head, OnPlane) else np.zeros(2)


def _kept_value(build: _Builder, head: Row, a: str, b: str) -> float:
    return head.length if isinstance(head, Rod) else build.angle(b) - build.angle(a)


def _refuse_unknown_rows(scene: Scene, joint_rows: list[list[Row]]) -> None:
    for joint, rows in zip(scene.joints, joint_rows, strict=True):
        if not isinstance(joint, Drive | UserConstraint) and tuple(map(type, rows)) not in _PAIRS.values():
            names = ", ".join(type(row).__name__ for row in rows)
            raise ValueError(f"joint {joint.name!r}: the planar core has no kernel for the rows {names} together")


def _drives(build: _Builder) -> arrays.Drives:
    drives = build.of(Prescribed, PrescribedAngle)
    slot, row, first = where(drives)
    parts = [_drive_parts(build, r) for r in drives]
    return arrays.Drives(
        slot=slot,
        row=row,
        side=1 - first,  # a drive's first end is ground
        point=table([point for point, _, _, _ in parts], 2),
        direction=table([direction for _, direction, _, _ in parts], 2),
        turn=floats(turn for _, _, turn, _ in parts),
        start=floats(start for _, _, _, start in parts),
        signal=ints([build.motion(r.joint) for r in drives]),
    )


def _drive_parts(build: _Builder, drive: PlacedRow) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return body-fixed point, direction, turn and starting value."""
    if isinstance(drive.row, PrescribedAngle):
        return np.zeros(2), np.zeros(2), 1.0, build.angle(drive.b)
    point, direction = drive.row.point, drive.row.direction
    return build.point(drive.b, point), direction, 0.0, float(direction @ point)


def _forces(build: _Builder) -> arrays.Forces:
    loads = [x for x in build.scene.loads if isinstance(x, Force | Torque)]
    parts = [_force_parts(build, x) for x in loads]
    return arrays.Forces(
        body=ints([build.body(x.body) for x in loads]),
        point=table([point for point, _, _, _ in parts], 2),
        vector=table([vector for _, vector, _, _ in parts], 2),
        follows=ints([follows for _, _, follows, _ in parts]),
        torque=floats(torque for _, _, _, torque in parts),
        signal=ints([build.signal(x.factor.segments()) for x in loads]),
    )


def _force_parts(build: _Builder, load: Force | Torque) -> tuple[np.ndarray, np.ndarray, int, float]:
    """Return body-fixed point, force, whether it turns with the body, and torque."""
    if isinstance(load, Torque):
        return np.zeros(2), np.zeros(2), 0, load.torque
    follows, vector = load.frame == "body", np.array(load.vector)
    turned = _rotation(build.angle(load.body)).T @ vector if follows else vector
    return build.point(load.body, load.point), turned, int(follows), 0.0


def _torsion_springs(build: _Builder) -> arrays.TorsionSprings:
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    initial = [build.angle(x.body_b) - build.angle(x.body_a) for x in loads]
    rest = [i if x.rest_angle is None else x.rest_angle for i, x in zip(initial, loads, strict=True)]
    return arrays.TorsionSprings(
        a=ints([build.body(x.body_a) for x in loads]),
        b=ints([build.body(x.body_b) for x in loads]),
        stiffness=floats(x.stiffness for x in loads),
        damping=floats(x.damping for x in loads),
        rest_angle=np.array(rest, dtype=float),
    )


def build_planar(scene: Scene) -> tuple[arrays.PlanarGroups, dict[int, Place]]:
    """Compile a planar scene; also return where each joint's rows are."""
    build = _Builder(scene)
    ordered: list[Any] = [scene.bodies[i] for i in build.layout.order]
    _refuse_unknown_rows(scene, build.joint_rows)
    joints = {name: _pair_joints(build, kinds) for name, kinds in _PAIRS.items()}
    drives, forces = _drives(build), _forces(build)
    pairs = contact_pairs(scene, build)
    groups = arrays.PlanarGroups(
        bodies=arrays.Bodies(
            mass=floats(b.mass for b in ordered),
            inertia=floats(_HELD_INERTIA if isinstance(b, PointMass) else b.inertia for b in ordered),
            scene_index=ints(build.layout.order),
            q=3 * ints(build.layout.order),
            v=3 * ints(build.layout.order) + 3 * build.n,
            parent=ints(build.layout.parent),
        ),
        slots=arrays.Slots(
            body=np.array(build.slot_bodies, dtype=np.int64).reshape(-1, 2),
            padding=np.array([[float(r >= rows) for r in range(3)] for rows in build.slot_rows]).reshape(-1, 3),
        ),
        loops=build.loops(),
        **joints,
        drives=drives,
        forces=forces,
        springs=springs(scene, build),
        torsion_springs=_torsion_springs(build),
        contact_pairs=pairs,
        contact_laws=contact_laws(scene, build.contact_slot),
        contact_modes=contact_modes(scene),
        near_pairs=contact_balls(pairs),
        watches=watches(scene, build),
        signals=signal_arrays(build.segments),
        world=World(np.array(scene.gravity, dtype=float), ints([0]), ints([0]), np.zeros(3)),
    )
    return arrays.PlanarGroups(*map(contiguous, groups)), build.place
