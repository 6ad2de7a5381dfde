"""Scene -> PlanarGroups: the arrays of the groups a planar scene uses."""

import math
from typing import Any

import numpy as np

from mbs_ref.cores.builder import Builder, Place, assembled
from mbs_ref.kernels.border.groups import empty, floats, ints
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.kernels.rigid.model import Forces, TorsionSprings
from mbs_ref.scene import Force, PlanarBody, PointMass, Scene, Torque, TorsionSpring

_HELD_INERTIA = 1.0  # kg m^2 in the idle third slot of a point mass: nothing ever turns it


def _rotation(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


class _Builder(Builder):
    """Planar bodies' places and angles."""

    def point(self, name: str, world: Any) -> np.ndarray:
        index = self.scene_index[name]
        if index < 0:
            return np.array(world, dtype=float)
        body: Any = self.scene.bodies[index]
        offset = np.array(world) - np.array(body.position)
        return offset if isinstance(body, PointMass) else _rotation(body.angle).T @ offset

    def direction(self, name: str, world: Any) -> np.ndarray:
        return _rotation(self.angle(name)).T @ world

    def angle(self, name: str) -> float:
        body: Any = self.scene.bodies[self.scene_index[name]] if name != "ground" else None
        return body.angle if isinstance(body, PlanarBody) else 0.0


def _forces(build: _Builder) -> Forces:
    loads = [x for x in build.scene.loads if isinstance(x, Force | Torque)]
    parts = [_force_parts(build, x) for x in loads]
    return Forces(
        body=ints([build.body(x.body) for x in loads]),
        point=floats([point for point, _, _, _ in parts], 2),
        force=floats([vector for _, vector, _, _ in parts], 2),
        torque=floats([torque for _, _, _, torque in parts], 1),
        follows=ints([follows for _, _, follows, _ in parts]),
        signal=ints([build.signal(x.factor.segments()) for x in loads]),
    )


def _force_parts(build: _Builder, load: Force | Torque) -> tuple[np.ndarray, np.ndarray, int, float]:
    """Return body-fixed point, force, whether it turns with the body, and torque."""
    if isinstance(load, Torque):
        return np.zeros(2), np.zeros(2), 0, load.torque
    follows, vector = load.frame == "body", np.array(load.vector)
    turned = build.direction(load.body, vector) if follows else vector
    return build.point(load.body, load.point), turned, int(follows), 0.0


def _torsion_springs(build: _Builder) -> TorsionSprings:
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    initial = [build.angle(x.body_b) - build.angle(x.body_a) for x in loads]
    rest = [i if x.rest_angle is None else x.rest_angle for i, x in zip(initial, loads, strict=True)]
    return empty(TorsionSprings, k=len(loads))._replace(
        a=ints([build.body(x.body_a) for x in loads]),
        b=ints([build.body(x.body_b) for x in loads]),
        stiffness=floats(x.stiffness for x in loads),
        damping=floats(x.damping for x in loads),
        rest_angle=floats(rest),
    )


def build_planar(scene: Scene) -> tuple[Any, dict[int, Place]]:
    """Compile a planar scene to PlanarGroups; also return where each joint's rows are."""
    build = _Builder(scene)
    inertia = [[_HELD_INERTIA if isinstance(b, PointMass) else b.inertia] for b in scene.bodies]
    groups = assembled(
        build,
        arrays.PlanarGroups,
        widths=np.full((2, build.n), 3),
        inertia=floats(inertia, 1),
        forces=_forces(build),
        torsion_springs=_torsion_springs(build),
    )
    return groups, build.place
