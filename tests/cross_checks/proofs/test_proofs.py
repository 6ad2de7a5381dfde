"""Proofs hold, and nothing false passes: doctored logs, wrong equations, truths with a wrong digit."""

from __future__ import annotations

import copy
import itertools
import json
import math
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

pytest.importorskip("flint", reason="proofs need python-flint: pip install 'mbs-ref[proofs]'")

from flint import arb, fmpq  # pyright: ignore[reportMissingImports]

from cross_checks.truths import seek_truth, stored_poses
from cross_checks.truths.proofs import integrate
from cross_checks.truths.proofs.certified import as_truth, examine, kept, read_log, varied, write_log
from cross_checks.truths.proofs.checker.formulas import Formulas, Refused, precision
from cross_checks.truths.proofs.checker.impacts import Impacts
from cross_checks.truths.proofs.checker.mechanics import Mechanics
from cross_checks.truths.proofs.checker.model import root
from cross_checks.truths.proofs.checker.proof import Proof, check
from cross_checks.truths.proofs.derivation import NotCovered
from cross_checks.truths.proofs.integrate import propose, prove, prove_family, rescaled
from cross_checks.truths.truth import Truth
from mbs_ref import Settings, scenes, simulate
from mbs_ref.observables.distance import farthest, relative, unmasked_distances
from mbs_ref.scene import GROUND, PlanarBody, Prismatic, Revolute, Scene, SpatialBody, Spherical
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine
from reports.cli import main

TIMES = [0.0, 0.1, 0.2]  # s
COVERED: dict[str, dict[str, Any]] = {
    "double_pendulum": {},
    "pendulum_chain": {"links": 4},
    "slider_crank": {},
    "spring_pendulum": {"damping": 0.3},
    "kepler": {},
    "spherical_pendulum": {},
    "torque_free_top": {},
    "spatial_slider_crank": {},
    "driven_pendulum": {},
    "car_axis": {},
    "n_four_bar": {},
    "spatial_n_four_bar": {"loops": 1},
    "disc_between_walls": {"law": "rigid"},
    "newtons_cradle": {"balls": 2},
    "colliding_spheres": {},
}


SLOW = ("car_axis", "colliding_spheres", "pendulum_chain", "spatial_slider_crank")


def proven(name: str, times: list[float] = TIMES, **parameters: Any) -> Any:
    return prove(scenes.make(name, **parameters), times)


@cache
def proof_of(name: str) -> Any:
    return proven(name, **COVERED[name])


@cache
def log_of(name: str) -> dict[str, Any]:
    """Return a log as a file holds it."""
    return json.loads(json.dumps(proof_of(name).log))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in COVERED]
)
def test_a_proof_is_checked_and_holds_the_truth(name):
    checked = check(log_of(name))
    enclosures = checked.enclosures
    assert checked.radius < 1e-15
    assert len(enclosures) == len(TIMES)
    scene = scenes.make(name, **COVERED[name])
    truth = seek_truth(scene, np.array(TIMES))
    assert isinstance(truth, Truth)
    proof = as_truth(scene, enclosures)
    assert max(farthest(scene, truth, proof)[:2]) <= truth.uncertainty + proof.uncertainty
    rates = np.nan_to_num(unmasked_distances(truth, proof, None)[..., 2:]).max((1, 2))  # NaN at impacts
    assert (rates <= truth.rate_uncertainty + proof.rate_uncertainty).all()


def test_the_truth_of_a_top_starts_from_the_exact_rates():
    """Rates in body axes that were rounded to doubles turned a top of a hundred turns out of its enclosure."""
    scene = varied(scenes.make("torque_free_top", turns=1.5), 61)
    times = np.array([0.0, scene.duration])
    truth = seek_truth(scene, times, afresh=True)
    assert isinstance(truth, Truth)
    assert farthest(scene, truth, as_truth(scene, prove(scene, times.tolist()).proof.enclosures))[1] < 8e-16


def test_a_stored_enclosure_is_a_proven_truth(tmp_path):
    scene, times = scenes.make("double_pendulum"), np.array(TIMES)
    stored_poses.save(scene, times, as_truth(scene, check(log_of("double_pendulum")).enclosures, "abc"), tmp_path)
    stored = stored_poses.load(scene, times, tmp_path)
    assert stored is not None
    assert (stored.kind, stored.difference) == ("proven", None)
    assert "log sha256 abc" in stored.how
    assert stored.uncertainty < 1e-15


