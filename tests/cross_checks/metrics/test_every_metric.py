"""Every metric on random numbers, computed again in a few lines of its own."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from cross_checks import metrics
from cross_checks.metrics import contact_figures, drifts, metric
from cross_checks.metrics.errors import MOST, reaction_error, significant_figures
from cross_checks.metrics.metric import Absent, Errors, Judged
from cross_checks.truths.truth import ONE_FIGURE, NoTruth, Truth
from mbs_ref.scene import GROUND, PlanarBody, PointMass, Scene
from mbs_ref.trajectory import Status, Trajectory

UNITS = {"position_error": "m", "orientation_error": "rad", "velocity_error": "m/s", "angular_velocity_error": "rad/s"}
BODIES = (PointMass(name="dot", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0)),
          PlanarBody(name="wide", mass=3.0, inertia=12.0, position=(5.0, 0.0)),
          PlanarBody(name="slim", mass=2.0, inertia=0.5, position=(0.0, 3.0)))  # fmt: skip
SCENE = Scene(name="three", bodies=BODIES, gravity=(0.0, 0.0), duration=2.0)
ARM = 0.5  # m, the least radius of gyration


def random_motion(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    flat = {"position": 2, "velocity": 2}
    names = ("position", "orientation", "velocity", "angular_velocity")
    return {name: rng.uniform(-1.0, 1.0, (n, 3, 2) if name in flat else (n, 3)) for name in names}


@pytest.mark.parametrize("seed", range(3))
def test_errors_and_what_is_unknown_of_them(seed):
    rng = np.random.default_rng(seed)
    n, doubt, turn = 6, 10 ** rng.uniform(-3, -1.5), None if seed else 0.02
    true, off = random_motion(rng, n), random_motion(rng, n)
    rates = np.where(rng.random(n) < 0.3, np.inf, 10 ** rng.uniform(-3, -1, n))
    scale = {name: 10 ** rng.uniform(-3, 0, (n, 3)) for name in true}
    run = {
        name: true[name] + (scale[name][..., None] if true[name].ndim == 3 else scale[name]) * off[name]
        for name in true
    }
    known = {"velocity": true["velocity"], "angular_velocity": true["angular_velocity"], "rate_uncertainty": rates}
    truth = Truth(true["position"], true["orientation"], doubt, "exact", "", turn_uncertainty=turn, **known)  # type: ignore[arg-type]
    path = Trajectory(np.arange(n) * 0.4, **run)
    judged = Judged(SCENE, path, truth)
    errors = judged.errors
    assert isinstance(errors, Errors)
    uncertain = {"position": doubt, "orientation": turn or doubt / ARM, "velocity": rates, "angular_velocity": rates}
    for place, name in enumerate(true):
        gap = run[name] - true[name]
        size = np.linalg.norm(gap, axis=-1) if gap.ndim == 3 else np.abs(gap)
        least = np.broadcast_to(np.reshape(uncertain[name], (-1, 1)), (n, 3))
        shown = np.where(size >= ONE_FIGURE * least, size, np.nan)
        below = np.where(np.isnan(shown) & np.isfinite(least), size + least, np.nan)
        if place % 2:
            shown[:, 0] = below[:, 0] = size[:, 0] = np.nan  # a particle has no orientation
        assert errors.sizes[..., place] == pytest.approx(shown, nan_ok=True)
        assert errors.bounds[..., place] == pytest.approx(below, nan_ok=True)
        assert errors.counted[..., place] == pytest.approx(shown if place > 1 else size, nan_ok=True)
        curve = metrics.every()[list(UNITS)[place]].curve(judged)
        finite = shown[np.isfinite(shown)]
        if finite.size:
            assert metric.largest_value(curve) == pytest.approx(finite.max())
        else:
            assert isinstance(curve, Absent)
            assert curve.below == pytest.approx(np.nanmax(below))
    length = judged.scales.length
    assert metric.known_to(SCENE, truth) == pytest.approx(max(doubt / length, turn or doubt / ARM))


def test_every_metric_has_its_unit_and_none_is_known_without_a_truth():
    units = UNITS | {"compliance_position": "m, rad", "compliance_velocity": "m/s, rad/s", "energy_drift": "J",
                     "momentum_drift": "kg m/s, kg m^2/s", "reaction_error": "N, N m"}  # fmt: skip
    every = metrics.every()
    assert {name: one.unit for name, one in every.items()} == units
    assert {name for name, one in every.items() if one.plotted} == {"compliance_position", "energy_drift"}
    path = Trajectory(np.arange(3.0), **random_motion(np.random.default_rng(1), 3))
    judged = Judged(SCENE, path, NoTruth("because"))
    assert {name for name in (*UNITS, "reaction_error") if isinstance(every[name].curve(judged), Absent)} == {
        *UNITS, "reaction_error"}  # fmt: skip
    assert judged.errors == Absent("no error: because")


def test_figures_of_curves():
    curves: dict[str, Any] = {"a": np.array([1.0, 3.0, 2.0]), "b": np.array([1.0, np.inf]), "c": Absent("x", 0.5),
                              "d": Absent("y"), "e": np.zeros(0), "f": np.array([-2.0, -1.0])}  # fmt: skip
    found = metric.figures(curves)
    assert found["measures"] == {"a": 3.0, "b": None, "c": None, "d": None, "e": None, "f": -1.0}
    assert found["bounds"] == {"c": 0.5}


def test_a_run_that_stops_early_is_not_held_against_the_truth(monkeypatch):
    path = Trajectory(np.arange(3.0), **random_motion(np.random.default_rng(2), 3))
    truth = Truth(path.position + np.array([3.0, 4.0]), path.orientation, 0.0, "exact", "")
    monkeypatch.setattr(metric, "truth_for", lambda scene, times: truth)
    off = metric.off_truth(SCENE, path)
    assert off
    assert off[:2] == pytest.approx([5.0, 0.0])
    assert metric.off_truth(SCENE, replace(path, status=Status.TOO_MANY_STEPS)) is None


@pytest.mark.parametrize("seed", range(3))
def test_reactions_differ_by_the_largest_over_the_joints_that_both_report(seed):
    rng = np.random.default_rng(seed)
    ours = {name: rng.normal(size=(rng.integers(3, 7), 3)) for name in "abcd"}
    theirs = {name: rng.normal(size=(rng.integers(3, 7), 3)) for name in "bcde"}
    gaps = []
    for name in "bcd":
        n = min(len(ours[name]), len(theirs[name]))
        gaps.append(np.abs(ours[name][:n] - theirs[name][:n]).max())
    assert reaction_error(ours, theirs) == max(gaps)
    ours["c"][0] = np.inf
    assert reaction_error(ours, theirs) is None


@pytest.mark.parametrize("seed", range(3))
def test_significant_figures_count_from_the_sun_and_moons_from_their_planets(seed):
    rng = np.random.default_rng(seed)
    names = ("sun", "moon", "earth", "mars", "ceres", "venus")
    true = rng.normal(size=(6, 3))
    ended = true + 10 ** rng.uniform(-9, 1, (6, 1)) * rng.normal(size=(6, 3))
    true[4] = np.nan
    ended[5], ended[0] = true[5] - true[0] + ended[0], ended[0]
    scene, path = (
        SimpleNamespace(body_names=names),
        SimpleNamespace(position=np.stack((rng.normal(size=(6, 3)), ended))),
    )
    found = significant_figures(scene, path, SimpleNamespace(position=true))  # type: ignore[arg-type]
    expected = {}
    for k, name in ((1, "moon"), (2, "earth"), (3, "mars"), (5, "venus")):
        c = 2 if name == "moon" else 0
        gap = np.linalg.norm((ended[k] - ended[c]) - (true[k] - true[c])) / np.linalg.norm(true[k] - true[c])
        expected[name] = min(MOST, -np.log10(gap)) if gap > 0.0 else MOST
    assert found == pytest.approx(expected)
    assert max(found.values()) <= MOST


def test_joints_gape_most_at_samples_or_over_the_steps_between(monkeypatch):
    residual = np.array([[1e-3, -5e-3], [2e-3, 1e-3], [0.0, -1e-3]])
    found = SimpleNamespace(residual=residual, rate=-3.0 * residual, joints=("a", "b"))
    monkeypatch.setattr(drifts, "rows", lambda scene, path: found)
    position, rate = drifts.compliance(None, None)  # type: ignore[arg-type]
    assert position.tolist() == [5e-3, 2e-3, 1e-3]
    assert rate == pytest.approx([15e-3, 6e-3, 3e-3])
    steps = np.array([[0.5, 0.0], [0.7, 9e-3], [0.9, 1e-4], [1.1, 7.0]])
    path: Any = SimpleNamespace(step_compliance=steps, times=np.arange(3.0))
    assert drifts._position(SimpleNamespace(scene=None, path=path)).tolist() == [5e-3, 9e-3, 1e-3]  # type: ignore[arg-type]
    assert drifts.worst_joint(None, path) == ("b", 5e-3)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(4))
def test_the_depth_is_the_largest_of_the_cubics_inside(seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.1, 1.0, 8))
    gap, rate = np.sin(times + seed) * rng.uniform(0.5, 1.0, 8), rng.normal(size=8)
    spline, depths = CubicHermiteSpline(times, gap, rate), [-gap.min()]
    for k in range(7):
        if gap[k] < 0.0 and gap[k + 1] < 0.0:
            depths.append(-spline(np.linspace(times[k], times[k + 1], 400)).min())
    assert contact_figures._deepest(times, gap, rate) == pytest.approx(max(depths), rel=2e-3)


@pytest.mark.parametrize(
    ("start", "end", "labels"),
    [(0.5, 0.0, {"penetration, m", "static sink, m", "stop distance, m"}), (0.5, 2e-4, {"penetration, m"}),
     (0.0, 0.0, {"penetration, m", "static sink, m", "creep, m/s"})],
)  # fmt: skip
def test_figures_of_a_contact_that_lasts(monkeypatch, start, end, labels):
    n = 9
    gap, rate = np.array([1e-3, -4e-3, -9e-3, -7e-3, *np.linspace(-6e-3, -5e-3, 5)]), np.full(n, 5e-5)
    slip = np.linspace(start, end, n)
    monkeypatch.setattr(contact_figures, "gap_of", lambda motion, contact: (gap, rate, slip))
    times = np.linspace(0.0, 4.0, n)
    way = np.linspace(0.0, 3e-3, n)
    still = np.zeros((n, 1))
    place = 7.0 + np.stack((way, 2.0 * way), axis=1)[:, None]
    path = Trajectory(times, place, still, np.zeros((n, 1, 2)), still)
    scene = SimpleNamespace(body_index=lambda name: 0)
    motion: Any = SimpleNamespace(trajectory=path, times=times, scene=scene)
    contact = SimpleNamespace(name="touch", friction=object(), body_a="a", body_b=GROUND)
    found = contact_figures._of_contact(motion, contact)
    assert found.keys() == labels
    assert found["penetration, m"] >= 9e-3
    assert found.get("static sink, m", 5e-3) == pytest.approx(5e-3)
    assert found.get("stop distance, m", 3e-3 * 5**0.5) == pytest.approx(3e-3 * 5**0.5)
    assert found.get("creep, m/s", 1.5e-3 * 5**0.5 / 2.0) == pytest.approx(1.5e-3 * 5**0.5 / 2.0)


@pytest.mark.parametrize(("events", "kept"), [(None, True), ([[0.1, 1.0]], True), ([[0.1, 0.0]], False), ([], False)])
def test_a_contact_that_begins_open_has_figures_where_an_event_opens_or_closes_it(monkeypatch, events, kept):
    gap = np.array([1e-3, -4e-3, -9e-3, 2e-3])
    monkeypatch.setattr(contact_figures, "gap_of", lambda motion, contact: (gap, np.ones(4), np.ones(4)))
    located = None if events is None else np.array(events, dtype=float).reshape(-1, 2)
    path = SimpleNamespace(event_times=located, event_names=("other", "touch"))
    motion: Any = SimpleNamespace(trajectory=path, times=np.arange(4.0), scene=None)
    found = contact_figures._of_contact(motion, SimpleNamespace(name="touch", friction=None))
    assert bool(found) == kept


def test_a_drift_is_unknown_without_a_balance_and_known_to_a_tenth_of_its_largest(monkeypatch):
    def balance(drift, resolution):
        found = SimpleNamespace(drift=drift, reason="no work", resolution=resolution, energy=np.array([1.0, 2.0]))
        monkeypatch.setattr(drifts, "energy_balance", lambda scene, path: found)
        return drifts.energy_drift(None, None)  # type: ignore[arg-type]

    assert balance(None, None) == Absent("no energy drift: no work")
    assert balance(np.array([0.0, -1e-3, 1e-4]), 0.9e-4).tolist() == [0.0, 1e-3, 1e-4]
    coarse = balance(np.array([0.0, -1e-3]), 1.1e-4)
    assert isinstance(coarse, Absent)
    assert "the work integral has an error of up to 0.00011 J at this output interval" in coarse.reason


@pytest.mark.parametrize("lacking", ["before", "after", "neither"])
def test_a_bounce_needs_two_samples_of_flight_on_both_sides(lacking):
    gap, rate = np.array([2.0, 1.0, -1.0, -1.0, 1.0, 2.0]), np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    rows = {"before": slice(1, None), "after": slice(None, -1), "neither": slice(None)}[lacking]
    found = contact_figures._flights(gap[rows], rate[rows])
    assert found == (((0, 1), (4, 5)) if lacking == "neither" else (None, None))


def test_every_metric_has_its_label_and_unit():
    assert {one.name: (one.label, one.unit, one.plotted) for one in metrics.every().values()} == {
        "compliance_position": ("compliance", "m, rad", True),
        "compliance_velocity": ("rate compliance", "m/s, rad/s", False),
        "energy_drift": ("energy drift", "J", True),
        "momentum_drift": ("momentum drift", "kg m/s, kg m^2/s", False),
        "reaction_error": ("joint force error", "N, N m", False),
        **{name: (name.replace("_", " "), unit, False) for name, unit in UNITS.items()},
    }


@pytest.mark.parametrize(("met", "parted", "found"), [
    ((-2.0, 0.25, 1.0), (1.0, 0.5, 1.0), {"restitution": 0.5, "duration, s": 0.25}), (None, (1.0, 0.5, 1.0), {}),
    ((-2.0, 0.25, 1.0), None, {}), (None, None, {}), ((2.0, 0.25, 1.0), (1.0, 0.5, 1.0), {}),
    ((-2.0, 0.25, 1.0), (-1.0, 0.5, 1.0), {}), ((-2.0, 0.6, 1.0), (1.0, 0.5, 1.0), {}),
    ((-2.0, 0.25, -1.0), (1.0, 0.5, 1.0), {}), ((-2.0, 0.5, 1.0), (1.0, 0.5, 1.0), {
        "restitution": 0.5, "duration, s": 0.0}),
])  # fmt: skip
def test_a_bounce_is_an_approach_and_then_a_parting_on_the_same_side(monkeypatch, met, parted, found):
    """Each is the rate at the surface, its time, and the side from which the body comes."""
    ends = iter(None if one is None else (*one[:2], np.array([one[2]])) for one in (met, parted))
    monkeypatch.setattr(contact_figures, "_flights", lambda gap, rate: ((0, 1), (4, 5)))
    monkeypatch.setattr(contact_figures, "_at_surface", lambda *given: next(ends))
    monkeypatch.setattr(contact_figures, "_free_mass", lambda *given: None)
    nothing: Any = None
    assert contact_figures._bounce(nothing, nothing, nothing, nothing) == found
