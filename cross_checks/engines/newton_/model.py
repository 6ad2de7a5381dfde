"""A scene as Newton's model: every body's frame is its joint's, along the world's axes at t = 0."""

# The extra has no type information here.
# pyright: reportMissingImports=false

from importlib.metadata import version
from typing import Any

version("newton")  # its absence means engine-missing, and is reported before that of Warp

import warp

from mbs_ref.kernels.jit import cache_folder

# Newton's modules read these settings of Warp when they are imported.
warp.config.log_level = warp.LOG_ERROR  # else it writes to stdout
warp.config.kernel_cache_dir = str(cache_folder() / "warp")
warp.config.enable_backward = False  # derivatives of kernels, unused: without them compiling takes a tenth

# ruff: noqa: E402
# isort: split

import newton
import numpy as np

from cross_checks.linkage.links import Link, Linkage
from cross_checks.linkage.tree import FIXED
from mbs_ref.scene.euler_parameters import rotation_matrices

DEVICE = "cpu"
X, Y, Z = np.eye(3)


def model_of(linkage: Linkage) -> Any:
    """Return the model; each tree is an articulation, whose joints have to be numbered in one piece.

    The check of inertias is left out: it adds 1e-6 kg m^2 to bodies that have none, as point masses do.
    """
    builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=tuple(linkage.gravity))
    bodies = {FIXED: -1}
    for tree in trees_of(linkage):
        joints = []
        for link in tree:
            bodies[link.body] = builder.add_link(
                xform=warp.transform(link.origin, warp.quat_identity()), mass=link.mass,
                com=warp.vec3(*link.centre), inertia=warp.mat33(*link.inertia.ravel()), lock_inertia=True,
                label=link.name,
            )  # fmt: skip
            joint = _add_joint(builder, bodies[link.parent], bodies[link.body], linkage, link)
            start = builder.joint_qd_start[joint]
            builder.joint_qd[start : start + len(link.rates)] = link.rates.tolist()
            joints.append(joint)
        builder.add_articulation(joints)
    return builder.finalize(device=DEVICE, skip_validation_inertia=True)


def trees_of(linkage: Linkage) -> list[list[Link]]:
    """Return the links tree by tree, each after its parent."""
    trees: dict[int, list[Link]] = {}
    root: dict[int, int] = {}
    for link in linkage.links:
        root[link.body] = link.body if link.parent == FIXED else root[link.parent]
        trees.setdefault(root[link.body], []).append(link)
    return list(trees.values())


def _axis(direction: np.ndarray) -> Any:
    return newton.ModelBuilder.JointDofConfig(axis=warp.vec3(*direction), armature=0.0, friction=0.0, damping=0.0)


def _add_joint(builder: Any, parent: int, child: int, linkage: Linkage, link: Link) -> int:
    """Add the joint, whose frames stand along the world's axes at t = 0; return its number."""
    place = {"parent_xform": warp.transform(link.origin - linkage.origin(link.parent), warp.quat_identity())}
    slides, turns = {
        "prismatic": (link.axes, ()), "revolute": ((), link.axes), "universal": ((), link.axes),
        "cylindrical": (link.axes[:1], link.axes[1:]), "planar": ((X, Y), (Z,)),
    }.get(link.kind, ((), ()))  # fmt: skip
    if link.kind == "weld":
        return builder.add_joint_fixed(parent, child, **place)
    if link.kind == "free":
        return builder.add_joint_free(child, parent=parent)
    if link.kind == "ball":
        return builder.add_joint_ball(parent, child, armature=0.0, friction=0.0, damping=0.0, **place)
    if link.kind == "revolute":
        return builder.add_joint_revolute(parent, child, axis=_axis(turns[0]), **place)
    if link.kind == "prismatic":
        return builder.add_joint_prismatic(parent, child, axis=_axis(slides[0]), **place)
    sliding, turning = map(_axis, slides), map(_axis, turns)
    return builder.add_joint_d6(parent, child, linear_axes=list(sliding), angular_axes=list(turning), **place)


def row_of(state: Any) -> np.ndarray:
    """Return coordinates, their rates, poses and velocities, one after the other."""
    parts = (state.joint_q, state.joint_qd, state.body_q, state.body_qd)
    return np.concatenate([part.numpy().ravel() for part in parts], dtype=float)


class Reader:
    """Reads rows as `row_of` makes them; velocities are those of centres of mass."""

    def __init__(self, linkage: Linkage, model: Any) -> None:
        links = [link for tree in trees_of(linkage) for link in tree]
        self.split = np.cumsum([model.joint_coord_count, model.joint_dof_count, 7 * len(links)])
        self.order = np.argsort([link.body for link in links])  # of Newton's bodies, in the scene
        self.centres = np.array([links[k].centre for k in self.order])
        numbers = {link.body: k for k, link in enumerate(links)}
        counted = [(numbers[link.body], k) for link in linkage.links for k in range(link.size)]
        starts = model.joint_q_start.numpy(), model.joint_qd_start.numpy()
        self.places, self.rates = ([int(start[joint]) + k for joint, k in counted] for start in starts)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q, v, *_ = np.split(state, self.split)
        return q[self.places], v[self.rates]

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        *_, poses, twists = np.split(state, self.split)
        place, twist = poses.reshape(-1, 7)[self.order], twists.reshape(-1, 6)[self.order]
        theta = place[:, [6, 3, 4, 5]]
        turn = rotation_matrices(theta / np.linalg.norm(theta, axis=1, keepdims=True))
        centre = place[:, :3] + np.einsum("nij,nj->ni", turn, self.centres)
        return turn, centre, twist[:, :3], twist[:, 3:]
