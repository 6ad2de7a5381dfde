"""The two crash occupants from the front and from the rear, run once for a full report."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from mbs_ref import Scene, Trajectory, scenes
from mbs_ref.crash.results import CrashResults, crash_results, sign_changes
from reports.facts.curves import Curves, Measured, Row, curves, film, plain
from reports.studies import crash

SHOWN = {crash.SIMPLIFIED: ("head", "thorax", "bottom", "thigh"), crash.VERTEBRAL: ("head", "C1", "C3", "C6")}
KINDS = {"External forces Q_e": "external", "Constraint forces Q_c": "constraint"}
FILMED = 10  # samples a picture
# Sled tests at 40 km/h, 12 to 15 g, belts without slack or limiter, of eight men's cadavers (mean 75.5 kg): Shaw et
# al., Stapp Car Crash Journal 53 (2009) 1-48. Largest travel ahead, m: mean, and least and most of the corridor of one
# deviation, as digitised in the validation catalogue of the SAFER HBM (github.com/saferhbm/validation at 53cd691)
SLED: dict[str, Any] = {"speed_change_km_h": 40.0, "slack": 0.0, "belt_limit": 0.0}
SLED_TESTS = {
    "head": (0.387, 0.322, 0.455),
    "T1": (0.257, 0.226, 0.281),
    "T8": (0.206, 0.175, 0.236),
    "hip": (0.026, -0.007, 0.063),
}


def measure() -> Measured:
    """Return both androids in both impacts. RuntimeError where a run does not reach its end."""
    measured = Measured()
    for impact, name in product(crash.IMPACTS, crash.NAMES):
        bare, solid = scenes.make(name, impact=impact, **crash.PAPER), scenes.make(name, impact=impact)
        add_crash(measured, bare, crash.finished(bare))
        add_figures(measured, solid, crash.finished(solid), ".solid")
    measured.tables["sled"] = sled_rows()
    return measured


def sled_rows() -> tuple[Row, ...]:
    """Return how far (m) parts of cadavers moved ahead on a sled, and those of both believable androids here."""
    sleds = {name: scenes.make(name, **SLED) for name in crash.NAMES}
    moved = {name: crash.forward(sled, crash.finished(sled)) for name, sled in sleds.items()}
    return tuple(
        {"part": part, "mean": mean, "least": least, "most": most}
        | {
            name.removeprefix("android_"): f"{found[part]:.3f}" + ("" if least <= found[part] <= most else ", outside")
            for name, found in moved.items()
        }
        for part, (mean, least, most) in SLED_TESTS.items()
    )


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
