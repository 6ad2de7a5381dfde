"""An MJCF model at the start as parts of a scene; what no scene can represent is refused or assumed."""

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations
from typing import Any

import mujoco
import numpy as np

from cross_checks.robots import LOCKED, RATE, Axis, own_forces, plain, six, three
from mbs_ref.scene import GROUND, Cylindrical, Prismatic, Revolute, SpatialBody, Spherical, Universal, Weld
from mbs_ref.scene.euler_parameters import from_matrix

SAME = 1e-9  # m, of directions 1: two joints' points and axes are one, or square to each other
TAKEN = (
    "taken are one, two hinges that cross at right angles, three that cross, a slide along a hinge; "
    f"-p JOINT={LOCKED} holds one still"
)
SPREAD = 1e-6  # three hinges whose axes span less than this have lost a freedom
FREE, BALL, SLIDE, HINGE = (int(kind) for kind in (
    mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE,
))  # fmt: skip
CONNECT, WELD = int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)
IGNORABLE = ("armature", "damping", "friction", "gravcomp", "springs", "tendons")

type Pair = Revolute | Prismatic | Spherical | Universal | Cylindrical


class Posed:
    """The model's bodies at the start. Bodies without joints are parts of those that carry them."""

    def __init__(self, model: Any, start: dict[str, float], ignored: list[str]) -> None:
        self.model, self.data, self.ignored = model, mujoco.MjData(model), ignored
        for name, value in start.items():
            joint = model.joint(name.removesuffix(RATE))
            if name.endswith(RATE):
                self.data.qvel[joint.dofadr[0]] = value
            else:
                self.data.qpos[joint.qposadr[0]] = value
        mujoco.mj_forward(model, self.data)
        self.moving = [b for b in range(1, model.nbody) if model.body_weldid[b] == b]

    def name(self, body: int) -> str:
        """Return the name of what carries a body."""
        carrier = int(self.model.body_weldid[body])
        return GROUND if carrier == 0 else plain(self.model.body(carrier).name or f"body_{carrier}")

    def parts(self, body: int) -> list[int]:
        return [b for b in range(1, self.model.nbody) if self.model.body_weldid[b] == body]

    def body(self, body: int) -> SpatialBody:
        """Return a moving body with all that is welded to it; its body axes are MuJoCo's."""
        model, data, own = self.model, self.data, self.parts(body)
        mass = float(model.body_mass[own].sum())
        centre = (model.body_mass[own, None] * data.xipos[own]).sum(axis=0) / mass
        inertia = np.zeros((3, 3))
        for part in own:
            turn, arm = data.ximat[part].reshape(3, 3), data.xipos[part] - centre
            inertia += turn @ np.diag(model.body_inertia[part]) @ turn.T
            inertia += model.body_mass[part] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        axes = data.xmat[body].reshape(3, 3)
        inertia = axes.T @ inertia @ axes
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, linear, angular, centre, body)
        return SpatialBody(
            name=self.name(body), mass=mass, inertia=six(0.5 * (inertia + inertia.T)), position=three(centre),
            orientation=tuple(from_matrix(axes).tolist()), velocity=three(linear @ data.qvel),
            angular_velocity=three(angular @ data.qvel),
        )  # fmt: skip

    def joints_of(self, body: int) -> list[int]:
        first = int(self.model.body_jntadr[body])
        return list(range(first, first + int(self.model.body_jntnum[body])))

    def axis(self, j: int) -> Axis:
        body = int(self.model.jnt_bodyid[j])
        ends = self.name(int(self.model.body_parentid[body])), self.name(body)
        return Axis(plain(self.model.joint(j).name or f"joint_{j}"), *ends, three(self.data.xanchor[j]),
                    three(self.data.xaxis[j]), self.model.jnt_type[j] == SLIDE)  # fmt: skip

    @cached_property
    def carried_by(self) -> dict[int, Pair | str | None]:
        """Return the joint that carries each moving body, None where it is free, or why a scene has none such."""
        return {body: self._between(body) for body in self.moving}

    def _between(self, body: int) -> Pair | str | None:
        listed = self.joints_of(body)
        kinds, axes = [int(self.model.jnt_type[j]) for j in listed], [self.axis(j) for j in listed]
        if kinds == [FREE]:
            return None
        ends: dict[str, Any] = {"name": axes[0].joint, "body_a": axes[0].body_a, "body_b": axes[0].body_b}
        point, along = axes[-1].point, [np.array(axis.along) for axis in axes]
        together = all(np.abs(np.subtract(axis.point, point)).max() < SAME for axis in axes)
        square = all(abs(a @ b) < SAME for a, b in combinations(along, 2))
        match kinds:
            case [kind] if kind == BALL:
                return Spherical(**ends, point=point)
            case [kind] if kind == SLIDE:
                return Prismatic(**ends, point=point, axis=three(along[0]))
            case [kind] if kind == HINGE:
                return Revolute(**ends, point=point, axis=three(along[0]))
            case [a, b] if a == b == HINGE and together and square:
                return Universal(**ends, point=point, axis_a=three(along[0]), axis_b=three(along[1]))
            case [a, b, c] if a == b == c == HINGE and together and abs(np.linalg.det(along)) > SPREAD:
                return Spherical(**ends, point=point)
            case [a, b] if {a, b} == {SLIDE, HINGE} and np.abs(np.cross(along[0], along[1])).max() < SAME:
                return Cylindrical(**ends, point=point, axis=three(along[0]))
        turning = ", ".join(f"{axis.joint!r} {'slides' if axis.slides else 'turns'}" for axis in axes)
        return f"body {self.name(body)!r} has joints that no joint of a scene makes together ({turning}): {TAKEN}"

    def joints(self) -> Iterator[Pair]:
        yield from (pair for pair in self.carried_by.values() if pair is not None and not isinstance(pair, str))

    def closures(self) -> Iterator[Spherical | Weld]:
        """Yield what equality constraints close."""
        for e, (a, b), places in self.equalities():
            name = plain(self.model.equality(e).name or f"closure_{e}")
            ends: dict[str, Any] = {"name": name, "body_a": self.name(a), "body_b": self.name(b)}
            part = Spherical if self.model.eq_type[e] == CONNECT else Weld
            yield part(**ends, point=three(places[0]))

    def equalities(self) -> Iterator[tuple[int, tuple[int, int], tuple[np.ndarray, np.ndarray]]]:
        model, data = self.model, self.data
        for e in range(model.neq):
            if model.eq_type[e] in (CONNECT, WELD) and data.eq_active[e]:
                pair = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
                marks = model.eq_data[e, :6].reshape(2, 3)
                marks = marks[::-1] if model.eq_type[e] == WELD else marks  # MuJoCo keeps a weld's the other way round
                at = [data.xpos[b] + data.xmat[b].reshape(3, 3) @ mark for b, mark in zip(pair, marks, strict=True)]
                yield e, pair, (at[0], at[1])

    def loads(self) -> Iterator[Any]:
        model = self.model
        for j in self.single():
            stiffness = 0.0 if "springs" in self.ignored else float(model.jnt_stiffness[j])
            damping = 0.0 if "damping" in self.ignored else float(model.dof_damping[model.jnt_dofadr[j]])
            yield from own_forces(self.axis(j), stiffness, damping, self.strain(j))

    def strain(self, j: int) -> float:
        """Return how far (rad, m) the spring of a hinge or slide is from relaxed at the start."""
        at = int(self.model.jnt_qposadr[j])
        return float(self.model.qpos_spring[at] - self.data.qpos[at])

    def single(self) -> list[int]:
        """Return the hinges and slides that carry a body alone."""
        model = self.model
        plain = [j for j in range(model.njnt) if model.jnt_type[j] in (SLIDE, HINGE)]
        return [j for j in plain if len(self.joints_of(model.jnt_bodyid[j])) == 1]