@pytest.mark.parametrize("method", ["dop853", "radau"])
@pytest.mark.parametrize("name", ["disc_between_walls", pytest.param("colliding_spheres", marks=pytest.mark.slow)])
def test_errors_after_impacts_are_within_the_estimate(name, method):
    """An event is located a little beyond its root: no error of the run's alone."""
    scene = scenes.make(name, **COVERED[name])
    proof = as_truth(scene, check(log_of(name)).enclosures)
    run = simulate(scene, Settings(method=method), np.array(TIMES))
    assert run.estimate is not None
    errors = np.nan_to_num(relative(scene, proof, run))  # NaN at impacts
    assert errors.max() > 1e-13
    assert (errors <= run.estimate.components).all()


def test_impacts_have_proven_times():
    impacts = proof_of("disc_between_walls").proof.impacts.times
    gap = Fraction(1) - Fraction(1, 2) - Fraction(0.1)  # m, at 5 m/s
    assert [name for name, _ in impacts] == ["right"]
    with precision(400):
        assert impacts[0][1].contains(arb(fmpq(*(gap / 5).as_integer_ratio())))


def test_impacts_of_several_bodies_are_proven():
    """Other bodies rest or move slowly while two collide: an enclosure that hardly grows contains its image."""
    scene = varied(scenes.make("newtons_cradle", law="rigid"), 11)
    proof = prove(scene, [0.0, scene.duration]).proof
    assert (len(proof.impacts.times), proof.reached >= scene.duration) == (4, True)
    assert proof.radius < 1e-20


def _bouncing(restitution: float = 0.8, mass: float = 1.0, speed: float = 0.0, **discs: tuple[float, float]) -> Any:
    """Return discs above a floor that fall from heights (m) at places (m), and bounce off it and off one another.

    The mass (kg) is of the first one, the speed (m/s, downward) of the last one.
    """
    law = scenes.make("newtons_cradle", balls=2, restitution=restitution).contacts[0].law
    bodies = [PlanarBody(name=name, mass=1.0, inertia=0.1, position=at) for name, at in discs.items()]
    bodies[0] = bodies[0].model_copy(update={"mass": mass})
    bodies[-1] = bodies[-1].model_copy(update={"velocity": (0.0, -speed)})
    floor = {"radius": 0.1, "point_1": (0.0, 0.0), "point_2": (1.0, 0.0), "extent": "line", "law": law}
    parts: list[Any] = [CircleOnLine(name=f"{b.name}.floor", body_a=b.name, center=b.position, **floor) for b in bodies]
    for a, b in itertools.combinations(bodies, 2):
        ends = {"body_a": a.name, "center_a": a.position, "body_b": b.name, "center_b": b.position}
        parts.append(CircleOnCircle(name=a.name + b.name, radius_a=0.1, radius_b=0.1, law=law, **ends))
    return Scene(name="bouncing", bodies=tuple(bodies), contacts=tuple(parts), gravity=(0.0, -9.81), duration=0.5)


def test_impacts_keep_the_digits():
    """Thirteen impacts of a disc between walls lose at most 5 digits of the exact place: 10 m folded into 0.8 m."""
    proof = prove(scenes.make("disc_between_walls", law="rigid"), [0.0, 2.0]).proof
    radius = Fraction(0.1)
    way = (Fraction(1, 2) + 10 - radius) % (2 * (1 - 2 * radius))
    place = radius + min(way, 2 * (1 - 2 * radius) - way)
    assert (len(proof.impacts.times), proof.radius < 10.0 ** (5 - integrate.DIGITS)) == (13, True)
    with precision(400):
        assert proof.enclosures[-1][0][0].contains(arb(fmpq(place.numerator, place.denominator)))


def test_impacts_of_discs_in_the_plane_are_enclosed_by_finer_ones():
    scene, times = _bouncing(a=(0.0, 0.5), b=(0.05, 0.8)), [0.0, 0.3, 0.5]
    coarse, fine = (prove(scene, times, aim).proof for aim in (1e-18, 1e-40))
    assert len(coarse.impacts.times) == len(fine.impacts.times) >= 3
    assert fine.radius < 1e-40 < coarse.radius * 1e12
    with precision(400):
        pairs = zip(coarse.enclosures[-1], fine.enclosures[-1], strict=True)
        assert all(a.contains(b) for first, second in pairs for a, b in zip(first, second, strict=True))


def test_the_saltation_matrix_of_a_bounce(monkeypatch):
    """[[-e, 0], [-g (1 + e) / v, -e]] for height and speed v < 0 (di Bernardo et al., Piecewise-smooth Systems)."""
    found, original = [], Impacts._saltation
    monkeypatch.setattr(Impacts, "_saltation", lambda *given: found.append(original(*given)) or found[-1])
    proof = prove(_bouncing(a=(0.0, 0.5)), [0.0, 0.35]).proof
    assert len(found) == 1
    units, speed = list(map(float, proof.model.units)), -math.sqrt(2 * 9.81 * 0.4)
    matrix = np.array([[float(x) for x in row] for row in found[0].tolist()])
    assert matrix[2:4, 2:4] == pytest.approx(np.array([[-0.8, 0.0], [-9.81 * 1.8 / speed * units[1], -0.8]]))
    assert matrix[:2, :2] == pytest.approx(np.eye(2))


