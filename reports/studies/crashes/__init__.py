"""The two crash occupants from the front and from the rear, run once for a full report."""

from dataclasses import replace
from itertools import product

import numpy as np

from mbs_ref import Scene, Trajectory, scenes
from mbs_ref.crash.results import CrashResults, crash_results, sign_changes
from reports.facts.curves import Curves, Measured, Row, curves, film, plain
from reports.studies import crash

SHOWN = {crash.SIMPLIFIED: ("head", "thorax", "bottom", "thigh"), crash.VERTEBRAL: ("head", "C1", "C3", "C6")}
KINDS = {"External forces Q_e": "external", "Constraint forces Q_c": "constraint"}
FILMED = 10  # samples a picture


def measure() -> Measured:
    """Return both androids in both impacts. RuntimeError where a run does not reach its end."""
    measured = Measured()
    for impact, name in product(crash.IMPACTS, crash.NAMES):
        bare, solid = scenes.make(name, impact=impact, **crash.PAPER), scenes.make(name, impact=impact)
        add_crash(measured, bare, crash.finished(bare))
        add_figures(measured, solid, crash.finished(solid), ".solid")
    return measured


def add_figures(measured: Measured, scene: Scene, path: Trajectory, kind: str = "") -> CrashResults:
    """Add the figures and the film of a run; return its results."""
    result, impact = crash_results(scene, path), scene.parameters["impact"]
    prefix = f"{scene.name.removeprefix('android_')}.{impact}{kind}"
    own = crash.figures(scene, path, result)
    measured.figures.update({f"{prefix}.{name}": value for name, value in own.items()})
    measured.films[f"{scene.name}, {impact}{', stops and contacts' if kind else ''}"] = film(scene, path, FILMED)
    return result


def add_crash(measured: Measured, scene: Scene, path: Trajectory) -> None:
    """Add the figures, tables, curves and film of a run."""
    result, label = add_figures(measured, scene, path), f"{scene.name}, {scene.parameters['impact']}"
    drawn = _plots(path, result)
    for kind, field in KINDS.items():
        drawn |= crash.forces(kind, scene, path.times, getattr(result.forces, field), SHOWN[scene.name])
    measured.curves.update({f"{label}: {name}": lines for name, lines in drawn.items()})
    for name, (values, unit) in _compared(result).items():
        name = f"impact from the {scene.parameters['impact']}: {name}"
        lines = curves(path.times, {f"{len(scene.bodies)} bodies": values}, unit)
        held = measured.curves.get(name, lines)
        measured.curves[name] = replace(lines, lines={**held.lines, **lines.lines})
    if result.cervical_torques:
        measured.tables[f"whiplash: {label}"] = _whiplash(path, result)
        measured.curves[f"whiplash: {label}"] = curves(path.times, result.cervical_torques, "N m")


def _plots(path: Trajectory, result: CrashResults) -> dict[str, Curves]:
    times = path.times
    works = {f"work of {name}": work for name, work in result.works.items()}
    balance = {"energy": result.energy - result.energy[0], **works, "energy less works": crash.imbalance(result)}
    places = {
        f"{name} {axis}": history[:, k]
        for name, history in (("head", result.head_excursion), ("hip", result.hip_excursion))
        for k, axis in enumerate("xy")
    }
    plots = {
        "Energy balance": curves(times, balance, "J"),
        "Excursions in the vehicle": curves(times, places, "m"),
        "Seat and belt forces": curves(times, {"seat": result.seat_force, "belts": result.belt_force}, "N"),
        "Accelerations": curves(times, {"head": result.head_g, "thorax": result.thorax_g}, "g"),
        "Neck": curves(times, {"axial force, kN": result.neck_axial / 1e3, "Nij": result.nij}, "kN, 1"),
    }
    if path.step_compliance is not None:
        gap = {"largest |C| of the steps": path.step_compliance[1:, 1]}
        plots["Constraint compliance"] = curves(times[1:], gap, "m", log=True)
    return plots


def _compared(result: CrashResults) -> dict[str, tuple[np.ndarray, str]]:
    """Return histories (n_t,) with their units, in which both androids are drawn."""
    return {
        "Head along x": (result.head_excursion[:, 0], "m"), "Head acceleration": (result.head_g, "g"),
        "Belt forces": (result.belt_force, "N"),
    }  # fmt: skip


def _whiplash(path: Trajectory, result: CrashResults) -> tuple[Row, ...]:
    """Return for each vertebra the largest and least torque (N m) and when it changes sign."""
    return tuple(
        {
            "vertebra": name, "largest": float(torque.max()), "least": float(torque.min()),
            "changes": ", ".join(f"{t:.3f} s" for t in plain(sign_changes(path.times, torque))) or "never",
        }
        for name, torque in result.cervical_torques.items()
    )  # fmt: skip
