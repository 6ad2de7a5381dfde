"""Symmetry as a judge: of our solver nothing is left but roundoff; a solver that breaks one is seen."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.conformance import symmetry
from cross_checks.conformance.cases import LABORATORY, SKY, Case, cases
from cross_checks.conformance.symmetry import BACK, SYMMETRIES, NotRunError, Violation, by_method, isolated, violations
from cross_checks.conformance.symmetry.placement import Placement, image
from cross_checks.isolation.parent import Isolated
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory

STEP, GAUSS = {"method": "rk4", "step": 1e-3}, {"method": "gauss", "rtol": 1e-13}
QUICK = [
    ("double_pendulum", {}, 1.0, STEP),  # chaos, as long as roundoff stays small
    ("n_four_bar", {}, 0.3, STEP),
    ("spring_pendulum", {}, 0.5, STEP),
    ("spatial_chain", {}, 0.3, STEP),
    ("torque_free_top", {}, 0.2, STEP),
    ("bouncing_ball", {}, None, STEP),
    ("oblique_disc", {}, None, STEP),
    ("newtons_cradle", {}, 0.3, STEP),
    ("bouncing_sphere", {}, None, STEP),
    ("rolling_sphere", {}, 0.3, STEP),
    ("colliding_spheres", {}, None, STEP),
    ("double_pendulum", {}, 1.0, {"method": "dop853", "rtol": 1e-11}),
    ("figure_eight", {}, 1.0, GAUSS),
    ("satellite", {}, 4000.0, GAUSS),
    ("solar_system", {"model": "gr_sun"}, 1e5, GAUSS),
    ("solar_system", {"model": "gr"}, 1e5, GAUSS),
]
FURTHER = {"newtons_cradle", "oblique_disc", "spatial_chain"}  # of QUICK, whose parts others have, too: slow
UNITS = {"other units", "other mass and length"}
# (engine, method, scene): symmetries that the engine breaks by more than it errs. MuJoCo's loop closures are soft
# within an absolute width, which no choice of units changes: 4e-5 m and 7e-5 m are left in 0.3 s.
KNOWN: dict[tuple[str, str, str], set[str]] = {
    ("mujoco", "rk4", "n_four_bar"): UNITS,
    ("mujoco", "euler", "n_four_bar"): UNITS,
    ("mujoco", "implicit", "n_four_bar"): {"other units"},
    ("mujoco", "implicitfast", "n_four_bar"): UNITS,
    **{("mjx", method, "n_four_bar"): UNITS for method in ("rk4", "euler", "implicitfast")},  # the same soft closures
    # REBOUND splits the motion about its first particle: with the Sun last, 7 km are left after 1e7 s
    ("rebound", "whfast", "outer_solar_system"): {"reordered"},
    ("rebound", "saba", "outer_solar_system"): {"reordered"},
}
STOPS = {  # runs that the engine does not finish at this step or tolerance
    ("exudyn", "tree_dopri5", "bouncing_ball")  # one of its runs does not come back
}


@cache
def left_of_ours(place: int) -> list[Violation]:
    """Return what is left of a case of QUICK, by our solver."""
    return left_of("mbs_ref", QUICK[place])


def left_of(engine: str, case: tuple) -> list[Violation]:
    name, parameters, t_end, chosen = case
    scene = scenes.make(name, **parameters)
    return violations(engines.get(engine), scene, Settings(t_end=t_end or scene.duration, **chosen))


@pytest.mark.parametrize("place", [
    pytest.param(place, id=f"{name}-{chosen['method']}", marks=[pytest.mark.slow] * (name in FURTHER))
    for place, (name, _, _, chosen) in enumerate(QUICK)
])  # fmt: skip
def test_our_solver_breaks_no_symmetry(place):
    found = left_of_ours(place)
    broken = [f"{each.symmetry}: {each.size:.1e} m, noise {each.noise:.1e} m" for each in found if each.is_broken]
    assert not broken
    assert sum(each.size is not None for each in found) >= 6


def test_each_symmetry_is_judged_on_some_quick_scene():
    found = [each for place in (2, 8) for each in left_of_ours(place)]
    judged = {each.symmetry for each in found if each.size is not None}
    assert judged == set(SYMMETRIES)


class Crooked(type(engines.get("mbs_ref"))):  # type: ignore[misc]
    """Our solver, but for a wind of 1e-9 m/s^2 along x, and a millimetre that is added where a body is called so."""

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        run = super().run(scene, settings, times)
        drift = np.zeros_like(run.position)
        drift[..., 0] = 0.5e-9 * run.times[:, None] ** 2
        if "z0" in scene.body_names:
            drift += 1e-3
        return replace(run, position=run.position + drift)


def test_a_solver_with_a_direction_or_a_favourite_name_is_seen():
    scene = scenes.make("spring_pendulum")
    found = {each.symmetry: each for each in violations(Crooked(), scene, Settings(t_end=0.5, **STEP))}  # type: ignore[abstract]
    assert {name for name, each in found.items() if each.is_broken} >= {"turned", "mirrored", "other units", "renamed"}
    assert not found["shifted"].is_broken
    assert found["renamed"].size == pytest.approx(1e-3 * np.sqrt(2.0), rel=1e-3)
    assert found["turned"].size == pytest.approx(2 * np.sin(0.35) * 0.5e-9 * 0.25, rel=1e-2)
    assert found["other mass and length"].size == pytest.approx(31 / 32 * 0.5e-9 * 0.25, rel=1e-2)


class Slanted(type(engines.get("mbs_ref"))):  # type: ignore[misc]
    """Our solver, whose velocities are off by a part of the step, as a first-order method's, and by a part for good."""

    def __init__(self, of_step: float, for_good: float) -> None:
        super().__init__()
        self.of_step, self.for_good = of_step, for_good

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        run = super().run(scene, settings, times)
        return replace(run, velocity=run.velocity + self.of_step * (settings.step or 0.0) + self.for_good)


