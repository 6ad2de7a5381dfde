"""The androids' crash as the first paper ran it: figures 1 to 5, and what its sentences say of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.judge import ladder
from cross_checks.metrics.state_error import off_truth
from mbs_ref import scenes
from mbs_ref.crash.outlines import excesses
from mbs_ref.crash.results import CrashResults, crash_results, sign_changes
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory
from reports.facts.curves import Curves, Film, curves, film

PICTURES = 9  # 0.025 s apart to 0.2 s
FINE = Settings(rtol=1e-8, samples=401, estimate="off")
SHOWN = {
    "simplified": ("head", "thorax", "bottom", "seat_base", "seat_back"),
    "vertebral": ("head", "C1", "C2", "C3", "C4", "C5", "C6"),
}
COMPONENTS = (("x", "N"), ("y", "N"), ("torque", "N m"))
FIGURES = {  # of Fox 1999: android, kind of force, caption
    "Fig. 3": ("simplified", "external", "external forces Q_e"),
    "Fig. 4": ("simplified", "constraint", "constraint forces and torques Q_c"),
    "Fig. 5": ("vertebral", "constraint", "head and neck constraint forces Q_c"),
}
BELIEVABLE: dict[str, Any] = {"stops": True, "body_contacts": True}
AS_THEY_RAN: dict[str, Any] = {"stabilization": "none", "reactions": False, "estimate": "off", "samples": 201}
METHODS: dict[
    str, tuple[tuple[str, dict[str, Any]], ...]
] = {  # of the papers, on each android; without located events, as they had none
    "simplified": (("rk4", {"step": 1e-4}), ("euler", {"step": 1e-4}), ("lsodar", {"rtol": 1e-6})),
    "vertebral": (("rk4", {"step": 5e-5}), ("lsodar", {"rtol": 1e-6})),
}


def measure_crash() -> tuple[dict[str, float | str], dict[str, Film], dict[str, Curves]]:
    """Run both androids from the front, and what is asked beside."""
    made = {kind: scenes.make(f"android_{kind}") for kind in SHOWN}
    paths = {kind: _run(scene) for kind, scene in made.items()}
    found = {kind: crash_results(made[kind], paths[kind]) for kind in made}
    figures: dict[str, float | str] = {}
    for kind, scene in made.items():
        figures |= _results(kind, scene, paths[kind], found[kind])
        figures |= _believable(kind)
        for method, more in METHODS[kind]:
            figures |= _method(kind, scene, method, more)
    figures["vertebral.rk4.refusal"] = simulate(made["vertebral"], Settings(method="rk4", step=1e-4)).message
    figures |= _constraints(made["simplified"]) | _in_space(made["simplified"])
    figures["seats.imbalance"] = _seats_imbalance(made["simplified"], found["simplified"])
    films = {
        "Fig. 1": _film("simplified", 15_500.0), "Fig. 2": film(made["vertebral"], paths["vertebral"], 5),
    }  # fmt: skip
    films["Fig. 2, joints that stop and parts that touch"] = _film("vertebral", 15_000.0, **BELIEVABLE)
    drawn = {}
    for name, (kind, field, caption) in FIGURES.items():
        drawn |= _forces(name, caption, made[kind], paths[kind].times, getattr(found[kind].forces, field), SHOWN[kind])
    return figures, films, drawn


def _seats_imbalance(scene: Scene, found: CrashResults) -> float:
    """Return the largest Q_e + Q_c (N, N m) of the two seat bodies, which do not move."""
    seats = [scene.body_index(name) for name in ("seat_base", "seat_back")]
    return float(np.abs(found.forces.external[:, seats] + found.forces.constraint[:, seats]).max())


def _in_space(planar: Scene) -> dict[str, float | str]:
    """Return what the android in space does: straight, against the planar one, and obliquely."""
    fine = Settings(rtol=1e-12, samples=21, estimate="off", reactions=False)
    flat, straight = (simulate(scene, fine) for scene in (planar, scenes.make("android_spatial", oblique=0.0)))
    path = simulate(scenes.make("android_spatial"), fine)
    within = Partial(straight.position[:, :, :2])
    apart = farthest(planar, within, flat)[0] if straight.ok else straight.message
    return {
        "spatial.apart": apart, "spatial.time": straight.timing.loop_s / flat.timing.loop_s,
        "spatial.sideways": float(np.abs(path.position[:, 0, 2]).max()) if path.ok else path.message,
    }  # fmt: skip


def _constraints(scene: Scene) -> dict[str, float | str]:
    """Return the work of the crash with every contact force replaced by a constraint (Fox 2001), and without."""
    settings = FINE.model_copy(update={"rtol": 1e-6, "samples": 41})
    one, other = simulate(scene, settings), simulate(scenes.make(scene.name, law="constraint"), settings)
    return {
        "contacts.steps": float(one.steps), "constraints.steps": float(other.steps),
        "constraints.status": str(other.status) if other.ok else other.message,
        "constraints.apart": farthest(scene, one, other)[0] if other.ok else "stopped",
    }  # fmt: skip


def _run(scene: Scene) -> Trajectory:
    path = simulate(scene, FINE)
    if not path.ok:
        raise RuntimeError(f"{scene.name}: {path.message}")
    return path


def _film(kind: str, force: float, **parameters: Any) -> Film:
    scene = scenes.make(f"android_{kind}", peak_force=force, **parameters)
    return film(scene, simulate(scene, FINE.model_copy(update={"samples": 8 * (PICTURES - 1) + 1})), 2)


def _forces(
    name: str, caption: str, scene: Scene, times: np.ndarray, values: np.ndarray, bodies: tuple[str, ...]
) -> dict[str, Curves]:
    return {
        f"{name}, {caption}: {part}": curves(
            times, {body: values[:, scene.body_index(body), c] for body in bodies}, f"{part}, {unit}"
        )
        for c, (part, unit) in enumerate(COMPONENTS)
    }


def _results(kind: str, scene: Scene, path: Trajectory, found: CrashResults) -> dict[str, float | str]:
    head = next(c.name for c in scene.contacts if c.body_a == "head")
    free = path.contacts[head][:, 0] <= 0.0
    left = float(path.times[np.argmax(free & (path.times > 0.0))])
    again = path.times[(path.times > left) & ~free]
    pull = found.forces.constraint[:, scene.body_index("head"), 0]
    figures: dict[str, float | str] = {
        f"{kind}.bodies": len(scene.bodies), f"{kind}.head_leaves": left,
        f"{kind}.head_back": float(again[0]) if len(again) else "never",
        f"{kind}.seat_force": float(found.seat_force.max()), f"{kind}.belt_force": float(found.belt_force.max()),
        f"{kind}.head_excursion": float(np.abs(found.head_excursion[:, 0]).max()),
        f"{kind}.head_pull_most": float(pull.max()), f"{kind}.head_pull_least": float(pull.min()),
        f"{kind}.largest_constraint_force": float(np.abs(found.forces.constraint[:, :, :2]).max()),
        f"{kind}.HIC36": found.measures["HIC36"], f"{kind}.loop_s": path.timing.loop_s,
        f"{kind}.deepest": max(float(depth.max()) for depth in excesses(Motion(scene, path)).values()),
    }  # fmt: skip
    torques = found.cervical_torques
    changed = [float(t) for torque in torques.values() for t in sign_changes(path.times, torque)[:1]]
    if changed:
        figures |= {
            f"{kind}.neck_changes": len(changed), f"{kind}.neck_first": min(changed),
            f"{kind}.neck_last": max(changed), f"{kind}.neck_most": max(float(t.max()) for t in torques.values()),
            f"{kind}.neck_least": min(float(t.min()) for t in torques.values()),
        }  # fmt: skip
    return figures


def _believable(kind: str) -> dict[str, float | str]:
    """Return what stops and contacts change, front and rear."""
    figures: dict[str, float | str] = {}
    for impact in ("front", "rear"):
        scene = scenes.make(f"android_{kind}", impact=impact, **BELIEVABLE)
        path = _run(scene)
        figures[f"{kind}.{impact}.believable_deepest"] = max(
            float(depth.max()) for depth in excesses(Motion(scene, path)).values()
        )
    for restraint in ("integral", "separate", "none"):
        scene = scenes.make(f"android_{kind}", impact="rear", head_restraint=restraint, **BELIEVABLE)
        found = crash_results(scene, _run(scene))
        figures[f"{kind}.rear.{restraint}.HIC36"] = found.measures["HIC36"]
        figures[f"{kind}.rear.{restraint}.Nij"] = found.measures["Nij"]
        figures[f"{kind}.rear.{restraint}.neck_least"] = float(found.neck_moment.min())
    return figures


def _method(kind: str, scene: Scene, method: str, more: dict) -> dict[str, float | str]:
    """Run a method of the papers under their own test |C| < h, and to the end."""
    settings = Settings(method=method, **more, **AS_THEY_RAN, events="located" if method == "lsodar" else "none")
    tested = simulate(scene, settings.model_copy(update={"stop_on_compliance": True}))
    path, stopped = simulate(scene, settings, ladder.grid(scene)), tested.status is Status.COMPLIANCE
    off = off_truth(scene, path)
    kept = np.zeros((1, 2)) if path.step_compliance is None else path.step_compliance
    name = f"{kind}.{method}"
    return {
        f"{name}.status": str(path.status), f"{name}.test": "fails" if stopped else "keeps",
        f"{name}.until": float(tested.times[-1]), f"{name}.compliance": float(kept[:, 1].max()),
        f"{name}.error": path.message if off is None else off[0],
        f"{name}.switches": float(path.method_switches or 0), f"{name}.steps": float(path.steps),
    }  # fmt: skip
