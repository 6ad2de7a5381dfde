"""Random mechanisms: the O(N) solver against the dense oracle, and short runs against the laws of mechanics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbs_ref import observables
from mbs_ref.cores import compile_scene
from mbs_ref.euler_parameters import rotation_matrices
from mbs_ref.scene import Scene
from mbs_ref.scene_file import dumps, loads
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.spatial_system import SpatialSystem
from mbs_ref.system import System
from mbs_ref.trajectory import Status, Trajectory
from tests.mbs_ref import exact_oracle
from tests.mbs_ref.dense_oracle import Augmented, Moment, Solution, augmented
from tests.mbs_ref.exact_oracle import has_extended_precision
from tests.mbs_ref.random_scenes import DURATION, random_scene

AGREEMENT = 1e-9  # relative, of accelerations and reactions, where the condition of C_q is below 1e6
DOUBTFUL = 1e-11  # relative: a larger difference may be the double-precision oracle's own error
EPS = float(np.finfo(float).eps)
BACKWARD = 1e-12  # relative: the equations themselves, whatever the condition
CONSERVED = 1e-7  # of the largest energy or momentum, over 0.1 s at rtol = 1e-10
COMPLIANT = 1e-10  # m, rad; ten times that for their rates
DEAD_END = 0.3  # of the smallest singular value at the start
CLOSE_LOOK = 1e-3  # s
QUICK, MANY = 60, 1000


class Figures(NamedTuple):
    """The worst of one scene; each is relative to the largest of its kind, as said where it is computed."""

    acceleration: float = 0.0  # against the oracle, forward error
    reaction: float = 0.0
    backward: float = 0.0  # what the solver's accelerations leave of the oracle's equations
    energy: float = 0.0
    momentum: float = 0.0
    compliance: float = 0.0  # m, rad
    lost: float = 0.0  # the larger of the two forward errors over eps * condition of C_q: 1 is what nobody can avoid
    condition: float = 1.0

    def worse(self, other: Figures) -> Figures:
        return Figures(*map(max, self, other))


# --- one moment -----------------------------------------------------------------------------------


def state_of(system: System, moment: Moment) -> np.ndarray:
    """Return the solver's state at a moment."""
    if not isinstance(system, SpatialSystem):
        pose = np.column_stack((moment.position, moment.orientation))
        return np.concatenate((pose.ravel(), moment.rate.ravel()))
    y, bodies = system.initial_state(), system.groups.bodies
    for q, v, k, rigid in zip(bodies.q, bodies.v, bodies.scene_index, bodies.rigid, strict=True):
        y[q : q + 3], y[v : v + 3] = moment.position[k], moment.rate[k, :3]
        if rigid:
            y[q + 3 : q + 7] = moment.orientation[k]
            y[v + 3 : v + 6] = rotation_matrices(moment.orientation[k]).T @ moment.rate[k, 3:]
    return y


def relative(found: np.ndarray, true: np.ndarray) -> float:
    """Return the largest difference over the largest value; nothing at all may happen, and then 1e-3 stands for it."""
    return float(np.abs(found - true).max() / max(float(np.abs(true).max()), 1e-3)) if true.size else 0.0


def compare(system: System, moment: Moment, exact: bool = False) -> Figures:
    """Compare the solver with the oracle at one moment: the plain relative difference of all accelerations together.

    Lengths are near 1 m, so that m/s^2 and rad/s^2 compare. A mechanism without a degree of freedom has none, and is
    measured against what its forces would do to free bodies. Where the oracle in double precision, which differences,
    cannot tell (beyond DOUBTFUL), or with `exact`, the one in extended precision does.
    """
    dense = augmented(moment)
    true = dense.solve()
    system.set_mode_time(moment.time)
    found = system.accelerations(moment.time, state_of(system, moment))
    forces = system.reactions(moment.time, state_of(system, moment)) if not true.redundant else {}
    if has_extended_precision() and (exact or max(_gaps(found, forces, true)) > DOUBTFUL):
        true = exact_oracle.solve(moment)
    acceleration, reaction = _gaps(found, forces, true)
    if moment.used.sum() == len(dense.kept):  # locked: nothing moves, and forces that cancel set the scale
        free = np.linalg.solve(dense.mass, dense.force)
        acceleration = float(np.abs(found - true.acceleration).max() / max(float(np.abs(free).max()), 1e-3))
    return Figures(
        acceleration=acceleration,
        reaction=reaction,
        backward=_backward(dense, found[moment.used]),
        lost=max(acceleration, reaction) / (EPS * true.condition),
        condition=true.condition,
    )


def _gaps(found: np.ndarray, forces: dict[str, np.ndarray], true: Solution) -> tuple[float, float]:
    """Return the relative differences of accelerations and of reactions; redundant rows leave the latter open."""
    return relative(found, true.acceleration), 0.0 if true.redundant else _reaction_gap(forces, true)


def _reaction_gap(found: dict[str, np.ndarray], true: Solution) -> float:
    """Of all wrenches together, N and N m: sizes are near 1 m. Redundant rows leave each joint's share open."""
    names = list(true.wrenches)
    if not names:
        return 0.0
    return relative(np.array([found[name] for name in names]), np.array([true.wrenches[name] for name in names]))


def _backward(dense: Augmented, acceleration: np.ndarray) -> float:
    """Return what is left of C_q a = gamma, and of M a - Q outside the span of C_q^T, in the mass norm."""
    x = dense.root.T @ acceleration
    force = np.linalg.solve(dense.root, dense.force)
    rest = x - force
    size = np.linalg.norm(x) + np.linalg.norm(force) + 1.0  # N / sqrt(kg): nothing may happen at all
    if not len(dense.gamma):
        return float(np.linalg.norm(rest) / size)
    gamma = dense.gamma / dense.row_scale
    gap = np.linalg.norm(dense.scaled @ x - gamma) / (dense.kept[0] * np.linalg.norm(x) + np.linalg.norm(gamma) + 1.0)
    rest = rest - dense.scaled.T @ np.linalg.lstsq(dense.scaled.T, rest, rcond=1e-9)[0]
    return float(max(gap, np.linalg.norm(rest) / size))


