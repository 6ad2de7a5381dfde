"""The sky's forces: the solver's kernels against those of the truths, and these against ERFA and first principles."""

from __future__ import annotations

import erfa
import numpy as np
import pytest

from cross_checks.truths.made_by.sky import directions
from cross_checks.truths.made_by.sky.particles import FIELDS, acceleration, start
from cross_checks.truths.made_by.sky.satellites import visible_share
from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import (
    CelestialLoad,
    Drag,
    Epoch,
    GravityGradient,
    LunarFigure,
    Newton,
    Oblateness,
    RadiationPressure,
    Relativity,
    Ring,
    StandardDrag,
    ThirdBody,
    Tide,
)

ROUNDOFF = 1e-13  # relative to the force, of the kernels' double precision
LOOSER = {  # what doubles, or the kernels' data, leave of some forces
    "Sun": 1e-11,  # two pulls that are equal but for 1 in 20 000
    "Moon": 1e-12,  # and for 1 in 50
    "standard drag": 1e-12,  # an altitude that is a thousandth of the distance
}
SPOT = np.longdouble(3e6)  # s after the epoch
GM = (2.0e14, 0.5e14, 0.3e14)  # m^3/s^2
SIZE = 7e6  # m
AXIS = (0.48, 0.6, 0.64)
STRONG = {  # each so strong, and so askew, that no part of it is below the roundoff of the others
    "newton": Newton(name="x", gm=GM),
    "relativity of all": Relativity(name="x", c=2e4),
    "relativity of the first": Relativity(name="x", form="central", c=2e4),
    "J2": Oblateness(name="x", body="b", radius=6e6, zonal=(0.1,), axis=AXIS),
    "J2 to J6": Oblateness(name="x", body="b", radius=6e6, zonal=(0.1, -0.2, 0.3, 0.2, -0.1), axis=AXIS),
    "the Earth's pole": Oblateness(name="x", body="b", radius=6e6, zonal=(0.1, 0.2), pole="earth_iau2006"),
    "figure": LunarFigure(name="x", body="b", radius=6e6, j2=0.1, c22=0.2),
    "tide": Tide(name="x", body="c", raiser="b", radius=6e6, love_number=30.0, lag=600.0, spin=(1e-3, 2e-3, -1e-3)),
    "ring": Ring(name="x", gm=1e14, radius=3e7, normal=AXIS, count=5),
    "Sun": ThirdBody(name="x", body="b", source="sun", gm=1e27),
    "Moon": ThirdBody(name="x", body="b", source="moon", gm=1e21),
    "drag": Drag(
        name="x", body="b", planet="c", coefficient=0.02, density=1e-3, altitude=5e5, scale_height=3e6, radius=6e6,
        spin=3e-4,
    ),
    "standard drag": StandardDrag(name="x", body="b", planet="c", coefficient=1e-6, radius=1.4072e7, spin=3e-4),
    "light": RadiationPressure(name="x", body="b", planet="c", coefficient=1e6, radius=1e5),
}  # fmt: skip
TRIO = (
    PointMass(name="a", mass=1.0, position=(0.0, 0.0, 0.0), velocity=(100.0, -700.0, 300.0)),
    PointMass(name="b", mass=1.0, position=(0.9 * SIZE, 0.7 * SIZE, -0.4 * SIZE), velocity=(-2000.0, 4000.0, 3000.0)),
    PointMass(name="c", mass=1.0, position=(-0.6 * SIZE, 1.3 * SIZE, 0.8 * SIZE), velocity=(1000.0, 500.0, -4000.0)),
)


def trio(load: CelestialLoad | None, bodies: tuple[PointMass, ...] = TRIO) -> Scene:
    loads = (Epoch(jd_tdb=2_455_555.25), *(() if load is None else (load,)))
    if not isinstance(load, Newton):
        loads += (Newton(name="newton", gm=GM[: len(bodies)]),)
    return Scene(name="trio", gravity=(0.0, 0.0, 0.0), bodies=bodies, loads=loads)


