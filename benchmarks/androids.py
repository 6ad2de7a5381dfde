"""The androids under the papers' integrators and others: compliance, work, stable steps, convergence, engines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from cross_checks import engines, ladder
from cross_checks.compare import judged_run
from cross_checks.matrix import Cell, judge_method
from cross_checks.metrics.pose_error import distance
from cross_checks.metrics.reaction_error import reaction_error
from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.cores import compile_scene
from mbs_ref.integrators import integrators
from mbs_ref.observables import constraint_residual
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory
from mbs_ref.trouble import Stiffness, stiffness

SIMPLIFIED, VERTEBRAL = NAMES = ("android_simplified", "android_vertebral")
IMPACTS = ("front", "rear")
PAPER_STEP = 1e-4  # s, Fox 1999
# the papers' step where these data bear it; RK4 bears 7.1e-5 s and Euler 5.1e-5 s on the vertebral android
STEPS = {SIMPLIFIED: {"rk4": PAPER_STEP, "euler": PAPER_STEP}, VERTEBRAL: {"rk4": 5e-5, "euler": 2.5e-5}}
BEYOND = {SIMPLIFIED: 8e-3, VERTEBRAL: PAPER_STEP}  # s, steps that RK4 cannot bear
RTOLS = {
    SIMPLIFIED: {"lsodar": (1e-4, 1e-6, 1e-8), "dassl": (1e-6, 1e-8), "dop853": (1e-6, 1e-8), "radau": (1e-6, 1e-8)},
    VERTEBRAL: {"lsodar": (1e-6,), "dop853": (1e-6, 1e-8)},
}
MOST_STEPS = 20_000  # of a run; the longest that is meant to end takes 8 000
TESTED = ("rk4", "euler", "lsodar")  # the papers' methods, whose compliance test is run, too
UNLIKE = ("dop853", "radau")  # explicit of order 8, implicit of order 5
FINE = 1e-9  # rtol at which the two are compared
WATCHED = {"head": "head", "hip": "bottom"}
SAMPLES = 201
ENGINE_BUDGET = 1.5  # s for a method's ladder


@dataclass(frozen=True)
class Run:
    """One android under one method and setting."""

    scene: str
    method: str
    settings: Settings
    path: Trajectory
    paper_test: str  # how the papers' test |C| < h at every step ends
    error: float | None  # m, from the truth, largest over bodies and samples; None: stopped, or the truth is too long


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
class Peer:
    """An engine's method on an android: the verdict on its ladder, and its joint reactions at its best setting."""

    cell: Cell
    reaction_gap: float | None  # N, N m, from ours; None where the engine gives no reactions
    reactions: int  # joints compared


@dataclass(frozen=True)
class AndroidFacts:
    """Everything measured."""

    runs: tuple[Run, ...]
    stable: tuple[Stable, ...]
    convergence: tuple[Convergence, ...]
    peers: tuple[Peer, ...]


def measure() -> AndroidFacts:
    """Run what takes a report no more than a minute; the vertebral android's truth takes half a minute by itself."""
    made = [scenes.make(name) for name in NAMES]
    return AndroidFacts(
        tuple(found for scene in made for found in numerics(scene)),
        tuple(stable(scene) for scene in made),
        tuple(convergence(SIMPLIFIED, impact) for impact in IMPACTS),
        tuple(peers(made[0])),
    )


# --- methods of integration ------------------------------------------------------------------------------


