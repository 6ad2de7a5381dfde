"""Random scenes on other engines: what an engine can do, it does as the reference solver does."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pytest

from cross_checks import engines as registry
from cross_checks.judge.one_run import checked_run
from cross_checks.linkage.links import linkage_of
from cross_checks.truths.oracle.random_scenes import DURATION, random_scene
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import PlanarBody, Scene, TorsionSpring, Weld
from mbs_ref.scene.traits import traits
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
FINER = (16, 64)  # where springs are stiff or a load jumps within a step, one of so much finer ones has to come as near


def comparable(name: str, scene: Scene) -> bool:
    """Return whether the engine takes the scene and promises its motion."""
    engine = registry.get(name)
    refused = engine.refusals(scene) or engine.method_refusals(scene, engine.method(CLOSE[name][0].method))
    return not refused and not (name in SOFT_LOOPS and linkage_of(scene).closures)


def apart(name: str, scene: Scene, finer: int = 1) -> float | None:
    """Return the largest distance of the engine's poses from the reference solver's, m or rad.

    None where the reference stops at a drive beyond its reach, as test_random_scenes.py shows.
    """
    ours = simulate(scene, Settings(rtol=1e-12, atol=1e-12, reactions=False, estimate="off"), TIMES)
    if not ours.ok:
        return None
    settings = CLOSE[name][0]
    if settings.step is not None:
        settings = settings.model_copy(update={"step": settings.step / finer})
    theirs = checked_run(registry.get(name), scene, settings, TIMES)
    assert isinstance(theirs, Trajectory), theirs
    assert theirs.ok, theirs.message
    return float(np.nanmax(farthest(scene, ours, theirs)[:2]))


class Survey(NamedTuple):
    """What came of many scenes."""

    compared: int
    loaded: int  # those compared that have loads
    worst: float  # m or rad
    complaints: list[str]  # a sentence for each scene that stays out of bounds


def survey(name: str, seeds: Iterable[int]) -> Survey:
    """Compare an engine on every scene that it takes and that the reference finishes."""
    pytest.importorskip(name)
    bound, gaps, loaded, found = CLOSE[name][1], [], 0, []
    for seed in seeds:
        scene = random_scene(seed, most=MOST_BODIES)
        gap = apart(name, scene) if comparable(name, scene) else None
        if gap is None:
            continue
        gaps.append(gap)
        loaded += bool(scene.loads)
        if gap <= bound:
            continue
        for factor in FINER:
            finer = apart(name, scene, factor) or 0.0
            if finer <= bound:
                break
        first_order = "breakpoints" in traits(scene) and finer <= 4.0 * gap / FINER[-1]  # a load jumps within a step
        if not (finer <= bound or first_order):
            found.append(f"seed {seed}: {name} is {gap:.3g} m or rad away, and no finer step helps")
    return Survey(len(gaps), loaded, max(gaps, default=0.0), found)


LOADED = (61, 68, 131, 172, 262, 292)  # MuJoCo takes these, and their springs move something


@pytest.mark.parametrize(
    ("name", "seeds", "least", "loaded"),
    [
        ("pinocchio", range(30), 8, 3),
        ("mujoco", (*range(12), *LOADED), 8, 6),
        ("exudyn", range(14), 5, 2),
        pytest.param("exudyn", range(30), 13, 5, marks=pytest.mark.slow),
    ],
)
def test_a_few_move_alike(name, seeds, least, loaded):
    found = survey(name, seeds)
    assert not found.complaints, "\n".join(found.complaints)
    assert found.compared >= least
    assert found.loaded >= loaded


def test_a_load_left_out_is_seen(monkeypatch):
    """An engine that drops the loads moves another way, by far more than the bound."""
    mujoco = registry.get("mujoco") if "mujoco" in registry.names() else pytest.skip("no MuJoCo here")
    run = mujoco.run
    monkeypatch.setattr(
        mujoco, "run", lambda scene, *rest: run(scene.model_copy(update={"loads": (), "name": "bare"}), *rest)
    )
    monkeypatch.setattr(registry, "get", lambda name: mujoco)
    for seed in LOADED:
        assert (apart("mujoco", random_scene(seed, most=MOST_BODIES)) or 0.0) > 100.0 * CLOSE["mujoco"][1]


@pytest.mark.parametrize("name", list(CLOSE))
def test_a_spring_between_welded_bodies_moves_nothing(name):
    pytest.importorskip(name)
    bodies = tuple(PlanarBody(name=n, mass=1.0, inertia=0.1, position=(x, 0.0)) for n, x in (("a", 0.0), ("b", 1.0)))
    weld = Weld(name="weld", body_a="a", body_b="b", point=(0.5, 0.0))
    spring = TorsionSpring(name="spring", body_a="a", body_b="b", stiffness=1e3, rest_angle=1.0)
    scene = Scene(name="stiffened", gravity=(0.0, -1.0), bodies=bodies, joints=(weld,), loads=(spring,))
    assert comparable(name, scene)
    gap = apart(name, scene)
    assert gap is not None
    assert gap < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", list(CLOSE))
def test_hundreds_move_alike(name, capsys):
    found = survey(name, range(600))
    with capsys.disabled():
        print(f"\n{name}: {found.compared} of 600 random scenes compared, worst {found.worst:.2g} m or rad")
    assert not found.complaints, "\n".join(found.complaints)
    assert found.compared > 50
    assert found.loaded > 20
