"""Are the runs' own error estimates honest? Random runs of the reference solver, compared with far tighter ones.

Half of the runs are of random mechanisms, half of the project's scenes over a random part of their duration; method
and step or tolerance are random too. The truth is a run of DOP853 at TIGHT, and known as well as LSODAR at its tightest
agrees with it. Seeds are split in halves: the estimate is tuned on the even ones, and judged by the odd ones.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.judge import ladder
from cross_checks.records import lines
from cross_checks.records.store import code_of
from cross_checks.truths import EPS, certificate, stored_poses
from cross_checks.truths.oracle.random_scenes import random_scene
from cross_checks.truths.truth import ONE_FIGURE, Truth
from mbs_ref import Scene, Settings, Trajectory, scenes
from mbs_ref.integrators import integrators
from mbs_ref.observables.distance import largest, relative, units_of
from mbs_ref.scene.scales import free_fall_time, scales_of, tolerance_unit
from mbs_ref.simulate import simulate
from mbs_ref.simulate.plan import make_plan

TIGHT = {"dop853": 1e-13, "lsodar": 1e-12}  # relative tolerances of the two runs that are the truth
LARGEST = 12  # bodies of a random mechanism
SAMPLES = (5, 21, 101)  # many outputs end every step
MAX_STEPS = 50_000  # of a run; a longer one is left out
HEAVY = {  # share of the duration taken
    "tracked_vehicle": 0.01, "granular_column": 0.02, "android_vertebral": 0.005, "solar_system": 0.002,
}  # fmt: skip


@dataclass(frozen=True)
class Trial:
    """One run and its truth."""

    seed: int
    scene: str
    method: str
    setting: str  # step or tolerance
    status: str
    estimate: float | None = None  # over the scene's scales; None where the run failed
    error: float | None = None  # likewise; None where there is no truth
    uncertainty: float | None = None  # of the truth
    cost: float | None = None  # of the estimate, over the run's loop
    code: str = ""  # digest of the sources that computed it

    @property
    def is_below(self) -> bool:
        """Whether the error is certainly above the estimate."""
        return self.is_decided and (self.error or 0.0) > (self.estimate or 0.0)

    @property
    def is_decided(self) -> bool:
        """Whether the truth is known well enough to tell which is larger."""
        if self.estimate is None or self.error is None or self.uncertainty is None:
            return False
        return abs(self.error - self.estimate) > self.uncertainty

    @property
    def overestimate(self) -> float | None:
        """The estimate over the error; None where the truth knows no figure of the error."""
        if self.estimate is None or not self.error or not self.error > ONE_FIGURE * (self.uncertainty or 0.0):
            return None
        return self.estimate / self.error


def stored(file: Path) -> dict[int, Trial]:
    """Return the trials in a file by their seeds; those of other sources are left out."""
    result = lines.read(file, Trial)[0] if file.is_file() else []
    return {one.seed: one for one in result if one.code == code_of(__name__)}


def proven() -> list[tuple[Scene, Truth]]:
    """Return the certified scenes whose stored truth is proven, with that truth at the output times of judged runs."""
    certified = [scenes.make(one.scene, **one.parameters) for one in certificate.every()]
    found = [(scene, stored_poses.load(scene, ladder.grid(scene))) for scene in certified]
    return [(scene, truth) for scene, truth in found if truth is not None and truth.kind == "proven"]


def trial(seed: int, among: Sequence[tuple[Scene, Truth]] = ()) -> Trial:
    """Return the trial of a seed, always the same: its run and its truth; `among` has scenes with proven truths.

    A run that is refused, or whose truth fails, says so in its status.
    """
    return replace(_made(seed, among), code=code_of(__name__))


def _made(seed: int, among: Sequence[tuple[Scene, Truth]]) -> Trial:
    rng, truth = np.random.default_rng([seed, 18]), None
    if among:
        scene, truth = among[int(rng.integers(len(among)))]
        t_end = scene.duration
    else:
        scene, t_end = _scene(rng, seed)
    method, settings = _settings(rng, scene, t_end)
    setting = f"step {settings.step:.3g}" if settings.step else f"rtol {settings.rtol:.3g}"
    samples = int(rng.choice(SAMPLES))
    settings = settings.model_copy(update={"max_steps": MAX_STEPS, "reactions": False, "samples": samples})
    about = (seed, scene.name, method, setting)
    try:
        times = ladder.grid(scene) if truth else make_plan(scene, settings, None).times
        path = simulate(scene, settings, times)
    except ValueError as error:
        return Trial(*about, f"refused: {error}")
    if path.estimate is None:
        return Trial(*about, str(path.status))
    value = float(min(path.estimate.value, 1e300))
    cost = path.estimate.cost_s / max(path.timing.loop_s, 1e-9)
    known = (truth, _rounding(scene, truth)) if truth else _truth(scene, times)
    if known is None:
        return Trial(*about, str(path.status), value, cost=cost)
    return Trial(*about, str(path.status), value, _gap(scene, path, known[0]), known[1], cost)


def _rounding(scene: Scene, truth: Truth) -> float:
    """Return the uncertainty of a proven truth over the scene's scales: its radius and its rounding."""
    rates = 2 * [0.0 if truth.rate_uncertainty is None else float(truth.rate_uncertainty.max())]
    own = truth.uncertainty, EPS * float(np.abs(truth.orientation).max()), *rates
    return float((np.array(own) / units_of(scales_of(scene))).max())


