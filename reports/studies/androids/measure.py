"""The androids under the papers' integrators and others: compliance, work, stable steps, convergence, engines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import product
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge import ladder
from cross_checks.judge.matrix import Cell, judge_method
from cross_checks.metrics.pose_error import distance
from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.observables import constraint_residual
from mbs_ref.scene import Scene
from mbs_ref.self_checks.stiffness import Stiffness, stiffness_at_start
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory

SIMPLIFIED, VERTEBRAL = NAMES = ("android_simplified", "android_vertebral")
IMPACTS = ("front", "rear")
PAPER_STEP = 1e-4  # s, Fox 1999
PAPERS: dict[str, Any] = {"stabilization": "none", "estimate": "off"}  # without stabilization, as they ran
OURS: dict[str, Any] = {"estimate": "off"}
# the papers' step where these data bear it; RK4 bears 7.1e-5 s and Euler 5.1e-5 s on the vertebral android
STEPS = {
    SIMPLIFIED: (("rk4", PAPER_STEP, PAPERS), ("euler", PAPER_STEP, PAPERS), ("generalized_alpha", 2.5e-4, OURS)),
    VERTEBRAL: (("rk4", 5e-5, PAPERS), ("euler", 2.5e-5, PAPERS), ("generalized_alpha", 2.5e-4, OURS)),
}
BEYOND = {SIMPLIFIED: 8e-3, VERTEBRAL: PAPER_STEP}  # s, steps that RK4 cannot bear
FINE = 1e-9  # rtol at which two unlike methods are compared
MANY = {"lsodar": (1e-4, 1e-6, 1e-8), "dassl": (1e-4,), "dop853": (1e-4, FINE), "radau": (1e-4, FINE)}
FEW = {"lsodar": (1e-6,), "dassl": (1e-4,), "dop853": (FINE,), "radau": (FINE,)}  # dassl alone takes seconds a run
RTOLS = {"front": MANY, "rear": FEW}
MOST_STEPS = 20_000  # of a run; the longest that is meant to end takes 8 000
TESTED = ("rk4", "euler", "lsodar")  # the papers' methods, whose compliance test is run, too
UNLIKE = ("dop853", "radau")  # explicit of order 8, implicit of order 5
WATCHED = {"head": "head", "hip": "bottom"}
ENGINE_BUDGET = 0.5  # s for a method's ladder
ADAPTIVE = {("pinocchio", "dop853")}
SHOWN = {  # on 48 bodies what takes seconds
    (SIMPLIFIED, "rear"): ADAPTIVE | {("exudyn", "tree_dopri5")},
    (VERTEBRAL, "front"): ADAPTIVE | {("pinocchio", "rk4"), ("mujoco", "rk4")},
    (VERTEBRAL, "rear"): ADAPTIVE,
}
FEWEST = 2  # rungs, which show an order


@dataclass(frozen=True)
class Run:
    """One android under one method and setting."""

    scene: str
    impact: str
    method: str
    settings: Settings
    path: Trajectory
    paper_test: str  # how the papers' test |C| < h at every step ends
    error: float | None  # m, from the truth, largest over bodies and samples; None where the run stopped


@dataclass(frozen=True)
class Stable:
    """What the linearised motion allows, and what becomes of a longer step."""

    scene: str
    stiffness: Stiffness
    limits: dict[str, float]  # explicit method -> s
    beyond: float  # s, a step that RK4 cannot bear
    refusal: str  # the sentence that meets it
    forced: str  # how it ends if it is run all the same


@dataclass(frozen=True)
class Convergence:
    """Two unlike integrators on one android and impact."""

    scene: str
    impact: str
    times: np.ndarray  # (n_t,) s
    gaps: dict[str, np.ndarray]  # head, hip -> (n_t,) m between the two methods
    compliance: dict[str, float]  # method -> m, largest |C|
    error: float | None  # m, of DOP853 from the truth
    uncertainty: float | None  # m, of the truth


@dataclass(frozen=True)
class AndroidFacts:
    """Everything measured."""

    runs: tuple[Run, ...]
    stable: tuple[Stable, ...]
    convergence: tuple[Convergence, ...]
    peers: tuple[Cell, ...]  # of other engines


def measure() -> AndroidFacts:
    """Run what takes a report half a minute; the vertebral android's truths are kept on disk."""
    made = [scenes.make(name, impact=impact) for name, impact in product(NAMES, IMPACTS)]
    runs = [found for scene in made for found in numerics(scene)]
    return AndroidFacts(
        tuple(runs),
        tuple(stable(scenes.make(name)) for name in NAMES),
        tuple(convergence(scene, _fine(scene, runs)) for scene in made),
        tuple(found for scene in made for found in peers(scene)),
    )


