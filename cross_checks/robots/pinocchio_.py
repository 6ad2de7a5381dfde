"""A robot in a URDF file as a scene, read by Pinocchio's own parser; and Pinocchio's dynamics of a file."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from cross_checks import robots
from cross_checks.robots import Axis, Robot, RobotError, of_file, own_forces, plain, refuse, six, three, unknown
from cross_checks.robots.parity import Dynamics, Unreadable, Values
from mbs_ref.scene import GROUND, Bushing, Prismatic, Revolute, Scene, SpatialBody, TorsionSpring
from mbs_ref.scene.euler_parameters import from_matrix

OPTIONS = "gravity, duration, base, ignore"
IGNORABLE = ("damping", "friction")
FREE = "root_joint"  # Pinocchio's name of the joint that a free root has
TURNING, SLIDING = ("revolute", "continuous"), ("prismatic",)


class Element(NamedTuple):
    """What the file says of one joint, and Pinocchio's model does not."""

    name: str
    kind: str
    child: str  # link
    damping: float  # N m s/rad
    friction: float  # N m
    limited: bool
    mimics: bool


def read_urdf(path: Path, given: Mapping[str, Any] | None = None) -> Robot:
    """Read a robot, at rest in its zero pose with its root fixed to the ground unless `given` says otherwise.

    `given` holds joint values (rad, m) by joint names, or "locked" for one that shall not move, rates (rad/s, m/s) as
    `joint.rate`, `gravity` (m/s^2, down along z), `duration` (s), `base`: "fixed" or "free", and `ignore`: a
    comma-separated list of IGNORABLE that the file has and the scene leaves out. Links behind fixed joints are parts of
    the link that carries them. Raises RobotError: no URDF, a joint that is floating, planar or
    mimics another, dry friction, a moving link without mass or with an inertia that no body has, an unknown name.
    """
    asked = dict(given or {})
    gravity, duration = float(asked.pop("gravity", 9.81)), float(asked.pop("duration", 1.0))
    base = str(asked.pop("base", "fixed"))
    if base not in ("fixed", "free"):
        raise RobotError(f"-p base={base}: allowed: fixed, free")
    ignored = [word for word in str(asked.pop("ignore", "")).split(",") if word]
    refuse(path, (f"-p ignore={word}: allowed: {', '.join(IGNORABLE)}" for word in ignored if word not in IGNORABLE))
    named = {element.name: element for element in _elements(path)}
    elements = {name: element._replace(**dict.fromkeys(ignored, 0.0)) for name, element in named.items()}
    movable = [name for name, element in elements.items() if element.kind != "fixed"]
    refuse(path, (unknown(name, movable, OPTIONS) for name in asked if name.removesuffix(robots.RATE) not in movable))
    locked = [name for name, value in asked.items() if value == robots.LOCKED]
    elements |= {name: elements[name]._replace(kind="fixed", mimics=False) for name in locked}
    refuse(path, _refusals(elements.values()))
    model = _model(path, locked, base == "free")
    if base == "free":
        elements[FREE] = Element(FREE, "floating", robots.base_of(path), 0.0, 0.0, False, False)
    start = {name: float(value) for name, value in asked.items() if value != robots.LOCKED}
    moving = _Posed(model, elements, start)
    refuse(path, moving.massless())
    with of_file(path):
        scene = Scene(
            name=plain(path.stem), source=path.name, description=f"The robot {model.name}, let go: no actuator acts.",
            duration=duration,
            gravity=(0.0, 0.0, -gravity), bodies=tuple(map(moving.body, moving.joints)),
            joints=tuple(moving.constraints()), loads=tuple(moving.dampers()), parameters=dict(given or {}),
        )  # fmt: skip
    return Robot(scene, (*_assumptions(elements.values(), base), *_left_out(named.values(), ignored)))


def _model(path: Path, locked: list[str], free: bool) -> Any:
    """Return Pinocchio's model, its root free or not, with some joints fixed in their zero pose."""
    root = (pinocchio.JointModelFreeFlyer(),) if free else ()
    try:
        model = pinocchio.buildModelFromUrdf(str(path), *root)
    except (ValueError, RuntimeError) as error:
        raise RobotError(f"{path}: Pinocchio cannot read it: {error}") from error
    kept = [model.getJointId(name) for name in locked]
    return pinocchio.buildReducedModel(model, kept, pinocchio.neutral(model)) if kept else model


def _elements(path: Path) -> Iterator[Element]:
    for joint in robots.root_of(path, "robot").findall("joint"):
        dynamics, child = joint.find("dynamics"), joint.find("child")
        numbers = {} if dynamics is None else dynamics.attrib
        yield Element(
            joint.get("name", ""), joint.get("type", ""), "" if child is None else child.get("link", ""),
            float(numbers.get("damping", 0.0)), float(numbers.get("friction", 0.0)), joint.find("limit") is not None,
            joint.find("mimic") is not None,
        )  # fmt: skip


def _refusals(elements) -> Iterator[str]:
    for element in elements:
        if element.kind == "fixed":
            continue
        if element.kind not in (*TURNING, *SLIDING):
            yield f"joint {element.name!r} is {element.kind}; taken: revolute, continuous, prismatic, fixed"
        if element.mimics:
            yield f"joint {element.name!r} mimics another; -p {element.name}={robots.LOCKED} holds it still"
        if element.friction:
            what = f"joint {element.name!r} has dry friction of {element.friction:g}; scenes have none in joints"
            yield f"{what}; -p ignore=friction leaves it out"


