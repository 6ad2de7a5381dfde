"""Bounces that end in rest: at the limit of their series, on one contact and on several, and what lifts off again."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.bodies import block_inertia
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, RigidLaw, SphereOnPlane
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

G = 9.81  # m/s^2
FINE = Settings(method="dop853", rtol=1e-12, estimate="off")
WIDTH, HEIGHT = 0.2, 0.8  # m, of a slender box


def _run(scene: Scene, t_end: float, **settings) -> Trajectory:
    run = simulate(scene, FINE.model_copy(update={"t_end": t_end, **settings}))
    assert run.ok, run.message
    return run


def _rest_time(run: Trajectory) -> float:
    assert run.event_times is not None
    return float(run.event_times[-1, 0])


@pytest.mark.parametrize(
    ("restitution", "name", "tolerance"),
    [(e, "bouncing_ball", 1e-10) for e in (0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95)]
    + [(e, "bouncing_sphere", 1e-9) for e in (0.001, 0.5, 0.95)],
)
def test_a_ball_rests_at_the_limit_of_its_bounces(restitution, name, tolerance):
    """sqrt(2 h/g) (1 + e)/(1 - e), the sum of the flights 2 e^n v/g."""
    limit = math.sqrt(2.0 * 0.1 / G) * (1.0 + restitution) / (1.0 - restitution)
    ball = scenes.make(name, law="rigid", restitution=restitution, gravity=G, speed=0.0, duration=1.3 * limit)
    run = _run(ball, 1.3 * limit)
    truth = seek_truth(ball, run.times)
    assert isinstance(truth, Truth)
    assert _rest_time(run) == pytest.approx(limit, rel=tolerance)
    assert np.abs(run.position - truth.position).max() < 1e-10
    assert np.abs(run.velocity[-1]).max() < 1e-14
    assert np.linalg.norm(run.contacts["floor"][-1, 1 : 1 + ball.dimension]) == pytest.approx(G, abs=1e-9)


def test_a_ball_laid_on_a_rigid_floor_rests_at_once():
    run = _run(scenes.make("bouncing_ball", law="rigid", gravity=G, speed=0.0, height=0.0), 1.0)
    assert _rest_time(run) < 1e-6  # when it has fallen by what a gap is known to
    assert np.abs(run.position[:, 0, 1] - 0.05).max() < 1e-12


@pytest.mark.parametrize("method", ["rk4", "radau", "lsodar", "dassl", "generalized_alpha"])
def test_every_integrator_comes_to_rest(method):
    step = {"step": 1e-3} if method in ("rk4", "generalized_alpha") else {"rtol": 1e-11}
    ball = scenes.make("bouncing_ball", law="rigid", gravity=G, speed=0.0, duration=1.0)
    run = simulate(ball, Settings(method=method, estimate="off", **step))  # type: ignore[arg-type]
    assert run.ok, run.message
    assert _rest_time(run) == pytest.approx(3.0 * math.sqrt(0.2 / G), abs=1e-6)
    assert run.position[-1, 0, 1] == pytest.approx(0.05, abs=1e-12)


def _box(tilt: float, restitution: float, drop: float = 0.0) -> Scene:
    """A box on its lower left corner or `drop` (m) above it, tilted to the left; all corners are rigid contacts."""
    c, s = math.cos(tilt), math.sin(tilt)
    up = 0.5 * HEIGHT * c + 0.5 * WIDTH * abs(s) + drop
    places = [(x * WIDTH, y * HEIGHT) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    corners = [(c * x - s * y, up + s * x + c * y) for x, y in places]
    return Scene(
        name="box", gravity=(0.0, -G),
        bodies=(PlanarBody(name="box", mass=10.0, inertia=10.0 * (WIDTH**2 + HEIGHT**2) / 12.0, position=(0.0, up),
                           angle=tilt),),
        contacts=tuple(_on_line(f"corner{k}", place, (0.0, 0.0), (1.0, 0.0), restitution)
                       for k, place in enumerate(corners)),
    )  # fmt: skip


def _on_line(name, place, start, end, restitution) -> CircleOnLine:
    return CircleOnLine(name=name, body_a="box", center=place, radius=0.0, point_1=start, point_2=end,
                        law=RigidLaw(restitution=restitution))  # fmt: skip


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_box_that_topples_comes_to_lie_on_its_side(restitution):
    run = _run(_box(math.atan2(WIDTH, HEIGHT) + 0.05, restitution, drop=0.01), 4.0)
    assert run.position[-1, 0, 1] == pytest.approx(0.5 * WIDTH, abs=1e-11)
    assert run.orientation[-1, 0] == pytest.approx(0.5 * math.pi, abs=1e-11)
    forces = [run.contacts[f"corner{k}"][-1, 2] for k in range(4)]
    assert forces == pytest.approx([0.5 * 10.0 * G, 0.0, 0.0, 0.5 * 10.0 * G], abs=1e-8)
    assert max(run.contacts[f"corner{k}"][:, 0].max() for k in range(4)) < 1e-12  # nothing penetrates


def test_a_box_rocks_to_rest_on_smooth_ground():
    """Only vertical impulses act: w'/w = (I - m b^2)/(I + m b^2), and for small tilts flights shorten by as much."""
    run = _run(_box(1e-4, 0.0), 0.1)
    inertia, arm = (WIDTH**2 + HEIGHT**2) / 12.0, 0.25 * WIDTH**2
    ratio = (inertia - arm) / (inertia + arm)
    assert run.event_times is not None
    flights = np.diff(np.unique(run.event_times[:, 0]))
    assert flights[1:6] / flights[:5] == pytest.approx(ratio, rel=1e-3)
    first = math.sqrt(2.0 * 1e-4 * (inertia + arm) / (0.5 * WIDTH * G))  # falls by the tilt at g b/(I/m + b^2)
    assert _rest_time(run) == pytest.approx(first * (1.0 + 2.0 * ratio / (1.0 - ratio)), rel=1e-3)
    assert np.abs(run.orientation[-1, 0]) < 1e-13


