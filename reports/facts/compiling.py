"""Compile the solver's kernels before anything is run or timed: plane, space and particles side by side."""

from typing import NamedTuple

from cross_checks import engines
from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import Report, each
from cross_checks.records.store import Store, code_of, digest_of
from mbs_ref import Settings, scenes
from mbs_ref.kernels.jit import cache_folder
from mbs_ref.scene.traits import Coordinates
from mbs_ref.simulate import simulate_scenes
from reports.facts.stored import keep, recall


class Core(NamedTuple):
    """The smallest scene that needs a part of the compiled code, and how it is run."""

    scene: str
    coordinates: Coordinates = "cartesian"
    every_method: bool = False  # their loops are compiled once for all cores, but for methods on the DAE itself


# The largest to compile come first. Of those that begin together one compiles every method's loop: others would compile
# the same, side by side.
CORES = {
    "space": Core("heavy_top"), "plane": Core("double_pendulum", every_method=True),
    "loops in space": Core("spatial_n_four_bar"), "contacts in space": Core("rolling_sphere"),
    "loops in the plane": Core("n_four_bar"), "contacts in the plane": Core("sliding_block"),
    "particles": Core("kepler", every_method=True), "trees in space": Core("heavy_top", "relative"),
    "trees in the plane": Core("double_pendulum", "relative"), "methods in space": Core("heavy_top", every_method=True),
}  # fmt: skip
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