# --- methods of integration ------------------------------------------------------------------------------


def numerics(scene: Scene) -> list[Run]:
    """Run the papers' methods without stabilization, and the others as they come."""
    fixed = [Settings(method=method, step=step, **more) for method, step, more in STEPS[scene.name]]
    adaptive = [
        Settings(method=method, rtol=rtol, stabilization="none" if method == "lsodar" else None)
        for method, rtols in RTOLS[str(scene.parameters["impact"])].items()
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


def run(scene: Scene, settings: Settings) -> Run:
    """Run one setting; the papers' methods under the papers' test, and again without it where it stops them."""
    settings = settings.model_copy(update={"reactions": False, "max_steps": MOST_STEPS})
    path, test = _tested(scene, settings) if settings.method in TESTED else (None, "not asked")
    path = path or simulate(scene, settings, ladder.grid(scene))
    impact = str(scene.parameters["impact"])
    return Run(scene.name, impact, str(settings.method), settings, path, test, _error(scene, path))


def _tested(scene: Scene, settings: Settings) -> tuple[Trajectory | None, str]:
    """Return the run and how the papers' test went; no run where the test ended it."""
    path = simulate(scene, settings.model_copy(update={"stop_on_compliance": True}), ladder.grid(scene))
    if path.status is Status.COMPLIANCE:
        return None, path.message
    return path, "kept to the end" if path.ok else "not reached"


def _error(scene: Scene, path: Trajectory) -> float | None:
    """Return the distance from the truth."""
    truth = truth_for(scene, ladder.grid(scene)) if path.ok else None
    return None if truth is None else float(np.max(distance(path.position, truth.position)))


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
    return Stable(
        scene.name, found, limits, beyond, simulate(scene, asked).message, f"{forced.status}: {forced.message}"
    )


# --- convergence ------------------------------------------------------------------------------------------


def convergence(scene: Scene, paths: dict[str, Trajectory] | None = None) -> Convergence:
    """Compare the head's and the hip's path by two unlike integrators (`paths`, by method), and with the truth."""
    times = ladder.grid(scene)
    paths = paths or {m: simulate(scene, Settings(method=m, rtol=FINE, reactions=False), times) for m in UNLIKE}
    one, other = (paths[method] for method in UNLIKE)
    gaps = {
        label: np.linalg.norm((one.position - other.position)[:, scene.body_index(body)], axis=1)
        for label, body in WATCHED.items()
    }
    truth = truth_for(scene, times)
    compliance = {m: float(np.abs(constraint_residual(scene, path)).max()) for m, path in paths.items()}
    known = None if truth is None else truth.uncertainty
    return Convergence(scene.name, str(scene.parameters["impact"]), times, gaps, compliance, _error(scene, one), known)


def _fine(scene: Scene, runs: Sequence[Run]) -> dict[str, Trajectory]:
    """Return the runs of the two methods at FINE."""
    own = [run for run in runs if (run.scene, run.impact) == (scene.name, scene.parameters["impact"])]
    return {run.method: run.path for run in own if run.method in UNLIKE and run.settings.rtol == FINE}


# --- engines ----------------------------------------------------------------------------------------------


def peers(scene: Scene, names: Sequence[str] | None = None, budget_s: float = ENGINE_BUDGET) -> list[Cell]:
    """Judge the methods of every other engine that can run the scene: all in the first crash, few in the others."""
    found, crash = [], (scene.name, str(scene.parameters["impact"]))
    ours = simulate(scene, Settings(rtol=FINE), ladder.grid(scene))
    for name in engines.names() if names is None else names:
        try:
            engine = engines.get(name)
        except engines.EngineMissing:
            continue
        if name == "mbs_ref" or engine.refusals(scene):
            continue
        able = [m for m in engine.methods() if not engine.method_refusals(scene, m)]
        shown = [m for m in able if crash not in SHOWN or (name, m.name) in SHOWN[crash]]
        found += [judge_method(scene, name, m, budget_s, rungs=_rungs(scene, m), reference=ours) for m in shown]
    return found


def _rungs(scene: Scene, method: Method) -> list[Settings]:
    """Return the method's ladder; on the vertebral android the coarsest two that the linearised motion bears."""
    rungs = ladder.rungs(method, scene)
    if scene.name == SIMPLIFIED:
        return rungs
    limit = stiffness_at_start(scene).step_limit(method.stability) if method.stability else np.inf
    return [rung for rung in rungs if rung.step is None or rung.step <= limit][:FEWEST]
