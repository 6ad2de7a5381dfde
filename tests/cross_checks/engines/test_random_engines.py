"""Random scenes on other engines: what an engine can do, it does as the reference solver does."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines as registry
from cross_checks.judge.one_run import checked_run
from cross_checks.mechanisms.random_scenes import DURATION, random_scene
from cross_checks.workshop.planar_tree import joint_tree
from cross_checks.workshop.spatial_tree import spatial_tree
from mbs_ref.scene import PlanarBody, Scene, TorsionSpring, Weld
from mbs_ref.scene.euler_parameters import geodesic_angle
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

MOST_BODIES = 8
TIMES = np.linspace(0.0, DURATION, 11)
CLOSE = {  # engine -> settings, and how near (m or rad) its method comes to the motion in 0.1 s
    "pinocchio": (Settings(method="dop853", rtol=1e-11, atol=1e-11), 1e-8),
    "mujoco": (Settings(method="rk4", step=1e-4), 1e-8),
    "exudyn": (Settings(method="generalized_alpha", step=1e-4), 1e-6),
}
SOFT_LOOPS = frozenset({"mujoco"})  # a joint outside of the tree is a soft constraint there: another limit
FINER = 64  # where springs are stiff or a load jumps within a step, so much finer ones have to come as near


def comparable(name: str, scene: Scene) -> bool:
    """Return whether the engine takes the scene and promises its motion."""
    engine = registry.get(name)
    refused = engine.refusals(scene) or engine.method_refusals(scene, engine.method(CLOSE[name][0].method))
    return not refused and not (name in SOFT_LOOPS and _closes_loops(scene))


def _closes_loops(scene: Scene) -> bool:
    tree = joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)
    return bool(tree.closures)


def apart(name: str, scene: Scene, finer: int = 1) -> float:
    """Return the largest distance of the engine's poses from the reference solver's, m or rad."""
    ours = simulate(scene, Settings(rtol=1e-12, atol=1e-12, reactions=False), TIMES)
    if not ours.ok:  # a drive beyond its reach: stopped with a reason, as test_random_scenes.py shows
        return 0.0
    settings = CLOSE[name][0]
    if settings.step is not None:
        settings = settings.model_copy(update={"step": settings.step / finer})
    theirs = checked_run(registry.get(name), scene, settings, TIMES)
    assert isinstance(theirs, Trajectory), theirs
    assert theirs.ok, theirs.message
    gap = float(np.abs(ours.position - theirs.position).max())
    turn = ours.orientation - theirs.orientation if scene.dimension == 2 else geodesic_angle(
        ours.orientation, theirs.orientation
    )  # fmt: skip
    return max(gap, float(np.abs(turn).max()))


def survey(name: str, seeds: range) -> tuple[int, float, list[str]]:
    """Return how many scenes were compared, the worst distance, and a sentence for each that stays out of bounds."""
    pytest.importorskip(name)
    count, worst, found = 0, 0.0, []
    for seed in seeds:
        scene = random_scene(seed, most=MOST_BODIES)
        if not comparable(name, scene):
            continue
        gap = apart(name, scene)
        count, worst = count + 1, max(worst, gap)
        if not gap <= CLOSE[name][1] and not apart(name, scene, FINER) <= CLOSE[name][1]:
            found.append(f"seed {seed}: {name} is {gap:.3g} m or rad away, and no finer step helps")
    return count, worst, found


@pytest.mark.parametrize(("name", "least"), [("pinocchio", 5), ("mujoco", 3), ("exudyn", 8)])
def test_a_few_move_alike(name, least):
    count, _, found = survey(name, range(30))
    assert not found, "\n".join(found)
    assert count >= least


@pytest.mark.parametrize("name", list(CLOSE))
def test_a_spring_between_welded_bodies_moves_nothing(name):
    pytest.importorskip(name)
    bodies = tuple(PlanarBody(name=n, mass=1.0, inertia=0.1, position=(x, 0.0)) for n, x in (("a", 0.0), ("b", 1.0)))
    weld = Weld(name="weld", body_a="a", body_b="b", point=(0.5, 0.0))
    spring = TorsionSpring(name="spring", body_a="a", body_b="b", stiffness=1e3, rest_angle=1.0)
    scene = Scene(name="stiffened", gravity=(0.0, -1.0), bodies=bodies, joints=(weld,), loads=(spring,))
    assert comparable(name, scene)
    assert apart(name, scene) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", list(CLOSE))
def test_hundreds_move_alike(name, capsys):
    count, worst, found = survey(name, range(600))
    with capsys.disabled():
        print(f"\n{name}: {count} of 600 random scenes compared, worst {worst:.2g} m or rad")
    assert not found, "\n".join(found)
    assert count > 50
