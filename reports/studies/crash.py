"""The crash of both androids, measured by one module for the studies of the crashes, the androids and the papers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cross_checks.judge import ladder
from cross_checks.metrics.metric import off_truth
from mbs_ref import Scene, Settings, Status, Trajectory
from mbs_ref.crash.outlines import excesses
from mbs_ref.crash.results import CrashResults, sign_changes
from mbs_ref.crash.stops import tension
from mbs_ref.files import package_data
from mbs_ref.observables.attachment import Motion
from mbs_ref.simulate import simulate
from reports.facts.curves import Curves, Value, curves

SIMPLIFIED, VERTEBRAL = NAMES = ("android_simplified", "android_vertebral")
IMPACTS = ("front", "rear")
FINE = Settings(rtol=1e-8, samples=401, estimate="off")
PAPER: dict[str, Any] = {"model": "paper"}
RAN = package_data(__name__, "papers", "runs.toml")  # the papers
COMPONENTS = (("x", "N"), ("y", "N"), ("torque", "N m"))


def finished(scene: Scene, settings: Settings = FINE, times: np.ndarray | None = None) -> Trajectory:
    """Return the run of a scene, at `times` (s) if given. RuntimeError where it does not reach its end."""
    path = simulate(scene, settings, times)
    if not path.ok:
        raise RuntimeError(f"{scene.name}: {path.message}")
    return path


def with_test(scene: Scene, settings: Settings, tested: bool = True) -> tuple[Trajectory, Trajectory, float | None]:
    """Return the run, the run that the papers' test |C| < h may stop, and the error (m); None where the run stopped.

    Without the test, or where it stops nothing, both runs are one.
    """
    times = ladder.grid(scene)
    test = simulate(scene, settings.model_copy(update={"stop_on_compliance": tested}), times)
    path = simulate(scene, settings, times) if test.status is Status.COMPLIANCE else test
    off = off_truth(scene, path)
    return path, test, None if off is None else off[0]


def deepest(scene: Scene, path: Trajectory) -> float:
    """Return the largest depth (m) by which parts pass through one another beyond what is soft."""
    return max(float(depth.max()) for depth in excesses(Motion(scene, path)).values())


def largest_gap(path: Trajectory) -> float:
    """Return the largest |C| (m) of the steps; 0 without steps."""
    return 0.0 if path.step_compliance is None else float(np.max(path.step_compliance[:, 1]))


def forces(name: str, scene: Scene, times: np.ndarray, values: np.ndarray, bodies: Sequence[str]) -> dict[str, Curves]:
    """Return generalized forces (n_t, n_bodies, 3) of some bodies over time, a plot for each component."""
    return {
        f"{name}: {part}": curves(
            times, {body: values[:, scene.body_index(body), c] for body in bodies}, f"{part}, {unit}"
        )
        for c, (part, unit) in enumerate(COMPONENTS)
    }


def imbalance(result: CrashResults) -> np.ndarray:
    """Return the energy (J) less the start's and all works (n_t,)."""
    return result.energy - result.energy[0] - np.sum(list(result.works.values()), axis=0)


def figures(scene: Scene, path: Trajectory, result: CrashResults) -> dict[str, Value]:
    """Return the figures of a crash, without the names of android and impact."""
    pull = result.forces.constraint[:, scene.body_index("head"), 0]
    seats = [scene.body_index(name) for name in ("seat_base", "seat_back")]
    of_seats = result.forces.external[:, seats] + result.forces.constraint[:, seats]  # N, N m: they do not move
    return {
        "bodies": len(scene.bodies), "rhs_calls": int(path.rhs_calls), "loop_s": float(path.timing.loop_s),
        "compliance": largest_gap(path),
        "imbalance": float(np.max(np.abs(imbalance(result))) / np.max(np.abs(result.works["pulse"]))),
        "seat_force": float(result.seat_force.max()), "belt_force": float(result.belt_force.max()),
        "head_excursion": float(np.abs(result.head_excursion[:, 0]).max()),
        "head_reach": float(result.head_excursion[np.argmax(np.abs(result.head_excursion[:, 0])), 0]),
        "hip_excursion": float(np.abs(result.hip_excursion[:, 0]).max()), **_trunk(scene, path),
        "head_pull_most": float(pull.max()), "head_pull_least": float(pull.min()),
        "largest_constraint_force": float(np.abs(result.forces.constraint[:, :, :2]).max()),
        "deepest": deepest(scene, path), "seats_imbalance": float(np.abs(of_seats).max()),
        **{name: float(value) for name, value in result.measures.items()},
        **_head_contact(scene, path), **_neck(path, result),
    }  # fmt: skip


def _t1(scene: Scene, motion: Motion) -> tuple[str, np.ndarray]:
    """Return the body of the first thoracic vertebra, and the place (n_t, 2), m, of its joint with the neck."""
    chest, neck = ("thorax", "neck") if "thorax" in scene.body_names else ("T1", "C6")
    joint: Any = next(j for j in scene.joints if j.name == f"{chest}-{neck}")
    return chest, motion.point(chest, joint.point)[0]


def forward(scene: Scene, path: Trajectory) -> dict[str, float]:
    """Return how far (m) head, first and eighth thoracic vertebra and hip move ahead in the vehicle at most."""
    trunk = "T8" if "T8" in scene.body_names else "thorax"
    ahead = {name: path.position[:, scene.body_index(body), 0]
             for name, body in (("head", "head"), ("T8", trunk), ("hip", "bottom"))}  # fmt: skip
    ahead["T1"] = _t1(scene, Motion(scene, path))[1][:, 0]
    return {name: float((x - x[0]).max()) for name, x in ahead.items()}


def _trunk(scene: Scene, path: Trajectory) -> dict[str, Value]:
    """Return T1's excursion (m), how far (deg) head and trunk bend, and what the shoulder belt pulls (N)."""
    motion = Motion(scene, path)
    chest, t1 = _t1(scene, motion)
    turned = {name: np.degrees(motion.angle(name)) for name in ("head", chest, "bottom")}
    flexion, bend = turned[chest] - turned["head"], turned["bottom"] - turned[chest]
    belt = [tension(motion, load) for load in scene.loads if load.name.startswith("belt.thorax")]  # type: ignore[arg-type]
    return {
        "t1_excursion": float(np.abs(t1[:, 0] - t1[0, 0]).max()), "neck_flexion": float(flexion.max()),
        "neck_extension": float(-flexion.min()), "trunk_flexion": float(bend.max()),
        "shoulder_belt": float(np.sum(belt, axis=0).max()),
    }  # fmt: skip


def _head_contact(scene: Scene, path: Trajectory) -> dict[str, Value]:
    """Return when (s) the head leaves the seat, and when it is back."""
    head = next(c.name for c in scene.contacts if c.body_a == "head")
    free = path.contacts[head][:, 0] <= 0.0
    left = float(path.times[np.argmax(free & (path.times > 0.0))])
    again = path.times[(path.times > left) & ~free]
    return {"head_leaves": left, "head_back": float(again[0]) if len(again) else "never"}


def _neck(path: Trajectory, result: CrashResults) -> dict[str, Value]:
    """Return how the cervical torques (N m) change sign; nothing where none does."""
    torques = result.cervical_torques
    changed = [float(t) for torque in torques.values() for t in sign_changes(path.times, torque)[:1]]
    if not changed:
        return {}
    return {
        "neck_changes": len(changed), "neck_first": min(changed), "neck_last": max(changed),
        "neck_most": max(float(t.max()) for t in torques.values()),
        "neck_least": min(float(t.min()) for t in torques.values()),
    }  # fmt: skip