@pytest.mark.parametrize(("of_step", "for_good", "broken"), [(1.0, 0.0, False), (0.0, 1e-3, True)])
def test_who_turns_back_takes_the_velocities_errors_along(of_step, for_good, broken):
    scene = scenes.make("spring_pendulum")
    found = violations(Slanted(of_step, for_good), scene, Settings(t_end=0.5, **STEP))  # type: ignore[abstract]
    (back,) = (each for each in found if each.symmetry == BACK)
    assert back.size > 1e-5
    assert back.exceeds_error == broken


def test_broken_symmetries_are_counted_not_cases():
    worse, mild = {"exceeds_error": True}, {"exceeds_error": False}
    cases = [("a", 9, [worse, mild, mild], ""), ("a", 8, [worse], ""), ("a", 0, [], "stops"), ("b", 7, [mild], "")]
    found = [{"engine": "quick", "method": method, "judged": judged, "broken": broken, "stopped": stopped}
             for method, judged, broken, stopped in cases]  # fmt: skip
    assert by_method(found) == [
        {"engine": "quick", "method": "a", "cases": 3, "stopped": 1, "judged": 17, "broken": 4, "beyond_error": 2},
        {"engine": "quick", "method": "b", "cases": 1, "stopped": 0, "judged": 7, "broken": 1, "beyond_error": 0},
    ]


def test_what_singles_out_a_direction_is_not_judged_by_turning():
    scene = scenes.make("satellite", drag=True)
    found = violations(engines.get("mbs_ref"), scene, Settings(t_end=1000.0, **GAUSS))
    reasons = [each.reason for each in found if each.symmetry == "turned"]
    assert reasons == ["drag: singles out a place, a direction or a date"]


def test_a_run_that_does_not_finish_judges_nothing():
    with pytest.raises(NotRunError, match="beyond what rk4 can bear"):
        left_of("mbs_ref", ("block_stack", {}, 0.05, STEP))


def test_an_image_of_an_image_is_the_scene():
    scene = scenes.make("bouncing_sphere")
    there = Placement(np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3.0, np.array([1.0, 2.0, 3.0]), 2.0, 4.0, 8.0)
    back = Placement(there.matrix.T, -there.length * there.matrix.T @ there.shift, 0.5, 0.25, 0.125)
    again = image(image(scene, there), back)
    assert again.contacts[0].law == scene.contacts[0].law
    assert np.array(again.bodies[0].position) == pytest.approx(np.array(scene.bodies[0].position), abs=1e-14)
    assert np.array(again.gravity) == pytest.approx(np.array(scene.gravity), abs=1e-14)


@pytest.fixture(scope="module")
def child():
    with Isolated() as call:
        yield call


@cache
def cases_of(engine: str) -> list[Case]:
    return list(cases([engine]))


@pytest.mark.slow
@pytest.mark.parametrize("scene", [name for name, *_ in (*LABORATORY, *SKY)])
@pytest.mark.parametrize("engine", engines.names()[1:])
def test_every_engine_breaks_what_it_is_known_to_break(engine, scene, child):
    """Beyond its own error, that is: methods that carry accelerations, or turn by parameters, break some within it."""
    wrong = {}
    for case in cases_of(engine):
        key = (engine, case.method, scene)
        if case.scene == scene:
            found = isolated(case, child)
            broken = {each["symmetry"] for each in found["broken"] if each["exceeds_error"]}
            if (bool(found["stopped"]), broken) != (key in STOPS, KNOWN.get(key, set())):
                wrong[case.name] = found
    assert not wrong


def test_a_run_is_cut_or_turned_back_unless_that_very_change_has_an_obstacle(monkeypatch):
    monkeypatch.setattr(symmetry.place, "cut_obstacle", lambda scene, back: f"back: {back}")
    nothing: Any = None
    assert symmetry._cut(nothing, nothing, nothing, nothing) == "back: False"
    assert symmetry._there_and_back(nothing, nothing, nothing, nothing) == "back: True"


def test_what_is_left_of_a_symmetry_is_seen_beside_the_runs_own_error(monkeypatch):
    """A way back also carries the error of its velocities for as long as the run; one that is not run says why."""
    still = np.zeros((3, 1, 2))
    plain = Trajectory(np.array([0.0, 1.0, 2.0]), still, still[..., 0], still, still[..., 0])
    finer: list[Any] = []
    monkeypatch.setattr(symmetry, "_run", lambda engine, scene, settings, times: finer.append(settings) or plain)
    monkeypatch.setattr(symmetry, "_noise", lambda *given: 0.125)
    monkeypatch.setattr(symmetry, "_gap", lambda scene, run, wanted: (0.25, 0.5))
    broken = {name: lambda *given, k=k: 2.0**k for k, name in enumerate(("turned", symmetry.BACK))}
    monkeypatch.setattr(symmetry, "SYMMETRIES", {**broken, "cut": lambda *given: "it has signals"})
    scene = scenes.make("pendulum")
    found = symmetry.violations(None, scene, Settings(method="rk4", step=0.5, t_end=2.0))  # type: ignore[arg-type]
    assert found == [
        symmetry.Violation("turned", 1.0, 0.125, 0.25), symmetry.Violation(symmetry.BACK, 2.0, 0.125, 0.25 + 2.0 * 0.5),
        symmetry.Violation("cut", None, 0.125, 0.25, "it has signals")]  # fmt: skip
    assert [one.step for one in finer] == [0.5, 0.25]
