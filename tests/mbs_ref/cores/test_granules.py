"""Granules: a neighbour search finds what brute force finds, and forces are those of a part for every pair."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cross_checks.conformance.symmetry.placement import Placement, obstacle
from mbs_ref import Scene, observables, scenes
from mbs_ref.cores import contact_shapes as arrays
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.contact import neighbours
from mbs_ref.scene import PlanarBody, SpatialBody, toml
from mbs_ref.scene.contact import Granules, ProgressiveLaw, RegularisedCoulomb
from mbs_ref.scene.traits import part_types, traits
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.film.drawing import drawing


def _spheres(place: np.ndarray, radius: np.ndarray, skin: float, room: int = 40) -> neighbours.Granules:
    n, dimension = place.shape
    lengths = {"n": n, "n + 1": n + 1, "dimension": dimension, "most": room * n, "buckets": 64}
    built, skins = np.full_like(place, np.nan), np.array([skin])
    return empty(neighbours.Granules, **lengths)._replace(place=place.copy(), reach=radius, skin=skins, built=built)


def _listed(grains: neighbours.Granules) -> list[tuple[int, int]]:
    return [(i, int(j)) for i, (p, q) in enumerate(zip(grains.first, grains.first[1:], strict=False))
            for j in grains.near[p:q]]  # fmt: skip


def _within(place: np.ndarray, radius: np.ndarray, skin: float) -> list[tuple[int, int]]:
    i, j = np.triu_indices(len(place), 1)
    near = np.linalg.norm(place[i] - place[j], axis=1) <= radius[i] + radius[j] + skin
    return list(zip(i[near].tolist(), j[near].tolist(), strict=True))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("far", [0.0, 1e4])  # m, from the origin; a grain far away from all others makes no grid larger
def test_neighbours_are_those_of_brute_force(dimension, far):
    random = np.random.default_rng(dimension)
    for _ in range(10):
        radius = random.uniform(0.02, 0.1, 150)
        place = random.uniform(-0.6, 0.6, (150, dimension)) + far
        place[0] += 1e6
        grains = _spheres(place, radius, 0.05)
        neighbours.refresh_neighbours(grains)
        assert grains.overflow[0] == 0
        assert _listed(grains) == _within(place, radius, 0.05)


def test_the_list_holds_until_a_sphere_has_moved_by_half_of_the_skin():
    random = np.random.default_rng(5)
    place, radius, skin = random.uniform(0.0, 1.0, (100, 2)), np.full(100, 0.04), 0.02
    grains, made = _spheres(place, radius, skin), 0
    velocity = random.standard_normal(place.shape)
    for step in range(60):
        grains.place[:] = place + 2e-3 * step * velocity
        before = grains.built.copy()
        neighbours.refresh_neighbours(grains)
        made += not np.array_equal(before, grains.built)
        touching = _within(grains.place, radius, 0.0)
        assert set(touching) <= set(_listed(grains))
    assert 5 < made < 50


def test_more_neighbours_than_there_is_room_for_are_reported():
    grains = _spheres(np.random.default_rng(1).uniform(0.0, 0.1, (50, 3)), np.full(50, 0.1), 0.01, room=2)
    neighbours.refresh_neighbours(grains)
    assert grains.overflow[0] == 1


ROUNDOFF = 1e-15  # of the largest acceleration, measured 3e-16: friction of both ways is rounded differently


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("space", [False, True])
def test_forces_are_those_of_a_part_for_every_pair(space, friction):
    given = {"grains": 25, "across": 3, "space": space, "friction": friction}
    pairs, group = (compile_scene(scenes.make("granular_column", search=search, **given)) for search in (False, True))
    start, n, random = pairs.initial_state(), pairs.n_positions, np.random.default_rng(1)
    pairs.start_contacts(0.0, start, False)
    for _ in range(20):
        y = start.copy()
        y[:n] += 0.02 * random.standard_normal(n)
        y[n:] += 0.5 * random.standard_normal(len(y) - n)
        expected = pairs.derivative(0.0, y)
        found = group.derivative(0.0, y)
        if not friction:
            assert np.array_equal(found, expected)
        assert np.abs(found - expected).max() <= ROUNDOFF * np.abs(expected).max()
    assert np.abs(expected).max() > 1e3  # they do touch


@pytest.mark.parametrize("space", [False, True])
def test_motion_is_that_of_a_part_for_every_pair(space):
    settings = Settings(method="rk4", step=2e-4, t_end=0.2, samples=6, events="none", estimate="off", reactions=False)
    given = {"grains": 20, "across": 3, "space": space}
    pairs, group = (simulate(scenes.make("granular_column", search=s, **given), settings) for s in (False, True))
    assert pairs.ok, pairs.message
    assert group.ok, group.message
    assert np.max(np.abs(group.position - pairs.position)) < 1e-9  # m, measured 0; impacts would multiply roundoff
    assert np.max(np.abs(pairs.position[-1] - pairs.position[0])) > 0.05


def test_all_pairs_are_looked_at_where_the_list_has_no_room(monkeypatch):
    scene = scenes.make("granular_column", grains=30, search=True)
    listed = compile_scene(scene)
    monkeypatch.setattr(arrays, "ROOM", {2: 1})
    full: Any = compile_scene(scene)
    y = listed.initial_state()
    y[: listed.n_positions] *= 0.5
    assert np.array_equal(full.derivative(0.0, y), listed.derivative(0.0, y))
    assert full.groups.granules.overflow[0] == 1


def _cloud(dimension: int, **more: Any) -> Scene:
    """Return spheres of many sizes that fly into each other, without walls."""
    random = np.random.default_rng(7)
    radius = random.uniform(0.03, 0.06, 30)
    cell = np.stack(np.unravel_index(np.arange(30), (6,) * dimension), axis=1)
    places = 0.15 * cell + random.uniform(-0.01, 0.01, (30, dimension))
    inertia: Any = (0.002,) * 3 + (0.0,) * 3 if dimension == 3 else 0.002
    kind = SpatialBody if dimension == 3 else PlanarBody
    bodies = tuple(
        kind(name=f"s{k}", mass=0.5 + 10.0 * radius[k], inertia=inertia, position=tuple(x), velocity=tuple(v))
        for k, (x, v) in enumerate(zip(places, -2.0 * (places - places.mean(axis=0)), strict=True))
    )
    law = ProgressiveLaw(stiffness=1e5, damping=2e4)
    group = Granules(name="cloud", radius=tuple(radius), law=law, **more)
    return Scene(name="cloud", duration=0.2, bodies=bodies, loads=(group,))


@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_is_conserved_and_the_energy_lost_is_the_work_of_the_contacts(dimension):
    scene = _cloud(dimension, friction=RegularisedCoulomb(coefficient=0.4, speed=0.01))
    path = simulate(scene, Settings(method="dop853", rtol=1e-9, samples=601, estimate="off", reactions=False))
    assert path.ok, path.message
    drift = observables.momentum_drift(scene, path)
    assert drift is not None
    assert np.max(drift) < 1e-12
    energy = observables.energy_balance(scene, path)
    assert energy.drift is not None
    assert energy.energy[-1] < 0.8 * energy.energy[0]
    assert np.max(np.abs(energy.drift)) < max(2.0 * energy.resolution, 1e-3 * energy.energy[0])


def test_granules_go_through_a_file_and_count_as_contact():
    scene = scenes.make("granular_column", search=True, friction=0.3)
    for one in (scene, _cloud(2)):
        assert toml.loads(toml.dumps(one)) == one
    assert {"contact", "friction"} <= traits(scene)
    assert {"granules", "progressive_law", "regularised_coulomb"} <= part_types(scene)


LAW = {"type": "progressive_law", "stiffness": 1e5}


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"radius": (0.0,)}, r"radius = \(0.0,\)"),
        ({"radius": (-0.1,)}, "radius.0"),
        ({"law": {"type": "flores_law", "stiffness": 1e5, "restitution": 0.5}}, "flores_law"),
        ({"law": {"type": "rigid_law", "restitution": 0.5}}, "rigid_law"),
    ],
)
def test_what_granules_cannot_have_is_named(given, named):
    with pytest.raises(ValueError, match=named):
        Granules.model_validate({"name": "grains", "radius": (0.1,), "law": LAW} | given)


def test_what_contradicts_the_scene_is_named():
    scene = scenes.make("granular_column", search=True)
    (part,) = scene.loads
    given = scene.model_dump() | {"parameters": {}}
    rubbing = part.model_copy(update={"friction": RegularisedCoulomb(coefficient=0.4, speed=0.01)})
    particles = [{"name": "p", "type": "point_mass", "mass": 1.0, "position": (0.0, 0.0), "velocity": (0.0, 0.0)}]
    for change, named in (
        ({"loads": (part.model_copy(update={"radius": (0.1, 0.1)}),)},
         r"loads\[0\] \(grains\): radius has 2 entries; allowed: 1, or 20, one a body"),
        ({"loads": (part, part.model_copy(update={"name": "others"}))}, "'grains', 'others' are all granules"),
        ({"bodies": particles, "loads": (rubbing,)}, "friction turns 'p', a point mass, and has no orientation"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=named):
            Scene.model_validate(given | change)
    with pytest.raises(ValueError, match="grains = 301: more than 300 need search = true"):
        scenes.make("granular_column", grains=301)


def test_steps_that_outputs_determine_are_not_doubled_across_kinks():
    scene = scenes.make("granular_column", grains=4, across=2, search=True)
    path = simulate(scene, Settings(method="dop853", rtol=1e-5, samples=2001, t_end=0.2, reactions=False))
    assert path.estimate is not None
    assert "twice the size" not in path.estimate.how


def test_grains_are_drawn_as_circles_and_have_no_image_elsewhere():
    scene = scenes.make("granular_column", grains=4, across=2, search=True)
    path = simulate(scene, Settings(samples=2, t_end=0.01, reactions=False, estimate="off"))
    picture = drawing(scene, path)
    assert [radius for _, radius in picture.circles] == [0.05] * 4
    assert np.array_equal(picture.circles[3][0], path.position[:, 3])
    assert not picture.labels
    floor, left, _ = (surface[-1] for surface in picture.surfaces)
    assert np.ptp(floor, axis=0)[1] == np.ptp(left, axis=0)[0] == 0.0  # level, upright
    assert np.all(np.abs(np.ptp(floor, axis=0)[0] - np.ptp(path.position[:, :, 0]) - 0.1) < 1e-12)
    assert "granules" in obstacle(scene, Placement(np.eye(2), np.ones(2)))