def refusals(posed: Posed) -> Iterator[str]:
    """Yield why the model is no scene."""
    yield from (why for why in posed.carried_by.values() if isinstance(why, str))
    for body in posed.moving:
        if not posed.model.body_mass[posed.parts(body)].sum() > 0.0:
            yield f"body {posed.name(body)!r} moves and has no mass"
    for word, text in _beyond(posed):
        if word not in posed.ignored:
            yield f"{text}; -p ignore={word} leaves it out"
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
    """Yield the word and the text of each feature that no scene can represent and that `ignore` omits."""
    model = posed.model
    single = set(posed.single())
    shared = np.array([joint not in single for joint in model.dof_jntid], dtype=bool)
    slides = [model.jnt_type[j] == SLIDE and abs(posed.strain(int(j))) > SAME for j in model.dof_jntid]
    stiffness, bent = model.jnt_stiffness[model.dof_jntid], _any_of(model.jnt_stiffnesspoly)[model.dof_jntid]
    damping, springs = shared & (model.dof_damping != 0.0), (stiffness != 0.0) & (shared | np.array(slides, dtype=bool))
    several = "that are not linear, or of one of several joints of a body"
    words = {
        "armature": ("rotor inertia (armature) of ", model.dof_armature),
        "friction": ("dry friction of ", model.dof_frictionloss),
        "damping": (f"dampers {several}: ", damping | _any_of(model.dof_dampingpoly)),
        "springs": (f"springs {several}, or of a slide and strained at the start: ", springs | bent),
    }
    for word, (text, values) in words.items():
        if np.any(values):
            names = (posed.axis(int(model.dof_jntid[k])).joint for k in np.flatnonzero(values))
            yield word, text + ", ".join(dict.fromkeys(names))
    if np.any(model.body_gravcomp):
        yield "gravcomp", "bodies whose weight is compensated (gravcomp)"
    pulling = ("tendon_stiffness", "tendon_damping", "tendon_frictionloss", "tendon_armature")
    if any(np.any(getattr(model, name)) for name in pulling):
        yield "tendons", "tendons that pull"


def _any_of(rows: np.ndarray) -> np.ndarray:
    """Return which rows hold anything but zeros."""
    return np.any(rows.reshape(len(rows), -1) != 0.0, axis=1)


def assumptions(posed: Posed, locked: list[str]) -> Iterator[str]:
    """Yield what is assumed."""
    model = posed.model
    limited = [posed.axis(j).joint for j in range(model.njnt) if model.jnt_limited[j]]
    balls = [posed.name(body) for body in posed.moving if len(posed.joints_of(body)) == 3]
    welded = [model.body(b).name or str(b) for b in range(1, model.nbody) if model.body_weldid[b] != b]
    yield "shapes do not collide, and no actuator acts"
    named = {
        "no limits of place or effort: {} have some in the file": limited,
        "three hinges are taken as the ball that they make away from gimbal lock: {}": balls,
        "fixed to the bodies that carry them: {}": welded, "locked in their zero pose: {}": locked,
    }  # fmt: skip
    yield from (text.format(", ".join(names)) for text, names in named.items() if names)
    yield from (f"left out: {text}" for word, text in _beyond(posed) if word in posed.ignored)
