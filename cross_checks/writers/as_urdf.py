"""A tree of bodies as a URDF file: every link's frame is its joint's, along the world's axes at t = 0.

URDF has neither gravity nor a start: readers take z up and the pose of the file. A planar scene is therefore written
in the plane of x and z, where its y is up; rates at the start stand in a comment.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cross_checks.linkage.links import FIXED, Link, Linkage, linkage_of
from cross_checks.writers import Form, refuse, xml
from mbs_ref import Settings
from mbs_ref.scene import Bushing, Drive, Scene, TorsionSpring

KINDS = {"revolute": "continuous", "prismatic": "prismatic", "weld": "fixed"}
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # a plane's x, y, z in the file's axes
ALONG = 1e-12  # of directions of length 1
WORLD = "world"


def write_urdf(scene: Scene, settings: Settings) -> str:
    """Return the scene as a URDF file; a single free body at the root becomes the file's root link.

    `settings` do not matter here. Raises NotWritable: closed loops, joints other than hinges, slides and welds, loads
    but the damper of a joint, contacts, particles, gravity that is not along -z (-y in the plane), two free bodies.
    """
    refuse(scene, "URDF", _untold(scene))
    linkage = linkage_of(scene)
    refuse(scene, "URDF", _refusals(linkage))
    floating = any(link.kind in ("free", "planar") for link in linkage.links)
    names = {link.body: link.name for link in linkage.links} | {FIXED: WORLD}
    turn = _turn(scene)
    return xml(
        "robot.urdf.j2",
        linkage=linkage, dampers=_dampers(linkage), names=names, world=WORLD, kinds=KINDS, joint_name=_joint_name,
        remarks=list(_remarks(linkage, floating=floating)), floating=floating,
        place=lambda vector: " ".join(repr(float(x) + 0.0) for x in turn @ vector),
        inertia_of=lambda link: (turn @ link.inertia @ turn.T).tolist(),
    )  # fmt: skip


def _untold(scene: Scene) -> Iterator[str]:
    """Yield what of a scene no URDF file holds, whatever its tree."""
    for contact in scene.contacts:
        yield f"contact {contact.name!r} has a law, and URDF has none"
    for load in scene.loads:
        if not isinstance(load, TorsionSpring | Bushing):
            yield f"load {load.name!r} is a {load.type}, and URDF has the damper of a joint alone"
    for joint in scene.joints:
        if isinstance(joint, Drive):
            yield f"joint {joint.name!r} prescribes a motion, and URDF has none"
    for event in scene.events:
        yield f"event {event.name!r} has no place in URDF"
    up = _turn(scene) @ np.resize((*scene.gravity, 0.0), 3)
    if up[2] > 0.0 or np.any(up[:2]):
        yield f"gravity is {list(scene.gravity)}: readers of URDF take it to be along -z (of the plane, along -y)"


def _turn(scene: Scene) -> np.ndarray:
    return Y_UP if scene.dimension == 2 else np.eye(3)


def _refusals(linkage: Linkage) -> Iterator[str]:
    for closure in linkage.closures:
        yield f"joint {closure.name!r} closes a loop, and URDF holds trees"
    free = [link.name for link in linkage.links if link.kind in ("free", "planar")]
    for link in linkage.links:
        joint = _joint_name(link)
        if link.kind not in (*KINDS, "free", "planar"):
            yield f"joint {joint!r} is a {link.kind} joint; URDF has hinges, slides and welds"
        if not link.inertia.any():
            yield f"body {link.name!r} is a particle, and readers of URDF want a moment of inertia of every link"
    if len(free) > 1:
        yield f"bodies {', '.join(map(repr, free))} are free, and a URDF file has one root"
    if len(free) == 1 and len([link for link in linkage.links if link.parent == FIXED]) > 1:
        yield f"body {free[0]!r} is free while others hang on ground, and a URDF file has one root"
    dampers = _dampers(linkage)
    for load in linkage.scene.loads:
        if load.name not in {one.name for one, _ in dampers.values()}:
            yield f"load {load.name!r} is not the damper of one joint alone, which is all that URDF has"


def _dampers(linkage: Linkage) -> dict[str, tuple[Any, float]]:
    """Return by bodies the loads that damp the one freedom of their link's joint, with their coefficients."""
    found = {}
    names = dict(enumerate(linkage.scene.body_names)) | {FIXED: "ground"}
    for link in linkage.links:
        for load in linkage.scene.loads:
            ends = {getattr(load, "body_a", ""), getattr(load, "body_b", "")}
            if ends == {link.name, names[link.parent]}:
                damping = _damping(load, link)
                if damping is not None:
                    found[link.name] = (load, damping)
    return found


def _damping(load: Any, link: Link) -> float | None:
    """Return what a load damps of a link's hinge or slide; None where it does anything else."""
    if isinstance(load, TorsionSpring) and link.kind == "revolute" and not load.stiffness:
        axis = link.axes[0] if load.axis is None else np.asarray(load.axis) / np.linalg.norm(load.axis)
        return load.damping if np.abs(np.cross(axis, link.axes[0])).max() < ALONG else None
    if isinstance(load, Bushing) and link.kind == "prismatic" and not any(load.stiffness) and not any(load.damping[1:]):
        axis = np.asarray(load.x_axis) / np.linalg.norm(load.x_axis)
        return load.damping[0] if np.abs(np.cross(axis, link.axes[0])).max() < ALONG else None
    return None


def _joint_name(link: Link) -> str:
    """Return the name of the scene's joint that hangs a link on its parent."""
    return link.joint or f"{link.name}_joint"


def _remarks(linkage: Linkage, *, floating: bool) -> Iterator[str]:
    """Yield what a reader of the file must know and URDF does not hold."""
    pull = float(np.linalg.norm(linkage.scene.gravity))
    yield f"gravity is {pull!r} m/s^2 along -z" + (f": mbs-ref ... -p gravity={pull!r}" if pull != 9.81 else "")
    if floating:
        yield "its root is free: mbs-ref ... -p base=free"
    for link in linkage.links:
        if np.any(link.rates):
            rates = ", ".join(map(repr, link.rates.tolist()))
            yield f"at t = 0 the rate of joint {_joint_name(link)} is {rates}"


FORMS = (Form("urdf", ".urdf", "a tree of links for any reader of URDF", write_urdf),)