def test_a_grazing_contact_is_not_decided(monkeypatch):
    monkeypatch.setattr(integrate, "SHORTEST", Fraction(1, 64))
    scene = scenes.make("colliding_spheres")
    a, b = scene.bodies
    radii = {"radius_a": 0.125, "radius_b": 0.125}
    start = (-0.0625, 0.25, 0.0)  # m: the spheres touch as a passes b
    contact = scene.contacts[0].model_copy(update={"center_a": start, **radii})
    grazing = scene.model_copy(update={"bodies": (a.model_copy(update={"position": start}), b), "contacts": (contact,)})
    stopped = prove(grazing, [0.0, 0.1])
    assert stopped.proof.reached <= 0.0625
    assert "close" in stopped.log["reason"] or "grazing" in stopped.log["reason"]


def test_only_an_exhibited_motion_is_not_unique():
    names = ("n_four_bar", "spatial_n_four_bar", "slider_crank", "double_pendulum")
    assert [check(log_of(name)).model.is_exhibited for name in names] == [True, True, False, False]


def _changed(scene: Any, kind: str, part: int, **fields: Any) -> Any:
    parts = list(getattr(scene, kind))
    parts[part] = parts[part].model_copy(update=fields)
    return scene.model_copy(update={kind: tuple(parts)})


PENDULUM: Any = scenes.make("double_pendulum", angle_1=2.0, angle_2=1.5)
LOWER = PENDULUM.bodies[1]
WRONG_SOLVERS = {
    "a mass": _changed(PENDULUM, "bodies", 1, mass=LOWER.mass * (1 + 1e-12)),
    "a mass rounded down": _changed(PENDULUM, "bodies", 1, mass=math.nextafter(LOWER.mass, 0.0)),
    "an inertia": _changed(PENDULUM, "bodies", 1, inertia=LOWER.inertia * (1 + 1e-12)),
    "no inertia": _changed(PENDULUM, "bodies", 0, inertia=1e-6),
    "a centre": _changed(PENDULUM, "bodies", 1, position=(LOWER.position[0], LOWER.position[1] * (1 + 1e-12))),
    "a spin": _changed(PENDULUM, "bodies", 1, angular_velocity=1e-13),
    "gravity": PENDULUM.model_copy(update={"gravity": (0.0, -9.81 * (1 + 1e-12))}),
    "gravity's sign": PENDULUM.model_copy(update={"gravity": (0.0, 9.81)}),
    "a slanted gravity": PENDULUM.model_copy(update={"gravity": (1e-12, -9.81)}),
    "a pivot": _changed(PENDULUM, "joints", 0, point=(1e-13, 0.0)),
    "a missing joint": PENDULUM.model_copy(update={"joints": PENDULUM.joints[:1]}),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG_SOLVERS)
def test_a_wrong_motion_is_outside_by_a_theorem(what, right_end):
    wrong = prove(WRONG_SOLVERS[what], [0.0, 0.05], 1e-14).proof.enclosures[-1]
    pairs = zip(right_end, wrong, strict=True)
    assert any(not x.overlaps(y) for first, second in pairs for x, y in zip(first, second, strict=True))


@pytest.fixture(scope="module")
def right_end() -> Any:
    return prove(PENDULUM, [0.0, 0.05], 1e-14).proof.enclosures[-1]


def _turns(number: Any = np.float64, coriolis: float = 1.0, steps: int = 200) -> np.ndarray:
    """Return how far both rods of PENDULUM turn in 0.05 s, by RK4 on Lagrange's equations in numbers of a kind."""
    (one, two), (pivot, pin) = PENDULUM.bodies, (np.array(joint.point) for joint in PENDULUM.joints)
    arm, *centres = (np.subtract(a, b) for a, b in ((pin, pivot), (one.position, pivot), (two.position, pin)))
    length, c1, c2 = (float(np.hypot(*x)) for x in (arm, *centres))
    start = [math.atan2(x, -y) for x, y in centres]
    mixed, gravity = two.mass * length * c2, 9.81
    own = one.inertia + one.mass * c1**2 + two.mass * length**2, two.inertia + two.mass * c2**2

    def rate(y: np.ndarray) -> np.ndarray:
        turn, w = y[0] - y[1], y[2:] ** 2 * number(coriolis)
        mass = np.array([[own[0], mixed * np.cos(turn)], [mixed * np.cos(turn), own[1]]], number)
        force = -np.array([
            mixed * np.sin(turn) * w[1] + (one.mass * c1 + two.mass * length) * gravity * np.sin(y[0]),
            -mixed * np.sin(turn) * w[0] + two.mass * c2 * gravity * np.sin(y[1]),
        ], number)  # fmt: skip
        return np.concatenate([y[2:], np.linalg.solve(mass, force)]).astype(number)

    y, h = np.array([*start, 0.0, 0.0], number), number(0.05 / steps)
    for _ in range(steps):
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        y = (y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))).astype(number)
    return np.asarray(y[:2], np.float64) - start


