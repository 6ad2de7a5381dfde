"""Contact as a constraint: touch-down by projection, lift-off where the multiplier would pull."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.of.seats import Flight, Shaker, flights
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators.loop.events import event_tables, settle
from mbs_ref.integrators.loop.leg import RUNNING, progress
from mbs_ref.kernels.answers import call_roots
from mbs_ref.kernels.contact.laws import VALUE
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, ConstraintLaw, RegularisedCoulomb
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

FINE = Settings(method="dop853", rtol=1e-12, estimate="off")
METHODS = {
    "dop853": (FINE, 1e-11),
    "rk4": (Settings(method="rk4", step=5e-4), 1e-8),
    "radau": (Settings(method="radau", rtol=1e-10), 1e-9),
    "lsodar": (Settings(method="lsodar", rtol=1e-11), 1e-9),
    "generalized_alpha": (Settings(method="generalized_alpha", step=2.5e-4), 3e-6),
    "dassl": (Settings(method="dassl", rtol=1e-9), 3e-6),
}


@pytest.mark.parametrize("name", METHODS)
def test_every_integrator_lifts_off_and_lands(name):
    settings, tolerance = METHODS[name]
    scene = scenes.make("ball_on_driven_seat")
    run = simulate(scene, settings.model_copy(update={"t_end": 0.3, "estimate": "off"}))
    truth = seek_truth(scene, run.times)
    assert run.ok, run.message
    assert isinstance(truth, Truth)
    assert np.abs(truth.position - run.position).max() < tolerance


@pytest.mark.parametrize("omega", [30.0, 33.0])
@pytest.mark.parametrize("rtol", [1e-5, pytest.param(1e-8, marks=pytest.mark.slow), 1e-11])
@pytest.mark.parametrize("method", ["lsodar", "dassl", "radau"])
def test_every_lift_off_and_landing_is_one_event(method, rtol, omega):
    scene = scenes.make("ball_on_driven_seat", omega=omega)
    flown = flights(Shaker(0.02, omega, 9.81), scene.duration)
    assert isinstance(flown, list)
    exact = [time for flight in flown for time in (flight.t0, flight.t1) if time < scene.duration]
    run = simulate(scene, Settings(method=method, rtol=rtol, estimate="off", reactions=False))
    assert run.ok, run.message
    assert run.event_times is not None
    np.testing.assert_allclose(run.event_times[:, 0], exact, rtol=0.0, atol=100.0 * rtol ** (2 / 3))


def test_a_closed_contacts_row_bears_its_own_name():
    system = compile_scene(scenes.make("ball_on_driven_seat"))
    y = system.initial_state()
    joints = system.row_joints()
    system.start_contacts(0.0, y, True)
    assert system.row_joints() == [*joints, "seat"]


def test_a_slope_asked_for_after_the_event_functions_is_that_of_its_own_time_state_and_modes():
    """The ball has the seat's acceleration, -A w^2 sin(w t), while it is held, and g once it is let go."""
    system = compile_scene(scenes.make("ball_on_driven_seat"))
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    _, table = event_tables(system.model)

    def held(t: float) -> float:
        return -0.02 * 30.0**2 * math.sin(30.0 * t)

    for t, state in itertools.product((0.01, 0.02), (y, y + np.array([0.0] * 7 + [1.0] + [0.0] * 4))):
        call_roots(system.model, system.work, 0.02, y, 0.0, table.new)
        slope = system.derivative(t, state)
        assert slope[1] == state[7]
        assert slope[7] == pytest.approx(held(t), rel=1e-12)
    call_roots(system.model, system.work, 0.04, y, 0.0, table.new)
    assert table.new[VALUE].min() < 0.0  # the seat falls faster than the ball
    assert settle(system.model, system.work, 0.04, y, table, progress(0.04), 9) == RUNNING
    assert system.derivative(0.04, y)[7] == pytest.approx(-9.81, rel=1e-12)


def test_lift_off_is_where_the_seat_falls_faster_than_the_ball():
    scene = scenes.make("ball_on_driven_seat")
    run = simulate(scene, FINE)
    assert run.event_times is not None
    first, landing = run.event_times[:2, 0]
    assert first == pytest.approx(math.asin(9.81 / (0.02 * 30.0**2)) / 30.0, abs=1e-13)
    found = flights(Shaker(0.02, 30.0, 9.81), 1.0)
    assert isinstance(found[0], Flight)  # type: ignore[index]
    assert landing == pytest.approx(found[0].t1, abs=1e-12)  # type: ignore[index]
    assert np.all(run.contacts["seat"][:, 2] >= 0.0)  # it never pulls
    assert run.contacts["seat"][:, 0].max() < 1e-12  # and never gives way


