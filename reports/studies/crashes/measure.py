"""The two crash occupants from the front and from the rear, run once for a full report."""

from __future__ import annotations

from itertools import product

import numpy as np

from mbs_ref import scenes
from mbs_ref.crash.results import CrashResults, crash_results, sign_changes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.facts.curves import Curves, curves, film, plain
from reports.studies.androids.measure import IMPACTS, NAMES
from reports.studies.crashes.facts import Crash, CrashFacts, Whiplash

SHOWN = {"android_simplified": ("head", "thorax", "bottom", "thigh"), "android_vertebral": ("head", "C1", "C3", "C6")}
COMPONENTS = ("x, N", "y, N", "torque, N m")
KINDS = {"External forces Q_e": "external", "Constraint forces Q_c": "constraint"}
FILMED = 5  # samples a picture


def measure() -> CrashFacts:
    """Return both androids in both impacts. RuntimeError where a run does not reach its end."""
    return CrashFacts(tuple(_run(name, impact) for impact, name in product(IMPACTS, NAMES)))


def _run(name: str, impact: str) -> Crash:
    scene = scenes.make(name, impact=impact)
    path = simulate(scene, Settings(rtol=1e-8, samples=401, estimate="off"))
    return crash(scene, path)


def crash(scene: Scene, path: Trajectory) -> Crash:
    """Return the facts of a run. RuntimeError where it did not reach its end."""
    if not path.ok:
        raise RuntimeError(f"{scene.name}: {path.message}")
    found = crash_results(scene, path)
    imbalance = _imbalance(found)
    return Crash(
        scene.name, str(scene.parameters["impact"]), scene.description, len(scene.bodies), int(path.rhs_calls),
        float(path.timing.loop_s), _largest_gap(path),
        float(np.max(np.abs(imbalance)) / np.max(np.abs(found.works["pulse"]))),
        float(found.seat_force.max()), float(found.belt_force.max()),
        _reach(found.head_excursion[:, 0]), _reach(found.hip_excursion[:, 0]),
        {key: float(value) for key, value in found.measures.items()}, film(scene, path, FILMED),
        _forces(scene, path, found), _plots(path, found), _compared(path, found), _whiplash(path, found),
    )  # fmt: skip


def _forces(scene: Scene, path: Trajectory, found: CrashResults) -> dict[str, Curves]:
    """Return the paper's Figs. 3 to 5: generalized forces per body against time."""
    made = {}
    for kind, field in KINDS.items():
        values = getattr(found.forces, field)
        for c, component in enumerate(COMPONENTS):
            lines = {body: values[:, scene.body_index(body), c] for body in SHOWN[scene.name]}
            made[f"{kind}, {component.split(',')[0]}"] = curves(path.times, lines, component)
    return made


def _plots(path: Trajectory, found: CrashResults) -> dict[str, Curves]:
    times = path.times
    works = {f"work of {name}": work for name, work in found.works.items()}
    balance = {"energy": found.energy - found.energy[0], **works, "energy less works": _imbalance(found)}
    places = {
        f"{name} {axis}": history[:, k]
        for name, history in (("head", found.head_excursion), ("hip", found.hip_excursion))
        for k, axis in enumerate("xy")
    }
    plots = {
        "Energy balance": curves(times, balance, "J"),
        "Excursions in the vehicle": curves(times, places, "m"),
        "Seat and belt forces": curves(times, {"seat": found.seat_force, "belts": found.belt_force}, "N"),
        "Accelerations": curves(times, {"head": found.head_g, "thorax": found.thorax_g}, "g"),
        "Neck": curves(times, {"axial force, kN": found.neck_axial / 1e3, "Nij": found.nij}, "kN, 1"),
    }
    if path.step_compliance is not None:
        gap = {"largest |C| of the steps": path.step_compliance[1:, 1]}
        plots["Constraint compliance"] = curves(times[1:], gap, "m", log=True)
    return plots


def _compared(path: Trajectory, found: CrashResults) -> dict[str, Curves]:
    """Return what both androids are drawn with."""
    histories = {
        "Head along x": (found.head_excursion[:, 0], "m"), "Head acceleration": (found.head_g, "g"),
        "Belt forces": (found.belt_force, "N"),
    }  # fmt: skip
    return {name: curves(path.times, {name: values}, unit) for name, (values, unit) in histories.items()}


def _whiplash(path: Trajectory, found: CrashResults) -> Whiplash | None:
    torques = found.cervical_torques
    if not torques:
        return None
    return Whiplash(
        curves(path.times, torques, "N m"),
        {name: float(torque.max()) for name, torque in torques.items()},
        {name: float(torque.min()) for name, torque in torques.items()},
        {name: plain(sign_changes(path.times, torque)) for name, torque in torques.items()},
    )


def _imbalance(found: CrashResults) -> np.ndarray:
    return found.energy - found.energy[0] - np.sum(list(found.works.values()), axis=0)


def _reach(history: np.ndarray) -> float:
    """Return the value furthest from zero, with its sign."""
    return float(history[np.argmax(np.abs(history))])


def _largest_gap(path: Trajectory) -> float:
    return 0.0 if path.step_compliance is None else float(np.max(path.step_compliance[:, 1]))
