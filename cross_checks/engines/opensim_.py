"""OpenSim: Simbody's minimal coordinates, loops by constraints that every step is projected on."""

import ctypes
import math
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import opensim  # an optional extra

from cross_checks.engine import RTOLS, STEPS, End, Loop, Method, Plan, Refusal
from cross_checks.linkage.forces import LinkageEngine
from cross_checks.linkage.links import FIXED, SIX, Closure, Link, Linkage, linkage_of, rest_length
from mbs_ref import Status
from mbs_ref.scene import Scene, SpringDamper
from mbs_ref.scene.traits import traits

STEPPED = "_fixed"
SHORTEST = 2e-8  # of a run: no step is shorter, whatever its error, for 5e7 steps are the most that a run may take
ENDLESS = "cpodes"  # in loops: no limit on steps ends it (seen in 4.6 on spatial_n_four_bar at 1e-8)
INTEGRATORS = {"rk_merson": "RungeKuttaMerson", "rk_feldberg": "RungeKuttaFeldberg", "rk3": "RungeKutta3",
               "verlet": "Verlet", "cpodes": "CPodes"}  # fmt: skip
METHODS = (
    Method("rk_merson", "adaptive", 4, "OpenSim's default: Runge-Kutta-Merson", RTOLS, embedded=3),
    Method("rk_feldberg", "adaptive", 5, "Runge-Kutta-Fehlberg", RTOLS),
    Method("rk3", "adaptive", 3, "Runge-Kutta 3 with an embedded estimate", RTOLS, embedded=2),
    Method("verlet", "adaptive", 2, "velocity Verlet", RTOLS[:4]),
    Method("cpodes", "adaptive", None, "CPODES: variable-order BDF", RTOLS),
    Method("rk_merson" + STEPPED, "fixed", 4, "Runge-Kutta-Merson at a fixed step", STEPS),
)
LEVEL = "Error"  # of what OpenSim prints otherwise

STRAIGHT = np.eye(3)
KINDS = {"revolute": "Pin", "prismatic": "Slider"}  # of joints, where OpenSim's name is another


def model_of(linkage: Linkage) -> tuple[Any, list[Any]]:
    """Return the model and the links' joints; rates at t = 0 are the coordinates' default speeds."""
    model = opensim.Model()
    model.setGravity(_vector(linkage.gravity))
    bodies = {FIXED: model.getGround()}
    joints = []
    for link in linkage.links:
        inertia = opensim.Inertia(*link.inertia[SIX].tolist())
        bodies[link.body] = body = opensim.Body(link.name, link.mass, _vector(link.centre), inertia)
        model.addBody(body)
        joints.append(_joint(link, bodies[link.parent], link.origin - linkage.origin(link.parent), body))
        model.addJoint(joints[-1])
    for closure in linkage.closures:
        for constraint in _constraints(bodies, linkage, closure):
            model.addConstraint(constraint)
    for load in linkage.scene.loads:
        assert isinstance(load, SpringDamper)  # every other load is refused before
        model.addForce(_spring(bodies, linkage, load))
    return model, joints


def _vector(x) -> Any:
    return opensim.Vec3(*(float(value) for value in x))


def _axes(link: Link) -> np.ndarray:
    """Return the joint's frame: pins turn about its z, sliders move along its x, universal joints turn about both."""
    if link.kind == "universal":
        return np.column_stack((*link.axes, np.cross(*link.axes)))
    if not len(link.axes):
        return STRAIGHT
    axis = link.axes[0]
    side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    return np.column_stack((side, other, axis) if link.kind == "revolute" else (axis, side, other))


def _angles(frame: np.ndarray) -> Any:
    """Return turns about the body's x, y and z in that order."""
    y = math.asin(max(-1.0, min(1.0, frame[0, 2])))
    if abs(frame[0, 2]) > 1.0 - 1e-12:  # x and z turn about the same line
        return opensim.Vec3(0.0, y, math.atan2(frame[1, 0], frame[1, 1]))
    return opensim.Vec3(math.atan2(-frame[1, 2], frame[2, 2]), y, math.atan2(-frame[0, 1], frame[0, 0]))


