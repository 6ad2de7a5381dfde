"""Figures of the papers' studies from random runs: each is recomputed from the run of its own scene and setting."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.records.numbers import metres, short
from cross_checks.records.record import Record
from mbs_ref import Scene, Settings, scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import SpringDamper
from mbs_ref.scenes.solar_system import julian_date
from mbs_ref.trajectory import Status, Timing, Trajectory
from reports.facts.curves import Measured
from reports.studies import crash, document, pairs, papers, sky, study, trust
from reports.studies.papers import crash_figures, lessons, track_figures
from reports.studies.sky import frames

N = 7


class Runs:
    """Random runs, one for each scene and setting: the same again for the same request."""

    def __init__(self, seed: int) -> None:
        self.rng, self.made, self.scene_of = np.random.default_rng(seed), {}, {}

    def __call__(self, scene: Scene, settings: Settings | None = None, times: np.ndarray | None = None) -> Trajectory:
        given = settings or Settings()
        about = (scene.name, str(sorted(scene.parameters.items())), len(scene.contacts), given.method, given.step)
        key = str((*about, given.rtol, given.stop_on_compliance, given.coordinates, given.stabilization))
        if key not in self.made:
            self.made[key] = self._run(scene, times)
            self.scene_of[id(self.made[key])] = scene
        return self.made[key]

    def _run(self, scene: Scene, times: np.ndarray | None) -> Trajectory:
        rng, n = self.rng, N if times is None else len(times)
        turns = ((), ()) if scene.dimension == 2 else ((4,), (3,))
        shapes = (scene.dimension,), turns[0], (scene.dimension,), turns[1]
        state = [rng.normal(size=(n, len(scene.bodies), *shape)) for shape in shapes]
        contacts = {part.name: rng.normal(size=(n, 5)) for part in scene.contacts}
        steps = np.column_stack((np.arange(n), rng.uniform(1e-9, 1e-3, n)))
        when = np.cumsum(rng.uniform(0.1, 0.3, n)) if times is None else times
        return Trajectory(
            when, *state, contacts=contacts, step_compliance=steps, message=f"message {rng.random():.6f}",
            steps=int(rng.integers(10**6)), rhs_calls=int(rng.integers(10**6)), events=int(rng.integers(10**3)),
            method_switches=int(rng.integers(99)), timing=Timing(build_s=rng.random(), loop_s=rng.random()),
        )  # fmt: skip


def gap(one: Trajectory, other: Trajectory) -> float:
    """Return the largest distance of places, m."""
    return float(np.linalg.norm(one.position - other.position, axis=2).max())


def largest_gap(path: Trajectory) -> float:
    assert path.step_compliance is not None
    return max(path.step_compliance[:, 1])


@pytest.fixture
def ran(monkeypatch) -> Runs:
    """Let random runs be those of the studies."""
    runs = Runs(5)
    for module in (crash_figures, track_figures, lessons, papers):
        monkeypatch.setattr(module, "simulate", runs)
    for module in (crash_figures, lessons):
        monkeypatch.setattr(module, "finished", runs)
    return runs


def results(path: Trajectory) -> Any:
    """Return results of a crash that tell whose they are."""
    rng = np.random.default_rng(path.steps)
    shape = (*path.position.shape[:2], 3)
    forces = SimpleNamespace(external=rng.normal(size=shape), constraint=rng.normal(size=shape))
    return SimpleNamespace(
        forces=forces, measures={"HIC36": rng.random(), "Nij": rng.random()}, neck_moment=rng.normal(size=N)
    )


def test_the_crash_of_the_first_paper(monkeypatch, ran):
    pulls: dict[str, np.ndarray] = {}
    tests: dict[str, tuple[Trajectory, Trajectory, float | None]] = {}

    def tension(motion: Any, load: Any) -> np.ndarray:
        return pulls.setdefault(load.name, np.maximum(0.0, ran.rng.normal(size=N)))

    def with_test(scene: Scene, settings: Settings) -> tuple[Trajectory, Trajectory, float | None]:
        path, test = ran(scene, settings), ran(scene, settings.model_copy(update={"stop_on_compliance": True}))
        ends = {"rk4": (Status.COMPLIANCE, 1e-3), "euler": (Status.SUCCESS, None), "lsodar": (Status.COMPLIANCE, 2e-4)}
        status, error = ends[str(settings.method)]
        key = f"{scene.name.removeprefix('android_')}.{settings.method}"
        tests[key] = path, replace(test, status=status), error
        assert settings.events == ("located" if settings.method == "lsodar" else "none")
        return tests[key]

    monkeypatch.setattr(crash_figures, "tension", tension)
    monkeypatch.setattr(crash_figures, "with_test", with_test)
    monkeypatch.setattr(crash_figures, "crash_results", lambda scene, path: results(path))
    monkeypatch.setattr(crash_figures, "deepest", lambda scene, path: float(path.steps))
    monkeypatch.setattr(crash_figures, "film", lambda scene, path, every: f"{scene.name} every {every}")
    found = crash_figures.measure_crash()
    expected: dict[str, Any] = {}
    built = {kind: scenes.make(f"android_{kind}", **crash.PAPER) for kind in ("simplified", "vertebral")}
    path, scene = ran(built["simplified"]), built["simplified"]
    for kind in built:
        for impact in ("front", "rear"):
            expected[f"{kind}.{impact}.believable_deepest"] = ran(scenes.make(f"android_{kind}", impact=impact)).steps
        for restraint in ("integral", "separate", "none"):
            own = results(ran(scenes.make(f"android_{kind}", impact="rear", head_restraint=restraint)))
            expected |= {f"{kind}.rear.{restraint}.{name}": value for name, value in own.measures.items()}
            expected[f"{kind}.rear.{restraint}.neck_least"] = own.neck_moment.min()
    for name, (run, test, error) in tests.items():
        expected |= {
            f"{name}.status": "success", f"{name}.test": "fails" if test.status is Status.COMPLIANCE else "keeps",
            f"{name}.until": test.times[-1], f"{name}.compliance": largest_gap(run), f"{name}.steps": run.steps,
            f"{name}.error": run.message if error is None else error, f"{name}.switches": run.method_switches,
        }  # fmt: skip
    assert tests.keys() == {"simplified.rk4", "simplified.euler", "simplified.lsodar", "vertebral.rk4"}
    force = {name: np.sqrt(own[:, 1] ** 2 + own[:, 2] ** 2) for name, own in path.contacts.items()}
    belts = [load for load in scene.loads if isinstance(load, SpringDamper)]
    back = [own for name, own in force.items() if name.endswith(".seat_back")] + [pulls[belt.name] for belt in belts]
    expected["seat_back.parts"] = len(back)
    expected["seat_back.changes"] = sum((a > 0.0) != (b > 0.0) for own in back for a, b in pairwise(own))
    expected |= {f"foot.{end}": force[f"foot.{end}.floor"].max() for end in ("heel", "ball")}
    types = {"revolutes": "revolute", "restoring": "torsion_spring", "tissue": "point_bushing"}
    parts = [part.type for part in (*built["vertebral"].joints, *built["vertebral"].loads)]
    expected |= {f"parts.{name}": parts.count(kind) for name, kind in types.items()}
    held = {kind: results(ran(own)).forces.constraint for kind, own in built.items()}
    motion, pull = Motion(scene, path), np.zeros((N, 2))
    for belt in belts:
        way = motion.point(belt.body_a, belt.point_a)[0] - motion.point(belt.body_b, belt.point_b)[0]
        pull += pulls[belt.name][:, None] * way / np.linalg.norm(way, axis=1)[:, None]
    strongest = max(pull, key=lambda row: math.hypot(*row))
    sizes = [np.linalg.norm(held["simplified"][:, scene.body_index(name), :2], axis=1) for name in
             ("head", "thorax", "lumbar")]  # fmt: skip
    neck = [held["vertebral"][:, built["vertebral"].body_index(name), 0] for name in
            ("head", "C1", "C2", "C3", "C4", "C5", "C6")]  # fmt: skip
    rising = sum(min(x) < 0.0 < max(x) and list(x).index(min(x)) < list(x).index(max(x)) for x in neck)
    expected |= {
        "start.gap": abs(path.contacts["bottom.buttock.seat_base"][0, 0]), "start.speed": abs(path.velocity[0]).max(),
        "rising.backward": strongest[0], "rising.downward": strongest[1], "rising.neck": rising,
        "rising.start": max(x[0] for x in sizes), "rising.least": min(max(x) for x in sizes),
    }  # fmt: skip
    expected["vertebral.rk4.refusal"] = ran(built["vertebral"], Settings(method="rk4", step=1e-4)).message
    rough = Settings(rtol=1e-6, samples=41, estimate="off")
    one, other = ran(scene, rough), ran(scenes.make(scene.name, law="constraint", **crash.PAPER), rough)
    expected |= {"contacts.steps": one.steps, "constraints.steps": other.steps, "constraints.status": "success",
                 "constraints.apart": gap(one, other)}  # fmt: skip
    fine = Settings(rtol=1e-12)
    flat, oblique = ran(scene, fine), ran(scenes.make("android_spatial", **crash.PAPER), fine)
    straight = ran(scenes.make("android_spatial", oblique=0.0, **crash.PAPER), fine)
    within = np.linalg.norm(straight.position[:, :, :2] - flat.position, axis=2).max()
    expected |= {"spatial.apart": within, "spatial.time": straight.timing.loop_s / flat.timing.loop_s,
                 "spatial.sideways": abs(oblique.position[:, 0, 2]).max()}  # fmt: skip
    assert found.figures == pytest.approx(expected)
    figures = {"Fig. 3, external forces Q_e": ("simplified", "external"),
               "Fig. 4, constraint forces and torques Q_c": ("simplified", "constraint"),
               "Fig. 5, head and neck constraint forces Q_c": ("vertebral", "constraint")}  # fmt: skip
    for title, (kind, field) in figures.items():
        values = getattr(results(ran(built[kind])).forces, field)
        for c, part in enumerate(("x", "y", "torque")):
            for body, line in found.curves[f"{title}: {part}"].lines.items():
                assert line == pytest.approx(values[:, built[kind].body_index(body), c], rel=1e-5)
    assert len(found.curves) == 9
    assert list(found.films) == ["Fig. 1", "Fig. 2", "Fig. 2, joints that stop and parts that touch"]


def test_outlines_are_where_the_parts_are(ran):
    """Every moment but the first draws the seats, and each part with its own radius where its ends are."""
    tables = crash_figures.outline_pictures()
    assert len(tables) == 5
    title = "outlines: 13 bodies, rear, bare"
    scene = scenes.make("android_simplified", impact="rear", **crash.PAPER)
    path = ran(scene, crash_figures.RUN)
    motion, shapes = Motion(scene, path), crash_figures.outlines("android_simplified")
    assert sorted({row["time"] for row in tables[title]}) == path.times[1:].tolist()
    for k, time in enumerate(path.times.tolist()):
        own = [row for row in tables[title] if row["time"] == time]
        drawn = {(row["x1"], row["y1"], row["x2"], row["y2"]): row for row in own}
        for shape in shapes if k else ():
            ends = [motion.point(shape.body, end)[0][k] for end in shape.ends]
            row = drawn[tuple(round(float(x), 4) for end in ends for x in end)]
            assert row["radius"] == shape.radius
            assert row["kind"] == ("arm" if shape.body in ("upper_arm", "lower_arm", "hand") else "body")
        seats = {part.body_b for part in scene.contacts if part.name.endswith((".seat_base", ".seat_back"))}
        assert sum(row["kind"] == "seat" for row in own) == len(seats) * bool(k)


@pytest.mark.slow
def test_the_track_of_the_second_paper(monkeypatch, ran):
    monkeypatch.setattr(track_figures, "film", lambda scene, path, every: "film")
    monkeypatch.setattr(track_figures, "rolling_slip", lambda motion, wheel: slips[wheel])
    rng = np.random.default_rng(8)
    slips = {wheel: rng.normal(size=N) for wheel in ("idler", "roller1", "roller2", "roller3")}
    slips["roller1"][2] = np.nan
    get = lambda name: SimpleNamespace(run=lambda scene, settings, times: replace(  # noqa: E731
        ran(scene, settings, times), steps=0))  # fmt: skip
    monkeypatch.setattr(track_figures.engines, "get", get)
    ridden: list[Trajectory] = []
    monkeypatch.setattr(track_figures, "_own_contacts", lambda scene, path: ridden.append(path) or {"track.own": 7.0})
    found = track_figures.measure_track()
    scene, bare = scenes.make("tracked_vehicle"), scenes.make("tracked_vehicle", model="paper")
    times = np.linspace(0.0, 0.5, 26)
    fine = ran(scene, Settings(method="rk4", step=5e-5), times)
    expected: dict[str, Any] = {}
    for method, more, papers_own in (("rk4", {"step": 1e-4}, True), ("euler", {"step": 1e-5}, True),
                                     ("lsodar", {"rtol": 1e-6}, True), ("dop853", {"rtol": 1e-8}, False),
                                     ("generalized_alpha", {"step": 1e-4}, False)):  # fmt: skip
        held: dict[str, Any] = {"stabilization": "none"} if papers_own else {}
        settings = Settings(method=method, **more, **held).model_copy(update={"stop_on_compliance": papers_own})
        path = ran(scene, settings, times)
        expected |= {f"track.{method}.test": "keeps", f"track.{method}.until": path.times[-1],
                     f"track.{method}.compliance": largest_gap(path), f"track.{method}.apart": gap(path, fine),
                     f"track.{method}.loop_s": path.timing.loop_s}  # fmt: skip
    dassl = ran(scene, Settings(method="dassl", rtol=1e-4))
    expected |= {"track.dassl.compliance": largest_gap(dassl), "track.dassl.loop_s": dassl.timing.loop_s}
    for name, how in (("pinocchio.finest_apart", {"method": "dop853", "rtol": 1e-9}),
                      ("pinocchio.apart", {"method": "rk4", "step": 1e-4}),
                      ("exudyn.apart", {"method": "generalized_alpha", "step": 1e-4})):  # fmt: skip
        expected[f"track.{name}"] = gap(ran(scene, Settings(**how), times), fine)
    step = Settings(method="rk4", step=1e-4)
    held_scene = scenes.make("tracked_vehicle", law="constraint", model="paper")
    one, other, chassis = ran(held_scene, step, times), ran(bare, step, times), scene.body_index("chassis")
    expected |= {
        "track.held.status": "success", "track.held.events": one.events, "track.soft.events": other.events,
        "track.held.calls": one.rhs_calls / other.rhs_calls, "track.held.compliance": largest_gap(one),
        "track.held.apart": np.linalg.norm((one.position - other.position)[:, chassis], axis=1).max(),
    }  # fmt: skip
    path, sliding, still = (
        ran(scene, step),
        ran(bare, step),
        ran(scenes.make("tracked_vehicle", torque=0.0), Settings()),
    )
    every = [abs(x) for own in slips.values() for x in own if not np.isnan(x)]
    wheels = [bare.body_names.index(name) for name in slips]
    expected |= {
        "track.rest": abs(still.position - still.position[0]).max(), "track.slip_median": np.median(every),
        "track.slip_95": np.percentile(every, 95.0), "track.slip_most": max(every),
        "track.sliding_turns": max(abs(sliding.angular_velocity[:, k]).max() for k in wheels),
        "track.travel": path.position[-1, 0, 0] - path.position[0, 0, 0],
        "track.sliding_travel": sliding.position[-1, 0, 0] - sliding.position[0, 0, 0],
    }  # fmt: skip
    assert found.figures == pytest.approx(expected | {"track.own": 7.0})
    assert ridden == [path]
    lines = found.curves["Track: wheels roll"].lines
    assert lines["chassis"] == pytest.approx(path.velocity[:, chassis, 0], rel=1e-5)
    for wheel in ("idler", "roller2"):
        radius = {c.radius for c in scene.contacts if c.body_a == wheel and c.type == "circle_on_line"}  # type: ignore[union-attr]
        rate = path.angular_velocity[:, scene.body_index(wheel)]
        assert lines[f"{wheel}'s rim"] == pytest.approx(-radius.pop() * rate, rel=1e-5)
    rough = scenes.make("tracked_vehicle", suspension=True, ground="bump", height=0.05)
    (pitch,) = (own for name, own in found.curves.items() if "pitch" in name)
    expected_pitch = np.degrees(ran(rough, step).orientation[:, rough.body_index("chassis")])
    assert pitch.lines["pitch"] == pytest.approx(expected_pitch, rel=1e-5)


def test_softer_soles_and_contacts(ran):
    scene = scenes.make("android_simplified")
    found = lessons.soles()
    for count in (2, 5):
        (path,) = (own for own in ran.made.values() if f"sole{count - 1}" in own.contacts
                   and f"sole{count}" not in own.contacts)  # fmt: skip
        built = ran.scene_of[id(path)]
        points = [part for part in built.contacts if part.name.startswith("sole")]
        heel, ball = (next(c for c in scene.contacts if c.name == f"foot.{end}.floor") for end in ("heel", "ball"))
        for k, point in enumerate(points):
            share = k / (count - 1)
            for name in ("center", "radius"):
                ends = [np.array(getattr(part, name)) for part in (heel, ball)]
                assert getattr(point, name) == pytest.approx((1.0 - share) * ends[0] + share * ends[1])
            assert point.law.stiffness == pytest.approx(2.0 / count * heel.law.stiffness)
            assert point.law.damping == pytest.approx(2.0 / count * heel.law.damping)
        assert len(built.contacts) == len(scene.contacts) - 2 + count
        force = [math.hypot(*row[1:3]) for point in points for row in path.contacts[point.name]]
        assert found[f"sole.{count}"] == pytest.approx(max(force))
    asked: list[Scene] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lessons, "farthest", lambda scene, one, other: [gap(one, other), 9.0])
        runs = [ran._run(scene, None) for _ in range(2)]
        given = iter(runs)
        patch.setattr(lessons, "finished", lambda scene: asked.append(scene) or next(given))
        shown = lessons.softer()
    assert shown == {"softer.calls": runs[1].rhs_calls / runs[0].rhs_calls, "softer.apart": gap(*runs)}
    for part, softer in zip(asked[0].contacts, asked[1].contacts, strict=True):
        assert softer.law.stiffness == pytest.approx(0.1 * part.law.stiffness)
        assert softer.law.damping == pytest.approx(0.1 * part.law.damping)


def test_rules_of_steps(ran):
    """m/c is m/(c d) at the deepest progressive contact; torques are damped by c^2/(4 k I) of the lighter part."""
    scene, found = scenes.make("android_simplified", **crash.PAPER), lessons.step_rules()
    stiff, path = lessons.stiffness_at_start(scene), ran(scene)
    system = lessons.compile_scene(scene)
    squares = system.contact_oscillators(0.0, system.initial_state(), 0.0)[:, 0]  # k/m, 1/s^2
    rules = []
    for part, square in zip(scene.contacts, squares, strict=True):
        law: Any = part.law.numbers()
        deepest = path.contacts[part.name][:, 0].max()
        rules.append(law.damping * deepest * square / law.stiffness)
    springs: list[Any] = [joint for joint in scene.loads if joint.type == "torsion_spring"]
    bodies: Any = {body.name: body for body in scene.bodies}
    least = [(joint, min(bodies[name].inertia for name in joint.ends)) for joint in springs]
    assert found["rules.simplified.damping"] == pytest.approx(1.0 / max(rules))
    assert found["rules.simplified.oscillation"] == stiff.oscillation_rule
    assert found["rules.simplified.stable"] == pytest.approx(stiff.step_limit(lessons.RK4))
    ratios = [joint.damping**2 / (4.0 * joint.stiffness * inertia) for joint, inertia in least]
    assert found["rules.simplified.overdamped"] == pytest.approx(min(ratios))
    assert found["stiff.simplified"] == pytest.approx(max(abs(stiff.modes)))
    assert found["stiff.simplified.modes"] == len(stiff.eigenvalues)
    assert found["stiff.simplified.undamped"] != found["stiff.simplified"]
    stable: list[Any] = [found[f"rules.{kind}.stable"] for kind in ("vertebral", "simplified")]
    assert stable[0] < stable[1]


def test_the_leading_matrix_has_a_negative_eigenvalue_for_each_row(ran):
    found: dict[str, Any] = dict(lessons.leading_matrix())
    for kind in ("simplified", "vertebral"):
        scene = scenes.make(f"android_{kind}", **crash.PAPER)
        bodies: Any = scene.bodies
        masses = [x for body in bodies for x in (body.mass, body.inertia)]
        assert found[f"leading.{kind}.mass"] == pytest.approx(max(masses) / min(masses))
        assert found[f"leading.{kind}.negative"] == found[f"leading.{kind}.rows"] > 0.0
        system = lessons.compile_scene(scene)
        rows, mass = system.jacobian(0.0, system.initial_state()), np.diag(system.mass_matrix())
        values = np.abs(np.linalg.eigvalsh(np.block([[mass, rows.T], [rows, np.zeros((len(rows),) * 2)]])))
        assert found[f"leading.{kind}.condition"] == pytest.approx(values.max() / values.min(), rel=1e-4)


def test_doors_on_hinges(monkeypatch):
    """A free body on one hinge has five rows that count; on three in a line as many; across each other it is fixed."""
    paths = iter(
        [SimpleNamespace(position=np.full((3, 1, 3), x) * np.arange(3)[:, None, None]) for x in (0.0, 0.1, -0.3)]
    )
    monkeypatch.setattr(lessons, "finished", lambda scene, settings: next(paths))
    monkeypatch.setattr(lessons, "farthest", lambda scene, one, other: [abs(one.position - other.position).max(), 9.0])
    assert lessons.counted_rows() == pytest.approx({
        "hinges.one.rows": 2.0, "hinges.one.rank": 5.0, "hinges.three.rows": 6.0, "hinges.three.rank": 5.0,
        "hinges.crossed.rows": 4.0, "hinges.crossed.rank": 6.0, "hinges.apart": 0.2, "hinges.crossed.moved": 0.6,
    })  # fmt: skip


def test_the_papers_sky_and_indices(monkeypatch, ran):
    asked: dict[str, float] = {}

    def observed(scene: Scene, engine: str, settings: Settings) -> Any:
        model, days = scene.parameters["model"], scene.parameters["days"]
        key = f"{model} {days:g} {settings.method} {settings.step} {settings.rtol}"
        asked[key] = ran.rng.random()
        return SimpleNamespace(status="success", figures={"earth": asked[key] + 1.0, "mars": asked[key], "moon": 7.0})

    monkeypatch.setattr(papers, "observed", observed)
    found = papers.measure_sky() | papers._indices()
    for days in (200, 360):
        for method, how in (("euler", "8640.0 None"), ("rk4", "86400.0 None"), ("lsodar", "None 1e-09"),
                            ("dop853", "None 1e-12")):  # fmt: skip
            assert found.pop(f"sky.{method}.{days}") == asked[f"lumped {days} {method} {how}"]
        for model in ("lumped", "full"):
            assert found.pop(f"sky.{model}.{days}") == asked[f"{model} {days} gauss None 1e-16"]
    rigid = scenes.make("solar_system", model="newton", days=360.0, formulation="euler_parameters", spin=True)
    for held in ("none", "projection"):
        path = ran(rigid, Settings(method="dop853", rtol=1e-12, stabilization=held))
        norms = [abs(float(row @ row) - 1.0) for row in path.orientation[-1]]
        assert found.pop(f"sky.norm.{held}") == pytest.approx(max(norms))
    crank = scenes.make("slider_crank")
    for method in ("dassl_index1", "dassl_index2", "dassl", "dassl_index3"):
        path = ran(crank, Settings(method=method, rtol=1e-4, stabilization="none"))
        assert found.pop(f"{method}.compliance") == largest_gap(path)
    assert not found


@pytest.mark.slow
def test_a_satellite_swings_as_the_linear_theory_says_and_a_large_swing_keeps_to_its_truth():
    found = papers.satellites()
    assert found["satellite.frequency"] == pytest.approx(1.0, abs=2e-3)
    assert 0.0 < float(found["satellite.off"]) < 1e-6
    assert float(found["satellite.norm"]) < 1e-12


def test_places_in_the_sky_are_compared_with_those_of_another_ephemeris(monkeypatch):
    rng, source = np.random.default_rng(4), "cross_checks.ephemerides.astropy_"
    theirs = {name: rng.normal(size=(2, 3)) for name in ("sun", "mercury", "earth", "moon", "mars", "jupiter")}
    directions = {"sun": np.array((1.0, 2.0, 2.0)), "moon": np.array((2.0, -1.0, 2.0))}
    dates: list[float] = []

    def at(name: str, jd: float) -> np.ndarray:
        return 1e11 * (theirs[name][0] + 0.01 * (jd - 2_451_545.0) * theirs[name][1])

    def place(source: str, name: str, jd: float) -> np.ndarray:
        dates.append(jd)
        return at(name, jd)

    names = scenes.make("solar_system").body_names
    ends = {days: 1e11 * rng.normal(size=(len(names), 3)) for days in pairs.DAYS}

    def run(scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
        path = Runs(3)(scene, settings, times)
        days = float(scene.parameters["days"])
        assert times[-1] == scene.duration == 86_400.0 * days
        assert scene.parameters["start"] == "1998-01-01"
        path.position[-1] = ends[days]
        return path

    def put(direction: np.ndarray, days: float, out: np.ndarray) -> None:
        out[:] = direction * (1.0 + days)

    monkeypatch.setitem(sys.modules, source, SimpleNamespace(place=place))
    monkeypatch.setattr(pairs, "simulate", run)
    for name, direction in directions.items():
        monkeypatch.setattr(pairs, f"{name}_place", partial(put, direction))
    found = pairs.sky_places()
    planets, moons = list(found.items())[: len(pairs.DAYS)], list(found.items())[len(pairs.DAYS) :]
    for (title, rows), days in zip(planets, pairs.DAYS, strict=True):
        assert title.endswith(f", day {days:g}")
        ours, jd = dict(zip(names, ends[days], strict=True)), julian_date("1998-01-01") + days
        assert [row["body"] for row in rows] == [n for n in names if n in theirs and n not in ("sun", "pluto")]
        for row in rows:
            name = str(row["body"])
            center = "earth" if name == "moon" else "sun"
            true = at(name, jd) - at(center, jd)
            apart = np.linalg.norm(ours[name] - ours[center] - true)
            assert row["apart"] == metres(apart)
            assert row["figures"] == pytest.approx(-np.log10(apart / np.linalg.norm(true)))
    for (title, rows), days in zip(moons, pairs.SATELLITE_DAYS, strict=True):
        assert title.endswith(f", day {days:g}")
        jd = 2_451_545.0 + days
        for row, (name, direction) in zip(rows, directions.items(), strict=True):
            assert row["body"] == name
            mine, true = (1.0 + days) * direction, at(name, jd) - at("earth", jd)
            angle = math.acos(mine @ true / np.linalg.norm(mine) / np.linalg.norm(true))
            assert row["apart"] == f"{short(angle)} rad"
            assert row["figures"] == pytest.approx(-np.log10(np.linalg.norm(mine - true) / np.linalg.norm(true)))
    starts = {julian_date("1998-01-01"): pairs.DAYS, 2_451_545.0: pairs.SATELLITE_DAYS}
    assert set(dates) == {start + days for start, every in starts.items() for days in every}
    monkeypatch.setitem(sys.modules, source, None)  # it is not installed
    assert pairs.sky_places() == {}


def test_a_splitting_method_loses_energy_and_the_moon(monkeypatch):
    record = Record("solar_system", {}, "rebound", "whfast", {}, "success", figures={"moon": 0.7, "earth": 3.0})
    asked: list[Any] = []
    monkeypatch.setattr(sky, "observed", lambda scene, engine, settings: asked.append(
        (scene.name, engine, settings)) or record)  # fmt: skip
    solvers = {"rebound": SimpleNamespace(run=lambda scene, settings: asked.append((scene.name, "", settings)))}
    monkeypatch.setattr(sky.engines, "get", solvers.__getitem__)
    balance = SimpleNamespace(drift=np.array([0.0, -6.0, 2.0]), energy=np.array([-2.0, 5.0, 7.0]))
    monkeypatch.setattr(sky, "energy_balance", lambda scene, path: balance)
    measured = Measured()
    sky.add_splitting(measured)
    assert measured.figures == {"splitting.energy": 3.0, "splitting.moon": 0.7}
    assert asked == [("solar_system", engine, sky.COARSE_SPLITTING) for engine in ("rebound", "")]
    monkeypatch.setattr(sky, "observed", lambda *given: replace(record, status="engine-missing"))
    measured = Measured()
    sky.add_splitting(measured)
    assert measured.figures == {}


def about(axis: int, angle: float) -> np.ndarray:
    """Return the matrix to components in axes that are turned by an angle about one of them."""
    c, s = math.cos(angle), math.sin(angle)
    return np.roll([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]], axis, (0, 1))


def test_turned_axes_and_elevations():
    """Axes turn by the matrices of a textbook; the zenith of a station is its normal, not its radius."""
    rng = np.random.default_rng(2)
    angles, places = rng.uniform(-3.0, 3.0, 6), 7e6 * rng.normal(size=(6, 3))
    for axis, name in enumerate("xyz"):
        expected = [about(axis, angle) @ place for angle, place in zip(angles, places, strict=True)]
        assert frames._about(name, angles, places) == pytest.approx(np.array(expected))
    days = 36_525.0 * rng.uniform(-30.0, 30.0, 6)
    for level, turn in ((0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)):
        expected = []
        for place, since in zip(places, days, strict=True):
            powers = (since / 36_525.0) ** np.arange(3)
            gamma, phi, psi, eps = np.radians(frames.SERIES["precession"] @ powers / 3600.0) * level
            angle = math.tau * (0.7790572732640 + 1.00273781191135448 * since)
            angle += math.radians(frames.SERIES["sidereal"] @ powers / 3600.0) * level
            expected.append(about(2, turn * angle) @ about(0, -eps) @ about(2, -psi) @ about(0, phi) @ about(2, gamma)
                            @ place)  # fmt: skip
        assert frames.turned(places, 2_451_545.0 + days, level, turn) == pytest.approx(
            np.array(expected), rel=1e-9, abs=0.1
        )
    longitude, latitude = rng.uniform(-1.0, 1.0, 2)
    a, flattening = 6_378_137.0, 1.0 / 298.257223563
    e2 = flattening * (2.0 - flattening)
    radius = a / math.sqrt(1.0 - e2 * math.sin(latitude) ** 2)
    up = np.array(
        [math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude)]
    )
    station = radius * up * (1.0, 1.0, 1.0 - e2)
    way = places - station
    expected = np.arcsin(way @ up / np.linalg.norm(way, axis=1))
    assert frames.elevations(places, longitude, latitude) == pytest.approx(expected, abs=1e-9)
    overhead = (station + 1e6 * up)[None]
    assert frames.elevations(overhead, longitude, latitude) == pytest.approx([math.pi / 2.0], abs=1e-6)
    times = np.linspace(0.0, 10.0, 41)
    found = frames.passes(math.radians(10.0) + np.sin(times), times)
    assert found[:, 0] == pytest.approx([0.0, math.pi, 2.0 * math.pi, 3.0 * math.pi][-len(found) :], abs=1e-4)


def test_a_comparison_states_the_largest_distance_and_the_fewest_figures(monkeypatch):
    clock = iter((1.0, 1.5, 10.0, 10.25))
    monkeypatch.setattr(frames.time, "perf_counter", lambda: next(clock))
    ours, theirs = np.array([[3.0, 4.0], [0.0, 1000.0]]), np.array([[3.0, 5.0], [0.0, 1003.0]])
    row = frames._row("name", "m", lambda: ours, lambda: theirs)
    assert row == {"name": "name", "unit": "m", "apart": 3.0, "ours_s": 0.5, "theirs_s": 0.25,
                   "figures": pytest.approx(-math.log10(1.0 / math.hypot(3.0, 5.0)))}  # fmt: skip


def test_a_table_of_violations_has_a_row_for_each_and_one_for_what_did_not_finish():
    broken = [
        {"symmetry": f"s{k}", "size": k, "noise": 2.0 * k, "error": 3.0 * k, "exceeds_error": True} for k in (1, 2)
    ]
    case = {"engine": "e", "method": "m", "scene": "s", "broken": broken, "stopped": "ended"}
    about = {"engine": "e", "method": "m", "scene": "s"}
    assert trust._violations(case) == [
        *(about | {name: one[name] for name in ("symmetry", "size", "noise", "error")} for one in broken),
        about | {"symmetry": "ended", "size": "", "noise": "", "error": ""}]  # fmt: skip
    assert len(trust._violations(case | {"stopped": ""})) == 2


def blocks() -> Iterator[dict[str, Any]]:
    yield {"each": "rows", "summary": "{name} of {all}", "open": "b", "blocks": [{"text": "{size:.1f} {all}"}]}
    yield {"each": ["x", "y"], "blocks": [{"text": "@ is {@}"}, {"table": "of @", "columns": {"head @": "{v}"}}]}
    yield {"table": "of *", "columns": {"v": "", "w": ""}}
    yield {"table": "ragged"}
    yield {"text": "hidden", "where": [["all", ">", 9.0]]}
    yield {"text": "shown", "layout": "pairs", "where": [["all", "<", 9.0], ["x", "=", "one"]]}
    yield {"claims": True}


def test_blocks_of_a_document():
    """Rows of a table become figures of their blocks; words replace the sign; criteria hide; claims are counted."""
    claim = {"group": "g", "paper": "1999", "where": "eq", "statement": "s", "result": "{all}"}
    made = document.Document("own", "p.html", "T", "n", "h", "l", list(blocks()), claim=[
        claim | {"verdict": "partly"}, claim | {"criteria": [["all", "<", 1.0]], "group": "other"},
        claim | {"criteria": [["all", ">", 1.0]]}, claim | {"criteria": [["all", "<", 9.0]]}])  # fmt: skip
    tables: dict[str, Any] = {
        "rows": ({"name": "a", "size": 1.25}, {"name": "b", "size": 2.25}),
        "of x": ({"v": 3.0},), "of y": ({"v": 4.0},),
        "ragged": ({"a": 1.0, "b": 2.0}, {"b": None, "c": 5.0}),
    }  # fmt: skip
    facts = Measured({"all": 7.0, "x": "one"}, tables)
    data: Any = SimpleNamespace(studies={"own": facts, "other": Measured({"y": "two"})})
    first, second, third, ragged, shown, claims = made.context(data)["shown"]
    assert [(one["title"], one["open"]) for one in first["items"]] == [("a of 7", False), ("b of 7", True)]
    assert [one["blocks"][0]["value"] for one in first["items"]] == ["1.2 7", "2.2 7"]
    assert [one["blocks"][0]["value"] for one in second["items"]] == ["x is one", "y is two"]
    assert [one["blocks"][1]["value"] for one in second["items"]] == [
        [{"title": "", "head": [f"head {name}"], "rows": [[value]]}] for name, value in (("x", "3"), ("y", "4"))
    ]
    assert third["value"] == [{"title": name, "head": ["v", "w"], "rows": [[value, "–"]]} for name, value in
                              (("x", "3"), ("y", "4"))]  # fmt: skip
    assert ragged["value"] == [{"title": "", "head": ["a", "b", "c"], "rows": [["1", "2", "–"], ["–", "–", "5"]]}]
    assert shown == {"kind": "text", "layout": "pairs", "value": "shown"}
    assert (claims["kind"], claims["layout"], first["kind"]) == ("claims", "", "each")
    assert claims["counted"] == "2 reproduced, 1 partly, 1 not reproduced"
    assert [len(rows) for rows in claims["groups"].values()] == [3, 1]
    assert claims["groups"]["g"][0]["result"] == "7"
    assert made.context(SimpleNamespace(studies={}))["shown"] is None  # type: ignore[arg-type]


def test_a_figure_of_a_row_stands_before_those_of_studies_with_its_name():
    shows: list[dict[str, Any]] = [{"text": "{size} of {all}"}, {"text": "large", "where": [["size", ">", 5.0]]}]
    made = document.Document("own", "p.html", "T", "n", "h", "l", [{"each": "rows", "blocks": shows}])
    facts = Measured({"size": 9.0, "all": 7.0}, {"rows": ({"size": 1.0}, {"size": 6.0})})
    data: Any = SimpleNamespace(studies={"own": facts, "other": Measured({"size": 8.0})})
    (shown,) = made.context(data)["shown"]
    assert [[block["value"] for block in one["blocks"]] for one in shown["items"]] == [
        ["1 of 7"], ["6 of 7", "large"]]  # fmt: skip


def test_what_a_study_depends_on(monkeypatch):
    """Its code and data files, but not what presents them; whether it is full, where that makes a difference."""
    own = study._sources("papers")
    assert own[0] == study.code_of("reports.studies.papers")
    assert "[[pairs]]" in study._sources("pairs")[1]
    listed = study.every()
    full = {name for name, one in listed.items() if one.fuller}
    assert {name for name in listed if study._fuller(name, True) == [True]} == full
    assert {name for name in listed if study._fuller(name, False) == [False]} == full
    assert list(listed.values()) == sorted(listed.values(), key=lambda one: (one.page, one.place))
