"""Engines with one mistake each, built from our own solver: the examination must detect every one."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np

from cross_checks.conformance.apart import Wrapped
from cross_checks.conformance.finding import Report
from cross_checks.engine import Engine, Method
from cross_checks.engine.plan import stopped
from mbs_ref import Settings, Status, Trajectory
from mbs_ref.scene import Cylindrical, PlanarBody, Prismatic, Scene, SpatialBody, TorqueVector, UserForce, Weld
from mbs_ref.scene.contact import Contact
from mbs_ref.scene.euler_parameters import conjugate, rotation_matrices
from mbs_ref.trajectory import POSES

type Change = Callable[[Scene], Scene]
type Spoil = Callable[[Scene, Trajectory], Trajectory]
METHODS = ("rk4", "dop853")


@dataclass(frozen=True)
class Mistake:
    """What is wrong: the scene that is run instead, what is done to its trajectory, or how it is run."""

    name: str
    change: Change = lambda scene: scene
    spoil: Spoil = lambda scene, path: path
    run: Callable[[Engine, Scene, Settings, np.ndarray], Trajectory] = lambda good, scene, settings, times: good.run(
        scene, settings, times
    )


class Broken(Wrapped):
    """A good engine with a mistake, under its own name."""

    def __init__(self, good: Engine, mistake: Mistake) -> None:
        super().__init__(good)
        self.mistake = mistake

    def methods(self) -> tuple[Method, ...]:
        return tuple(method for method in self.inner.methods() if method.name in METHODS)

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        settings = settings.model_copy(update={"method": self.method(settings.method).name})
        if times is None:
            return self.inner.run(scene, settings)
        changed = self.mistake.change(scene) if not self.refusals(scene) else scene
        path = self.mistake.run(self.inner, changed, settings, times)
        return self.mistake.spoil(scene, path) if path.ok else path


def mistakes() -> tuple[Mistake, ...]:
    """Return every mistake."""

    def changes(name: str, make: Callable[[Scene], dict[str, Any]], *only: int) -> Mistake:
        """Return a change of scenes, of those of a dimension where one is given."""
        dimensions = only or (2, 3)
        return Mistake(name, lambda s: s.model_copy(update=make(s)) if s.dimension in dimensions else s)

    def of_parts(name: str, parts: str, kind: Any, make: Callable[[Any], Any], *only: int) -> Mistake:
        def made(scene: Scene) -> dict[str, Any]:
            return {parts: tuple(make(part) if isinstance(part, kind) else part for part in getattr(scene, parts))}

        return changes(name, made, *only)

    def spoils(name: str, make: Callable[[Trajectory], dict[str, Any]], *only: int) -> Mistake:
        dimensions = only or (2, 3)
        return Mistake(name, spoil=lambda s, path: replace(path, **make(path)) if s.dimension in dimensions else path)

    def clocks(name: str, make: Callable[[float], float]) -> Mistake:
        return spoils(name, lambda p: {"timing": replace(p.timing, loop_s=make(p.timing.loop_s))})

    drag = UserForce(name="hidden", function=lambda t, q, v: -0.01 * v)
    return (
        changes("dropped joint", lambda s: {"joints": s.joints[:-1]}),
        of_parts("inertia about another point", "bodies", PlanarBody | SpatialBody, _moved_inertia),
        of_parts("inertia in wrong axes", "bodies", SpatialBody,
                 lambda b: b.model_copy(update={"inertia": tuple(b.inertia[k] for k in (2, 0, 1, 4, 5, 3))})),
        changes("gravity off by a thousandth", lambda s: {"gravity": tuple(1.001 * part for part in s.gravity)}),
        changes("hidden damping", lambda s: {"loads": (*s.loads, drag)}, 2),
        of_parts("sliders that do not slide", "joints", Prismatic | Cylindrical,
                 lambda j: Weld(name=j.name, body_a=j.body_a, body_b=j.body_b, point=j.point), 3),
        of_parts("torques in wrong axes", "loads", TorqueVector,
                 lambda load: load.model_copy(update={"frame": "world"})),
        changes("bodies that pass through each other", lambda s: {"contacts": ()}),
        of_parts("contacts without loss", "contacts", object, _lossless),
        Mistake("one step late", run=_late),
        Mistake("lost order", run=_of_first_order),
        Mistake("state restarted half-way", spoil=_restarted),
        Mistake("stopped by every weld", run=_dead_on_welds),
        Mistake("bodies swapped", spoil=_swapped),
        spoils("angular velocities in body axes", lambda p: {"angular_velocity": np.einsum(
            "...ji,...j->...i", rotation_matrices(p.orientation), p.angular_velocity)}, 3),
        Mistake("orientations of the other sign", spoil=_turned_back),
        spoils("angles wrong, positions right", lambda p: {
            "orientation": p.orientation + 0.01 * (p.orientation - p.orientation[:1]),
            "angular_velocity": 1.01 * p.angular_velocity}, 2),
        Mistake("a clock that counts two fifths", run=_slow_clock),
        spoils("single precision", lambda p: {"position": _single(p.position), "velocity": _single(p.velocity)}),
        spoils("velocities of the other sign", lambda p: {"velocity": -p.velocity}),
        spoils("velocities times 1.01", lambda p: {"velocity": 1.01 * p.velocity}),
        spoils("velocities zero but the first", lambda p: {"velocity": _first_alone(p.velocity)}),
        spoils("velocities one sample late", lambda p: {"velocity": p.velocity[[0, *range(len(p.times) - 1)]]}),
        spoils("angular velocities zero but the first",
               lambda p: {"angular_velocity": _first_alone(p.angular_velocity)}),
        clocks("a clock that lies", lambda loop_s: 1e-6 * loop_s),
        clocks("a clock beyond the call", lambda loop_s: 3600.0),
        spoils("samples at other times", lambda p: {"times": p.times * (1.0 + 1e-6)}),
    )  # fmt: skip


@dataclass(frozen=True)
class Caught:
    """How a mistake was noticed."""

    mistake: str
    applies: bool  # False for the engine without a mistake
    by: tuple[str, ...]  # questions failed


def self_test(good: Engine, examine: Callable[[Engine, str], Report]) -> Iterator[Caught]:
    """Examine the engine with each mistake in turn; first with none, where every failure is a false alarm."""
    for mistake in (Mistake("none"), *mistakes()):
        report = examine(Broken(good, mistake), good.name)
        questions = tuple(dict.fromkeys(finding.question for finding in report.of("failed")))
        yield Caught(mistake.name, mistake.name != "none", questions)


def _moved_inertia(body):
    if isinstance(body, PlanarBody):
        return body.model_copy(update={"inertia": 1.25 * body.inertia})
    if isinstance(body, SpatialBody):
        return body.model_copy(update={"inertia": tuple(1.25 * part for part in body.inertia)})
    return body


def _lossless(contact: Contact) -> Contact:
    """Take damping, and a restitution below 1, out of a contact."""
    law = contact.law.model_copy(update={"damping": 0.0, "restitution": 1.0})
    return contact.model_copy(update={"law": law})


def _dead_on_welds(good: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    """Blow up, with a message, wherever a weld is."""
    if not any(isinstance(joint, Weld) for joint in scene.joints):
        return good.run(scene, settings, times)
    return stopped(scene, Status.NON_FINITE, "NaN arose before the first sample")


def _late(good: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    """Return each state one step, or a thousandth of an interval, after its time."""
    late = settings.step or 1e-3 * float(times[1] - times[0])
    shifted = np.concatenate((times[:1], times[1:] - late))
    if shifted[1] <= 0.0:
        shifted = np.concatenate((times[:1], times[1:] - 0.5 * late))
        settings = settings.model_copy(update={"step": 0.5 * late})
    return replace(good.run(scene, settings, shifted), times=times)


def _of_first_order(good: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    """Run explicit Euler, at a step fine enough for its errors to look like those of a better method."""
    if not settings.step:
        return good.run(scene, settings, times)
    return good.run(scene, settings.model_copy(update={"method": "euler", "step": settings.step / 4}), times)


def _slow_clock(good: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    """Report two fifths of the processor time of the call."""
    began = process_time()
    path = good.run(scene, settings, times)
    return replace(path, timing=replace(path.timing, loop_s=0.4 * (process_time() - began)))


def _taken(path: Trajectory, index: Any) -> Trajectory:
    return replace(path, **{part: getattr(path, part)[index] for part in POSES})


def _restarted(scene: Scene, path: Trajectory) -> Trajectory:
    half = len(path.times) // 2
    return _taken(path, [*range(half), *range(len(path.times) - half)])


def _swapped(scene: Scene, path: Trajectory) -> Trajectory:
    n = len(scene.bodies)
    return path if n == 1 else _taken(path, np.s_[:, [1, 0, *range(2, n)]])


def _single(exact: np.ndarray) -> np.ndarray:
    """Round what comes back; the start stays exact, as a number that was read in would."""
    return np.concatenate((exact[:1], exact[1:].astype(np.float32).astype(float)))


def _first_alone(values: np.ndarray) -> np.ndarray:
    return np.concatenate((values[:1], np.zeros_like(values[1:])))


def _turned_back(scene: Scene, path: Trajectory) -> Trajectory:
    turned = path.orientation
    return replace(path, orientation=2.0 * turned[:1] - turned if scene.planar else conjugate(turned))