def test_a_seat_that_shakes_gently_keeps_its_ball():
    run = simulate(scenes.make("ball_on_driven_seat", amplitude=0.01), FINE)
    force = 9.81 - 0.01 * 30.0**2 * np.sin(30.0 * run.times)
    assert run.events == 0
    assert run.contacts["seat"][:, 2] == pytest.approx(force, abs=1e-9)


def test_a_stiff_force_tends_to_the_constraint():
    rigid = simulate(scenes.make("ball_on_driven_seat"), FINE).position[:, 0, 1]
    springs = {"law": "spring_damper", "stiffness": 1e5, "damping": 600.0}, {
        "law": "spring_damper", "stiffness": 1e7, "damping": 6000.0,
    }  # fmt: skip
    runs = [
        simulate(scenes.make("ball_on_driven_seat", **each), Settings(rtol=1e-9, estimate="off")) for each in springs
    ]
    gaps = [np.abs(run.position[:, 0, 1] - rigid).max() for run in runs]
    assert gaps[1] < 0.3 * gaps[0] < 1e-2


def _box(height: float, tilt: float) -> Scene:
    """A box above the ground, on two corners that are constraints once they touch."""
    c, s = math.cos(tilt), math.sin(tilt)
    corners = [(c * x + 0.1 * s, height + s * x - 0.1 * c) for x in (-0.2, 0.2)]
    return Scene(
        name="box", gravity=(0.0, -9.81),
        bodies=(PlanarBody(name="box", mass=2.0, inertia=0.03, position=(0.0, height), angle=tilt),),
        contacts=tuple(
            CircleOnLine(name=f"corner{k}", body_a="box", center=corner, radius=0.0, point_1=(0.0, 0.0),
                         point_2=(1.0, 0.0), law=ConstraintLaw())
            for k, corner in enumerate(corners)
        ),
    )  # fmt: skip


def test_a_tilted_box_falls_on_one_corner_then_on_both_and_rests():
    run = simulate(_box(0.2, 0.2), FINE.model_copy(update={"t_end": 2.0}))
    assert run.ok, run.message
    assert run.position[-1, 0, 1] == pytest.approx(0.1, abs=1e-11)
    assert run.orientation[-1, 0] == pytest.approx(0.0, abs=1e-11)
    forces = [run.contacts[f"corner{k}"][-1, 2] for k in range(2)]
    assert forces == pytest.approx([9.81, 9.81], abs=1e-9)


def test_a_plastic_impact_keeps_momentum_and_the_slower_ball_does_not_stick():
    """Ball 0 hits 1: both go on at half the speed, and separate only if something pulls them; 1 hits 2 likewise."""
    centers = [(0.0, 0.0), (0.3, 0.0), (0.6, 0.0)]
    row = Scene(
        name="row",
        bodies=tuple(PlanarBody(name=f"b{k}", mass=1.0, inertia=0.01, position=c, velocity=(float(k == 0), 0.0))
                     for k, c in enumerate(centers)),
        contacts=tuple(CircleOnCircle(name=f"p{k}", body_a=f"b{k}", center_a=centers[k], radius_a=0.1,
                                      body_b=f"b{k + 1}", center_b=centers[k + 1], radius_b=0.1, law=ConstraintLaw())
                       for k in range(2)),
    )  # fmt: skip
    run = simulate(row, FINE)
    assert run.ok, run.message
    assert run.velocity[-1, :, 0] == pytest.approx([1.0 / 3.0] * 3, abs=1e-12)


def _on_corners(places: np.ndarray, slopes: np.ndarray, velocity: tuple[float, float], turning: float) -> Scene:
    """A body about the origin that touches, at every one of its corners, a line of its own through that corner."""
    return Scene(
        name="corners",
        bodies=(PlanarBody(name="body", mass=2.0, inertia=0.3, position=(0.0, 0.0), velocity=velocity,
                           angular_velocity=turning),),
        contacts=tuple(
            CircleOnLine(name=f"corner{k}", body_a="body", center=(x, y), radius=0.0, point_1=(x, y),
                         point_2=(x + math.cos(slope), y + math.sin(slope)), law=ConstraintLaw())
            for k, ((x, y), slope) in enumerate(zip(places.tolist(), slopes.tolist(), strict=True))
        ),
    )  # fmt: skip


