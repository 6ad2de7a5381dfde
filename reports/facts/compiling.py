"""Compile the solver's kernels before it is run or timed: plane, space and particles side by side."""

from collections.abc import Callable
from functools import partial

from cross_checks import engines
from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import Report, each
from cross_checks.judge.answers import Preparation
from cross_checks.records.store import Store, code_of, digest_of
from mbs_ref import Settings, scenes
from mbs_ref.files import package_data
from mbs_ref.kernels.jit import cache_folder
from mbs_ref.scene.traits import Coordinates
from mbs_ref.simulate import simulate_scenes
from mbs_ref.simulate.method_choice import AUTO
from reports.facts.stored import keep, recall

CORES = package_data(__name__, "cores.toml")  # scene, coordinates, ...
LANES = "runs in lanes"  # for batches alone: a report makes none
IN_LANES = "double_pendulum", "spatial_chain", "n_four_bar", "spatial_slider_crank", "bouncing_ball"
SOLVER = "mbs_ref"
PROGRAM: tuple[str, Coordinates, bool] = ("pendulum", "cartesian", False)  # what other engines that compile run


def compile_kernels(store: Store, report: Report, lanes: bool = False) -> None:
    """Make all preparations; with `lanes` those of runs side by side, too."""
    wanted = preparations(store, lanes)
    if wanted:
        report(0, len(wanted), f"{', '.join(map(str, wanted))}: minutes, once for each change of the solver")
    for done, (one, _) in enumerate(each(wanted, lambda call, one: one.work(call)), 1):
        report(done, len(wanted), f"done: {one}")


def preparations(store: Store, lanes: bool = False) -> list[Preparation]:
    """Return what the store does not know to be compiled here: the solver on each core, and other engines' programs."""
    works = {core: (SOLVER, partial(run_methods, SOLVER, *what)) for core, what in CORES.items()}
    works |= {LANES: (SOLVER, run_in_lanes)} if lanes else {}
    works |= {
        one.name: (one.name, partial(run_methods, one.name, *PROGRAM)) for one in engines.installed() if one.compiles
    }
    keys = {name: _key(name, engine) for name, (engine, _) in works.items()}
    known = {name for name, key in keys.items() if recall(store, key, bool) and cache_folder().is_dir()}
    return [Preparation(engine, f"compiling {name}", partial(_prepare, store, keys[name], work))
            for name, (engine, work) in works.items() if name not in known]  # fmt: skip


def _key(name: str, engine: str) -> str:
    return digest_of(["compiled", name, code_of(type(engines.get(engine)).__module__), str(cache_folder())])


def _prepare(store: Store, key: str, work: Callable[[], None], call: Caller) -> None:
    getattr(call, "patient", call)(work)
    keep(store, key, bool, True)


def run_in_lanes() -> None:
    """Run the first hundredth of trees, closed loops and a contact as a batch does."""
    for built in map(scenes.make, IN_LANES):
        simulate_scenes([built], _settings("dop853", "adaptive", built.duration, "relative"), lanes=True)


def run_methods(engine: str, scene: str, coordinates: Coordinates, every_method: bool) -> None:
    """Run the first hundredth of a scene by an engine's default method, or by every method that takes it."""
    built, solver = scenes.make(scene), engines.get(engine)
    methods = solver.methods() if every_method else (solver.method(None),)
    chosen = [(method.name, method.kind) for method in methods if not solver.refusal(built, method)]
    for name, kind in (*chosen, (AUTO, "adaptive")) if engine == SOLVER else chosen:
        solver.run(built, _settings(name, kind, built.duration, coordinates))


def _settings(method: str, kind: str, duration: float, coordinates: Coordinates) -> Settings:
    short = {"t_end": 0.01 * duration, "samples": 2, "estimate": "off", "coordinates": coordinates}
    knob = {"rtol": 1e-6} if kind == "adaptive" else {"step": 0.005 * duration}
    return Settings(method=method, **short, **knob)  # type: ignore[arg-type]
