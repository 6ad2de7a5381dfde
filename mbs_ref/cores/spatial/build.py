"""Scene -> SpatialGroups: the arrays of the groups a spatial scene uses."""

from typing import Any

import numpy as np

from mbs_ref.cores.builder import Builder, Place, assembled, ends, forces, torsion_springs
from mbs_ref.kernels.border.groups import floats, ints
from mbs_ref.kernels.rigid.model import TorsionSprings
from mbs_ref.kernels.spatial import model as arrays
from mbs_ref.scene import Bushing, Scene, SpatialBody, TorsionSpring
from mbs_ref.scene.base.directions import normals, unit
from mbs_ref.scene.celestial import CelestialPart, Epoch, GravityGradient, Newton
from mbs_ref.scene.euler_parameters import rotation_matrices

_HELD_INERTIA = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)  # kg m^2 in the idle block of a point mass: nothing ever turns it


def world_axes(body: Any) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a body at t = 0; one for ground (None) and point masses."""
    return rotation_matrices(body.orientation) if isinstance(body, SpatialBody) else np.eye(3)


class _Builder(Builder):
    """Spatial bodies' places and axes."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.axes = {body.name: world_axes(body) for body in scene.bodies}
        self.centre = {body.name: np.array(body.position) for body in scene.bodies}

    def point(self, name: str, world: Any) -> np.ndarray:
        if name == "ground":
            return np.array(world, dtype=float)
        return self.axes[name].T @ (np.array(world) - self.centre[name])

    def direction(self, name: str, world: Any) -> np.ndarray:
        return np.array(world, dtype=float) if name == "ground" else self.axes[name].T @ world


def _torsion_springs(build: _Builder) -> TorsionSprings:
    loads = [x for x in build.scene.loads if isinstance(x, TorsionSpring)]
    pairs = [(x, normals(x.axis)) for x in loads]
    return torsion_springs(
        build,
        lambda load: load.rest_angle or 0.0,
        zero=floats([build.direction(x.body_a, f[0]) for x, f in pairs], 3),
        quarter=floats([build.direction(x.body_a, f[1]) for x, f in pairs], 3),
        mark=floats([build.direction(x.body_b, f[0]) for x, f in pairs], 3),
    )


def _bushings(build: _Builder) -> arrays.Bushings:
    loads = [x for x in build.scene.loads if isinstance(x, Bushing)]
    directions = [(unit(x.x_axis), unit(x.y_axis)) for x in loads]
    frames = [np.column_stack((x, y, np.cross(x, y))) for x, y in directions]
    pairs = list(zip(loads, frames, strict=True))
    return arrays.Bushings(
        *ends(build, loads),
        floats([build.point(x.body_a, x.point) for x in loads], 3),
        floats([build.point(x.body_b, x.point) for x in loads], 3),
        floats((build.direction(x.body_a, f) for x, f in pairs), 3, 3),
        floats((build.direction(x.body_b, f) for x, f in pairs), 3, 3),
        floats([x.stiffness for x in loads], 6),
        floats([x.damping for x in loads], 6),
    )


def _attraction(build: _Builder) -> arrays.Attraction:
    """Return Newton's gm in elimination order; ValueError where a load acts on scenes of particles alone."""
    known = (Newton, Epoch, GravityGradient)
    others = [x.name for x in build.scene.loads if isinstance(x, CelestialPart) and not isinstance(x, known)]
    newtons = [x for x in build.scene.loads if isinstance(x, Newton)]
    if others:
        raise ValueError(
            f"loads {', '.join(others)} act in scenes of free point masses alone; rigid bodies know newton "
            "and gravity_gradient"
        )
    if len(newtons) > 1:
        raise ValueError(f"loads {', '.join(x.name for x in newtons)} are all of type newton; give one")
    if newtons and len(newtons[0].gm) != build.n:
        raise ValueError(f"load {newtons[0].name!r}: gm needs {build.n} entries, one a body; got {len(newtons[0].gm)}")
    return arrays.Attraction(floats(newtons[0].gm[i] for i in build.layout.order) if newtons else np.zeros(0))


def _gradients(build: _Builder) -> arrays.Gradients:
    loads = [x for x in build.scene.loads if isinstance(x, GravityGradient)]
    ends = [
        ints([build.body(name) for name in names]) for names in ([x.planet for x in loads], [x.body for x in loads])
    ]
    return arrays.Gradients(ends[0], ends[1], floats(x.gm for x in loads))


def build_spatial(scene: Scene) -> tuple[Any, dict[int, Place]]:
    """Compile a spatial scene to SpatialGroups; also return where each joint's rows are."""
    build = _Builder(scene)
    rigid = np.array([isinstance(b, SpatialBody) for b in scene.bodies], dtype=int)
    inertia = [b.inertia if isinstance(b, SpatialBody) else _HELD_INERTIA for b in scene.bodies]
    groups = assembled(
        build,
        arrays.SpatialGroups,
        widths=np.array((3 + 4 * rigid, 3 + 3 * rigid)),
        inertia=floats(inertia, 6),
        forces=forces(build),
        torsion_springs=_torsion_springs(build),
        bushings=_bushings(build),
        attraction=_attraction(build),
        gradients=_gradients(build),
    )
    return groups, build.place
