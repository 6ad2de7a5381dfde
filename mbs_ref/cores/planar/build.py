"""Scene -> PlanarGroups: the arrays of the groups a planar scene uses."""

import math
from functools import partial
from typing import Any

import numpy as np

from mbs_ref.cores.builder import Builder, Place, assembled, forces, torsion_springs
from mbs_ref.kernels.border.groups import floats
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.scene import PlanarBody, PointMass, Scene, TorsionSpring

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


def _rest_angle(build: _Builder, load: TorsionSpring) -> float:
    return build.angle(load.body_b) - build.angle(load.body_a) if load.rest_angle is None else load.rest_angle


def build_planar(scene: Scene) -> tuple[Any, dict[int, Place]]:
    """Compile a planar scene to PlanarGroups; also return where each joint's rows are."""
    build = _Builder(scene)
    inertia = [[_HELD_INERTIA if isinstance(b, PointMass) else b.inertia] for b in scene.bodies]
    groups = assembled(
        build,
        arrays.PlanarGroups,
        widths=np.full((2, build.n), 3),
        inertia=floats(inertia, 1),
        forces=forces(build),
        torsion_springs=torsion_springs(build, partial(_rest_angle, build)),
    )
    return groups, build.place