WRONG_RUNS = {
    "a Coriolis term dropped": lambda: _turns(coriolis=0.0), "a Coriolis term doubled": lambda: _turns(coriolis=2.0),
    "single precision": lambda: _turns(np.float32), "steps too long": lambda: _turns(steps=2),
    "a digit changed": lambda: np.add(_turns(), (0.0, 1e-10)), "a sign": lambda: -_turns(),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG_RUNS)
def test_a_wrong_run_is_outside_by_a_theorem(what, right_end):
    """RK4 in 200 steps errs by less than 1e-12 rad; each wrong run is farther from the enclosure."""
    enclosed = np.array([float(own[3].mid()) for own in right_end])
    assert np.abs(_turns() - enclosed).max() < 1e-12
    assert np.abs(WRONG_RUNS[what]() - enclosed).max() > 1e-11


def test_an_enclosure_holds_a_finer_one():
    coarse, fine = proven("double_pendulum").proof, prove(scenes.make("double_pendulum"), TIMES, 1e-40).proof
    assert fine.radius < 1e-40 < coarse.radius
    with precision(400):
        pairs = zip(coarse.enclosures[-1], fine.enclosures[-1], strict=True)
        assert all(a.contains(b) for first, second in pairs for a, b in zip(first, second, strict=True))


def test_free_fall_is_exact():
    at_rest = scenes.make("double_pendulum")
    body = at_rest.bodies[0].model_copy(update={"velocity": (1.0, 2.0), "angular_velocity": 3.0})
    end = prove(at_rest.model_copy(update={"bodies": (body,), "joints": ()}), [0.0, 0.5]).proof.enclosures[-1][0]
    height = Fraction(body.position[1]) + 1 - Fraction(9.81) / 8
    with precision(400):
        assert end[1].contains(arb(fmpq(height.numerator, height.denominator)))
        assert end[3].contains(arb(1.5))


DOCTORED = {
    "a coefficient": lambda log: log["steps"][1][2][0].__setitem__(1, log["steps"][1][2][0][1] + (1 << 110)),
    "a start": lambda log: log["steps"][0][2][0].__setitem__(0, log["steps"][0][2][0][0] + (1 << 110)),
    "a step of no length": lambda log: log["steps"][2].__setitem__(1, 0),
    "an impact without contacts": lambda log: log["steps"][2].extend([1, 4]),
    "a step back in its window": lambda log: log["steps"][2].extend([-1, 4]),
    "infinite bits": lambda log: log.__setitem__("bits", math.inf),
    "a longer step": lambda log: log["steps"][2].__setitem__(0, log["steps"][2][0] * 2),
    "a negative step": lambda log: log["steps"][2].__setitem__(0, -log["steps"][2][0]),
    "a missing step": lambda log: log["steps"].pop(2),
    "a missing end": lambda log: log["steps"].pop(),
    "a smaller radius": lambda log: log.__setitem__("radius", log["radius"] / 2),
    "a missing row": lambda log: log["steps"][0][2].pop(),
    "a start value": lambda log: (
        log["system"]["starts"].__setitem__(0, len(log["system"]["lines"])),
        log["system"]["lines"].append(["c", 1, 1 << 60]),
    ),
    "a start at another line": lambda log: log["system"]["starts"].__setitem__(0, log["system"]["f"][1]),
    "an impact of no contact": lambda log: log["system"]["contacts"].append([0, 0, []]),
    "a heavier body": lambda log: log["scene"]["bodies"][0].__setitem__("mass", 1.000000000001),
    "no formulas": lambda log: log["system"].__setitem__("lines", []),
    "a word for a number": lambda log: log["steps"][0].__setitem__(1, "one"),
    "times backward": lambda log: log["times"].reverse(),
    "a singular unit": lambda log: log["system"].__setitem__("units", ["0", "1", "1"]),
}  # fmt: skip


@pytest.mark.parametrize("what", DOCTORED)
def test_a_doctored_log_is_refused(what):
    log = copy.deepcopy(log_of("double_pendulum"))
    DOCTORED[what](log)
    with pytest.raises(Refused):
        check(log)


