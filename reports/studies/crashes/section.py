"""The androids of Fox 1999: the counterparts of the paper's figures, and what a detailed model changes."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from mbs_ref.crash.results import CrashResults, sign_changes
from mbs_ref.trajectory import Trajectory
from reports.film import filmstrip, gif
from reports.page.numbers import short
from reports.page.plots.histories import histories
from reports.page.report_data import ReportData
from reports.page.section import Section
from reports.studies.crashes.measure import Crash

LEAD = (
    "Two planar crash occupants, 13 bodies, and 48 with every vertebra, at 50 km/h from the front and from the rear. "
    "Without friction, joint stops or a toe-board, which the paper does not name, the legs swing up: sound numerics, "
    "crude biomechanics. TTI is made for side impacts; here it takes the accelerations of this one."
)
SHOWN = {"android_simplified": ("head", "thorax", "bottom", "thigh"), "android_vertebral": ("head", "C1", "C3", "C6")}
COMPONENTS = ("x, N", "y, N", "torque, N m")
KINDS = {"External forces Q_e": "external", "Constraint forces Q_c": "constraint"}
ABSENT = "rigid thorax"


def context(data: ReportData) -> dict[str, Any]:
    runs = list(data.crashes)
    return {
        "androids": [_shown(run) for run in runs],
        "columns": [run.label for run in runs],
        "levels": _levels(runs) if runs else [],
        "changes": [_change(*pair) for pair in _pairs(runs)],
        "whiplash": [_whiplash(run) for run in runs if run.results.cervical_torques],
    }


def _shown(run: Crash) -> dict[str, Any]:
    scene, path = run.scene, run.path
    few = path.upto(0) if not path.ok else _every(path, 5)
    return {
        "name": run.label,
        "description": scene.description,
        "gif": _data_uri("gif", gif(scene, few)),
        "strip": _data_uri("png", filmstrip(scene, few)),
        "forces": _forces(run),
        "plots": _plots(run),
        "open": scene.parameters["impact"] == "front",
    }


def _every(path: Trajectory, n: int) -> Trajectory:
    fields = ("times", "position", "orientation", "velocity", "angular_velocity")
    return replace(path, **{name: getattr(path, name)[::n] for name in fields})


def _forces(run: Crash) -> dict[str, Any]:
    """Return the paper's Figs. 3 to 5: generalized forces per body against time."""
    found = {}
    for kind, field in KINDS.items():
        values = getattr(run.results.forces, field)
        for c, component in enumerate(COMPONENTS):
            lines = {body: values[:, run.scene.body_index(body), c] for body in SHOWN[run.scene.name]}
            found[f"{kind}, {component.split(',')[0]}"] = histories(run.path.times, lines, component)
    return found


def _plots(run: Crash) -> dict[str, Any]:
    found, times = run.results, run.path.times
    works = {f"work of {name}": work for name, work in found.works.items()}
    balance = {"energy": found.energy - found.energy[0], **works, "energy less works": _imbalance(run)}
    places = {
        f"{name} {axis}": history[:, k]
        for name, history in (("head", found.head_excursion), ("hip", found.hip_excursion))
        for k, axis in enumerate("xy")
    }
    plots = {
        "Energy balance": histories(times, balance, "J"),
        "Excursions in the vehicle": histories(times, places, "m"),
        "Seat and belt forces": histories(times, {"seat": found.seat_force, "belts": found.belt_force}, "N"),
        "Accelerations": histories(times, {"head": found.head_g, "thorax": found.thorax_g}, "g"),
        "Neck": histories(times, {"axial force, kN": found.neck_axial / 1e3, "Nij": found.nij}, "kN, 1"),
    }
    if run.path.step_compliance is not None:
        gap = {"largest |C| of the steps": run.path.step_compliance[1:, 1]}
        plots["Constraint compliance"] = histories(times[1:], gap, "m", log=True)
    return plots


def _imbalance(run: Crash) -> np.ndarray:
    found = run.results
    return found.energy - found.energy[0] - np.sum(list(found.works.values()), axis=0)


def _whiplash(run: Crash) -> dict[str, Any]:
    """Return the cervical torques and when they change sign."""
    torques = run.results.cervical_torques
    changes = {name: sign_changes(run.path.times, torque) for name, torque in torques.items()}
    return {
        "name": run.label,
        "plot": histories(run.path.times, torques, "N m"),
        "rows": [
            (name, f"{torques[name].max():.0f}", f"{torques[name].min():.0f}",
             ", ".join(f"{t:.3f} s" for t in when) or "never")
            for name, when in changes.items()
        ],
    }  # fmt: skip


