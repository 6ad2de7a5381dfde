"""The androids under the papers' integrators and others: compliance, work, stable steps, convergence, engines."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from itertools import product
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge import ladder
from cross_checks.judge.cell import cell_of
from cross_checks.judge.one_run import judged_run
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.metrics.state_error import off_truth
from cross_checks.records.store import Store, default_path
from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.observables import constraint_residual
from mbs_ref.observables.distance import distances
from mbs_ref.scene import Scene
from mbs_ref.self_checks.stiffness import stiffness_at_start
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory
from reports.facts.curves import Curves, curves, plain
from reports.studies.androids.facts import AndroidFacts, Convergence, Peer, Run, Stable

SIMPLIFIED, VERTEBRAL = NAMES = ("android_simplified", "android_vertebral")
IMPACTS = ("front", "rear")
PAPER_STEP = 1e-4  # s, Fox 1999
PAPERS: dict[str, Any] = {"stabilization": "none"}  # without stabilization, as they ran
OURS: dict[str, Any] = {}
# the papers' step where these data bear it; RK4 bears 7.1e-5 s and Euler 5.1e-5 s on the vertebral android
STEPS = {
    SIMPLIFIED: (("rk4", PAPER_STEP, PAPERS), ("euler", PAPER_STEP, PAPERS), ("generalized_alpha", 2.5e-4, OURS)),
    VERTEBRAL: (("rk4", 5e-5, PAPERS), ("euler", 2.5e-5, PAPERS), ("generalized_alpha", 2.5e-4, OURS)),
}
BEYOND = {SIMPLIFIED: 8e-3, VERTEBRAL: PAPER_STEP}  # s, steps that RK4 cannot bear
FINE = 1e-9  # rtol at which two unlike methods are compared
MANY = {"lsodar": (1e-4, 1e-6, 1e-8), "dassl": (1e-4,), "dop853": (1e-4, FINE), "radau": (1e-4, FINE)}
FEW = {"lsodar": (1e-6,), "dassl": (1e-4,), "dop853": (FINE,), "radau": (FINE,)}  # dassl alone takes seconds a run
RTOLS = {(SIMPLIFIED, "front"): MANY}  # FEW in the other crashes
MOST_STEPS = 20_000  # of a run; the longest that is meant to end takes 8 000
TESTED = ("rk4", "euler", "lsodar")  # the papers' methods, whose compliance test is run, too
UNLIKE = ("dop853", "radau")  # explicit of order 8, implicit of order 5
WATCHED = {"head": "head", "hip": "bottom"}
ADAPTIVE = {("pinocchio", "dop853")}
PEER_TARGETS = {"adaptive": (1e-3, 1e-6), "fixed": (1e-3,)}  # over the scene's scales; finer takes minutes
SHOWN = {  # on 48 bodies what takes seconds
    (SIMPLIFIED, "rear"): ADAPTIVE | {("exudyn", "tree_dopri5")},
    (VERTEBRAL, "front"): ADAPTIVE,
    (VERTEBRAL, "rear"): ADAPTIVE,
}


def measure() -> AndroidFacts:
    """Run everything; the vertebral android's truths are kept on disk."""
    made = [scenes.make(name, impact=impact) for name, impact in product(NAMES, IMPACTS)]
    runs = [numerics(scene) for scene in made]
    with Store(default_path()) as store:
        return AndroidFacts(
            tuple(run for own in runs for run, _ in own),
            tuple(stable(scenes.make(name)) for name in NAMES),
            tuple(convergence(scene, _fine(own)) for scene, own in zip(made, runs, strict=True)),
            tuple(found for scene in made for found in peers(Runs(store), scene)),
        )


# --- methods of integration ------------------------------------------------------------------------------


def numerics(scene: Scene) -> list[tuple[Run, Trajectory]]:
    """Run the papers' methods without stabilization, and the others as they come."""
    fixed = [Settings(method=method, step=step, **more) for method, step, more in STEPS[scene.name]]
    adaptive = [
        Settings(method=method, rtol=rtol, stabilization="none" if method == "lsodar" else None)
        for method, rtols in RTOLS.get((scene.name, str(scene.parameters["impact"])), FEW).items()
        for rtol in rtols
        if _is_installed(method)
    ]
    return [run(scene, _with_events(settings)) for settings in (*fixed, *adaptive)]


def _is_installed(method: str) -> bool:
    package = integrators()[method].package
    return package is None or find_spec(package) is not None


def _with_events(settings: Settings) -> Settings:
    """A method that locates no events takes the forces as the state clips them."""
    located = integrators()[str(settings.method)].locates_events
    return settings if located else settings.model_copy(update={"events": "none"})


def run(scene: Scene, settings: Settings) -> tuple[Run, Trajectory]:
    """Run one setting; the papers' methods under the papers' test, and again without it where it stops them."""
    settings = settings.model_copy(update={"reactions": False, "estimate": "off", "max_steps": MOST_STEPS})
    path, test = _tested(scene, settings) if settings.method in TESTED else (None, "not asked")
    path = path or simulate(scene, settings, ladder.grid(scene))
    given = {"step": settings.step, "rtol": settings.rtol}
    kept = path.step_compliance if path.step_compliance is not None and len(path.step_compliance) else None
    return Run(
        scene.name, str(scene.parameters["impact"]), str(settings.method), given, str(path.status), path.message,
        int(path.steps), int(path.rejected_steps), int(path.rhs_calls), path.method_switches, int(path.events),
        float(path.timing.loop_s), None if kept is None else _finite(float(np.max(kept[:, 1]))), _curve(kept), test,
        _error(scene, path),
    ), path  # fmt: skip


