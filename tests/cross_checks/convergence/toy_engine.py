"""An engine of synthetic methods on real scenes, through the public plugin interface, and its judgement by `check`.

    python -m tests.cross_checks.convergence.toy_engine --count 2000

Method `a17` is seed 17 of CALIBRATION, `b17` of HELD_OUT, without those in chaos, which a scene has or has not. The
motion is the scene's truth plus the method's state: its components displace the bodies at nodes in time, joined by
smooth waves that vanish at t = 0, with their velocities. They count in lengths of the scene, and are normalised so that
a limit has its stated distance in the measure of the error. Prints the figures and the worst twenty verdicts.
"""

from __future__ import annotations

import argparse
import os
import sys
from functools import cache

import numpy as np

from cross_checks.engine import End, Engine, Loop, Method
from cross_checks.engines import ADAPTERS
from cross_checks.judge import cell as judging
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store
from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.traits import PART_TYPES
from mbs_ref.trajectory import Status
from tests.cross_checks.convergence.law import SyntheticMethod, size
from tests.cross_checks.convergence.measure import Judged, markdown, mistakes, report
from tests.cross_checks.convergence.synthetic import CALIBRATION, HELD_OUT, draw

FAMILIES = {"a": CALIBRATION, "b": HELD_OUT}
SMOOTH = ("pendulum", "double_pendulum", "spring_pendulum", "spherical_pendulum")
WITH_CONTACT = "bouncing_ball"
COUNT = "TOY_METHODS"  # environment variable: how many methods the engine offers


@cache
def drawn(name: str) -> SyntheticMethod:
    """Return the synthetic method of a name, against a truth known exactly and a motion that amplifies nothing."""
    return draw(int(name[1:]), FAMILIES[name[0]], uncertainty=1e-16, amplification=1.0)


@cache
def offered(count: int) -> tuple[Method, ...]:
    """Return so many methods, alternately of both families."""
    names = (f"{family}{seed}" for seed in range(2 * count) for family in FAMILIES)
    named = [(name, drawn(name)) for name in names]
    listed = [
        Method(name, m.kind, m.order, m.category, embedded=m.embedded if m.kind == "adaptive" else None,
               roundoff=m.roundoff, locates_events=m.is_smooth)
        for name, m in named if m.category != "chaos"
    ]  # fmt: skip
    return tuple(listed[:count])


class ToyEngine(Engine):
    """Truths with prescribed errors."""

    name, package = "toy_engine", "numpy"
    part_types = frozenset(PART_TYPES)

    def methods(self):
        return offered(int(os.environ.get(COUNT, "100")))

    def version(self):
        return "1.0"

    def build(self, scene, plan):
        return scene, drawn(plan.method.name)

    def advance(self, model, plan):
        scene, method = model
        outcome = method.run(plan.rtol or plan.step * method.duration / scene.duration)
        if outcome.status == "cannot":
            raise ValueError(f"{'rtol' if plan.rtol else 'step'} = {plan.rtol or plan.step:g} is not admitted")
        state = np.zeros(len(method.limit)) if outcome.state is None else outcome.state
        states = displaced(scene, method, state, plan.times).reshape(len(plan.times), -1)
        if outcome.state is not None:
            return Loop(states, End(len(plan.times)), steps=outcome.steps)
        status = Status(outcome.status if outcome.status in set(Status) else "engine-error")
        return Loop(states[:1], End(1, status, f"ended with {outcome.status}"), steps=outcome.steps)

    def poses(self, model, plan, states):
        scene, n = model[0], len(states)
        truth = truth_for(scene, plan.times)
        shift, rate = states.reshape(n, 2, len(scene.bodies), scene.dimension).swapaxes(0, 1)
        turn, spin = truth.orientation[:n], np.nan_to_num(truth.angular_velocity[:n])
        return truth.position[:n] + shift, turn, np.nan_to_num(truth.velocity[:n]) + rate, spin


def displaced(scene: Scene, method: SyntheticMethod, state: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return displacements (m) and velocities (m/s) of the bodies, (n_t, 2, n_bodies, dimension)."""
    scales, numbers = scales_of(scene), len(scene.bodies) * scene.dimension
    nodes = int(np.clip(times[-1] / (2.0 * scales.time), 1, len(state) // numbers))
    waves = _waves(times, nodes, scales.time)

    def moved(components: np.ndarray) -> np.ndarray:
        used = components[: nodes * numbers].reshape(nodes, len(scene.bodies), scene.dimension)
        return np.tensordot(waves, used, 1)

    largest = np.where(np.arange(len(state)) // numbers % 2, -1.0, 1.0)  # the fastest motion that components allow
    reference = method.limit if method.label == "wrong-limit" else largest
    unit = size(reference) / np.max(np.linalg.norm(moved(reference), axis=3))
    return unit * np.array([scales.length, scales.speed])[:, None, None] * moved(state)


def _waves(times: np.ndarray, nodes: int, unit: float) -> np.ndarray:
    """Return a wave of cos^2 around each node and its rate per `unit` (s), (n_t, 2, nodes)."""
    width = times[-1] / nodes
    phase = 0.5 * np.pi * np.clip((times[:, None] - width * np.arange(1, nodes + 1)) / width, -1.0, 1.0)
    return np.stack([np.cos(phase) ** 2, -0.5 * np.pi * unit / width * np.sin(2.0 * phase)], axis=1)


ENGINE = ToyEngine


def judged(runs: Runs, method: Method) -> Judged:
    """Return what `check` states of a method of the engine, on a scene that suits it."""
    toy = drawn(method.name)
    scene = scenes.make(SMOOTH[int(method.name[1:]) % len(SMOOTH)] if toy.is_smooth else WITH_CONTACT)
    cell, _ = judging.judged(runs, scene, ToyEngine.name, method, runs.truth(scene))
    good = [float(run["setting"].partition("=")[2]) for run in cell.runs if run["status"] == "success"]
    finest = toy.run(good[-1] * (toy.duration / scene.duration if toy.kind == "fixed" else 1.0)) if good else None
    return Judged(toy, cell.verdict, len(cell.runs), finest, reason=cell.reason)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--batch", type=int, default=250, help="methods for which one store in memory is held")
    given = parser.parse_args()
    os.environ[COUNT], os.environ[ADAPTERS] = str(given.count), __file__
    methods, verdicts = ENGINE().methods(), []
    for first in range(0, given.count, given.batch):
        runs = Runs(Store())
        verdicts += [judged(runs, method) for method in methods[first : first + given.batch]]
        print(f"{len(verdicts)} of {given.count} methods", file=sys.stderr)
    print(markdown(report(verdicts)))
    for j in mistakes(verdicts)[:20]:
        print(f"{j.method.label}, {j.method.category}, {j.method.kind} {j.method.order}: {j.verdict}: {j.reason}")


if __name__ == "__main__":
    main()
