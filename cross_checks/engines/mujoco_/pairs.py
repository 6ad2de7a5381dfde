"""Contacts of a scene as MuJoCo's pairs of spheres, planes and boxes, and the effective mass of a pair."""

import mujoco
import numpy as np

from cross_checks.linkage.links import Linkage, Z, lifted
from mbs_ref.scene import GROUND
from mbs_ref.scene.base.part import normals, unit
from mbs_ref.scene.contact import CircleOnLine, RoundPair, SphereOnPlane
from mbs_ref.scene.euler_parameters import from_matrix

CORNER = 1e-9  # m, radius of the sphere that stands for a corner
REACH, THICK = 100.0, 1.0  # m: half length of an endless surface on a body, and depth of a box without a thickness
ENDLESS = (2.0 * REACH, 2.0 * REACH)  # m


def add_pair(spec, frames, linkage: Linkage, contact):
    """Add the two geoms of a contact and return their pair, apart from which neither touches anything."""
    if isinstance(contact, RoundPair):
        _add_sphere(frames, linkage, f"{contact.name}/b", contact.body_b, contact.center_b, contact.radius_b)
        first = (contact.center_a, contact.radius_a)
    else:
        _add_surface(frames, linkage, contact)
        first = (contact.center, contact.radius)
    _add_sphere(frames, linkage, f"{contact.name}/a", contact.body_a, *first)
    pair = spec.add_pair(name=contact.name, geomname1=f"{contact.name}/b", geomname2=f"{contact.name}/a")
    pair.margin, pair.gap, pair.condim = 0.0, 0.0, 1
    if contact.friction is not None:
        pair.condim, pair.friction = 3, (contact.friction.coefficient, contact.friction.coefficient, 0.0, 0.0, 0.0)
    return pair


def _add_geom(frames, linkage: Linkage, name: str, body: str, point, kind, **more) -> None:
    frame, place = frames[linkage.scene.body_index(body)], linkage.local(body, point)
    frame.add_geom(name=name, type=kind, pos=place, mass=0.0, contype=0, conaffinity=0, **more)


def _add_sphere(frames, linkage: Linkage, name: str, body: str, center, radius: float) -> None:
    size = (max(radius, CORNER), 0.0, 0.0)
    _add_geom(frames, linkage, name, body, center, mujoco.mjtGeom.mjGEOM_SPHERE, size=size)


def _add_surface(frames, linkage: Linkage, contact) -> None:
    """Add a plane to the world, or below a bounded or moving surface a box."""
    axes, middle, sides = frame_of(contact)
    place = (frames, linkage, f"{contact.name}/b", contact.body_b)
    if contact.body_b == GROUND and sides == ENDLESS and contact.thickness is None:
        kind, size = mujoco.mjtGeom.mjGEOM_PLANE, (0.0, 0.0, 1.0)
    else:
        depth = contact.thickness or THICK
        kind, size = mujoco.mjtGeom.mjGEOM_BOX, (0.5 * sides[0], 0.5 * sides[1], 0.5 * depth)
        middle = middle - 0.5 * depth * axes[:, 2]
    _add_geom(*place, middle, kind, size=size, quat=from_matrix(axes))


def frame_of(contact) -> tuple[np.ndarray, np.ndarray, tuple[float, float]]:
    """Return axes (3, 3) of a flat surface as columns, the normal last, its middle (3,) m, and its sides (m)."""
    if isinstance(contact, SphereOnPlane):
        normal, middle, sides = unit(contact.normal), lifted(contact.point), contact.size or ENDLESS
        along = unit(contact.edge) if contact.edge else normals(normal)[0]
    else:
        start, end = lifted(contact.point_1), lifted(contact.point_2)
        along = unit(end - start)
        bounded, normal = contact.extent != "line", np.cross(Z, along)
        middle = 0.5 * (start + end) if bounded else start
        sides = (float(np.linalg.norm(end - start)), 2.0 * REACH) if bounded else ENDLESS
    return np.column_stack((along, np.cross(normal, along), normal)), middle, sides


def effective_mass(model: mujoco.MjModel, data: mujoco.MjData, contact) -> float:
    """Return 1/(J M^-1 J^T) (kg) of a contact's normal at the pose of the data; closed loops are not considered."""
    geoms = [data.geom(f"{contact.name}/{end}") for end in "ab"]
    flat = isinstance(contact, CircleOnLine | SphereOnPlane)
    normal = frame_of(contact)[0][:, 2] if flat else unit(geoms[0].xpos - geoms[1].xpos)
    place = geoms[0].xpos - model.geom(geoms[0].id).size[0] * normal
    row, jacobian, solved = np.zeros((1, model.nv)), np.empty((3, model.nv)), np.empty((1, model.nv))
    for geom, sign in zip(geoms, (1.0, -1.0), strict=True):
        mujoco.mj_jac(model, data, jacobian, None, place, model.geom_bodyid[geom.id])
        row += sign * normal @ jacobian
    mujoco.mj_solveM(model, data, solved, row)
    return 1.0 / float((row @ solved.T).item())