def _housner(tilt: float) -> Scene:
    """The box with a wall at each of its feet, which keep it from sliding."""
    box = _box(tilt, 0.0)
    left, right = (box.contacts[k].center for k in (0, 1))  # type: ignore[union-attr]
    far = left[0] + WIDTH
    walls = (_on_line("left", left, (left[0], 1.0), (left[0], 0.0), 0.0),
             _on_line("right", right, (far, 0.0), (far, 1.0), 0.0))  # fmt: skip
    return box.model_copy(update={"contacts": (*box.contacts[:2], *walls)})


def test_a_box_that_does_not_slide_rocks_as_housner_says():
    """Angular momentum about the new edge: w'/w = 1 - 3/2 sin^2 a, tan a = b/h, at every impact, and it ends in rest.

    Between impacts the energy is kept: cos(a - tilt) of the next turning point follows from w'^2.
    """
    tilt = 0.1
    run = _run(_housner(tilt), 8.0)
    assert run.event_times is not None
    impacts = np.unique(run.event_times[:, 0])
    slope = math.atan2(WIDTH, HEIGHT)
    ratio, size = 1.0 - 1.5 * math.sin(slope) ** 2, 0.5 * math.hypot(WIDTH, HEIGHT)
    energy, expected = math.cos(slope - tilt) - math.cos(slope), []
    for _ in range(6):
        expected.append(_quarter(slope, energy, 0.75 * G / size))
        energy *= ratio**2
    flights = np.diff(np.concatenate(([0.0], impacts[:6])))
    assert flights == pytest.approx(np.array(expected) * [1.0, 2.0, 2.0, 2.0, 2.0, 2.0], abs=1e-9)
    assert np.abs(run.orientation[-1]).max() < 1e-12
    assert np.abs(run.velocity[-1]).max() < 1e-12


def _quarter(slope: float, energy: float, pull: float) -> float:
    """Return the time (s) from the turning point to the impact of tilt'' = -pull sin(slope - tilt), by quadrature."""
    top = slope - math.acos(math.cos(slope) + energy)
    s, weights = np.polynomial.legendre.leggauss(60)
    s = 0.5 * (s + 1.0)
    tilts = top * (1.0 - s**2)  # takes the root at the turning point away
    rate = np.sqrt(2.0 * pull * (np.cos(slope - top) - np.cos(slope - tilts)))
    return float(0.5 * weights @ (2.0 * top * s / rate))


