"""The exact events against a dense scan of the motion, and the impulses against conservation laws."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from tests.mbs_ref.hidden_events.cases import case
from tests.mbs_ref.hidden_events.exact import SIGNS, Flight, Segment, gap, history, solve
from tests.mbs_ref.hidden_events.families import FAMILIES
from tests.mbs_ref.hidden_events.roots import Undecided, roots
from tests.mbs_ref.hidden_events.world import Contact, Length, Level, Mark, Watch, World
from tests.mbs_ref.hidden_events.write_scene import Units, write_scene

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 6))]
PER_TURN, AT_LEAST = 200, 2000  # samples of a scan
MOST_SAMPLES = 200_000


def _position(flight: Flight, arm: np.ndarray, times: np.ndarray) -> np.ndarray:
    """By rotation matrices, unlike `Flight.point`."""
    tau = (times - flight.start)[:, None]
    path = flight.place + flight.velocity * tau + flight.acceleration * tau**2 / 2.0
    return path + Rotation.from_rotvec(tau * flight.spin).apply(flight.turned @ arm)


def _excess(watch: Watch, world: World, segment: Segment, times: np.ndarray) -> np.ndarray:
    """How far a quantity is above its threshold."""

    def at(mark: Mark) -> np.ndarray:
        return _position(segment.flights[mark.body], mark.arm, times)

    if isinstance(watch, Level):
        flight = segment.flights[watch.body]
        offset = next(body.offset for body in world.bodies if body.name == watch.body)
        if watch.coordinate == 3:
            return flight.spin[2] * times - watch.value
        if watch.rate:
            arm = _position(flight, offset, times) - _position(flight, np.zeros(3), times)
            rate = flight.velocity + flight.acceleration * (times - flight.start)[:, None] + np.cross(flight.spin, arm)
            return rate[:, watch.coordinate] - watch.value
        return _position(flight, offset, times)[:, watch.coordinate] - watch.value
    apart = at(watch.a) - at(watch.b)
    if isinstance(watch, Length):
        return np.linalg.norm(apart, axis=1) - watch.value
    if watch.normal is None:
        return np.linalg.norm(apart, axis=1) - watch.radius_a - watch.radius_b
    return apart @ watch.normal - watch.radius_a


def _scanned(watch: Watch, world: World, segment: Segment) -> list[float]:
    """Return the crossings of a dense scan, with the extremes between its samples."""
    signs = SIGNS[getattr(watch, "crossing", "either")]
    spin = sum(float(np.linalg.norm(flight.spin)) for flight in segment.flights.values())
    count = int(AT_LEAST + PER_TURN * spin * (segment.end - segment.start) / (2.0 * np.pi))
    assert count < MOST_SAMPLES
    times = np.linspace(segment.start, segment.end, count)
    value = _excess(watch, world, segment, times)
    size = np.abs(value)
    extremes = np.flatnonzero((size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:]) & (value[:-2] * value[2:] > 0.0)) + 1
    further = []
    for k in extremes:
        sign = np.sign(value[k])
        further.append(minimize_scalar(
            lambda t, sign=sign: sign * _excess(watch, world, segment, np.array([t]))[0],
            bounds=(times[k - 1], times[k + 1]), method="bounded", options={"xatol": 1e-13},
        ).x)  # fmt: skip
    times = np.sort(np.concatenate((times, further)))
    above = _excess(watch, world, segment, times) > 0.0
    changes = np.flatnonzero(above[1:] != above[:-1])
    return [0.5 * (times[k] + times[k + 1]) for k in changes if (1 if above[k + 1] else -1) in signs]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("family", FAMILIES)
def test_a_dense_scan_of_the_motion_has_the_same_events(family, seed):
    world = case(family, seed).world
    segments, events = history(world), solve(world)
    for watch in world.watches:
        exact = [event.time for event in events if event.name == watch.name]
        if not isinstance(watch, Level) and watch.acts:
            _require_solid(watch, world, segments)
            continue
        scanned = [time for segment in segments for time in _scanned(watch, world, segment)]
        assert len(scanned) == len(exact)
        assert np.allclose(scanned, exact, rtol=0.0, atol=world.horizon / AT_LEAST)


def _require_solid(watch: Contact | Length, world: World, segments: list[Segment]) -> None:
    """A contact that acts touches at the ends of its own segments and nowhere else; a plate within its edges alone."""
    for segment in segments:
        inside = np.linspace(segment.start, segment.end, AT_LEAST)
        if isinstance(watch, Length) or not watch.edges:
            sign = -1.0 if isinstance(watch, Length) else 1.0
            assert np.all(sign * _excess(watch, world, segment, inside) > -1e-12)
            ends = [segment.end] if segment.impact is watch else []
            assert all(abs(_excess(watch, world, segment, np.array([end]))[0]) < 1e-13 for end in ends)
            continue
        apart = (_position(segment.flights[mark.body], mark.arm, inside) for mark in (watch.a, watch.b))
        sideways = np.max(np.abs(np.subtract(*apart) @ np.array(watch.edges).T), axis=1)
        deep = -_excess(watch, world, segment, inside)
        touching = (sideways < watch.half - 1e-9) & (deep > 1e-9) & (deep < (watch.thickness or np.inf))
        assert not np.any(touching)


def _energy(world: World, flights: dict[str, Flight], time: float) -> float:
    total = 0.0
    for body in world.bodies:
        flight, at = flights[body.name], np.array([time])
        velocity = flight.point(body.offset, at, 1)[0]
        place = flight.point(body.offset, at)[0]
        turning = 0.0 if body.kind == "point" else body.inertia * flight.spin @ flight.spin
        free = body.kind in ("free", "point")
        total += 0.5 * (body.mass * velocity @ velocity + turning) - free * body.mass * world.gravity @ place
    return total


def _closing(hit: Contact, flights: dict[str, Flight], at: np.ndarray) -> np.ndarray:
    a, b = (flights[mark.body].point(mark.arm, at, 1)[0] for mark in (hit.a, hit.b))
    return a - b


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("family", ["studs", "bullets", "turning", "valves"])
def test_impulses_obey_restitution_and_take_the_energy_that_it_takes(family, seed):
    world = case(family, seed).world
    segments = history(world)
    for before, after in pairwise(segments):
        hit, at = before.impact, np.array([before.end])
        assert isinstance(hit, Contact)
        apart = [before.flights[mark.body].point(mark.arm, at)[0] for mark in (hit.a, hit.b)]
        normal = hit.normal if hit.normal is not None else (apart[0] - apart[1]) / np.linalg.norm(apart[0] - apart[1])
        speeds = [float(normal @ _closing(hit, each.flights, at)) for each in (before, after)]
        assert speeds[1] == pytest.approx(-(hit.restitution or 0.0) * speeds[0], rel=1e-6, abs=1e-9 * abs(speeds[0]))
        energies = [_energy(world, each.flights, before.end) for each in (before, after)]
        if hit.restitution == 1.0:
            assert energies[1] == pytest.approx(energies[0], rel=1e-9)
        else:
            assert energies[1] < energies[0]


def test_a_pair_of_roots_within_a_billionth_is_separated_and_a_double_root_is_undecided():
    def parabola(depth):
        return lambda t, h: ((t - 0.3) ** 2 - depth, 2.0 * (t - 0.3), 2.0 + 0.0 * t)

    pair = roots(parabola(1e-18), 0.0, 1.0)
    assert [time for time, _ in pair] == pytest.approx([0.3 - 1e-9, 0.3 + 1e-9], abs=1e-13)
    assert [sign for _, sign in pair] == [-1, 1]
    assert roots(parabola(-1e-18), 0.0, 1.0) == []
    with pytest.raises(Undecided):
        roots(parabola(0.0), 0.0, 1.0)


def test_the_bound_of_every_gap_holds():
    """Differences of slopes never exceed the bound times the width."""
    rng = np.random.default_rng(0)
    for family in FAMILIES:
        world = case(family, 0).world
        segment = history(world)[0]
        for watch in world.watches:
            function = gap(watch, world, segment.flights, 0.0)
            middle = rng.uniform(segment.start, segment.end, 200)
            half = 10.0 ** rng.uniform(-6.0, -1.0, 200)
            _, slope, bound = function(middle, half)
            for side in (middle - half, middle + half):
                assert np.all(
                    np.abs(function(side, half)[1] - slope)
                    <= bound * half * (1.0 + 1e-9) + 1e-9 * (1.0 + np.abs(slope))
                )


@pytest.mark.parametrize("seed", range(4))
def test_a_stiff_spring_holds_for_half_a_period(seed):
    """Against the equation of motion, integrated in steps of a hundredth of the contact."""
    drawn = case("springs", seed)
    body, first = drawn.world.bodies[0], history(drawn.world)[0]
    hit, at = first.impact, np.array([first.end])
    assert hit is not None
    apart = first.flights["ball"].point(hit.a.arm, at)[0] - hit.b.arm
    inward = hit.normal if isinstance(hit, Contact) else -apart / np.linalg.norm(apart)
    speed = float(inward @ body.velocity)
    stiffness = write_scene("s", drawn.world, Units(1.0, 1.0, 1.0))
    part = next(part for part in (*stiffness.contacts, *stiffness.loads) if part.name == hit.name)
    k = part.law.stiffness if isinstance(hit, Contact) else part.stiffness
    run = solve_ivp(
        lambda _, y: (y[1], -k / body.mass * y[0]), (0.0, 1.5 * hit.hold), (0.0, speed), rtol=1e-10, atol=1e-12,
        max_step=0.01 * hit.hold, events=lambda t, y: y[0] if t > 0.5 * hit.hold else -1.0,
    )  # fmt: skip
    assert run.t_events[0][-1] == pytest.approx(hit.hold, rel=1e-7)
    assert run.y_events[0][-1][1] == pytest.approx(-speed, rel=1e-7)
