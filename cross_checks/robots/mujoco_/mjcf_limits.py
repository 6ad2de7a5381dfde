"""What of an MJCF model no scene holds: refused by name, left out where asked, or assumed and said."""

from collections.abc import Iterator

import numpy as np

from cross_checks.robots.mujoco_.mjcf_pose import CONNECT, SAME, SLIDE, WELD, Posed
from cross_checks.robots.robot import LOCKED

IGNORABLE = ("armature", "damping", "friction", "gravcomp", "springs", "tendons")


def refusals(posed: Posed) -> Iterator[str]:
    """Yield why the model is no scene."""
    yield from (why for why in posed.carried_by.values() if isinstance(why, str))
    for body in posed.moving:
        if not posed.model.body_mass[posed.parts(body)].sum() > 0.0:
            yield f"body {posed.name(body)!r} moves and has no mass"
    for word, told in _beyond(posed):
        if word not in posed.ignored:
            yield f"{told}; -p ignore={word} leaves it out"
    yield from _couplings(posed)
    option = posed.model.opt
    if option.density or option.viscosity or np.any(option.wind):
        yield "the model moves in a fluid (density, viscosity or wind)"
    if posed.model.nflex:
        yield "the model has deformable parts (flex)"


def _couplings(posed: Posed) -> Iterator[str]:
    """Yield what is wrong with equality constraints."""
    model = posed.model
    for e, _, (one, other) in posed.equalities():
        gap = float(np.abs(one - other).max())
        if gap > SAME:
            yield f"the loop of equality {model.equality(e).name or e!r} is open at the start by {gap:.2g} m"
    for e in range(model.neq):
        if model.eq_type[e] not in (CONNECT, WELD) and posed.data.eq_active[e]:
            name = model.equality(e).name or e
            yield f"equality {name!r} couples joints or tendons; -p JOINT={LOCKED} holds one still"


def _beyond(posed: Posed) -> Iterator[tuple[str, str]]:
    """Yield what a scene cannot hold and may be asked to leave out, by its word."""
    model = posed.model
    single = set(posed.single())
    shared = np.array([joint not in single for joint in model.dof_jntid], dtype=bool)
    strained = np.array([_is_strained(posed, int(joint)) for joint in model.dof_jntid], dtype=bool)
    stiffness, bent = model.jnt_stiffness[model.dof_jntid], _any_of(model.jnt_stiffnesspoly)[model.dof_jntid]
    damping, springs = shared & (model.dof_damping != 0.0), (stiffness != 0.0) & (shared | strained)
    several = "that are not linear, or of one of several joints of a body"
    words = {
        "armature": ("rotor inertia (armature) of ", model.dof_armature),
        "friction": ("dry friction of ", model.dof_frictionloss),
        "damping": (f"dampers {several}: ", damping | _any_of(model.dof_dampingpoly)),
        "springs": (f"springs {several}, or of a slide and strained at the start: ", springs | bent),
    }
    for word, (told, values) in words.items():
        if np.any(values):
            names = (posed.axis(int(model.dof_jntid[k])).joint for k in np.flatnonzero(values))
            yield word, told + ", ".join(dict.fromkeys(names))
    if np.any(model.body_gravcomp):
        yield "gravcomp", "bodies whose weight is compensated (gravcomp)"
    pulling = ("tendon_stiffness", "tendon_damping", "tendon_frictionloss", "tendon_armature")
    if any(np.any(getattr(model, name)) for name in pulling):
        yield "tendons", "tendons that pull"


def _any_of(rows: np.ndarray) -> np.ndarray:
    """Return which rows hold anything but zeros."""
    return np.any(rows.reshape(len(rows), -1) != 0.0, axis=1)


def _is_strained(posed: Posed, joint: int) -> bool:
    """Return whether a slide's spring is not relaxed at the start."""
    at = int(posed.model.jnt_qposadr[joint])
    return posed.model.jnt_type[joint] == SLIDE and abs(posed.model.qpos_spring[at] - posed.data.qpos[at]) > SAME


def assumptions(posed: Posed, locked: list[str]) -> Iterator[str]:
    """Yield what is assumed."""
    model = posed.model
    limited = [posed.axis(j).joint for j in range(model.njnt) if model.jnt_limited[j]]
    balls = [posed.name(body) for body in posed.moving if len(posed.joints_of(body)) == 3]
    welded = [model.body(b).name or str(b) for b in range(1, model.nbody) if model.body_weldid[b] != b]
    yield "shapes do not collide, and no actuator acts"
    if limited:
        yield f"no limits of place or effort: {', '.join(limited)} have some in the file"
    if balls:
        yield f"three hinges are taken as the ball that they make away from gimbal lock: {', '.join(balls)}"
    if welded:
        yield f"fixed to the bodies that carry them: {', '.join(welded)}"
    if locked:
        yield f"locked in their zero pose: {', '.join(locked)}"
    yield from (f"left out: {told}" for word, told in _beyond(posed) if word in posed.ignored)