@pytest.mark.parametrize("clock", [None, 0])
def test_a_doctored_clock_is_refused(clock):
    log = copy.deepcopy(log_of("driven_pendulum"))
    log["system"]["clock"] = clock
    with pytest.raises(Refused, match=r"is not time|do not move"):
        check(log)


def _rates(log: dict[str, Any]) -> list[arb]:
    """Return y' by a log's formulas at one point."""
    with precision(1000):
        formulas = Formulas(log["system"])
        y = [arb(k * k + 3) / 7 for k in range(formulas.n)]
        return formulas.run(formulas.f, [*y, *root(formulas, y)])


def test_a_wrong_impact_is_refused():
    """Each line of the impact of two spheres is changed in turn: a sign, or an operand; none passes."""
    log, lines = log_of("newtons_cradle"), log_of("newtons_cradle")["system"]["lines"]
    clearance, rate, changes = log["system"]["contacts"][0]
    system, wrong = Formulas(log["system"]), 0
    for k in system._plan((clearance, rate, *(place for _, place in changes))):
        operation, first, second = lines[k]
        if operation not in "+-*/":
            continue
        other = {"+": "-", "-": "+", "*": "+", "/": "*"}[operation]
        doctored = json.loads(json.dumps(log))
        doctored["system"]["lines"][k] = [other, first, second]
        wrong += 1
        with pytest.raises(Refused):
            check(doctored)
    assert wrong >= 8