# --- a short run ----------------------------------------------------------------------------------


def judge(scene: Scene, path: Trajectory) -> Figures:
    """Judge a run by what it must keep; energy only where the samples resolve the work."""
    balance, drift = observables.energy_balance(scene, path), observables.momentum_drift(scene, path)
    energy = momentum = 0.0
    scale = max(1.0, np.abs(balance.energy).max(), np.abs(observables.kinetic_energy(scene, path)).max())
    if path.ok and balance.drift is not None and balance.resolution < 0.1 * CONSERVED * scale:
        energy = float(np.abs(balance.drift).max() / scale)
    if drift is not None:
        mass = np.array([body.mass for body in scene.bodies])
        momentum = float(drift.max() / max(1.0, (mass @ np.linalg.norm(path.velocity, axis=2).T).max()))
    residual, rate = observables.constraint_residual(scene, path), observables.constraint_rate(scene, path)
    compliance = max(np.abs(residual).max(initial=0.0), 0.1 * np.abs(rate).max(initial=0.0))
    return Figures(energy=energy, momentum=momentum, compliance=float(compliance))


def figures(scene: Scene, exact: bool = False) -> Figures:
    """Compare at the start and at the end of a short run, and judge the run."""
    system = compile_scene(scene)
    start = compare(system, Moment.start(scene), exact)
    path = simulate(scene, Settings(rtol=1e-10, t_end=DURATION, samples=41))
    if not path.ok:
        assert is_dead_end(scene, path), path.message
    return start.worse(judge(scene, path)).worse(compare(system, Moment.of(scene, path, -1), exact))


def is_dead_end(scene: Scene, path: Trajectory) -> bool:
    """Return whether a drive forced its loop to the end of its reach: it was said, and the oracle sees the rank go."""
    if len(path.times) == 1:  # it stopped before the first output: look closer
        path = simulate(scene, Settings(rtol=1e-10, t_end=CLOSE_LOOK, samples=401))
    first, last = (augmented(Moment.of(scene, path, k)).kept[-1] for k in (0, -1))
    said = path.status in (Status.SINGULAR, Status.PROJECTION) and "nearest to rank loss" in path.message
    return said and last < DEAD_END * first


def complaints(seed: int, found: Figures) -> list[str]:
    bounds = Figures(AGREEMENT, AGREEMENT, BACKWARD, CONSERVED, CONSERVED, COMPLIANT, np.inf, 1e6)
    return [
        f"seed {seed}: {name} {value:.3g} exceeds {bound:g}"
        for name, value, bound in zip(Figures._fields, found, bounds, strict=True)
        if not value <= bound
    ]


def survey(seeds: range, exact: bool = False) -> tuple[Figures, list[str]]:
    """Return the worst figures of many scenes, and a sentence for every one out of bounds."""
    worst, found = Figures(), []
    for seed in seeds:
        one = figures(random_scene(seed), exact)
        worst = worst.worse(one)
        found += complaints(seed, one)
    return worst, found


@pytest.mark.parametrize("first", range(0, QUICK, 10))
def test_a_few_agree_with_the_dense_oracle_and_keep_what_they_must(first):
    _, found = survey(range(first, first + 10))
    assert not found, "\n".join(found)


@pytest.mark.slow
def test_a_thousand_agree_with_the_dense_oracle_and_keep_what_they_must(capsys):
    worst, found = survey(range(MANY), exact=True)
    with capsys.disabled():
        print(f"\n{MANY} random scenes, worst:", ", ".join(f"{k} {v:.2g}" for k, v in worst._asdict().items()))
    assert not found, "\n".join(found)


@pytest.mark.skipif(not has_extended_precision(), reason="no extended precision here")
def test_the_exact_oracle_settles_who_errs():
    """Two scenes where the double-precision oracle is off by more than 1e-8 in the angular accelerations alone."""
    for seed in (89, 134):
        scene = random_scene(seed)
        moment, system = Moment.start(scene), compile_scene(scene)
        true, rough = exact_oracle.solve(moment).acceleration, augmented(moment).solve().acceleration
        system.set_mode_time(0.0)
        found = system.accelerations(0.0, state_of(system, moment))
        assert relative(found[:, 2:], true[:, 2:]) < 1e-9 < relative(rough[:, 2:], true[:, 2:])


scene_strategy = st.integers(0, 2**32 - 1).map(lambda seed: random_scene(seed, most=8))


@settings(max_examples=25, deadline=None)
@given(scene_strategy)
def test_any_reads_back_from_its_file_and_agrees(scene):
    assert loads(dumps(scene)) == scene
    found = compare(compile_scene(scene), Moment.start(scene))
    assert not complaints(0, found)


def test_a_seed_gives_the_same_scene():
    assert random_scene(5) == random_scene(5)
    assert random_scene(5) != random_scene(6)


def test_every_part_occurs():
    """The generator reaches all that a scene without contacts and planets may hold."""
    from typing import get_args

    from mbs_ref import scene as language
    from mbs_ref.celestial import CelestialLoad

    every = {part for union in (language.Body, language.Joint, language.Load) for part in get_args(get_args(union)[0])}
    every -= {language.UserForce, *get_args(CelestialLoad)}
    seen = {type(p) for k in range(80) for s in [random_scene(k, most=12)] for p in (*s.bodies, *s.joints, *s.loads)}
    assert seen == every
