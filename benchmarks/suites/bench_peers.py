"""Our time over the best peer's at equal error at the end, in m: one thread, two outputs, interleaved runs.

Every engine has the coarsest setting, of eight to a decade, whose largest error in position is below that. The best
peer is what its users write: DOP853 in C++ over Pinocchio's headers, compiled for this processor, with ABA in local or
world axes for trees, and constraintDynamics or the loop-constrained ABA for loops; in the sky heyoka's series, unrolled
with fast_math, without equations for bodies at rest, and REBOUND's IAS15 and WHFast. A line states the ratio of the
whole calls, as each engine's adapter makes them, and that of the loops. In heyoka's call the series are compiled, after
the first from its own cache.
`python -m pytest -s -m '' -p no:xdist benchmarks/suites/bench_peers.py` prints a line a scene,
the times of loops and, in brackets, of calls.
"""

import time
from collections.abc import Callable, Sequence
from importlib import import_module

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Engine, Method
from mbs_ref import Scene, Settings, scenes
from mbs_ref.cores.relative import no_tree
from mbs_ref.files import package_data
from mbs_ref.observables.distance import Partial, farthest

DURATION = 1.0  # s, unless the case states another
TRUTH = {"method": "dop853", "rtol": 1e-13}  # unless the case states another
TURNS = 15  # of which a setting's least time counts
TOO_LONG = 2.0  # s of loop: a finer setting is not tried
OURS, OWN = "mbs_ref", ("dop853", "taylor", "gauss")
AT_BEST = {"pinocchio_cpp": "EveryAlgorithm", "heyoka": "Unrolled"}  # engine -> class in its adapter
STATED = package_data(__name__, "peers.toml")

Times = tuple[float, float]  # s, of the loop and of the whole call
Timed = Callable[[], Times]


def settings(method: Method, duration: float = DURATION) -> list[Settings]:
    """Return settings of a method, coarse to fine, eight to a decade."""
    fine = 10.0 ** (-np.arange(57) / 8.0)
    if method.kind == "adaptive":
        return [Settings(method=method.name, rtol=3e-4 * x**2) for x in fine]
    return [Settings(method=method.name, step=duration / np.ceil(50.0 / x)) for x in fine]


def solver_of(engine: str) -> Engine:
    """Return an engine; of some the class that leaves nothing out, whose package is optional."""
    if engine not in AT_BEST:
        return engines.get(engine)
    return getattr(import_module(f"cross_checks.engines.{engine}_"), AT_BEST[engine])()


def loop(engine: str, scene: Scene, chosen: Settings) -> tuple[np.ndarray | None, Times]:
    """Return where the bodies are at the end, None where a run does not get there, and its times."""
    solver, other = solver_of(engine), scene.model_copy()  # our solver would reuse the system of the same scene
    began = time.perf_counter()
    path = solver.run(other, chosen, np.array([0.0, scene.duration]))
    times = path.timing.loop_s, time.perf_counter() - began
    return (path.position[-1] if path.status == "success" else None), times


def cheapest(engine: str, scene: Scene, choices: list[Settings], truth: np.ndarray, error: float) -> Timed | None:
    """Return a run at the coarsest setting that reaches the error, or None."""
    for chosen in choices:
        end, (seconds, _) = loop(engine, scene, chosen)
        if end is not None and farthest(scene, Partial(end[None]), Partial(truth[None]))[0] <= error:
            return lambda chosen=chosen: loop(engine, scene, chosen)[1]
        if seconds > TOO_LONG:
            return None
    return None


def entrants(scene: Scene, peers: Sequence[tuple[str, str]], truth: np.ndarray, error: float) -> dict[str, Timed]:
    """Return who reaches the error, by name."""
    result, lean = {}, {"estimate": "off", "reactions": False, "samples": 2}
    for engine, name in (*((OURS, name) for name in OWN), *peers):
        if engine not in engines.names():
            continue
        solver = solver_of(engine)
        method = solver.method(name)
        if solver.refusals(scene) or solver.method_refusals(scene, method):
            continue
        for coordinates in ("cartesian", "relative") if engine == OURS and not any(no_tree(scene)) else ("cartesian",):
            own = [
                one.model_copy(update={**lean, "coordinates": coordinates}) for one in settings(method, scene.duration)
            ]
            run = cheapest(engine, scene, own, truth, error)
            if run is not None:
                result[f"{engine} {name} {coordinates}"] = run
    return result


@pytest.mark.parametrize("case", STATED["cases"])
def test_over_the_best_peer(benchmark, case):
    stated = STATED["cases"][case]
    scene, aim = scenes.make(stated["scene"], **stated["parameters"]), stated["aim"]
    scene = scene.model_copy(update={"duration": stated.get("duration", DURATION)})
    peers = STATED["peers"][stated["peers"]][: stated.get("most")]
    truth, _ = loop(OURS, scene, Settings(**stated.get("truth", TRUTH), estimate="off", reactions=False))
    assert truth is not None
    runs = entrants(scene, peers, truth, stated["error"])
    seen: dict[str, list[Times]] = {who: [] for who in runs}

    def turn() -> None:
        for who, run in runs.items():
            seen[who].append(run())

    benchmark.pedantic(turn, rounds=TURNS, warmup_rounds=1)
    best = {who: np.min(times, axis=0) for who, times in seen.items()}
    ours = np.min([times for who, times in best.items() if who.startswith(OURS)], axis=0)
    theirs = np.min([times for who, times in best.items() if not who.startswith(OURS)], axis=0)
    of_loop, of_call = (ours / theirs).tolist()
    benchmark.extra_info |= {"of_call": of_call, "of_loop": of_loop, "aim": aim}
    benchmark.extra_info |= {who: times.tolist() for who, times in best.items()}
    shown = ", ".join(f"{who} {1e3 * best[who][0]:.3g} ({1e3 * best[who][1]:.3g}) ms"
                      for who in sorted(best, key=lambda who: best[who][0]))  # fmt: skip
    print(f"\n{case}: {of_call:.2f} of the best peer's call (aim {aim:g}), {of_loop:.2f} of its loop; {shown}")