def _scene(rng: np.random.Generator, seed: int) -> tuple[Scene, float]:
    if rng.random() < 0.5:
        scene = random_scene(seed, most=LARGEST)
        return scene, scene.duration * float(rng.uniform(1.0, 20.0))
    name = str(rng.choice(scenes.names()))
    scene = scenes.make(name)
    return scene, scene.duration * float(rng.uniform(0.05, 1.0)) * HEAVY.get(name, 1.0)


def _settings(rng: np.random.Generator, scene: Scene, t_end: float) -> tuple[str, Settings]:
    method = str(rng.choice([name for name in integrators() if _takes(scene, name)]))
    kind = integrators()[method].kind
    if kind == "fixed" or (kind == "both" and rng.random() < 0.3):
        step = min(t_end / 20.0, free_fall_time(scene) * 10.0 ** float(rng.uniform(-4.0, -1.5)))
        return method, Settings(method=method, step=step, t_end=t_end)
    rtol = 10.0 ** float(rng.uniform(-11.0, -2.0))
    return method, Settings(method=method, rtol=rtol, atol=rtol * tolerance_unit(scene), t_end=t_end)


def _takes(scene: Scene, method: str) -> bool:
    settings = Settings(method=method, step=1e-3) if integrators()[method].kind == "fixed" else Settings(method=method)
    try:
        make_plan(scene, settings, None)
    except ValueError:
        return False
    return True


def _truth(scene: Scene, times: np.ndarray) -> tuple[Trajectory | Truth, float] | None:
    """Return a far tighter run, and how well another method agrees with it."""
    runs = [
        simulate(scene, Settings(method=name, rtol=rtol, atol=rtol * tolerance_unit(scene), reactions=False,
                                 estimate="off", max_steps=20 * MAX_STEPS), times)
        for name, rtol in TIGHT.items()
    ]  # fmt: skip
    if not all(run.ok for run in runs):
        return None
    return runs[0], _gap(scene, *runs)


def _gap(scene: Scene, first: Trajectory, second: Trajectory | Truth) -> float:
    return float(min(largest(relative(scene, first, second, np.inf)), 1e300))


def table(result: Iterable[Trial]) -> list[dict[str, Any]]:
    """Return a row a method and one for all: runs judged, those below their error, and how far above the others are."""
    every = list(result)
    methods = sorted({one.method for one in every})
    return [_row("all", every), *(_row(name, [one for one in every if one.method == name]) for name in methods)]


def _row(name: str, result: list[Trial]) -> dict[str, Any]:
    decided = [one for one in result if one.is_decided]
    over = [one.overestimate for one in result if one.overestimate is not None]
    costs = [one.cost for one in result if one.cost is not None]
    low, median, high = np.percentile(over, (1, 50, 90)).tolist() if over else (None, None, None)
    return {
        "method": name, "runs": len(result), "with_estimate": len(costs), "judged": len(decided),
        "below": sum(one.is_below for one in decided),
        "share_below": sum(one.is_below for one in decided) / len(decided) if decided else None,
        "overestimate_1": low, "overestimate_median": median, "overestimate_90": high,
        "cost_median": float(np.median(costs)) if costs else None,
    }  # fmt: skip


def to_dict(one: Trial) -> dict[str, Any]:
    """Return plain data for JSON."""
    return asdict(one) | {"is_below": one.is_below, "overestimate": one.overestimate}