def _levels(runs: list[Crash]) -> list[tuple[str, list[str]]]:
    """Return rows of what the detailed model changes, and its cost."""
    rows = [("bodies", [str(len(run.scene.bodies)) for run in runs])]
    rows.append(("right-hand sides", [str(run.path.rhs_calls) for run in runs]))
    rows.append(("integration at rtol 1e-8, s", [f"{run.path.timing.loop_s:.2f}" for run in runs]))
    rows.append(("largest |C|, m", [f"{_largest_gap(run.path):.1e}" for run in runs]))
    share = [np.max(np.abs(_imbalance(run))) / np.max(np.abs(run.results.works["pulse"])) for run in runs]
    rows.append(("energy less works, of the pulse's work", [f"{value:.1e}" for value in share]))
    for label, history in (("peak seat force, N", "seat_force"), ("peak belt force, N", "belt_force")):
        rows.append((label, [f"{np.max(getattr(run.results, history)):.0f}" for run in runs]))
    for label, history in (("head excursion, m", "head_excursion"), ("hip excursion, m", "hip_excursion")):
        rows.append((label, [f"{np.max(np.abs(getattr(run.results, history)[:, 0])):.3f}" for run in runs]))
    names = dict.fromkeys(name for run in runs for name in run.results.measures)
    return rows + [(name, [_measure(run, name) for run in runs]) for name in names]


def _pairs(runs: list[Crash]) -> list[tuple[Crash, Crash]]:
    """Return the coarser and the finer model of each impact that both ran in."""
    by_impact: dict[str, list[Crash]] = {}
    for run in sorted(runs, key=lambda run: len(run.scene.bodies)):
        by_impact.setdefault(str(run.scene.parameters["impact"]), []).append(run)
    return [(pair[0], pair[1]) for pair in by_impact.values() if len(pair) == 2]


def _change(coarse: Crash, fine: Crash) -> dict[str, Any]:
    """Say and draw what the detailed model changes in one impact."""
    figures = {
        "the head's travel along x": ("m", *(_reach(run.results.head_excursion[:, 0]) for run in (coarse, fine))),
        "the peak belt force": ("kN", *(float(run.results.belt_force.max()) / 1e3 for run in (coarse, fine))),
        "HIC36": ("", *(run.results.measures["HIC36"] for run in (coarse, fine))),
        "Nij": ("", *(run.results.measures["Nij"] for run in (coarse, fine))),
        "the right-hand sides": ("", *(float(run.path.rhs_calls) for run in (coarse, fine))),
        "the time of integration": ("ms", *(1e3 * run.path.timing.loop_s for run in (coarse, fine))),
    }
    told = [f"{what} {short(a, 3)} to {short(b, 3)} {unit}".rstrip() for what, (unit, a, b) in figures.items()]
    impact = coarse.scene.parameters["impact"]
    bodies = [len(run.scene.bodies) for run in (coarse, fine)]
    return {
        "name": f"impact from the {impact}",
        "told": f"From {bodies[0]} to {bodies[1]} bodies: {'; '.join(told)}.",
        "plots": {
            "Head along x": _both(coarse, fine, lambda found: found.head_excursion[:, 0], "m"),
            "Head acceleration": _both(coarse, fine, lambda found: found.head_g, "g"),
            "Belt forces": _both(coarse, fine, lambda found: found.belt_force, "N"),
        },
    }


def _reach(history: np.ndarray) -> float:
    """Return the value furthest from zero, with its sign."""
    return float(history[np.argmax(np.abs(history))])


def _both(coarse: Crash, fine: Crash, history: Callable[[CrashResults], np.ndarray], unit: str) -> dict[str, Any]:
    lines = {f"{len(run.scene.bodies)} bodies": history(run.results) for run in (coarse, fine)}
    return histories(coarse.path.times, lines, unit)


def _measure(run: Crash, name: str) -> str:
    value = run.results.measures.get(name)
    return ABSENT if value is None else f"{value:.4g}"


def _largest_gap(path: Trajectory) -> float:
    return 0.0 if path.step_compliance is None else float(np.max(path.step_compliance[:, 1]))


def _data_uri(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


SECTION = Section("androids", "The androids of the first paper", LEAD, context, template="crashes/section.html")
