"""Random mechanisms: the O(N) solver against the dense oracle, and short runs against the laws of mechanics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cross_checks.truths.oracle import Augmented, Moment, Solution, augmented
from cross_checks.truths.oracle.random_scenes import DURATION, random_scene
from mbs_ref import observables
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.toml import dumps, loads
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory
from tests.mbs_ref.cores import exact_oracle
from tests.mbs_ref.cores.dead_end import is_dead_end
from tests.mbs_ref.cores.exact_oracle import has_extended_precision

AGREEMENT = 1e-9  # relative, of accelerations and reactions, where the condition of C_q is below 1e6
DOUBTFUL = 1e-11  # relative: a larger difference may be the double-precision oracle's own error
EPS = float(np.finfo(float).eps)
BACKWARD = 1e-12  # relative: the equations themselves, whatever the condition
CONSERVED = 1e-7  # of the largest energy or momentum, over 0.1 s at rtol = 1e-10
COMPLIANT = 1e-10  # m, rad; ten times that for their rates
QUICK, MANY = 20, 1000
ENERGIES = 0.5  # share of the scenes, at least, whose energy the samples resolve
DEAR = (24, 421, 802, 847)  # end where a loop is at its reach, which takes 20 s to confirm: slow tests alone
FLOATING = (86, 87, 92, 111, 172, 184, 203, 241)  # nothing is tied to ground: their momentum is judged


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
    """Return the largest difference over the largest value."""
    return float(np.abs(found - true).max()) / _largest(true) if true.size else 0.0


def _largest(values: np.ndarray) -> float:
    """Return the largest value; nothing at all may happen, and then 1e-3 stands for it."""
    return max(float(np.abs(values).max()), 1e-3)


def _free(dense: Augmented) -> np.ndarray:
    """Return what the forces would do to free bodies.

    It is the scale of a mechanism without freedom that hardly moves: its accelerations are what is left of forces that
    cancel, each of which a solver knows to eps of itself. One that drives move fast is measured against its own.
    """
    return np.linalg.solve(dense.mass, dense.force)


def compare(system: System, moment: Moment, exact: bool = False) -> Figures:
    """Compare the solver with the oracle at one moment: the plain relative difference of all accelerations together.

    Lengths are near 1 m, so that m/s^2 and rad/s^2 compare. Where the oracle in double precision, which differences,
    cannot tell (beyond DOUBTFUL), or with `exact`, the one in extended precision does.
    """
    dense = augmented(moment)
    true = dense.solve()
    system.set_mode_time(moment.time)
    found = system.accelerations(moment.time, state_of(system, moment))
    over = system.reactions_over(np.array([moment.time]), state_of(system, moment)[None]) if not true.redundant else {}
    forces = {name: values[0] for name, values in over.items()}
    if has_extended_precision() and (exact or max(_gaps(found, forces, true)) > DOUBTFUL):
        true, dense = exact_oracle.solve(moment)
    acceleration, reaction = _gaps(found, forces, true)
    if moment.used.sum() == len(dense.kept):
        acceleration *= _largest(true.acceleration) / max(_largest(true.acceleration), _largest(_free(dense)))
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
    """Return what is left of C_q a = gamma, and of M a + C_q^T lambda = Q with the best lambda, in the mass norm.

    Each is relative to matrix times solution plus right-hand side: the smallest relative change of the data that makes
    the answer exact (Rigal and Gaches 1967; Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., theorem
    7.1). Near a singular pose lambda is large, and roundoff in C_q moves C_q^T lambda by eps of that. A mechanism
    without freedom hardly moves: what is left of its rows is eps of the forces that cancel (`_free`).
    """
    x = dense.root.T @ acceleration
    force = np.linalg.solve(dense.root, dense.force)
    size = np.linalg.norm(x) + np.linalg.norm(force) + 1.0  # N / sqrt(kg): nothing may happen at all
    if not len(dense.gamma):
        return float(np.linalg.norm(x - force) / size)
    gamma, largest = dense.gamma / dense.row_scale, dense.kept[0]
    moving = np.linalg.norm(x) + (np.linalg.norm(force) if len(x) == len(dense.kept) else 0.0)
    gap = np.linalg.norm(dense.scaled @ x - gamma) / (largest * moving + np.linalg.norm(gamma) + 1.0)
    lam = np.linalg.lstsq(dense.scaled.T, force - x, rcond=1e-9)[0]
    rest = np.linalg.norm(x + dense.scaled.T @ lam - force) / (size + largest * np.linalg.norm(lam))
    return float(max(gap, rest))


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


def short_run(scene: Scene) -> Trajectory:
    return simulate(scene, Settings(rtol=1e-10, t_end=DURATION, samples=41, estimate="off"))


def figures(scene: Scene, exact: bool = False) -> Figures:
    """Compare at the start and at the end of a short run, and judge the run."""
    system = compile_scene(scene)
    start = compare(system, Moment.start(scene), exact)
    path = short_run(scene)
    if not path.ok:
        assert is_dead_end(scene, path), path.message
    return start.worse(judge(scene, path)).worse(compare(system, Moment.of(scene, path, -1), exact))


def complaints(seed: int, found: Figures) -> list[str]:
    bounds = Figures(AGREEMENT, AGREEMENT, BACKWARD, CONSERVED, CONSERVED, COMPLIANT, np.inf, 1e6)
    return [
        f"seed {seed}: {name} {value:.3g} exceeds {bound:g}"
        for name, value, bound in zip(Figures._fields, found, bounds, strict=True)
        if not value <= bound
    ]


def survey(seeds: Sequence[int], exact: bool = False) -> tuple[Figures, list[str]]:
    """Return the worst figures of many scenes, and a sentence for every one out of bounds."""
    worst, found, energies = Figures(), [], 0
    for seed in seeds:
        one = figures(random_scene(seed), exact)
        worst, energies = worst.worse(one), energies + (one.energy > 0.0)
        found += complaints(seed, one)
    if energies < ENERGIES * len(seeds):
        found.append(f"the energy of {energies} of {len(seeds)} scenes is judged")
    return worst, found


@pytest.mark.parametrize("first", range(0, QUICK, 10))
def test_a_few_agree_with_the_dense_oracle_and_keep_what_they_must(first):
    _, found = survey([seed for seed in range(first, first + 10) if seed not in DEAR])
    assert not found, "\n".join(found)


@pytest.mark.parametrize("seed", FLOATING)
def test_what_floats_keeps_its_momentum(seed):
    scene = random_scene(seed)
    path = simulate(scene, Settings(rtol=1e-10, t_end=DURATION, samples=3, estimate="off"))
    drift = observables.momentum_drift(scene, path)
    assert drift is not None
    assert judge(scene, path).momentum < 1e-11
    thrown = replace(path, velocity=path.velocity + np.linspace(0.0, 1e-4, 3)[:, None, None])
    assert judge(scene, thrown).momentum > CONSERVED


@pytest.mark.slow
def test_a_thousand_agree_with_the_dense_oracle_and_keep_what_they_must(capsys):
    worst, found = survey(range(MANY), exact=True)
    with capsys.disabled():
        print(f"\n{MANY} random scenes, worst:", ", ".join(f"{k} {v:.2g}" for k, v in worst._asdict().items()))
    assert not found, "\n".join(found)


@pytest.mark.parametrize("seed", [627, 930, *(pytest.param(s, marks=pytest.mark.slow) for s in (314, 917, *DEAR))])
def test_a_loop_driven_to_the_end_of_its_reach_ends_the_run(seed):
    path = short_run(random_scene(seed))
    assert is_dead_end(random_scene(seed), path), path.message


@pytest.mark.parametrize("seed", [7, 726])
def test_a_stop_where_the_motion_goes_on_is_no_dead_end(seed):
    scene = random_scene(seed)
    words = short_run(random_scene(917)).message.split("the constraint", 1)[1]
    for time in (0.02, 0.09):
        path = short_run(scene)
        assert path.ok
        stopped = replace(path, status=Status.SINGULAR, message=f"at t = {time} s the constraint{words}")
        assert not is_dead_end(scene, stopped)


def test_the_digits_that_closures_lose_are_won_back():
    """Three poses next to singular ones: the smallest relative pivot is 4e-5, 2e-7 and 5e-7."""
    for seed, sample in ((644, 0), (644, -1), (314, -1)):
        scene = random_scene(seed)
        moment = Moment.of(scene, short_run(scene), sample)
        found = compare(compile_scene(scene), moment, exact=True)
        assert max(found.acceleration, found.reaction) < 20.0 * EPS * found.condition


class Off:
    """A solver that is wrong in one acceleration, by an error relative to the largest."""

    def __init__(self, system: System, place: int, error: float) -> None:
        self.system, self.place, self.error = system, place, error

    def __getattr__(self, name: str) -> Any:
        return getattr(self.system, name)

    def accelerations(self, t: float, y: np.ndarray) -> np.ndarray:
        found = self.system.accelerations(t, y)
        found.ravel()[self.place] += self.error * max(1.0, float(np.abs(found).max()))
        return found


@pytest.mark.parametrize("seed", [3, 42, 89, 314, 463, 644, 726])
def test_a_solver_that_is_slightly_wrong_is_caught(seed):
    """644 is locked, near a singular pose and at rest: there a wrong share of the forces shows as well."""
    scene = random_scene(seed)
    moment = Moment.start(scene)
    wrong: Any = Off(compile_scene(scene), int(np.flatnonzero(moment.used)[-1]), 1e-7)
    found = compare(wrong, moment, exact=True)
    assert found.acceleration > AGREEMENT
    assert found.backward > BACKWARD


@pytest.mark.skipif(not has_extended_precision(), reason="no extended precision here")
def test_the_exact_oracle_settles_who_errs():
    """Two scenes where the double-precision oracle is off by more than 1e-8 in the angular accelerations alone."""
    for seed in (89, 134):
        scene = random_scene(seed)
        moment, system = Moment.start(scene), compile_scene(scene)
        true, rough = exact_oracle.solve(moment)[0].acceleration, augmented(moment).solve().acceleration
        system.set_mode_time(0.0)
        found = system.accelerations(0.0, state_of(system, moment))
        assert relative(found[:, 2:], true[:, 2:]) < 1e-9 < relative(rough[:, 2:], true[:, 2:])


scene_strategy = st.integers(0, 2**32 - 1).map(lambda seed: random_scene(seed, most=8))


@settings(max_examples=25, deadline=None)
@given(scene_strategy)
@example(random_scene(52888830, most=8))  # locked at rest, under forces of 4 kN: roundoff leaves 1e-12 m/s^2
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
    from mbs_ref.scene.celestial import CelestialLoad
    from mbs_ref.scene.contact import Granules

    every = {part for union in (language.Body, language.Joint, language.Load) for part in get_args(get_args(union)[0])}
    # the user's own, and rolling without slipping, which is no C(q), have tests of theirs; granules
    # are loads by which bodies touch
    every -= {language.UserForce, language.UserConstraint, language.RollingWheel, Granules, *get_args(CelestialLoad)}
    seen = {type(p) for k in range(60) for s in [random_scene(k, most=12)] for p in (*s.bodies, *s.joints, *s.loads)}
    assert seen == every