def _joint(link: Link, parent: Any, place: np.ndarray, body: Any) -> Any:
    angles, here = _angles(_axes(link)), opensim.Vec3(0.0)
    create = getattr(opensim, f"{KINDS.get(link.kind, link.kind.capitalize())}Joint")
    joint = create(f"{link.name}_joint".replace("/", "_"), parent, _vector(place), angles, body, here, angles)
    turning_first = link.rates[[2, 0, 1]] if link.kind == "planar" else link.turning_first
    for k, rate in enumerate(turning_first):
        joint.get_coordinates(k).setDefaultSpeedValue(float(rate))
    return joint


def _constraints(bodies: dict[int, Any], linkage: Linkage, closure: Closure) -> list[Any]:
    """Return what ties two bodies; a hinge is a shared point, and a point of b on the axis in a."""
    a, b = bodies[closure.a], bodies[closure.b]
    on_a, on_b = closure.point_a - linkage.origin(closure.a), closure.point_b - linkage.origin(closure.b)
    at_a, at_b = _vector(on_a), _vector(on_b)
    if closure.kind == "rod":
        return [opensim.ConstantDistanceConstraint(a, at_a, b, at_b, closure.length)]
    if closure.kind == "weld":
        return [opensim.WeldConstraint(closure.name, a, at_a, opensim.Vec3(0.0), b, at_b, opensim.Vec3(0.0))]
    shared = [opensim.PointConstraint(a, at_a, b, at_b)]
    if closure.kind == "hinge":
        axis = _vector(closure.axis)
        shared.append(opensim.PointOnLineConstraint(a, axis, at_a, b, _vector(on_b + closure.axis)))
    return shared


def _spring(bodies: dict[int, Any], linkage: Linkage, load: SpringDamper) -> Any:
    ends = []
    for name, point in ((load.body_a, load.point_a), (load.body_b, load.point_b)):
        ends += [bodies[linkage.scene.body_index(name)], _vector(linkage.local(name, point))]
    return opensim.PointToPointSpring(*ends, load.stiffness, rest_length(load))


def values(state: Any) -> np.ndarray:
    """Return a copy of Simbody's state vector."""
    return np.array(state.getY().to_numpy())


class Reader:
    """Reads state vectors in a state of its own."""

    def __init__(self, linkage: Linkage, model: Any, joints: list[Any], state: Any) -> None:
        self.model, self.state = model, opensim.State(state)
        self.bodies = [model.getBodySet().get(link.name) for link in linkage.of_body]
        self.centres = np.array([link.centre for link in linkage.of_body])
        self.counted = [
            joint.get_coordinates(k)
            for joint, link in zip(joints, linkage.links, strict=True)
            for k in ((1, 2, 0) if link.kind == "planar" else range(link.size))[: link.size]  # it turns, then slides
        ]

    def _put(self, state: np.ndarray) -> None:
        self.state.setY(opensim.Vector.createFromMat(state))
        self.model.realizeVelocity(self.state)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self._put(state)
        places = [coordinate.getValue(self.state) for coordinate in self.counted]
        return np.array(places), np.array([coordinate.getSpeedValue(self.state) for coordinate in self.counted])

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        self._put(state)
        placed = [body.getTransformInGround(self.state) for body in self.bodies]
        moving = [body.getVelocityInGround(self.state) for body in self.bodies]
        turns = [place.R().asMat33() for place in placed]
        turn = np.array([[[matrix.get(i, j) for j in range(3)] for i in range(3)] for matrix in turns])
        omega = np.array([velocity.get(0).to_numpy() for velocity in moving])
        arm = np.einsum("nij,nj->ni", turn, self.centres)
        centre = np.array([place.p().to_numpy() for place in placed]) + arm
        speed = np.array([velocity.get(1).to_numpy() for velocity in moving]) + np.cross(omega, arm)
        return turn, centre, speed, omega


class Counts(NamedTuple):
    """Of all integrations since the manager was initialized; zeros where the log states none."""

    steps: int = 0
    rhs_calls: int = 0
    rejected_steps: int = 0


def counted(manager: Any, t: float) -> tuple[Any, Counts]:
    """Integrate to time t (s); return the state, and what was counted since the manager was initialized.

    Nothing that OpenSim prints reaches standard output.
    """
    sink = opensim.StringLogSink()
    opensim.Logger.removeFileSink()
    opensim.Logger.addSink(sink)
    with _unprinted():
        opensim.Logger.setLevelString("Info")
        try:
            state = manager.integrate(t)
        finally:
            opensim.Logger.setLevelString(LEVEL)
            opensim.Logger.removeSink(sink)
    return state, _read(sink.getString())