def _plastic_impact(places: np.ndarray, slopes: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return the velocity after, by trying all sets: no impulse of those in it, and no separation, is below 0."""
    normals = np.column_stack((-np.sin(slopes), np.cos(slopes)))
    rows = np.column_stack((normals, places[:, 0] * normals[:, 1] - places[:, 1] * normals[:, 0]))
    mobility = np.diag([1 / 2.0, 1 / 2.0, 1 / 0.3])
    for chosen in itertools.chain.from_iterable(itertools.combinations(range(len(rows)), n) for n in range(4)):
        j = rows[list(chosen)]
        impulses = np.linalg.lstsq(j @ mobility @ j.T, -j @ before, rcond=1e-12)[0]
        after = before + mobility @ j.T @ impulses
        if np.all(impulses >= 0.0) and np.all(rows @ after >= -1e-12):
            return after
    raise AssertionError("no set of contacts is complementary")


@pytest.mark.parametrize("seed", range(12))
def test_an_impact_on_many_corners_solves_their_complementarity(seed):
    """Opening what pulls, one after the other and for good, leaves corners that go through their surface."""
    rng = np.random.default_rng(seed)
    places, slopes = rng.uniform(-1.0, 1.0, (6, 2)), rng.uniform(-1.2, 1.2, 6)
    before = np.array([rng.normal(0.0, 0.3), -1.0, rng.normal(0.0, 2.0)])
    scene = _on_corners(places, slopes, (before[0], before[1]), before[2])
    run = simulate(scene, Settings(method="dop853", rtol=1e-12, t_end=1e-9, samples=2, estimate="off"))
    assert run.ok, run.message
    after = np.append(run.velocity[-1, 0], run.angular_velocity[-1, 0])
    assert after == pytest.approx(_plastic_impact(places, slopes, before), abs=1e-6)  # in 1e-9 s it turns a little


def test_more_contacts_than_a_body_can_lean_on_share_its_weight():
    """Five corners in a row on one line: forces are not unique, but none pulls and the box stays."""
    places = np.column_stack((np.linspace(-0.2, 0.2, 5), np.full(5, -0.1)))
    scene = _on_corners(places, np.zeros(5), (0.0, 0.0), 0.0).model_copy(update={"gravity": (0.0, -9.81)})
    run = simulate(scene, FINE.model_copy(update={"t_end": 1.0}))
    assert run.ok, run.message
    forces = np.array([run.contacts[f"corner{k}"][:, 2] for k in range(5)])
    assert forces.min() >= -1e-12
    assert forces.sum(axis=0) == pytest.approx(2.0 * 9.81, abs=1e-10)
    assert np.abs(run.position[:, 0]).max() < 1e-12


def test_a_vehicle_on_constraints_does_not_rock_in_its_last_digits():
    """Impacts of 1e-13 m once followed each other by the thousand: who lands lifts another by as much."""
    scene = scenes.make("tracked_vehicle", model="paper", law="constraint")
    run = simulate(scene, Settings(method="rk4", step=1e-4, t_end=2e-3, samples=3, estimate="off", reactions=False))
    assert run.ok, run.message
    assert run.event_times is not None
    held = [k for k, part in enumerate(scene.contacts) if part.law.HOLDS]
    assert np.isin(run.event_times[:, 1], held).sum() < 40


def test_constraints_refuse_what_they_do_not_mean():
    line = {"name": "floor", "body_a": "ball", "center": (0.0, 1.0), "radius": 1.0, "point_1": (0.0, 0.0),
            "point_2": (1.0, 0.0), "law": ConstraintLaw()}  # fmt: skip
    with pytest.raises(ValueError, match="friction"):
        CircleOnLine(**line, friction=RegularisedCoulomb(coefficient=0.3))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="capped"):
        CircleOnLine(**line, extent="capped")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="impacts and sticking are events"):
        simulate(scenes.make("ball_on_driven_seat"), Settings(method="rk4", step=1e-3, events="none", estimate="off"))