@pytest.mark.parametrize("name", ["double_pendulum", "slider_crank", "spherical_pendulum", "torque_free_top"])
def test_a_wrong_equation_is_refused(name):
    """A sign of the equations is another, a term is dropped, or a constant differs in its last bit."""
    right, wrong = _rates(log_of(name)), 0
    lines = log_of(name)["system"]["lines"]
    signs = [k for k, line in enumerate(lines) if line[0] in "+-"]
    numbers = [k for k, line in enumerate(lines) if line[0] == "c" and line[2] > 2]
    zero, some = lines.index(["c", 0, 1]), [*signs[:: len(signs) // 8], *numbers[-2:]]
    for k, dropped in ((k, dropped) for k in some for dropped in (False, True)):
        log = copy.deepcopy(log_of(name))
        operation, first, second = log["system"]["lines"][k]
        other = ["-" if operation == "+" else "+", first, second]
        log["system"]["lines"][k] = [operation, first + 1, second] if k in numbers else other
        if dropped:
            log["system"]["lines"][k] = [operation, first, zero]
            if k in numbers or zero > k:
                continue
        try:
            if all(abs(float(a - b)) < 1e-100 for a, b in zip(right, _rates(log), strict=True)):
                continue  # a line on which the motion does not depend
        except Refused:
            continue  # no acceleration fulfils it
        wrong += 1
        with pytest.raises(Refused):
            check(log)
    assert wrong >= 3


def test_a_step_on_another_branch_is_refused():
    """Beyond the second step the distance is negative, so that attraction repels; each step alone is proven."""
    log, proof = copy.deepcopy(log_of("kepler")), Proof(log_of("kepler"))
    numerator, denominator, rows = log["steps"][0]
    proof.step(Fraction(numerator, denominator), rows)
    start = [[x] for x in (*proof.middle, *[-x for x in proof.z])]
    other = propose(proof.formulas, Fraction(1, 256), start, len(rows[0]) - 1, log["bits"])[0]
    with pytest.raises(Refused, match="box"):
        proof.step(Fraction(1, 256), rescaled(other, Fraction(1), log["bits"]))
    proof.z = [-x for x in proof.z]
    proof.step(Fraction(1, 256), rescaled(other, Fraction(1), log["bits"]))


WRONG_CHECKERS = {
    "no gyroscopic moment": ("torque_free_top", "_inertia", lambda old: lambda self, part, turn: [
        [old(self, part, turn)[0][0] * int(i == j) for j in range(3)] for i in range(3)]),
    "a wrong arm": ("double_pendulum", "offset", lambda old: lambda self, body, point: [
        x * 2 for x in old(self, body, point)]),
    "half a field": ("kepler", "well", lambda old: lambda *given: old(*given) / 2),
    "a wrong potential": ("double_pendulum", "potential", lambda old: lambda *given: 2 * old(*given)),
    "no damper": ("spring_pendulum", "_driven", lambda old: lambda *given: arb(0)),
    "a still drive": ("driven_pendulum", "signal", lambda old: lambda self, signal, t: 0 * t),
    "a wide clearance": ("newtons_cradle", "clearance", lambda old: lambda *given: 2 * old(*given)),
    "no impulse": ("newtons_cradle", "struck", lambda old: lambda self, part, states, rates, later: old(
        self, part, states, rates, rates)),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG_CHECKERS)
def test_a_wrong_equation_of_the_checker_is_detected(what, monkeypatch):
    name, method, wrong = WRONG_CHECKERS[what]
    monkeypatch.setattr(Mechanics, method, wrong(getattr(Mechanics, method)))
    with pytest.raises(Refused):
        check(log_of(name))


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [("pendulum", "length", 1.0), pytest.param("double_pendulum", "mass_2", 0.6, marks=pytest.mark.slow)],
)
def test_a_family_holds_its_members(name, parameter, value):
    def make(x: float) -> Any:
        return scenes.make(name, **{parameter: x})

    low, high = value - 1e-6, value + 1e-6
    (family,) = prove_family(make, low, high, TIMES)
    enclosures = check(json.loads(json.dumps(family.log))).enclosures
    assert family.proof.radius < 1e-5
    for member in (low, value + 3e-7, high):
        own = prove(make(member), TIMES).proof.enclosures[-1]
        pairs = zip(enclosures[-1], own, strict=True)
        assert all(a.contains(b) for first, second in pairs for a, b in zip(first, second, strict=True))
    beyond = prove(make(high + 1e-5), TIMES).proof.enclosures[-1]
    pairs = zip(enclosures[-1], beyond, strict=True)
    assert not all(a.overlaps(b) for first, second in pairs for a, b in zip(first, second, strict=True))


def _bounce(restitution: float = 0.8, speed: float = 0.0, height: float = 0.5) -> tuple[float, float]:
    """Return height (m) and velocity (m/s) of a disc of `_bouncing` after 0.35 s, in closed form, after one bounce."""
    g, t = 9.81, 0.35
    fast = math.sqrt(speed**2 + 2 * g * (height - 0.1))  # m/s, at touch-down
    late = t - (fast - speed) / g  # s, since then
    return 0.1 + restitution * fast * late - g * late**2 / 2, restitution * fast - g * late


BOUNCES = {
    "restitution": (0.8, lambda e: _bouncing(e, a=(0.0, 0.5)), lambda e: _bounce(restitution=e)),
    "height": (0.5, lambda h: _bouncing(a=(0.0, h)), lambda h: _bounce(height=h)),
    "speed": (0.5, lambda v: _bouncing(speed=v, a=(0.0, 0.5)), lambda v: _bounce(speed=v)),
}


@pytest.mark.parametrize("what", BOUNCES)
def test_a_family_of_bounces_is_enclosed_tightly(what):
    """The saltation matrix has a column of the parameter: the band is as wide as the closed form, to second order."""
    value, make, closed = BOUNCES[what]
    low, high = value - 1e-7, value + 1e-7
    (family,) = prove_family(make, low, high, [0.0, 0.35])
    ((_, y, *rest),) = check(json.loads(json.dumps(family.log))).enclosures[-1]
    for k, ball in enumerate((y, rest[7])):
        ends = closed(low)[k], closed(high)[k]
        assert float(ball.lower()) <= min(ends) + 1e-14
        assert float(ball.upper()) >= max(ends) - 1e-14
        assert 2 * float(ball.rad()) < abs(ends[1] - ends[0]) * 1.02
    own = prove(make(value + 3e-8), [0.0, 0.35]).proof.enclosures[-1][0]
    assert y.contains(own[1])


def test_a_family_of_speeds_keeps_its_width_through_three_impacts():
    """Between walls, a path of v t is folded: all members move by as much, and the band is 2 t dv wide."""

    def make(speed: float) -> Any:
        return scenes.make("disc_between_walls", law="rigid", speed=speed)

    (family,) = prove_family(make, 5.0 - 1e-5, 5.0 + 1e-5, [0.0, 0.5])
    x = family.proof.enclosures[-1][0][0]
    assert len(family.proof.impacts.times) == 3
    assert float(x.mid()) == pytest.approx(0.4, abs=1e-12)  # 0.4 + 0.8 + 0.8 + 0.5 = 2.5 m
    assert float(x.rad()) == pytest.approx(0.5e-5, rel=2e-3)


def test_a_family_of_masses_that_collide_is_enclosed():
    """A disc of mass m hits one of 1 kg at rest: v = (m - e) / (m + 1) and (1 + e) m / (m + 1) times its speed."""

    def make(mass: float) -> Any:
        scene = _bouncing(mass=mass, a=(0.0, 1.0), b=(0.5, 1.0))
        moving = scene.bodies[0].model_copy(update={"velocity": (2.0, 0.0)})
        return scene.model_copy(update={"bodies": (moving, scene.bodies[1]), "gravity": (0.0, 0.0)})

    low, high = 1.999, 2.001
    (family,) = prove_family(make, low, high, [0.0, 0.3])
    for own, closed in zip(family.proof.enclosures[-1], (lambda m: 2 * (m - 0.8), lambda m: 2 * 1.8 * m), strict=True):
        ends = [closed(m) / (m + 1) for m in (low, high)]
        assert float(own[8].lower()) <= min(ends) + 1e-14
        assert float(own[8].upper()) >= max(ends) - 1e-14
        assert 2 * float(own[8].rad()) < abs(ends[1] - ends[0]) * 1.02


def test_a_family_whose_order_of_impacts_differs_is_not_decided(monkeypatch):
    """Two discs fall side by side: which one touches first depends on the parameter."""
    monkeypatch.setattr(integrate, "HALVINGS", 1)
    monkeypatch.setattr(integrate, "ATTEMPTS", 5)
    monkeypatch.setattr(integrate, "SHORTEST", Fraction(1, 16))
    proofs = prove_family(lambda h: _bouncing(a=(0.0, h), b=(1.0, 0.5)), 0.4999, 0.5004, [0.0, 0.3])
    reached = [one.proof.reached for one in proofs]
    assert len(proofs) == 2
    assert (reached[0] < 0.29, reached[1] >= 0.3) == (True, True)
    assert "from 0.4999 to 0.50015" in proofs[0].log["reason"]


def test_a_family_whose_start_rates_vary_holds_its_members():
    """Closures decide the start rates of a slider-crank, and they differ among lengths of its rod."""

    def make(length: float) -> Any:
        return scenes.make("slider_crank", rod_length=length)

    (family,) = prove_family(make, 2.0 - 1e-6, 2.0 + 1e-6, [0.0, 0.05])
    enclosures = check(json.loads(json.dumps(family.log))).enclosures
    assert family.proof.radius < 1e-4
    own = prove(make(2.0 - 1e-6), [0.0, 0.05]).proof.enclosures[-1]
    pairs = zip(enclosures[-1], own, strict=True)
    assert all(a.contains(b) for first, second in pairs for a, b in zip(first, second, strict=True))


def _random_tree(dimension: int, seed: int, count: int = 5) -> Any:
    """Return a tree of bodies that are pinned to random earlier ones; in space by balls or by hinges."""
    dice = np.random.default_rng([seed, dimension])

    def away() -> np.ndarray:
        direction = dice.standard_normal(dimension)
        return 0.5 * direction / np.linalg.norm(direction)

    bodies, joints = [], []
    for k in range(count):
        parent = bodies[dice.integers(k)] if k else None
        pin = parent.position + away() if parent else np.zeros(dimension)
        place = {"name": f"b{k}", "mass": float(dice.uniform(0.5, 2.0)), "position": tuple((pin + away()).tolist())}
        moments = dice.uniform(0.05, 0.1, 3).tolist()
        ends = {"name": f"j{k}", "body_a": parent.name if parent else GROUND, "body_b": f"b{k}", "point": pin.tolist()}
        if dimension == 2:
            bodies.append(PlanarBody(**place, inertia=moments[0]))
            joints.append(Revolute(**ends))
        else:
            bodies.append(SpatialBody(**place, inertia=(*moments, 0.0, 0.0, 0.0)))
            hinge = Revolute(**ends, axis=dice.standard_normal(3).tolist())
            joints.append(hinge if dice.integers(2) else Spherical(**ends))
    gravity = (0.0, -9.81) if dimension == 2 else (0.0, 0.0, -9.81)
    return Scene(name="tree", bodies=tuple(bodies), joints=tuple(joints), gravity=gravity, duration=1.0)


@pytest.mark.parametrize("ends", [(GROUND, "a"), ("a", GROUND)])
def test_a_turning_slide_on_a_slanted_hinge_is_proven(ends):
    """The hinge's axis has length 1 to rounding alone; the start rates are the scene's rates along both axes."""
    axis, spin, slide = np.array([0.6, 0.0, 0.8]), 2.0, 0.7  # rad/s, m/s
    along, at = np.array([0.48, 0.6, -0.64]), np.array([0.3, 0.5, -0.2])
    turning = {"inertia": (0.1, 0.2, 0.15, 0.0, 0.0, 0.0), "angular_velocity": tuple((spin * axis).tolist())}
    a, b = (
        SpatialBody(name=name, mass=1.0, position=tuple(place.tolist()), velocity=tuple(speed.tolist()), **turning)
        for name, place, speed in (
            ("a", at, np.cross(spin * axis, at)),
            ("b", at + along, np.cross(spin * axis, at + along) + slide * along),
        )
    )
    hinge = Revolute(name="hinge", body_a=ends[0], body_b=ends[1], point=(0.0, 0.0, 0.0), axis=tuple(axis.tolist()))
    slider = Prismatic(name="slider", body_a="a", body_b="b", point=a.position, axis=tuple(along.tolist()))
    scene = Scene(name="slide", bodies=(a, b), joints=(hinge, slider), gravity=(0.0, 0.0, -9.81), duration=0.2)
    checked = check(json.loads(json.dumps(prove(scene, TIMES).log)))
    proof = as_truth(scene, checked.enclosures)
    run = simulate(scene, Settings(method="dop853", rtol=1e-12), np.array(TIMES))
    assert checked.radius < 1e-15
    assert max(farthest(scene, proof, run)[:2]) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 11, 12])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_random_tree_is_proven(dimension, seed):
    proof = prove(_random_tree(dimension, seed), [0.0, 0.5, 1.0], 1e-18)
    assert not proof.log["reason"]
    assert check(json.loads(json.dumps(proof.log))).radius < 1e-18


