"""Engines with one mistake each, made of our own solver: an examination that is worth its name notices every one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from cross_checks.conformance.finding import Report
from cross_checks.conformance.wrapped import Wrapped
from cross_checks.engine import Engine, Method
from cross_checks.engine.outcome import stopped
from mbs_ref.scene import Cylindrical, PlanarBody, Prismatic, Scene, SpatialBody, TorqueVector, UserForce, Weld
from mbs_ref.scene.euler_parameters import conjugate, rotation_matrices
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Trajectory

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
    return (
        Mistake("dropped joint", change=lambda s: s.model_copy(update={"joints": s.joints[:-1]})),
        Mistake("inertia about another point", change=lambda s: _bodies(s, _moved_inertia)),
        Mistake("inertia in wrong axes", change=lambda s: _bodies(s, _turned_inertia)),
        Mistake("gravity off by a thousandth", change=lambda s: s.model_copy(update={"gravity": _scaled(s.gravity)})),
        Mistake("hidden damping", change=_damped),
        Mistake("one step late", run=_late),
        Mistake("lost order", run=_of_first_order),
        Mistake("state restarted half-way", run=_restarted),
        Mistake("sliders that do not slide", change=_stuck),
        Mistake("torques in wrong axes", change=_torques_in_world),
        Mistake("stopped by every weld", run=_dead_on_welds),
        Mistake("single precision", spoil=_in_single),
        Mistake("velocities of the other sign", spoil=lambda s, p: replace(p, velocity=-p.velocity)),
        Mistake("velocities times 1.01", spoil=lambda s, p: replace(p, velocity=1.01 * p.velocity)),
        Mistake("velocities zero but the first", spoil=lambda s, p: replace(p, velocity=_first_alone(p.velocity))),
        Mistake("velocities one sample late", spoil=lambda s, p: replace(p, velocity=_shifted(p.velocity))),
        Mistake("angular velocities zero but the first",
                spoil=lambda s, p: replace(p, angular_velocity=_first_alone(p.angular_velocity))),
        Mistake("angular velocities in body axes", spoil=_body_rates),
        Mistake("bodies swapped", spoil=lambda s, p: _ordered(p, [1, 0, *range(2, len(s.bodies))])),
        Mistake("orientations of the other sign", spoil=_turned_back),
        Mistake("angles wrong, positions right", spoil=_angles_off),
        Mistake("a clock that lies", spoil=lambda s, p: _clocked(p, 1e-6 * p.timing.loop_s)),
        Mistake("a clock beyond the call", spoil=lambda s, p: _clocked(p, 3600.0)),
        Mistake("samples at other times", spoil=lambda s, p: replace(p, times=p.times * (1.0 + 1e-6))),
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


def _bodies(scene: Scene, change: Callable) -> Scene:
    return scene.model_copy(update={"bodies": tuple(change(body) for body in scene.bodies)})


def _moved_inertia(body):
    if isinstance(body, PlanarBody):
        return body.model_copy(update={"inertia": 1.25 * body.inertia})
    if isinstance(body, SpatialBody):
        return body.model_copy(update={"inertia": tuple(1.25 * part for part in body.inertia)})
    return body


def _turned_inertia(body):
    if not isinstance(body, SpatialBody):
        return body
    xx, yy, zz, xy, xz, yz = body.inertia
    return body.model_copy(update={"inertia": (zz, xx, yy, xz, yz, xy)})


def _scaled(gravity: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(1.001 * part for part in gravity)


def _damped(scene: Scene) -> Scene:
    if scene.dimension == 3:
        return scene
    drag = UserForce(name="hidden", function=lambda t, q, v: -0.01 * v)
    return scene.model_copy(update={"loads": (*scene.loads, drag)})


def _stuck(scene: Scene) -> Scene:
    """Weld what a joint in space would let slide."""
    sliders = Prismatic | Cylindrical if scene.dimension == 3 else ()
    joints = [
        Weld(name=j.name, body_a=j.body_a, body_b=j.body_b, point=j.point) if isinstance(j, sliders) else j
        for j in scene.joints
    ]
    return scene.model_copy(update={"joints": tuple(joints)})


def _torques_in_world(scene: Scene) -> Scene:
    """Leave a torque where it began instead of turning it with its body."""
    turned = [load.model_copy(update={"frame": "world"}) if isinstance(load, TorqueVector) else load
              for load in scene.loads]  # fmt: skip
    return scene.model_copy(update={"loads": tuple(turned)})


def _dead_on_welds(good: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    """Blow up, aloud, wherever a weld is."""
    path = good.run(scene, settings, times)
    if not any(isinstance(joint, Weld) for joint in scene.joints):
        return path
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


def _restarted(good: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    path, half = good.run(scene, settings, times), len(times) // 2
    return path if not path.ok else _ordered_in_time(path, [*range(half), *range(len(times) - half)])


def _ordered_in_time(path: Trajectory, samples: list[int]) -> Trajectory:
    parts = ("position", "orientation", "velocity", "angular_velocity")
    return replace(path, **{part: getattr(path, part)[samples] for part in parts})


def _ordered(path: Trajectory, bodies: list[int]) -> Trajectory:
    if path.position.shape[1] == 1:
        return path
    parts = ("position", "orientation", "velocity", "angular_velocity")
    return replace(path, **{part: getattr(path, part)[:, bodies] for part in parts})


def _in_single(scene: Scene, path: Trajectory) -> Trajectory:
    """Round what comes back; the start stays exact, as a number that was read in would."""
    rounded = {}
    for part in ("position", "velocity"):
        exact = getattr(path, part)
        rounded[part] = exact.astype(np.float32).astype(float)
        rounded[part][0] = exact[0]
    return replace(path, **rounded)


def _clocked(path: Trajectory, loop_s: float) -> Trajectory:
    return replace(path, timing=replace(path.timing, loop_s=loop_s))


def _first_alone(values: np.ndarray) -> np.ndarray:
    spoiled = np.zeros_like(values)
    spoiled[0] = values[0]
    return spoiled


def _shifted(values: np.ndarray) -> np.ndarray:
    return np.concatenate((values[:1], values[:-1]))


def _body_rates(scene: Scene, path: Trajectory) -> Trajectory:
    if scene.dimension == 2:
        return path
    axes = rotation_matrices(path.orientation)
    return replace(path, angular_velocity=np.einsum("...ji,...j->...i", axes, path.angular_velocity))


def _turned_back(scene: Scene, path: Trajectory) -> Trajectory:
    if scene.dimension == 2:
        return replace(path, orientation=2.0 * path.orientation[:1] - path.orientation)
    return replace(path, orientation=conjugate(path.orientation))


def _angles_off(scene: Scene, path: Trajectory) -> Trajectory:
    """Turn a hundredth too far, and say so in the angular velocity."""
    if scene.dimension == 3:
        return path
    start = path.orientation[:1]
    return replace(
        path, orientation=start + 1.01 * (path.orientation - start), angular_velocity=1.01 * path.angular_velocity
    )