def _curve(kept: np.ndarray | None) -> Curves | None:
    """Return |C| over time, as long as it is finite."""
    if kept is None:
        return None
    good = kept[1:][np.isfinite(kept[1:, 1])]
    return (
        curves(good[:, 0], {"|C|": good[:, 1]}, "largest |C| since the last sample, m", log=True) if len(good) else None
    )


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _tested(scene: Scene, settings: Settings) -> tuple[Trajectory | None, str]:
    """Return the run and how the papers' test went; no run where the test ended it."""
    path = simulate(scene, settings.model_copy(update={"stop_on_compliance": True}), ladder.grid(scene))
    if path.status is Status.COMPLIANCE:
        return None, path.message
    return path, "kept to the end" if path.ok else "not reached"


def _error(scene: Scene, path: Trajectory) -> float | None:
    """Return the largest distance (m) from the truth."""
    off = off_truth(scene, path)
    return None if off is None else off[0]


# --- stable steps -----------------------------------------------------------------------------------------


def stable(scene: Scene) -> Stable:
    """Linearise the motion at the start, ask for a step too long, and take it all the same."""
    found = stiffness_at_start(scene)
    limits = {name: found.step_limit(m.stability) for name, m in integrators().items() if m.stability}
    beyond = BEYOND[scene.name]
    asked = Settings(method="rk4", step=beyond, samples=26, reactions=False)
    most = {"max_steps": MOST_STEPS, "max_events": MOST_STEPS}
    bold = {"stabilization": "none", "estimate": "off", "refuse_unstable": False, **most}
    forced = simulate(scene, asked.model_copy(update=bold))
    rules = {"1/omega": found.oscillation_rule, "m/c": found.damping_rule}
    return Stable(
        scene.name, plain(np.real(found.modes)), plain(np.imag(found.modes)), found.fastest_decay,
        {name: value for name, value in rules.items() if np.isfinite(value)},
        {name: _finite(float(value)) for name, value in limits.items()}, beyond, simulate(scene, asked).message,
        f"{forced.status}: {forced.message}",
    )  # fmt: skip


# --- convergence ------------------------------------------------------------------------------------------


def convergence(scene: Scene, paths: dict[str, Trajectory] | None = None) -> Convergence:
    """Compare the head's and the hip's path by two unlike integrators (`paths`, by method), and with the truth."""
    times = ladder.grid(scene)
    fine: dict[str, Any] = {"rtol": FINE, "reactions": False, "estimate": "off"}
    paths = paths or {m: simulate(scene, Settings(method=m, **fine), times) for m in UNLIKE}
    one, other = (paths[method] for method in UNLIKE)
    apart = distances(scene, one, other)[..., 0]
    gaps = {label: apart[:, scene.body_index(body)] for label, body in WATCHED.items()}
    truth = truth_for(scene, times)
    compliance = {m: float(np.abs(constraint_residual(scene, path)).max()) for m, path in paths.items()}
    known = None if truth is None else truth.uncertainty
    drawn = curves(times[1:], {part: gap[1:] for part, gap in gaps.items()}, "distance, m", log=True)
    return Convergence(scene.name, str(scene.parameters["impact"]), drawn, compliance, _error(scene, one), known)


def _fine(own: Sequence[tuple[Run, Trajectory]]) -> dict[str, Trajectory]:
    """Return the paths of the two methods at FINE."""
    return {run.method: path for run, path in own if run.method in UNLIKE and run.settings["rtol"] == FINE}


# --- engines ----------------------------------------------------------------------------------------------


def peers(runs: Runs, scene: Scene, names: Sequence[str] | None = None) -> list[Peer]:
    """Judge the methods of every other engine that can run the scene: all in the first crash, few in the others."""
    found, crash = [], (scene.name, str(scene.parameters["impact"]))
    truth, ours = runs.truth(scene), simulate(scene, Settings(rtol=FINE, estimate="off"), ladder.grid(scene))
    for name in engines.names() if names is None else names:
        try:
            engine = engines.get(name)
        except engines.EngineMissing:
            continue
        if name == "mbs_ref" or engine.refusals(scene):
            continue
        able = [m for m in engine.methods() if not engine.method_refusals(scene, m)]
        shown = [m for m in able if crash not in SHOWN or (name, m.name) in SHOWN[crash]]
        found += [peer(runs, scene, name, method, truth, ours) for method in shown]
    return found


def peer(runs: Runs, scene: Scene, engine: str, method: Method, truth: Truth | NoTruth, ours: Trajectory) -> Peer:
    """Judge one method; its joint forces are compared with ours at the setting that speaks for it."""
    tried, answers = search(runs, scene, engine, method, truth, PEER_TARGETS[method.kind])
    cell = cell_of(tried, answers)
    spoken = next((r for r in tried.records.values() if ladder.label(Settings(**r.settings)) == cell.setting), None)
    forces = None
    if spoken is not None:
        again, _ = judged_run(
            scene, engine, Settings(**spoken.settings), ladder.grid(scene), truth=truth, reference=ours
        )
        forces = again.measure("reaction_error")
    return Peer(cell, forces)