def _assumptions(elements, base: str) -> Iterator[str]:
    limited = [element.name for element in elements if element.limited and element.kind not in ("fixed", "continuous")]
    fixed = [element.child for element in elements if element.kind == "fixed"]
    yield "the root is fixed to the ground, and z is up" if base == "fixed" else "the root is free, and z is up"
    yield "links do not collide: their shapes are not read"
    named = {"no limits of place, rate or effort: {} have some in the file": limited,
             "fixed to the links that carry them: {}": fixed}  # fmt: skip
    yield from (text.format(", ".join(names)) for text, names in named.items() if names)


def _left_out(elements, ignored: list[str]) -> Iterator[str]:
    for word in ignored:
        names = [element.name for element in elements if getattr(element, word)]
        yield f"left out: {word} of {', '.join(names) or 'no joint'}"


class _Posed:
    """The robot's links at the start."""

    def __init__(self, model: Any, elements: dict[str, Element], start: dict[str, float]) -> None:
        self.model, self.elements, self.data = model, elements, model.createData()
        self.joints = range(1, model.njoints)
        q, v = pinocchio.neutral(model), np.zeros(model.nv)
        for i in self.joints:
            joint, name = model.joints[i], model.names[i]
            if joint.nv > 1:  # a free root stays where it is, and its axis is nobody's
                continue
            turn = start.get(name, 0.0)
            q[joint.idx_q : joint.idx_q + joint.nq] = turn if joint.nq == 1 else (np.cos(turn), np.sin(turn))
            v[joint.idx_v] = start.get(name + robots.RATE, 0.0)
        pinocchio.forwardKinematics(model, self.data, q, v)
        self.q = q

    def link(self, i: int) -> str:
        return plain(self.elements[self.model.names[i]].child)

    def massless(self) -> Iterator[str]:
        for i in self.joints:
            if not self.model.inertias[i].mass > 0.0:
                yield f"link {self.link(i)!r} moves and has no mass"

    def body(self, i: int) -> SpatialBody:
        """Return the link that joint i carries; its body axes are the joint's."""
        inertia, place, rate = self.model.inertias[i], self.data.oMi[i], self.data.v[i]
        turn, arm = np.array(place.rotation), np.array(inertia.lever)
        velocity = turn @ (rate.linear + np.cross(rate.angular, arm))
        moments = np.array(inertia.inertia)
        return SpatialBody(
            name=self.link(i), mass=inertia.mass, inertia=six(0.5 * (moments + moments.T)),
            position=three(place.act(arm)), orientation=tuple(from_matrix(turn).tolist()), velocity=three(velocity),
            angular_velocity=three(turn @ rate.angular),
        )  # fmt: skip

    def constraints(self) -> Iterator[Revolute | Prismatic]:
        for axis in (self.axis(i) for i in self.joints if self.model.names[i] != FREE):
            kind = Prismatic if axis.slides else Revolute
            yield kind(name=axis.joint, body_a=axis.body_a, body_b=axis.body_b, point=axis.point, axis=axis.along)

    def dampers(self) -> Iterator[TorsionSpring | Bushing]:
        for i in self.joints:
            yield from own_forces(self.axis(i), 0.0, self.elements[self.model.names[i]].damping)

    def axis(self, i: int) -> Axis:
        """Return the axis of joint i in the world, from the columns of its Jacobian in its own axes."""
        model, name, parent = self.model, self.model.names[i], self.model.parents[i]
        jacobian = pinocchio.computeJointJacobian(model, model.createData(), self.q, i)
        column, slides = jacobian[:, model.joints[i].idx_v], self.elements[name].kind in SLIDING
        along = np.array(self.data.oMi[i].rotation) @ (column[:3] if slides else column[3:])
        ends = GROUND if parent == 0 else self.link(parent), self.link(i)
        return Axis(plain(name), *ends, three(self.data.oMi[i].translation), three(along), slides)


def by_pinocchio(path: Path, q: Values, v: Values) -> Dynamics:
    """Return the dynamics that Pinocchio computes; the other joints stay neutral."""
    read = pinocchio.buildModelFromUrdf if path.suffix == ".urdf" else pinocchio.buildModelFromMJCF
    try:
        model = read(str(path))
    except (ValueError, RuntimeError) as error:
        raise Unreadable(str(error).strip().splitlines()[0]) from error
    model = model[0] if isinstance(model, tuple) else model
    unknown = [name for name in q if not model.existJointName(name)]
    if unknown:
        raise Unreadable(f"it has no joint {', '.join(unknown)}")
    data = model.createData()
    index = [model.joints[model.getJointId(name)].idx_v for name in q]
    turned, rates = np.zeros((2, model.nv))
    turned[index], rates[index] = list(q.values()), list(v.values())
    places = pinocchio.integrate(model, pinocchio.neutral(model), turned)
    upper = np.triu(pinocchio.crba(model, data, places))
    mass = upper + np.triu(upper, 1).T
    gravity = pinocchio.computeGeneralizedGravity(model, data, places).copy()
    bias = pinocchio.nonLinearEffects(model, data, places, rates).copy()
    return Dynamics(mass[np.ix_(index, index)], gravity[index], bias[index])


READER = by_pinocchio