def _read(log: str) -> Counts:
    steps = re.search(r"steps taken / attempted: (\d+) / (\d+)", log)
    calls = re.search(r"number of realizations: (\d+)", log)
    if steps is None or calls is None:
        return Counts()
    taken, attempted = map(int, steps.groups())
    return Counts(taken, int(calls[1]), attempted - taken)


@contextmanager
def _unprinted() -> Iterator[None]:
    """Send what the process prints to nowhere, native code's prints among it."""
    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    flush(None)
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    try:
        yield
    finally:
        flush(None)
        os.dup2(kept, 1)
        os.close(kept)


opensim.Logger.setLevelString(LEVEL)


@dataclass(frozen=True)
class Built:
    """An OpenSim model, its manager, and its state at t = 0."""

    linkage: Linkage
    model: Any
    manager: Any
    start: Any
    reader: Reader
    applied: None = None  # OpenSim's own springs act


class OpenSim(LinkageEngine):
    """OpenSim's Manager over Simbody."""

    name: ClassVar[str] = "opensim"
    package: ClassVar[str] = "opensim"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    takes_loads: ClassVar[bool] = False
    lacks: ClassVar[frozenset[str]] = frozenset({"cylindrical"})
    extra: ClassVar[frozenset[str]] = frozenset({"spring_damper"})
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld", "rod"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = [
            f"load {load.name!r}: opensim's spring between points has no damping and pushes as well as it pulls"
            for load in scene.loads
            if isinstance(load, SpringDamper) and (load.damping or load.tension_only)
        ]
        return super().topology_refusals(scene) + [Refusal(reason, permanent=False) for reason in reasons]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name == ENDLESS and "closed-loop" in traits(scene):
            reasons.append(
                Refusal(f"{method.name} makes steps of no length without end in a loop's singular pose", True)
            )
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        model, joints = model_of(linkage)
        state = model.initSystem()
        # settings count only before the manager is initialized
        manager = opensim.Manager(model)
        chosen = INTEGRATORS[plan.method.name.removesuffix(STEPPED)]
        manager.setIntegratorMethod(getattr(opensim.Manager, f"IntegratorMethod_{chosen}"))
        if plan.method.kind == "fixed":
            manager.setIntegratorFixedStepSize(plan.step)
        else:
            manager.setIntegratorAccuracy(plan.rtol)
            manager.setIntegratorMinimumStepSize(SHORTEST * float(plan.times[-1]))
        manager.setWriteToStorage(False)
        manager.setPerformAnalyses(False)
        manager.setRecordStatesTrajectory(False)
        return Built(linkage, model, manager, state, Reader(linkage, model, joints, state))

    def advance(self, model: Built, plan: Plan) -> Loop:
        manager = model.manager
        state = model.start
        states = np.full((len(plan.times), len(values(state))), np.nan)
        states[0] = values(state)
        state.setTime(0.0)
        manager.initialize(state)
        counts = Counts(sum(plan.counts))
        for k, t in enumerate(plan.times[1:].tolist(), start=1):
            try:
                if k == len(plan.times) - 1 and plan.method.kind == "adaptive":
                    state, counts = counted(manager, t)
                else:
                    state = manager.integrate(t)
            except RuntimeError as error:
                return Loop(states, _failure(error, k))
            if abs(state.getTime() - t) > 1e-9 * plan.times[-1]:
                reason = f"opensim came back at t = {state.getTime():g} s without a word"
                return Loop(states, End(k, Status.ENGINE_ERROR, reason))
            states[k] = values(state)
        if counts.steps > plan.max_steps:
            reason = f"max_steps = {plan.max_steps} were used up: {counts.steps} steps"
            return Loop(states, End(len(states), Status.TOO_MANY_STEPS, reason), *counts)
        return Loop(states, End(len(states)), *counts)


ENGINE = OpenSim


def _failure(error: RuntimeError, k: int) -> End:
    """Return the end before sample k in Simbody's own words, which begin after the place in its source."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and "thrown at" not in line]
    stuck = "Unable to advance time" in str(error)
    words = " ".join(lines) or "no reason given"
    return End(k, Status.STEP_TOO_SMALL if stuck else Status.ENGINE_ERROR, f"opensim stopped: {words}")
