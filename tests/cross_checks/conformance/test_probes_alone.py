"""Parts of the examination: what its scenes hold, what its broken engines break, and what counts as noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.conformance import examine, ladder, plugin
from cross_checks.conformance import symmetry as violation
from cross_checks.conformance.broken_engines import _dead_on_welds, _late, mistakes
from cross_checks.conformance.cases import Case
from cross_checks.conformance.probes import NORMALS, RADIUS, _on_floor, bounces, probes
from cross_checks.engine.plan import initial_sample
from mbs_ref import scenes
from mbs_ref.scene import Weld
from mbs_ref.scene.contact import RigidLaw
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Trajectory

RNG = np.random.default_rng(6)


def motion(scene: Any, times: np.ndarray) -> Trajectory:
    n, b, d = len(times), len(scene.bodies), scene.dimension
    turns, spins = ((4,), (3,)) if d == 3 else ((), ())
    return Trajectory(times, *(RNG.normal(size=(n, b, *shape)) for shape in ((d,), turns, (d,), spins)))


def test_a_bounce_has_the_part_that_it_is_for():
    for kind, scene in bounces():
        assert (kind, scene.dimension) in probes()
        (contact,) = scene.contacts
        assert kind in (contact.type, contact.law.type)
        assert len(scene.bodies) == 1 + ("on_circle" in contact.type or "on_sphere" in contact.type)


def test_every_broken_engine_differs_from_the_good_one_somewhere():
    listed = [
        *(*probes().values(), *(scene for _, scene in bounces())),
        scenes.make("pendulum"),
        scenes.make("n_four_bar"),
    ]
    times = np.linspace(0.0, 1.0, 5)
    for mistake in mistakes():
        changes = any(mistake.change(scene) != scene for scene in listed)
        spoils = False
        for scene in listed[-4:]:
            path = motion(scene, times)
            path = replace(path, timing=replace(path.timing, loop_s=1.0))
            spoiled = mistake.spoil(scene, path)
            spoils |= any(not np.array_equal(getattr(spoiled, name), getattr(path, name)) for name in (
                "times", "position", "orientation", "velocity", "angular_velocity"))  # fmt: skip
            spoils |= spoiled.timing.loop_s != 1.0
        assert changes or spoils or mistake.run.__name__ != "<lambda>", mistake.name


def test_an_engine_that_a_weld_stops_runs_without_one():
    good: Any = SimpleNamespace(run=lambda scene, settings, times: motion(scene, times))
    times = np.linspace(0.0, 1.0, 3)
    plain = scenes.make("pendulum")
    weld = Weld(name="weld", body_a="ground", body_b="rod", point=(0.0, 0.0))
    welded = plain.model_copy(update={"joints": (weld,)})
    assert _dead_on_welds(good, plain, Settings(), times).ok
    assert _dead_on_welds(good, welded, Settings(), times).status is Status.NON_FINITE


@pytest.mark.parametrize("settings", [Settings(method="rk4", step=0.04), Settings(method="rk4", step=0.5), Settings()])
def test_a_late_engine_gives_states_of_earlier_times(settings):
    asked: list[np.ndarray] = []
    good: Any = SimpleNamespace(run=lambda scene, settings, times: asked.append(times) or motion(scene, times))
    times = np.array([0.0, 0.3, 0.7])
    path = _late(good, scenes.make("pendulum"), settings, times)
    assert np.array_equal(path.times, times)
    assert asked[0][0] == 0.0
    assert (asked[0][1:] < times[1:]).all()
    assert (asked[0][1:] > 0.0).all()


def test_a_deviation_counts_by_the_finest_run(monkeypatch):
    """An error within roundoff by chance at a coarse step does not acquit a finer run that is not."""
    made: Any = SimpleNamespace(runs=[1, 2, 3], bar=0.0, posterior=lambda *given: None)
    monkeypatch.setattr(ladder, "_sentence", lambda what, shown, errors, floor, bar: f"off by {errors}")
    curves = [np.array([error]) for error in (1e-3, 1e-16, 1e-5)]
    assert ladder._Rungs.deviation(made, "energy", curves, 1e-12) == "off by [0.001, 1e-16, 1e-05]"
    assert ladder._Rungs.deviation(made, "energy", curves, 1e-4) == ""


@pytest.mark.parametrize(("nudge", "tolerance"), [(1e-3, 1e-2), (1e-2, 1e-3)])
def test_noise_is_the_largest_of_a_nudge_and_of_another_tolerance(nudge, tolerance):
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 3)
    plain = motion(scene, times)

    def run(scene, settings, times):
        offset = nudge if scene.name == "nudged" else tolerance if settings.rtol != 1e-6 else 0.0
        return replace(plain, position=plain.position + offset * np.array([0.6, 0.8]))

    engine: Any = SimpleNamespace(name="made", run=run)
    assert violation._noise(engine, scene, Settings(rtol=1e-6), times, plain) == pytest.approx(1e-2)


def test_an_engine_that_runs_nothing_does_not_conform(monkeypatch):
    for name in ("_identity", "_refusal", "_inconsistent", "_unknown_method"):
        monkeypatch.setattr(examine, name, lambda *given: "")
    for questioned, outcome in (([], "failed"), (["one"], "passed")):
        found = {one.question: one.outcome for one in examine._whole(None, "made", questioned)}  # type: ignore[arg-type]
        assert found["something runs"] == outcome


def test_a_symmetry_that_does_not_apply_is_not_judged(monkeypatch):
    sizes = {"turned": 1.0, "mirrored": None, "shifted": 1e-9, "renamed": None, "reordered": 1e-3}
    found = [violation.Violation(name, size, 1e-6, 1e-2) for name, size in sizes.items()]
    monkeypatch.setattr(violation, "violations", lambda *given: found)
    facts = violation.facts(Case("mbs_ref", "rk4", "pendulum", {}, Settings(method="rk4", step=0.1)))
    assert (facts["judged"], facts["stopped"]) == (3, "")
    assert [(one["symmetry"], one["exceeds_error"]) for one in facts["broken"]] == [
        ("turned", True), ("reordered", False)]  # fmt: skip


def test_symmetries_of_a_method_are_added_over_its_cases():
    def case(method: str, judged: int, beyond: list[bool], stopped: str = "") -> dict[str, Any]:
        return {"engine": "e", "method": method, "judged": judged, "stopped": stopped,
                "broken": [{"exceeds_error": one} for one in beyond]}  # fmt: skip

    rows = violation.by_method([case("m", 3, [True, False]), case("n", 2, []), case("m", 5, [False], "stops")])
    assert rows == [
        {"engine": "e", "method": "m", "cases": 2, "stopped": 1, "judged": 8, "broken": 3, "beyond_error": 1},
        {"engine": "e", "method": "n", "cases": 1, "stopped": 0, "judged": 2, "broken": 0, "beyond_error": 0},
    ]


def rising(scene: Any, paths: list[Trajectory], **more: Any) -> Any:
    """Return runs of one method on a scene, as an examination holds them."""
    method = SimpleNamespace(name="made", roundoff=1e-16, rounding=lambda steps: 1e-15, kind="fixed", order=4)
    runs = [SimpleNamespace(setting=f"run {k}", path=path, settings=Settings(step=0.1)) for k, path in enumerate(paths)]
    question = SimpleNamespace(scene=scene, times=paths[0].times, truth=None)
    held = {"deviation": lambda what, curves, floor, size=None: f"{what} {floor:.3g}", "bar": 0.5, "shown": None}
    return SimpleNamespace(method=method, runs=runs, question=question, errors=[1e-3, 1e-4], **(held | more))


def test_what_no_weakness_exempts(monkeypatch):
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 5)
    start = initial_sample(scene)
    paths = [motion(scene, times) for _ in range(2)]
    for path in paths:
        for name in ("position", "orientation", "velocity", "angular_velocity"):
            getattr(path, name)[0] = getattr(start, name)[0]
    sure = iter((3.0, 0.5))
    monkeypatch.setattr(ladder, "slope_misses", lambda *given: (np.zeros((1, 1)), next(sure)))
    monkeypatch.setattr(ladder, "impossible_time", lambda runs: "")
    assert dict(ladder._always(rising(scene, paths)))["start"] == ""
    sure = iter((3.0, 0.5))
    paths[1].position[0, 0, 0] += 1e-6 * scales_of(scene).length
    found = dict(ladder._always(rising(scene, paths)))
    assert found["start"].startswith("the first sample is off: position by 1.0e-06")
    assert found["velocities"].endswith(" 5")  # ten times what the finest run's slopes are sure to
    assert found["asked times"] == ""


def test_errors_below_what_the_truth_knows_do_not_count(monkeypatch):
    floors: list[float] = []
    monkeypatch.setattr(ladder, "_sentence", lambda what, shown, errors, floor, bar: floors.append(floor) or "")
    for name in ("energy_drift", "joint_gaps"):
        monkeypatch.setattr(ladder, name, lambda *given: None)
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 3)
    for known in (0.25, 0.0):
        monkeypatch.setattr(ladder, "known_to", lambda scene, truth, known=known: known)
        list(ladder._exemptible(rising(scene, [replace(motion(scene, times), steps=9)] * 2)))
    assert floors == [pytest.approx(0.25 * ladder.ONE_FIGURE), ladder.GOOD]


def test_unresolved_motions_are_run_with_ever_half_the_step(monkeypatch):
    steps: list[float] = []

    def called(engine: Any, scene: Any, settings: Settings, times: np.ndarray) -> Any:
        steps.append(settings.step or 0.0)
        return SimpleNamespace(path=motion(scene, times), settings=settings)

    monkeypatch.setattr(ladder, "called", called)
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 3)
    question: Any = SimpleNamespace(scene=scene, times=times, truth=None)
    runs: Any = (SimpleNamespace(path=motion(scene, times), settings=Settings(step=0.1)),)

    @dataclass(frozen=True)
    class Open:
        question: Any
        runs: Any
        shown: Any = None
        bar: float = 0.5
        errors: tuple[float, ...] = (1.0,)

    found = ladder._refined(None, Open(question, runs))  # type: ignore[arg-type]
    assert steps == [0.1 * 0.5**k for k in range(1, ladder.MORE + 1)]
    assert len(found.runs) == 1 + ladder.MORE


def test_runs_that_fail_are_no_rungs(monkeypatch):
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 3)
    good = motion(scene, times)
    bad = replace(good, status=Status.NON_FINITE, message="NaN arose")
    answers = iter((good, bad, bad))
    monkeypatch.setattr(ladder, "rungs", lambda *given, **more: [Settings(step=0.1)] * 3)
    monkeypatch.setattr(ladder, "called", lambda *given: SimpleNamespace(path=next(answers), setting="h"))
    monkeypatch.setattr(ladder._Rungs, "row", lambda self: len(self.runs))
    method: Any = SimpleNamespace(name="made", exemption=lambda scene: "", kind="fixed", order=4)
    question: Any = SimpleNamespace(scene=scene, times=times, truth=None, is_smooth=True)
    (finding,), rungs = ladder.climb(None, method, question)  # type: ignore[arg-type]
    assert rungs == 1
    assert finding.detail == "fewer than two runs end: h: NaN arose; h: NaN arose"
    assert finding.exemption == ladder.ALOUD  # what stops before the end says so
    answers, method.exemption = iter((good, bad, bad)), lambda scene: "springs hold its loops"
    ((finding,), _) = ladder.climb(None, method, question)  # type: ignore[arg-type]
    assert finding.exemption == "springs hold its loops"


@pytest.mark.parametrize("verdict", ["agrees", "departs", "no truth"])
def test_a_test_fails_unless_a_motion_agrees(monkeypatch, verdict):
    monkeypatch.setattr("cross_checks.judge", lambda *given, **more: SimpleNamespace(verdict=verdict))
    wrapped: Any = plugin.mbs_judge
    agrees = (wrapped._get_wrapped_function() if hasattr(wrapped, "_get_wrapped_function") else wrapped.__wrapped__)()
    if verdict == "agrees":
        assert agrees("a").verdict == verdict
        return
    with pytest.raises(pytest.fail.Exception):
        agrees("a")


def test_the_floor_of_a_plane_probe_is_a_line_across_its_normal():
    floor: Any = _on_floor(RigidLaw(restitution=0.5), 2).contacts[0]
    along, normal = np.subtract(floor.point_2, floor.point_1), np.array(NORMALS[2])
    assert along @ normal == pytest.approx(0.0, abs=1e-15)
    assert along[0] * normal[1] - along[1] * normal[0] == pytest.approx(RADIUS)  # the free side is on the left


@pytest.mark.parametrize("scene", [scenes.make("n_four_bar", loops=2), scenes.make("bricard")], ids=["plane", "space"])
def test_every_mistake_of_a_scene_changes_what_its_name_says_and_in_its_dimension(scene):
    by_name = {mistake.name: mistake for mistake in mistakes()}
    joints = by_name["dropped joint"].change(scene).joints
    assert joints == scene.joints[: len(scene.joints) - 1]
    for name, dimensions in (("hidden damping", {2}), ("sliders that do not slide", {3})):
        changed = by_name[name].change(scene) != scene
        assert not changed or scene.dimension in dimensions, name
    loads = by_name["hidden damping"].change(scene).loads
    assert len(loads) == len(scene.loads) + (scene.dimension == 2)
    gravity = by_name["gravity off by a thousandth"].change(scene).gravity
    assert gravity == pytest.approx([1.001 * part for part in scene.gravity])
    bodies = by_name["inertia in wrong axes"].change(scene).bodies
    for one, other in zip(bodies, scene.bodies, strict=True):
        assert (one.inertia == other.inertia) == (scene.dimension == 2)
    path = motion(scene, np.linspace(0.0, 1.0, 3))
    for name, dimension in (("angular velocities in body axes", 3), ("angles wrong, positions right", 2)):
        spoiled = by_name[name].spoil(scene, path)
        assert (spoiled is path) == (scene.dimension != dimension), name
