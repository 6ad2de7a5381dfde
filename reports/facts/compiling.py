"""Compile the solver's kernels before anything is run or timed: plane, space and particles side by side."""

import tomllib
from importlib.resources import files

from cross_checks import engines
from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import Report, each
from cross_checks.records.store import Store, code_of, digest_of
from mbs_ref import Settings, scenes
from mbs_ref.kernels.jit import cache_folder
from mbs_ref.scene.traits import Coordinates
from mbs_ref.simulate import simulate_scenes
from reports.facts.stored import keep, recall

CORES = tomllib.loads((files(__package__) / "cores.toml").read_text(encoding="utf-8"))  # scene, coordinates, ...
LANES = "runs in lanes"  # for batches alone: a report makes none
SOLVER = "mbs_ref"


def compile_kernels(store: Store, report: Report, lanes: bool = False) -> None:
    """Run every method of the solver once on each core that the store does not know to be compiled here.

    With `lanes` runs side by side, too.
    """
    keys = {core: _key(core) for core in ([*CORES, LANES] if lanes else CORES)}
    wanted = [core for core, key in keys.items() if not (recall(store, key, bool) and cache_folder().is_dir())]
    if wanted:
        report(0, len(wanted), f"compiling {', '.join(wanted)}: a minute, once for each change of the solver")
    for done, (core, _) in enumerate(each(wanted, _compile), 1):
        report(done, len(wanted), f"compiled {core}")
        keep(store, keys[core], bool, True)


def _key(core: str) -> str:
    return digest_of(["compiled", core, code_of(type(engines.get(SOLVER)).__module__), str(cache_folder())])


def _compile(call: Caller, core: str) -> None:
    if core == LANES:
        call(run_in_lanes)
    else:
        call(run_methods, *CORES[core])


def run_in_lanes() -> None:
    """Run the first hundredth of trees and of a closed loop as a batch does."""
    for built in map(scenes.make, ("double_pendulum", "spatial_chain", "n_four_bar")):
        simulate_scenes([built], _settings("dop853", "adaptive", built.duration, "relative"), lanes=True)


def run_methods(scene: str, coordinates: Coordinates, every_method: bool) -> None:
    """Run the first hundredth of a scene by the default method, or by every method that takes it."""
    built, solver = scenes.make(scene), engines.get(SOLVER)
    for method in solver.methods() if every_method else (solver.method(None),):
        if not solver.method_refusals(built, method):
            solver.run(built, _settings(method.name, method.kind, built.duration, coordinates))


def _settings(method: str, kind: str, duration: float, coordinates: Coordinates) -> Settings:
    short = {"t_end": 0.01 * duration, "samples": 2, "estimate": "off", "coordinates": coordinates}
    knob = {"rtol": 1e-6} if kind == "adaptive" else {"step": 0.005 * duration}
    return Settings(method=method, **short, **knob)  # type: ignore[arg-type]