def numerics(scene: Scene) -> list[Run]:
    """Run the papers' methods without stabilization, and the others as they come."""
    papers: dict[str, Any] = {"stabilization": "none", "samples": SAMPLES, "unresolved": "keep"}
    fixed = [Settings(method=m, step=h, **papers) for m, h in STEPS[scene.name].items()]
    adaptive = [
        Settings(method=method, rtol=rtol, stabilization="none" if method == "lsodar" else None, samples=SAMPLES)
        for method, rtols in RTOLS[scene.name].items()
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
    """Run one setting, and again under the papers' test."""
    settings = settings.model_copy(update={"reactions": False, "max_steps": MOST_STEPS})
    path = simulate(scene, settings)
    return Run(scene.name, str(settings.method), settings, path, _paper_test(scene, settings), _error(scene, path))


def _paper_test(scene: Scene, settings: Settings) -> str:
    if settings.method not in TESTED:
        return "not asked"
    tested = simulate(scene, settings.model_copy(update={"stop_on_compliance": True}))
    return "kept to the end" if tested.status is Status.SUCCESS else tested.message


def _error(scene: Scene, path: Trajectory) -> float | None:
    """Return the distance from the truth at those samples that the judged grid has, too."""
    grid = ladder.grid(scene)
    truth = truth_for(scene, grid) if path.ok and scene.name == SIMPLIFIED else None
    if truth is None:
        return None
    shared = [int(np.argmin(np.abs(path.times - t))) for t in grid]
    assert np.allclose(path.times[shared], grid, atol=1e-12)
    return float(np.max(distance(path.position[shared], truth.position)))


# --- stable steps -----------------------------------------------------------------------------------------


def stable(scene: Scene) -> Stable:
    """Linearise the motion at the start, ask for a step too long, and take it all the same."""
    system = compile_scene(scene)
    y = system.initial_state()
    system.set_mode_time(0.0)
    system.start_contacts(0.0, y, True)
    found = stiffness(system, 0.0, y)
    limits = {name: found.step_limit(m.stability) for name, m in integrators().items() if m.stability}
    beyond = BEYOND[scene.name]
    asked = Settings(method="rk4", step=beyond, samples=2, reactions=False, unresolved="keep")
    bold = {"refuse_unstable": False, "max_steps": MOST_STEPS, "max_events": MOST_STEPS}
    forced = simulate(scene, asked.model_copy(update=bold))
    return Stable(
        scene.name, found, limits, beyond, simulate(scene, asked).message, f"{forced.status}: {forced.message}"
    )


# --- convergence ------------------------------------------------------------------------------------------


def convergence(name: str, impact: str, rtol: float = FINE) -> Convergence:
    """Compare the head's and the hip's path by two unlike integrators, and with the truth."""
    scene = scenes.make(name, impact=impact)
    times = ladder.grid(scene)
    paths = {m: simulate(scene, Settings(method=m, rtol=rtol, reactions=False), times) for m in UNLIKE}
    one, other = paths.values()
    gaps = {
        label: np.linalg.norm((one.position - other.position)[:, scene.body_index(body)], axis=1)
        for label, body in WATCHED.items()
    }
    truth = truth_for(scene, times)
    compliance = {m: float(np.abs(constraint_residual(scene, path)).max()) for m, path in paths.items()}
    error = None if truth is None else float(np.max(distance(one.position, truth.position)))
    return Convergence(name, impact, times, gaps, compliance, error, None if truth is None else truth.uncertainty)


# --- engines ----------------------------------------------------------------------------------------------


def peers(scene: Scene, names: Sequence[str] | None = None, budget_s: float = ENGINE_BUDGET) -> list[Peer]:
    """Judge every method of every other engine that can run the scene."""
    found = []
    ours = simulate(scene, Settings(rtol=FINE), ladder.grid(scene))
    for name in engines.names() if names is None else names:
        try:
            engine = engines.get(name)
        except engines.EngineMissing:
            continue
        if name == "mbs_ref" or engine.refusals(scene):
            continue
        able = [m for m in engine.methods() if not engine.method_refusals(scene, m)]
        found += [_peer(scene, name, judge_method(scene, name, method, budget_s), ours) for method in able]
    return found


def _peer(scene: Scene, engine: str, cell: Cell, ours: Trajectory) -> Peer:
    if not cell.setting:
        return Peer(cell, None, 0)
    kind, text = cell.setting.split("=")
    value = float(text)
    fixed = kind == "step"
    accuracy: dict[str, Any] = {"step": value, "unresolved": "keep"} if fixed else {"rtol": value}
    settings = Settings(method=cell.method, **accuracy)
    _, path = judged_run(scene, engine, settings, ladder.grid(scene))
    if path is None or not path.ok:
        return Peer(cell, None, 0)
    common = path.reactions.keys() & ours.reactions.keys()
    return Peer(cell, reaction_error(path.reactions, ours.reactions), len(common))
