"""Loads as MuJoCo's own tendons, joint springs and actuators without control."""

from collections.abc import Iterable

import mujoco
import numpy as np

from cross_checks.engine.prescribed import constant_value
from cross_checks.linkage.links import Linkage, Z, rest_length, rest_turn
from mbs_ref.scene import Force, SpringDamper, Torque, TorqueVector, TorsionSpring

SAME_AXIS = 1e-9  # of directions of length 1


def add_tendon(spec, frames, name: str, ends: Iterable[tuple[int, np.ndarray]]):
    """Return a tendon between two points, each in the frame of its body."""
    tendon = spec.add_tendon(name=name)
    for end, (body, point) in enumerate(ends):
        frames[body].add_site(name=f"{name}/{end}", pos=point)
        tendon.wrap_site(f"{name}/{end}")
    return tendon


def _linear(coefficient: float) -> np.ndarray:
    """Return a linear law in the shape of the specification's polynomial coefficients."""
    return np.array([coefficient, 0.0, 0.0])


def _add_spring(spec, frames, linkage: Linkage, load: SpringDamper) -> None:
    ends = ((load.body_a, load.point_a), (load.body_b, load.point_b))
    places = [(linkage.scene.body_index(body), linkage.local(body, point)) for body, point in ends]
    tendon, rest = add_tendon(spec, frames, load.name, places), rest_length(load)
    tendon.stiffness, tendon.damping = _linear(load.stiffness), _linear(load.damping)
    tendon.springlength = (0.0 if load.tension_only else rest, rest)


def turning(linkage: Linkage, load: TorsionSpring) -> dict[str, float] | None:
    """Return by MuJoCo's joints what the angle of a torsion spring is a sum of; None where it is no such sum.

    Between bodies that no hinge parts it is an empty sum: the spring is inside of one body, and moves nothing.
    """
    axis = Z if load.axis is None else np.asarray(load.axis) / np.linalg.norm(load.axis)
    paths = [list(linkage.path(name)) for name in (load.body_b, load.body_a)]
    weights: dict[str, float] = {}
    for path, other, sign in ((*paths, 1.0), (*paths[::-1], -1.0)):
        for link in path:
            for k, (kind, along) in enumerate(link.freedoms if link not in other else ()):
                if kind == "slide":
                    continue
                if kind != "turn" or np.abs(np.cross(along, axis)).max() > SAME_AXIS:
                    return None
                weights[f"{link.name}/{k}"] = sign * float(np.sign(along @ axis))
    return weights


def _add_torsion(spec, frames, linkage: Linkage, load: TorsionSpring) -> None:
    """Add the spring and damper of one hinge, whose damping MuJoCo's Euler takes implicitly; else of a tendon."""
    weights = turning(linkage, load)
    if not weights:
        return
    rest = rest_turn(linkage.scene, load)
    first, sign = next(iter(weights.items()))
    hinge = spec.joint(first)
    if len(weights) == 1 and not np.any((hinge.stiffness, hinge.damping)):
        hinge.stiffness, hinge.damping, hinge.springref = _linear(load.stiffness), _linear(load.damping), sign * rest
        return
    tendon = spec.add_tendon(name=load.name)
    for label, weight in weights.items():
        tendon.wrap_joint(label, weight)
    tendon.stiffness, tendon.damping, tendon.springlength = _linear(load.stiffness), _linear(load.damping), (0.0, 0.0)
    if rest:
        _motor(spec, load.name, mujoco.mjtTrn.mjTRN_TENDON, load.name, load.stiffness * rest)


def _motor(spec, name: str, transmission, target: str, force: float, refsite: str = "", gear=(1.0, 0, 0, 0, 0, 0)):
    """A constant force: the actuator's bias alone, so that no control input is needed."""
    motor = spec.add_actuator(name=name, trntype=transmission, target=target, gear=gear)
    if refsite:
        motor.refsite = refsite
    motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    motor.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    motor.gainprm[0] = 0.0
    motor.biasprm[0] = force


def _add_push(spec, frames, linkage: Linkage, load: Force | Torque | TorqueVector) -> None:
    """Add a constant force or torque at a site, along its axes or along those of a site at rest."""
    scene, scale = linkage.scene, constant_value(load.factor) or 0.0
    k = scene.body_index(load.body)
    point = load.point if isinstance(load, Force) else scene.bodies[k].position
    frames[k].add_site(name=load.name, pos=linkage.local(load.body, point))
    vector = scale * (load.torque * Z if isinstance(load, Torque) else np.resize((*load.vector, 0.0), 3))
    gear = (*vector, 0.0, 0.0, 0.0) if isinstance(load, Force) else (0.0, 0.0, 0.0, *vector)
    reference = f"{load.name}/world" if getattr(load, "frame", "body") == "world" else ""
    if reference:
        spec.worldbody.add_site(name=reference, pos=linkage.local("ground", point))
    _motor(spec, load.name, mujoco.mjtTrn.mjTRN_SITE, load.name, 1.0, reference, gear)


LOADS = {
    **dict.fromkeys((Force, Torque, TorqueVector), _add_push), SpringDamper: _add_spring, TorsionSpring: _add_torsion,
}  # fmt: skip


def load_refusals(linkage: Linkage) -> list[str]:
    """Return why MuJoCo's own elements cannot stand for the scene's loads, load by load."""
    reasons = []
    for load in linkage.scene.loads:
        where = f"load {load.name!r}"
        if type(load) not in LOADS:
            reasons.append(f"{where}: mujoco is not yet taught {load.type}")
        elif isinstance(load, Force | Torque | TorqueVector) and constant_value(load.factor) is None:
            reasons.append(f"{where} varies in time, which mujoco is not yet taught")
        elif isinstance(load, SpringDamper) and load.tension_only and load.damping:
            reasons.append(f"{where}: a mujoco tendon damps while slack, so tension_only allows no damping")
        elif isinstance(load, SpringDamper) and load.limit is not None:
            reasons.append(f"{where}: a mujoco tendon has no limit of its pull")
        elif isinstance(load, TorsionSpring) and turning(linkage, load) is None:
            reasons.append(f"{where} acts about no hinges between its bodies, which mujoco is not yet taught")
    return reasons