def of_the_solver(scene: Scene) -> np.ndarray:
    system = compile_scene(scene)
    y = system.initial_state()
    return system.derivative(float(SPOT), y)[len(y) // 2 :].reshape(-1, 3)


def of_the_truth(scene: Scene) -> np.ndarray:
    place, rate = start(scene)
    return acceleration(scene)(np.array([SPOT]), place[None], rate[None])[0]


def test_every_part_of_the_sky_is_written_twice():
    of_rigid_bodies = GravityGradient  # no particle feels it: test_gravity_gradient.py sums over point masses
    assert {*FIELDS, Epoch, of_rigid_bodies} == set(CelestialLoad.__args__)
    assert {type(load) for load in STRONG.values()} == set(FIELDS)


@pytest.mark.parametrize("name", STRONG)
def test_the_solver_and_the_truth_know_the_same_force(name):
    scene = trio(STRONG[name])
    solver, truth = of_the_solver(scene), of_the_truth(scene)
    without = 0.0 if name == "newton" else of_the_truth(trio(None))
    share = np.linalg.norm(truth - without) / np.linalg.norm(truth)
    assert share > 1e-2, "too weak to be told from the rest"
    allowed = LOOSER.get(name, ROUNDOFF)
    assert np.linalg.norm(solver - truth) < allowed * np.linalg.norm(truth) / min(1.0, share)


def test_a_probe_without_gm_feels_the_moons_figure():
    probe = trio(STRONG["figure"])
    newton = Newton(name="newton", gm=(0.0, GM[1], 0.0))
    probe = probe.model_copy(update={"loads": (*probe.loads[:-1], newton)})
    assert of_the_solver(probe) == pytest.approx(of_the_truth(probe).astype(float), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("place", np.linspace(-1.2, 1.2, 5))
def test_the_visible_share_is_counted_point_by_point(place):
    """A satellite 7000 km behind the Earth's edge, the Sun's disc cut into a million points."""
    radius, high, far = 6.4e6, 7e6, 1.5e11
    edge, disc = np.arcsin(radius / high), 6.957e8 / far
    angle = np.pi - edge - place * disc  # of the satellite from the Sun, as the Earth sees it
    r = np.array([[high * np.cos(angle), high * np.sin(angle), 0.0]], dtype=np.longdouble)
    away = r - np.array([far, 0.0, 0.0])
    found = float(visible_share(r, away, np.longdouble(radius))[0, 0])
    sun, earth = -away[0] / np.linalg.norm(away[0].astype(float)), -r[0] / high
    across = np.array([sun[1], -sun[0], 0.0])
    grid = (np.arange(1000) + 0.5) / 500 - 1
    u, w = np.meshgrid(grid, grid)
    inside = u**2 + w**2 < 1
    size = np.arcsin(6.957e8 / np.linalg.norm(away[0].astype(float)))
    point = [sun[k] + size * (u[inside] * across[k] + w[inside] * (k == 2)) for k in range(3)]
    towards = sum(p * e for p, e in zip(point, earth, strict=True)) / np.sqrt(sum(p * p for p in point))
    assert found == pytest.approx(float(np.mean(towards < np.cos(edge))), abs=2e-3)


@pytest.mark.parametrize("day", [-9000.0, 0.0, 3700.5, 9125.0])
def test_the_series_of_sun_moon_and_pole_against_erfa(day):
    """Montenbruck and Gill claim some 0.1 % for Sun and Moon; the pole lacks nutation of 2 seconds of arc."""
    d = np.array([day], dtype=np.longdouble)
    of_date = erfa.pnm06a(2_451_545.0, day)
    moon = erfa.moon98(2_451_545.0, day)["p"] * 149_597_870_700.0
    sun = -np.asarray(erfa.epv00(2_451_545.0, day)[0]["p"]) * 149_597_870_700.0
    for found, wanted in ((directions.moon_place(d)[0], moon), (directions.sun_place(d)[0], sun)):
        assert np.linalg.norm((found - wanted).astype(float)) < 2e-3 * np.linalg.norm(wanted)
    two_seconds = 1e-5  # rad
    assert directions.earth_pole(d)[0].astype(float) == pytest.approx(of_date[2], abs=two_seconds)


@pytest.mark.parametrize("day", [-9000.0, 0.0, 3700.5, 9125.0])
def test_the_moon_turns_its_x_axis_to_the_earth(day):
    libration = np.radians(9.0)  # the largest, optical
    d = np.array([day], dtype=np.longdouble)
    axes, place = directions.moon_axes(d)[0], directions.moon_place(d)[0]
    assert (axes @ axes.T).astype(float) == pytest.approx(np.eye(3), abs=1e-17)
    assert float(-place @ axes[0]) > np.cos(libration) * np.linalg.norm(place.astype(float))


def lagrangian(gm: np.ndarray, c2: float, x: np.ndarray, v: np.ndarray) -> np.longdouble:
    """Return c^2 times the post-Newtonian terms of the Lagrangian (Landau and Lifshitz, Fields, eq 106.17), per G."""
    total = np.longdouble(0)
    for i in range(len(gm)):
        total += gm[i] * (v[i] @ v[i]) ** 2 / 8
        for j in range(len(gm)):
            if j == i:
                continue
            r = np.sqrt((x[j] - x[i]) @ (x[j] - x[i]))
            n = (x[i] - x[j]) / r
            total += 1.5 * gm[i] * gm[j] / r * (v[i] @ v[i])
            total -= gm[i] * gm[j] / (4 * r) * (7 * (v[i] @ v[j]) + (v[i] @ n) * (v[j] @ n))
            for k in range(len(gm)):
                if k != i:
                    total -= gm[i] * gm[j] * gm[k] / (2 * r * np.sqrt((x[k] - x[i]) @ (x[k] - x[i])))
    return total


def test_relativity_of_all_follows_from_the_lagrangian():
    """m a = dL1/dx - d/dt dL1/dv with Newton's accelerations put in, by differences in extended precision."""
    gm = np.array([2.0, 0.5, 0.3], dtype=np.longdouble)
    x = np.array([[0, 0, 0], [0.9, 0.7, -0.4], [-0.6, 1.3, 0.8]], dtype=np.longdouble)
    v = np.array([[0.1, -0.7, 0.3], [-0.5, 0.8, 0.6], [0.2, 0.1, -0.9]], dtype=np.longdouble)
    bodies = tuple(PointMass(name=n, mass=1.0, position=p, velocity=w) for n, p, w in zip("abc", x, v, strict=True))
    newton = Newton(name="n", gm=tuple(gm.astype(float)))
    alone = Scene(name="alone", gravity=(0.0, 0.0, 0.0), bodies=bodies, loads=(newton,))
    both = alone.model_copy(update={"loads": (newton, Relativity(name="r", c=10.0))})
    gm = np.array(newton.gm, dtype=np.longdouble)
    x, v = start(alone)
    a = of_the_truth(alone)
    h = np.longdouble(1e-4)

    def slope(function, y):
        """Return the gradient by y (3, 3), to fourth order."""
        found = np.zeros_like(y)
        for index in np.ndindex(y.shape):
            for step, weight in ((1, 8), (2, -1)):
                moved = np.zeros_like(y)
                moved[index] = step * h
                found[index] += weight * (function(y + moved) - function(y - moved)) / (12 * h)
        return found

    def momentum(time):
        place, rate = x + time * v + time**2 / 2 * a, v + time * a
        return slope(lambda w: lagrangian(gm, 100.0, place, w), rate)

    force = slope(lambda p: lagrangian(gm, 100.0, p, v), x)
    for step, weight in ((1, 8), (2, -1)):
        force -= weight * (momentum(step * h) - momentum(-step * h)) / (12 * h)
    wanted = force / gm[:, None] / 100.0
    assert (of_the_truth(both) - a).astype(float) == pytest.approx(wanted.astype(float), rel=1e-8)


def test_a_lagging_tide_is_the_pull_of_two_bulges():
    """Two masses on the body make the bulge that the raiser raised one lag before; by plain Newton's attraction."""
    load = STRONG["tide"].model_copy(update={"lag": 1.0})
    scene = trio(load)
    place, rate = start(scene)
    found = (of_the_truth(scene) - of_the_truth(trio(None)))[1]
    r, v = place[1] - place[2], rate[1] - rate[2]
    distance = np.sqrt(r @ r)
    earlier = r - load.lag * (v - np.cross(np.array(load.spin, dtype=np.longdouble), r))
    axis = earlier / np.sqrt(earlier @ earlier)
    # the bulge's quadrupole k2 m R^5 / r*^3 as masses on its axis, the same mass taken from the centre
    arm = np.longdouble(1e-4) * distance
    bulge = load.love_number * GM[1] * load.radius**5 / np.sqrt(earlier @ earlier) ** 3 / (2 * arm**2)
    wanted = 2 * bulge * r / distance**3
    for sign in (1, -1):
        apart = r - sign * arm * axis
        wanted = wanted - bulge * apart / np.sqrt(apart @ apart) ** 3
    late = (of_the_truth(scene) - of_the_truth(trio(load.model_copy(update={"lag": 0.0}))))[1]
    off = np.linalg.norm((found - wanted).astype(float))
    assert off < 1e-2 * np.linalg.norm(late.astype(float))  # of second order in the lag