def test_lasting_contact_is_not_covered():
    with pytest.raises(NotCovered, match="contact floor"):
        prove(scenes.make("bouncing_ball"), TIMES)


def test_a_limit_of_time_states_how_far_the_proof_reaches():
    stopped = prove(scenes.make("pendulum_chain", links=3), [0.0, 5.0], limit=0.3)
    assert 0.0 < stopped.proof.reached < 5.0
    assert "limit" in stopped.log["reason"]


def test_a_kept_log_is_checked_again(tmp_path):
    scene = scenes.make("pendulum")

    def examined() -> dict[str, Any]:
        return examine(scene, np.array(TIMES), 1e-18, 60.0, tmp_path)[0]

    first, again = examined(), examined()
    assert first["truth"] == "inside"
    same = ("truth", "radius", "steps", "prover_s", "log_bytes")  # prover_s, too: the log is that of the first
    assert [again[key] for key in same] == [first[key] for key in same]
    ((made, times, aim),) = kept(tmp_path)
    assert (made.name, times.tolist(), aim >= first["radius"]) == ("pendulum", list(TIMES), True)
    (file,) = tmp_path.iterdir()
    log = read_log(file)
    log["steps"][1][2][0][1] += 1 << 110
    write_log(log, file)
    assert (examined()["truth"], str(file) in examined()["reason"]) == ("refused", True)