def test_a_stack_of_balls_bounces_to_rest_and_bears_its_weight():
    heights = [0.15, 0.4, 0.65]
    bodies = tuple(PlanarBody(name=f"b{k}", mass=1.0 + k, inertia=0.01, position=(0.0, y))
                   for k, y in enumerate(heights))  # fmt: skip
    floor = CircleOnLine(name="floor", body_a="b0", center=(0.0, 0.15), radius=0.1, point_1=(0.0, 0.0),
                         point_2=(1.0, 0.0), law=RigidLaw(restitution=0.5))  # fmt: skip
    pairs = tuple(CircleOnCircle(name=f"p{k}", body_a=f"b{k}", center_a=(0.0, heights[k]), radius_a=0.1,
                                 body_b=f"b{k + 1}", center_b=(0.0, heights[k + 1]), radius_b=0.1,
                                 law=RigidLaw(restitution=0.5)) for k in range(2))  # fmt: skip
    run = _run(Scene(name="stack", gravity=(0.0, -G), bodies=bodies, contacts=(floor, *pairs)), 3.0)
    assert run.position[-1, :, 1] == pytest.approx([0.1, 0.3, 0.5], abs=1e-11)
    forces = [run.contacts[name][-1, 2] for name in ("floor", "p0", "p1")]
    assert np.abs(forces) == pytest.approx([6.0 * G, 5.0 * G, 3.0 * G], abs=1e-8)


@pytest.mark.parametrize("gap", [0.0, 1e-3])
def test_a_cradle_without_restitution_goes_on_as_one(gap):
    run = _run(scenes.make("newtons_cradle", restitution=0.0, gap=gap), 0.2)
    assert run.velocity[-1, :, 0] == pytest.approx([0.2] * 5, abs=1e-12)


def test_balls_whose_restitution_is_small_collapse_within_a_limit_time():
    """Three balls in a row collide without end where e < 7 - 4 sqrt(3) = 0.0718 (McNamara and Young 1992)."""
    run = _run(scenes.make("newtons_cradle", balls=3, restitution=0.05), 0.2)
    assert run.velocity[-1, :, 0] == pytest.approx([1.0 / 3.0] * 3, abs=1e-9)


def test_a_ball_on_a_vibrating_table_rests_and_lifts_off_again():
    """It lifts off at rest where A w^2 sin(w t) = g, whatever bounces went before."""
    seat = scenes.make("ball_on_driven_seat", amplitude=0.0115)
    bouncing = seat.contacts[0].model_copy(update={"law": RigidLaw(restitution=0.3)})
    run = _run(seat.model_copy(update={"contacts": (bouncing,)}), 1.0)
    assert run.event_times is not None
    times = run.event_times[:, 0]
    lift_off = (math.asin(G / (0.0115 * 30.0**2)) + 2.0 * math.pi * np.arange(5)) / 30.0
    late = [np.abs(times - t).min() for t in lift_off[lift_off < 1.0]]
    assert late == pytest.approx(np.zeros(len(late)), abs=1e-9)
    assert run.contacts["seat"][:, 0].max() < 1e-12
    assert run.contacts["seat"][:, 2].min() >= 0.0


def test_a_box_in_space_falls_flat_and_askew_and_rests_on_its_corners():
    sides, heights = (0.4, 0.3, 0.2), []
    for turn in ((1.0, 0.0, 0.0, 0.0), (math.cos(0.15), 0.6 * math.sin(0.15), 0.8 * math.sin(0.15), 0.0)):
        run = _run(_block(sides, turn), 3.0)
        heights.append(run.position[-1, 0, 2])
        total = sum(run.contacts[f"corner{k}"][-1, 3] for k in range(8))
        assert total == pytest.approx(2.0 * G, abs=1e-8)
        assert np.abs(run.angular_velocity[-1]).max() < 1e-10
    assert heights == pytest.approx([0.1, 0.1], abs=1e-10)


def _block(sides: tuple[float, float, float], turn: tuple[float, float, float, float]) -> Scene:
    signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
    corners = signs * sides @ rotation_matrices(np.array(turn)).T + [0.0, 0.0, 0.5]
    law = RigidLaw(restitution=0.3)
    return Scene(
        name="block", gravity=(0.0, 0.0, -G),
        bodies=(SpatialBody(name="box", mass=2.0, inertia=block_inertia(2.0, *sides), position=(0.0, 0.0, 0.5),
                            orientation=turn),),
        contacts=tuple(SphereOnPlane(name=f"corner{k}", body_a="box", center=tuple(corner), radius=0.0,
                                     point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0), law=law)
                       for k, corner in enumerate(corners.tolist())),
    )  # fmt: skip
