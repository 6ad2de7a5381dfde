"""Our time over the best peer's at equal error: 1e-6 m after 1 s, one thread, two outputs, interleaved runs.

Every engine has the coarsest setting, of eight to a decade, whose largest error in position is below that. The best
peer is what its users write: DOP853 in C++ over Pinocchio's headers where the scene is a tree and a compiler is there.
`python -m pytest -s -m '' -p no:xdist benchmarks/suites/bench_peers.py` prints a line a scene.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Method
from mbs_ref import scenes
from mbs_ref.cores.relative.layout import no_tree
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

ERROR, DURATION = 1e-6, 1.0  # m, s
TIMES = np.array([0.0, DURATION])
TURNS = 15  # of which a setting's least time counts
TOO_LONG = 2.0  # s of loop: a finer setting is not tried
OURS = "mbs_ref"
TREES = (("pinocchio_cpp", "dop853"), ("pinocchio", "dop853"), ("mujoco", "rk4"), ("exudyn", "tree_dopri5"))
LOOPED = (("pinocchio", "dop853"), ("mujoco", "rk4"), ("exudyn", "generalized_alpha"))
DRIVEN = (("pinocchio", "dop853"), ("exudyn", "tree_dopri5"), ("mujoco", "rk4"))
CASES: dict[str, tuple[str, dict[str, Any], tuple[tuple[str, str], ...], float]] = {  # with the largest ratio aimed at
    **{f"chain {n}": ("pendulum_chain", {"links": n}, TREES, 0.6) for n in (3, 10, 30)},
    **{f"chain {n}": ("pendulum_chain", {"links": n}, TREES[:1], 0.3) for n in (100, 300)},
    "ball chain 10": ("spatial_chain", {"links": 10}, TREES, 0.8),
    "four-bars 1": ("n_four_bar", {"loops": 1}, LOOPED, 1.0),
    "four-bars 10": ("n_four_bar", {"loops": 10}, LOOPED, 0.4),
    "four-bars 40": ("n_four_bar", {"loops": 40}, LOOPED[:2], 0.15),
    "android": ("android_simplified", {}, DRIVEN, 0.25),
}

Timed = Callable[[], float]


def settings(method: Method) -> list[Settings]:
    """Return settings of a method, coarse to fine, eight to a decade."""
    fine = 10.0 ** (-np.arange(33) / 8.0)
    if method.kind == "adaptive":
        return [Settings(method=method.name, rtol=3e-4 * x**2) for x in fine]
    return [Settings(method=method.name, step=DURATION / np.ceil(50.0 / x)) for x in fine]


def loop(engine: str, scene: Scene, chosen: Settings) -> tuple[np.ndarray | None, float]:
    """Return where the bodies are at the end, None where a run does not get there, and the time of the loop (s)."""
    path = engines.get(engine).run(scene, chosen, TIMES)
    return (path.position[-1] if path.status == "success" else None), path.timing.loop_s


def cheapest(engine: str, scene: Scene, choices: list[Settings], truth: np.ndarray) -> Timed | None:
    """Return a run at the coarsest setting that reaches the error, or None."""
    for chosen in choices:
        end, seconds = loop(engine, scene, chosen)
        if end is not None and farthest(scene, Partial(end[None]), Partial(truth[None]))[0] <= ERROR:
            return lambda chosen=chosen: loop(engine, scene, chosen)[1]
        if seconds > TOO_LONG:
            return None
    return None


def is_tree(scene: Scene) -> bool:
    """Return whether our solver has relative coordinates for it."""
    return not any(no_tree(scene))


def entrants(scene: Scene, peers: tuple[tuple[str, str], ...], truth: np.ndarray) -> dict[str, Timed]:
    """Return who reaches the error, by name."""
    result, lean = {}, {"estimate": "off", "reactions": False, "samples": len(TIMES)}
    for engine, name in ((OURS, "dop853"), *peers):
        if engine not in engines.names():
            continue
        solver = engines.get(engine)
        method = solver.method(name)
        if solver.refusals(scene) or solver.method_refusals(scene, method):
            continue
        for coordinates in ("cartesian", "relative") if engine == OURS and is_tree(scene) else ("cartesian",):
            own = [one.model_copy(update={**lean, "coordinates": coordinates}) for one in settings(method)]
            run = cheapest(engine, scene, own, truth)
            if run is not None:
                result[f"{engine} {name} {coordinates}"] = run
    return result


@pytest.mark.parametrize("case", CASES)
def test_over_the_best_peer(benchmark, case):
    name, parameters, peers, aim = CASES[case]
    scene = scenes.make(name, **parameters)
    truth, _ = loop(OURS, scene, Settings(method="dop853", rtol=1e-12, estimate="off", reactions=False))
    assert truth is not None
    runs = entrants(scene, peers, truth)
    best = dict.fromkeys(runs, np.inf)

    def turn() -> None:
        for who, run in runs.items():
            best[who] = min(best[who], run())

    benchmark.pedantic(turn, rounds=TURNS, warmup_rounds=1)
    ours = min(seconds for who, seconds in best.items() if who.startswith(OURS))
    theirs = min(seconds for who, seconds in best.items() if not who.startswith(OURS))
    benchmark.extra_info |= {"ratio": ours / theirs, "aim": aim} | best
    shown = ", ".join(f"{who} {1e3 * best[who]:.3g} ms" for who in sorted(best, key=best.__getitem__))
    print(f"\n{case}: {ours / theirs:.2f} of the best peer (aim {aim:g}); {shown}")