def test_stored_logs_are_checked_at_their_own_radius_and_times(tmp_path, monkeypatch):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "runs.sqlite"))
    examine(scenes.make("pendulum"), np.array(TIMES), 1e-9, 60.0, tmp_path / "proofs")
    (file,) = (tmp_path / "proofs").iterdir()
    stored = file.read_bytes()
    done = CliRunner().invoke(main, ["proofs", "--again", "--radius", "1e-25", "--json"])
    (row,) = json.loads(done.stdout)
    assert (done.exit_code, row["truth"], row["t_end"], file.read_bytes()) == (0, "inside", TIMES[-1], stored)
    for given in (["pendulum"], ["-p", "length=2"], ["--seed", "1"]):
        refused = CliRunner().invoke(main, ["proofs", "--again", *given])
        assert (refused.exit_code, "--again" in refused.output) == (2, True)


def test_a_proof_without_a_step_is_no_defect():
    stopped = CliRunner().invoke(main, ["prove", "pendulum", "--limit", "1e-6"])
    assert (stopped.exit_code, "not proven beyond t = 0 s" in stopped.output) == (1, True)


def test_the_command_proves_and_checks(tmp_path):
    file = str(tmp_path / "log.gz")
    done = CliRunner().invoke(main, ["prove", "pendulum", "--t-end", "0.2", "-o", file, "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["radius"] < 1e-15
    checked = CliRunner().invoke(main, ["prove", "--check", file])
    assert checked.exit_code == 0, checked.output
    (tmp_path / "log.gz").write_bytes(b"nothing")
    assert CliRunner().invoke(main, ["prove", "--check", file]).exit_code == 1


def test_a_radius_above_the_requested_one_fails_unless_a_family_is_enclosed(monkeypatch):
    """The prover reaches 1e-15 here, whatever is requested."""
    words = ["prove", "pendulum", "--t-end", "0.1", "--samples", "2"]
    family = CliRunner().invoke(main, [*words, "--radius", "1e-60", "--vary", "length=1+-1e-9"])
    assert family.exit_code == 0, family.output
    real = integrate.prove
    monkeypatch.setattr(integrate, "prove", lambda made, times, radius, *more: real(made, times, 1e-15, *more))
    assert CliRunner().invoke(main, words).exit_code == 0
    done = CliRunner().invoke(main, [*words, "--radius", "1e-60"])
    assert (done.exit_code, "above the requested 1.0e-60" in done.output) == (1, True)
    for end in ("0", "-1"):
        refused = CliRunner().invoke(main, ["prove", "pendulum", "--t-end", end])
        assert (refused.exit_code, f"--t-end {end}: a proof needs a duration > 0" in refused.output) == (2, True)
