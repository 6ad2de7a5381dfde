"""Figures of the studies, computed again from made-up runs, forces and records in a few lines of their own."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.judge.vocabulary import ANSWERS, OURS
from cross_checks.records.numbers import duration, short
from cross_checks.records.record import Error, Record
from mbs_ref import scenes
from mbs_ref.scene.celestial import AU_M
from mbs_ref.trajectory import Status, Timing, Trajectory
from reports.facts.curves import Measured
from reports.facts.report_data import Entry
from reports.studies import androids, contact, crash, crashes, document, models, pairs, sky, space, study, trust
from reports.studies.models import Ladder, Rung, choose
from reports.studies.papers import crash_figures, lessons
from reports.studies.sky import frames

N = 7
RNG = np.random.default_rng(3)
TIMES = np.cumsum(RNG.uniform(0.01, 0.03, N)) - 0.01


def motion(scene: Any, n: int = N, **more: Any) -> Trajectory:
    bodies = len(scene.bodies)
    shapes = (bodies, 2), (bodies,), (bodies, 2), (bodies,)
    return Trajectory(TIMES[:n], *(RNG.normal(size=(n, *shape)) for shape in shapes), **more)


@pytest.fixture(scope="module")
def android() -> Any:
    return scenes.make(crash.SIMPLIFIED, **crash.PAPER)


@pytest.fixture
def results(android) -> Any:
    """Return results of a crash of no law, the extremes in the middle."""
    series = lambda *shape: RNG.normal(size=(N, *shape))  # noqa: E731
    bodies = len(android.bodies)
    return SimpleNamespace(
        forces=SimpleNamespace(external=series(bodies, 3), constraint=series(bodies, 3)), energy=series(),
        works={"pulse": series(), "belts": series()}, seat_force=series(), belt_force=series(),
        head_excursion=series(2), hip_excursion=series(2), head_g=series(), thorax_g=series(), neck_axial=series(),
        nij=series(), measures={"HIC36": 77.0, "Nij": 0.3}, neck_moment=series(),
        # the last changes its sign twice
        cervical_torques={"C1": 2.0 * series(), "C2": 3.0 * series(), "C3": np.resize([-2.0, 2.0, 2.0, -2.0], N)},
    )  # fmt: skip


def first_change(torque: np.ndarray) -> float | None:
    """Return the first sample at which a torque of more than 1 N m has another sign than the one before it."""
    before = 0.0
    for time, value in zip(TIMES, torque, strict=True):
        if abs(value) > 1.0:
            if value * before < 0.0:
                return time
            before = value
    return None


def test_figures_of_a_crash(monkeypatch, android, results):
    joint = next(j for j in android.joints if j.name == "thorax-neck")
    turn = {"head": RNG.normal(size=N), "thorax": RNG.normal(size=N), "bottom": RNG.normal(size=N)}
    place, pulls = RNG.normal(size=(N, 2)), {}
    for load in android.loads:
        if load.name.startswith("belt.thorax"):
            pulls[load.name] = RNG.uniform(0.0, 5.0, N)
    seen: list[Any] = []
    moving = SimpleNamespace(point=lambda *given: (seen.append(given), (place, None))[1], angle=turn.__getitem__)
    monkeypatch.setattr(crash, "Motion", lambda scene, path: moving)
    monkeypatch.setattr(crash, "tension", lambda motion, load: pulls[load.name])
    depths = {"a": np.array([0.1, 0.4]), "b": np.array([0.3, -0.2])}
    monkeypatch.setattr(crash, "excesses", lambda motion: depths)
    touch = next(c.name for c in android.contacts if c.body_a == "head")
    force = np.array([5.0, 3.0, 0.0, 0.0, 2.0, 0.0, 1.0])
    path = motion(android, rhs_calls=99, timing=Timing(build_s=8.0, loop_s=0.25), contacts={touch: force[:, None]},
                  step_compliance=np.array([[0.1, 1e-5], [0.2, 7e-4], [0.9, 3e-4]]))  # fmt: skip
    found = crash.figures(android, path, results)
    works = results.works
    imbalance = results.energy - results.energy[0] - works["pulse"] - works["belts"]
    head, seats = android.body_names.index("head"), [android.body_names.index(f"seat_{k}") for k in ("base", "back")]
    pull, reach = results.forces.constraint[:, head, 0], results.head_excursion[:, 0]
    t1 = place[:, 0] - place[0, 0]
    expected = {
        "bodies": len(android.bodies), "rhs_calls": 99, "loop_s": 0.25, "compliance": 7e-4,
        "imbalance": abs(imbalance).max() / abs(works["pulse"]).max(),
        "seat_force": results.seat_force.max(), "belt_force": results.belt_force.max(),
        "head_excursion": abs(reach).max(), "head_reach": max(reach, key=abs),
        "hip_excursion": abs(results.hip_excursion[:, 0]).max(),
        "t1_excursion": abs(t1).max(), "neck_flexion": math.degrees((turn["thorax"] - turn["head"]).max()),
        "neck_extension": math.degrees((turn["head"] - turn["thorax"]).max()),
        "trunk_flexion": math.degrees((turn["bottom"] - turn["thorax"]).max()),
        "shoulder_belt": sum(pulls.values()).max(),  # type: ignore[union-attr]
        "head_pull_most": pull.max(), "head_pull_least": pull.min(), "deepest": 0.4,
        "largest_constraint_force": abs(results.forces.constraint[:, :, :2]).max(),
        "seats_imbalance": abs((results.forces.external + results.forces.constraint)[:, seats]).max(),
        "HIC36": 77.0, "Nij": 0.3, "head_leaves": TIMES[2], "head_back": TIMES[4],
    }  # fmt: skip
    torques = list(results.cervical_torques.values())
    changes = [t for torque in torques if (t := first_change(torque)) is not None]
    if changes:
        expected |= {"neck_changes": len(changes), "neck_first": min(changes), "neck_last": max(changes),
                     "neck_most": max(t.max() for t in torques),
                     "neck_least": min(t.min() for t in torques)}  # fmt: skip
    assert found == pytest.approx(expected)
    assert seen == [("thorax", joint.point)]
    never = replace(path, contacts={touch: np.array([5.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0])[:, None]})
    assert crash.figures(android, never, results)["head_back"] == "never"
    assert crash.largest_gap(replace(path, step_compliance=None)) == 0.0


def test_curves_and_tables_of_a_crash(android, results):
    steps = np.array([[0.0, 0.0], [0.1, 2e-5], [0.2, 1e-5]])
    path = motion(android, step_compliance=steps)
    drawn = crashes._plots(path, results)
    lines = {(name, line): y for name, one in drawn.items() for line, y in one.lines.items()}
    expected = {
        ("Energy balance", "energy"): results.energy - results.energy[0],
        ("Energy balance", "work of pulse"): results.works["pulse"],
        ("Energy balance", "work of belts"): results.works["belts"],
        ("Energy balance", "energy less works"): results.energy - results.energy[0] - sum(results.works.values()),
        ("Excursions in the vehicle", "head x"): results.head_excursion[:, 0],
        ("Excursions in the vehicle", "head y"): results.head_excursion[:, 1],
        ("Excursions in the vehicle", "hip x"): results.hip_excursion[:, 0],
        ("Excursions in the vehicle", "hip y"): results.hip_excursion[:, 1],
        ("Seat and belt forces", "seat"): results.seat_force, ("Seat and belt forces", "belts"): results.belt_force,
        ("Accelerations", "head"): results.head_g, ("Accelerations", "thorax"): results.thorax_g,
        ("Neck", "axial force, kN"): results.neck_axial / 1000.0, ("Neck", "Nij"): results.nij,
        ("Constraint compliance", "largest |C| of the steps"): steps[1:, 1],
    }  # fmt: skip
    assert lines.keys() == expected.keys()
    for key, values in expected.items():
        assert lines[key] == pytest.approx(values, rel=1e-5), key
    assert {name: one.y_label for name, one in drawn.items()} == {
        "Energy balance": "J", "Excursions in the vehicle": "m", "Seat and belt forces": "N", "Accelerations": "g",
        "Neck": "kN, 1", "Constraint compliance": "m"}  # fmt: skip
    compared = {name: (values.tolist(), unit) for name, (values, unit) in crashes._compared(results).items()}
    assert compared == {"Head along x": (results.head_excursion[:, 0].tolist(), "m"),
                        "Head acceleration": (results.head_g.tolist(), "g"),
                        "Belt forces": (results.belt_force.tolist(), "N")}  # fmt: skip
    for row, (name, torque) in zip(crashes._whiplash(path, results), results.cervical_torques.items(), strict=True):
        assert (row["vertebra"], row["largest"], row["least"]) == (name, torque.max(), torque.min())
        first = first_change(torque)
        assert row["changes"].split(", ")[0] == ("never" if first is None else f"{first:.3f} s")  # type: ignore[union-attr]
    plots = crash.forces("Q", android, path.times, results.forces.external, ("thorax", "head"))
    assert [(name, one.y_label) for name, one in plots.items()] == [
        ("Q: x", "x, N"), ("Q: y", "y, N"), ("Q: torque", "torque, N m")]  # fmt: skip
    for c, one in enumerate(plots.values()):
        for body, line in one.lines.items():
            assert line == pytest.approx(results.forces.external[:, android.body_names.index(body), c], rel=1e-5)


def test_curves_of_the_tracked_vehicle():
    names = ("chassis", "sprocket", "foot")
    touch = [("a", "ground", "line", 0.0), ("b", "ground", "line", 0.0), ("c", "sprocket", "pin_on_sprocket", 0.3),
             ("d", "sprocket", "pin_on_sprocket", 0.3), ("e", "foot", "line", 0.0)]  # fmt: skip
    scene: Any = SimpleNamespace(
        bodies=names,
        body_names=names,
        body_index=names.index,
        joints=[SimpleNamespace(name=n) for n in ("pin1", "pin2", "x")],
        contacts=[SimpleNamespace(name=n, body_b=b, type=t, pitch_radius=r) for n, b, t, r in touch],
    )
    contacts = {part.name: RNG.normal(size=(N, 4)) for part in scene.contacts}
    pins = [joint.name for joint in scene.joints if joint.name.startswith("pin")]
    reactions = {joint.name: RNG.normal(size=(N, 3)) for joint in scene.joints}
    steps = np.array([[0.0, 1.0], [0.1, 2e-5], [0.2, 1e-5]])
    path = motion(scene, contacts=contacts, reactions=reactions, step_compliance=steps)
    energy = contact.Balance(np.array([0.0, 1.0, 2.0]), np.array([5.0, 9.0, 4.0]), np.array([0.0, 3.0, -2.0]), 8.0)
    drawn = contact.vehicle_curves(scene, path, energy)
    chassis, sprocket = (scene.body_names.index(name) for name in ("chassis", "sprocket"))
    radius = {c.pitch_radius for c in scene.contacts if c.type == "pin_on_sprocket"}.pop()
    rim, speed = -radius * path.angular_velocity[:, sprocket], path.velocity[:, chassis, 0]
    ground, teeth = ([contacts[c.name] for c in scene.contacts if c.body_b == name] for name in ("ground", "sprocket"))
    pull = np.array([np.hypot(reactions[name][:, 0], reactions[name][:, 1]) for name in pins])
    away = path.position[:, chassis] - path.position[0, chassis]
    expected = {"x": away[:, 0], "y": away[:, 1], "chassis": speed, "sprocket's pitch circle": rim, "slip": rim - speed,
                "normal, all feet": sum(c[:, 2] for c in ground), "thrust, all feet": sum(c[:, 1] for c in ground),
                "tooth": np.max([np.hypot(c[:, 1], c[:, 2]) for c in teeth], axis=0), "largest": pull.max(axis=0),
                "mean": pull.mean(axis=0), "dop853": steps[1:, 1], "energy less work": [0.0, 1.0, 1.0]}  # fmt: skip
    lines = {name: y for one in drawn.values() for name, y in one.lines.items()}
    assert lines.keys() == expected.keys()
    for name, values in expected.items():
        assert lines[name] == pytest.approx(np.asarray(values), rel=1e-4), name
    units = [one.y_label.split(", ")[-1] for one in drawn.values()]
    assert units == ["m", "m/s", "N", "N", "N", "m", "J"]


def test_rows_of_contact(monkeypatch):
    ball = contact._ball("lankarani_nikravesh")
    exact = contact.impact(ball.contacts[0].law, 1.0, 1.0).restitution
    run = SimpleNamespace(velocity=np.array([[[0.0, 9.0]], [[0.0, exact + 3e-6]]]))
    monkeypatch.setattr(contact, "simulate", lambda scene, settings: run)
    row = contact._restitution("lankarani_nikravesh")
    nominal = ball.contacts[0].law.restitution
    assert (row["exact"], row["computed"], row["nominal"]) == (exact, exact + 3e-6, nominal)
    assert row["difference"] == pytest.approx(3e-6)
    assert row["note"] == (", not returned" if abs(nominal - exact) > 1e-3 else "")
    errors = {str(n): 1.0 / n for n in contact.STEPS}
    line = contact._line(errors)
    assert (line.x, line.lines["error"]) == (
        tuple(map(float, contact.STEPS)),
        pytest.approx([1.0 / n for n in contact.STEPS], rel=1e-5),
    )


def test_what_euler_parameters_cost(monkeypatch):
    loops = {True: iter((0.9, 0.4, 0.7) * 3), False: iter((0.2, 0.3, 0.1) * 3)}
    runs = lambda scene, settings: SimpleNamespace(  # noqa: E731
        timing=Timing(loop_s=next(loops[hasattr(scene.bodies[0], "inertia")])))  # fmt: skip
    monkeypatch.setattr(space, "simulate", runs)
    assert space._cost_ratio() == pytest.approx(4.0)


def test_the_loss_of_norm_of_rk4(monkeypatch):
    """The leading term: a step of angle 2a turns into a factor 1 - a^6 / 144 (a^6 / 72 of the square)."""
    half = 0.1
    exact = (1.0 - half**2 / 2.0 + half**4 / 24.0) ** 2 + (half - half**3 / 6.0) ** 2
    assert 1.0 - math.sqrt(exact) == pytest.approx(half**6 / 144.0, rel=0.01)
    monkeypatch.setattr(space, "off_truth", lambda scene, path: [0.0, path.steps * 1e-3, 0.0, 0.0])
    row: dict[str, Any] = dict(space._norm_drift(half))
    assert row["measured"] == pytest.approx(row["steps"] * half**6 / 144.0, rel=0.02)
    assert row["formula"] == pytest.approx(row["measured"], rel=0.02)
    assert row["steps"] == math.ceil(20.0 * math.pi / half)
    assert row["free"] == row["normalised"] == pytest.approx(row["steps"] * 1e-3)


def record(name: str, **figures: float) -> Record:
    parameters = {"model": name, "days": 200.0, "formulation": "point", "spin": False}
    return Record("solar_system", parameters, "mbs_ref", "gauss", {}, "success", figures=figures)


def test_figures_against_physics():
    runs = [record("lumped", earth=3.0, mars=2.5), record("newton", earth=4.0, mars=6.0, moon=1.0),
            record("gr_sun", earth=9.0, mars=9.0, moon=9.0), record("gr", earth=4.2, mars=6.5, moon=3.5)]  # fmt: skip
    measured = Measured()
    sky.add_levels(measured, runs)
    assert [row["worst"] for row in measured.tables["figures: Physics in the model"]] == [2.5, 4.0, 9.0, 4.2]
    assert measured.figures["levels.gains"] == (
        "newton takes the worst planet from 2.5 to 4.0; gr takes the Moon from 1.0 to 3.5")  # fmt: skip
    assert (measured.figures["levels.first"], measured.figures["levels.last"]) == (2.5, 4.2)
    curve = measured.curves["Figures against physics"]
    assert curve.lines == {"earth": (3.0, 4.0, 9.0, 4.2), "mars": (2.5, 6.0, 9.0, 6.5), "moon": (None, 1.0, 9.0, 3.5)}
    assert curve.x == tuple(sky.LEVELS[str(r.parameters["model"])] for r in runs)
    rigid = replace(record("newton", earth=4.0, moon=1.0), steps=9, times={"loop_s": 0.5, "build_s": 7.0},
                    final={"a": {}, "b": {}}, measures={"compliance_position": 1e-12})  # fmt: skip
    turning = replace(rigid, parameters=rigid.parameters | {"formulation": "euler_parameters", "spin": True})
    sky.add_formulations(measured, [rigid, turning])
    point, body = measured.tables["formulations"]
    assert (point["numbers"], body["numbers"]) == (2 * 6, 2 * 13)
    assert (point["norm"], body["norm"]) == (None, 1e-12)
    assert [body[key] for key in ("worst", "moon", "steps", "loop_s")] == [4.0, 1.0, 9, 0.5]
    assert (point["model"], body["model"]) == ("point masses", "rigid bodies, Euler parameters, turning")


def test_orbits_in_the_ecliptic():
    measured = Measured()
    tilt = math.radians(23.0 + 26.0 / 60.0 + 21.406 / 3600.0)
    places = {name: RNG.normal(size=(5, 3)) * AU_M for name in ("sun", "earth", "saturn", "moon")}
    sky.add_orbits(measured, places)
    for group, name in (("inner", "earth"), ("outer", "saturn")):
        seen = (places[name] - places["sun"]) / AU_M
        curve = measured.curves[f"{group} planets: {name}"]
        assert curve.x == pytest.approx(seen[:, 0], abs=6e-5)
        assert curve.lines[name] == pytest.approx(seen[:, 1] * math.cos(tilt) + seen[:, 2] * math.sin(tilt), abs=6e-5)
        assert (curve.x_label, curve.y_label) == ("x, au", "y, au")
    assert not [name for name in measured.curves if "moon" in name]


def rungs(seed: int) -> Ladder:
    chance = random.Random(seed)
    made = [Rung(f"m{k}", 10 ** chance.uniform(-3, 0), chance.randrange(999), {"a, m": chance.random()},
                 chance.uniform(0.5, 6.0) if k < 5 else None) for k in range(6)]  # fmt: skip
    return Ladder("Title", "note", "rk4", "figures", tuple(made), "m5" if seed % 2 else "")


@pytest.mark.parametrize("seed", range(6))
def test_the_least_model(seed):
    ladder = rungs(seed)
    reach = [(r, math.inf if r.name == ladder.reference else r.accuracy) for r in ladder.rungs]
    for error in (0.3, 1e-2, 1e-5, 1e-9):
        enough = [r for r, has in reach if has is not None and 10.0**-has <= error]
        best = min(enough, key=lambda r: r.loop_s, default=None)
        found = choose(ladder, error)
        assert found.best == best
        known = [r for r in ladder.rungs if r.accuracy is not None and (best is None or r.loop_s < best.loop_s)]
        cheaper = known or [r for r in ladder.rungs if best is not None and r.loop_s < best.loop_s]
        near = max(cheaper, key=lambda r: r.accuracy or 0.0, default=None)
        shown = {r.name: "the model that the others are compared with" if r.accuracy is None
                 else f"{10.0 ** -r.accuracy:.2g}" for r in ladder.rungs}  # fmt: skip
        less = "" if near is None else f"{near.name!r} comes closest with {shown[near.name]}"
        if best is None:
            assert found.sentence == f"Title: no model reaches {error:.3g}{'; ' * bool(less)}{less}."
            continue
        less = f"; of the cheaper ones {less}" if less else ""
        by = f" Errors are counted from {ladder.reference!r}, which is no truth." if ladder.reference else ""
        assert found.sentence == (f"Title: {best.name!r} is enough for {error:.3g}: {shown[best.name]}, "
                                  f"{duration(best.loop_s)}{less}.{by}")  # fmt: skip
    most: dict[str, int] = {}
    for figures in range(1, math.floor(max(r.accuracy for r in ladder.rungs if r.accuracy)) + 1):
        able = [r for r, has in reach if has is not None and has >= figures]
        most[min(able, key=lambda r: r.loop_s).name] = figures
    assert ladder.cheapest() == [f"up to {figures}: {name}" for name, figures in most.items()]
    for row, rung in zip(ladder.rows(), ladder.rungs, strict=True):
        assert (row["model"], row["time"], row["right-hand sides"]) == (
            rung.name,
            duration(rung.loop_s),
            str(rung.work),
        )
        assert row["over the first"] == f"{rung.loop_s / ladder.rungs[0].loop_s:.3g}"
        assert row["figures"] == (None if rung.accuracy is None else f"{rung.accuracy:.1f}")
        assert row["a, m"] == short(rung.shown["a, m"], 3)


def test_what_models_show(monkeypatch):
    assert models._digits(1.01, 1.0) == pytest.approx(2.0)
    assert models._digits(-2.0, 2.0) == pytest.approx(-math.log10(2.0))
    assert models._digits(3.0, 3.0) is None
    scene: Any = SimpleNamespace(body_index=lambda name: 1, bodies=[None, SimpleNamespace(position=(3.0, 4.0))])
    path, full = (Trajectory(np.arange(3.0), RNG.normal(size=(3, 2, 2)), RNG.normal(size=(3, 2)), np.zeros((3, 2, 2)),
                             np.zeros((3, 2))) for _ in range(2))  # fmt: skip
    slip = np.array([-3.0, 1.0, np.nan, 2.0])
    monkeypatch.setattr(models, "rolling_slip", lambda motion, wheel: slip)
    monkeypatch.setattr(models, "Motion", lambda scene, path: None)
    shown, digits = models._drive(scene, path, scene, full)
    way, most = (run.position[-1, 1, 0] - run.position[0, 1, 0] for run in (path, full))
    pitch = math.degrees(abs(path.orientation[:, 1]).max())
    assert shown == pytest.approx({"way, m": way, "slip of a roller, median": 2.0, "hull's pitch, degrees": pitch})
    assert digits == pytest.approx(-math.log10(abs(way - most) / abs(most)))
    monkeypatch.setattr(models, "farthest", lambda *given: [0.05, 9.0])
    assert models._orbit(scene, path, scene, full) == ({"off the fullest model, m": 0.05}, pytest.approx(2.0))
    monkeypatch.setattr(models, "farthest", lambda *given: [0.0, 9.0])
    assert models._orbit(scene, path, scene, full)[1] is None
    excursion = {id(path): np.array([[0.1, 9.0], [-0.5, 0.0]]), id(full): np.array([[0.4, 9.0], [0.2, 0.0]])}
    monkeypatch.setattr(models, "crash_results", lambda scene, path: SimpleNamespace(
        head_excursion=excursion[id(path)], measures={"HIC36": 5.0, "Nij": 0.2, "other": 1.0}))  # fmt: skip
    monkeypatch.setattr(models, "deepest", lambda scene, path: -0.1)
    shown, digits = models._crash(scene, path, scene, full)
    assert shown == {"HIC36": 5.0, "Nij": 0.2, "head's travel, m": 0.5, "passes through, m": 0.0}
    assert digits == pytest.approx(-math.log10(0.1 / 0.4))


@pytest.mark.parametrize("length", [0.3, 1.0, 17.0])
def test_the_digits_of_a_model_count_its_error_over_the_scenes_own_length(monkeypatch, length):
    """A pendulum of any length that ends a hundredth of it away has two digits."""
    scene = scenes.make("pendulum", length=length)
    path: Any = SimpleNamespace(step_compliance=np.array([[0.0, 1e-9], [0.1, 3e-7]]))
    monkeypatch.setattr(models, "off_truth", lambda scene, path: [0.01 * length, 9.0, 9.0, 9.0])
    assert models._error(scene, path) == ({"largest |C|, m": 3e-7}, pytest.approx(2.0))
    monkeypatch.setattr(models, "off_truth", lambda scene, path: None)
    assert models._error(scene, path)[1] is None


def result(scene: str, engine: str, target: float, chance: random.Random) -> pairs.Result:
    error = Error(target * chance.uniform(0.1, 0.9), "exact", 0.0, None, length=3.0)
    run = Record(scene, {}, engine, chance.choice("pq"), {"step": chance.random()}, "success", error=error,
                 times={"loop_s": 10 ** chance.uniform(-4, 0)},
                 measures={"compliance_position": chance.random(), "energy_drift": chance.random()})  # fmt: skip
    reached = chance.random() < 0.8
    entry = (
        Entry(engine, "reached", run, method=run.method) if reached else Entry(engine, "not-tried", reason="too long")
    )
    return pairs.Result(scene, target, entry, scene == "a", 2.5 if reached else None)


@pytest.mark.parametrize("seed", range(4))
def test_pairs_side_by_side(seed):
    chance, targets = random.Random(seed), (1e-3, 1e-6)
    rows = []
    for scene in "ab":
        for target in targets:
            own = [result(scene, engine, target, chance) for engine in (OURS, "x", "y")]
            rows += sorted(own, key=lambda r: r.entry.best.times["loop_s"] if r.entry.best else math.inf)
    rows.append(pairs.Result("b", None, Entry("z", "cannot", reason="no")))
    for row in rows:
        shown, run = row.shown(), row.entry.best
        assert (shown["scene"], shown["target"]) == (row.scene, row.target)
        if run is None or run.error is None:
            assert shown["setting"] == f"{ANSWERS[row.entry.answer][0]}: {row.entry.reason}"
            assert shown["loop_s"] == shown["error"] == shown["ratio"] == ""
            continue
        assert [shown[key] for key in ("error", "drift", "loop_s", "ratio")] == [
            run.error.value, run.measures["energy_drift"], run.times["loop_s"], 2.5]  # fmt: skip
        assert shown["compliance"] == (run.measures["compliance_position"] if row.scene == "a" else "no rows")
    table = {(row["scene"], row["engine"]): row for row in pairs.side_by_side(rows)}
    drawn = pairs.costs(rows)
    for scene in "ab":
        cheapest = []
        for target in targets:
            times = {r.entry.engine: r.entry.best.times["loop_s"] for r in rows
                     if (r.scene, r.target) == (scene, target) and r.entry.best}  # fmt: skip
            for r in rows:
                if (r.scene, r.target) == (scene, target) and r.entry.best:
                    text = table[scene, r.entry.engine][f"within {short(target)}"]
                    mark = pairs.CHEAPEST if r.entry.engine == min(times, key=times.__getitem__) else ""
                    assert text == f"{mark}{duration(times[r.entry.engine])}, {r.entry.method}"
            cheapest += [min(times, key=times.__getitem__)] if times else []
        (title,) = (name for name in drawn if name.startswith(f"{scene} "))
        assert title == f"{scene} {pairs.CHEAPEST}{', '.join(dict.fromkeys(cheapest))}"
        for engine, line in drawn[title].lines.items():
            times = {r.target: r.entry.best.times["loop_s"] for r in rows
                     if r.entry.best and (r.scene, r.entry.engine) == (scene, engine)}  # fmt: skip
            assert line == tuple(map(times.get, targets))
        assert drawn[title].x == targets
    assert table["b", "z"][f"within {short(targets[0])}"] == "cannot: no"


def test_both_androids_and_both_impacts_stand_under_their_own_names(monkeypatch, android, results):
    monkeypatch.setattr(crashes, "crash_results", lambda scene, path: results)
    monkeypatch.setattr(crashes, "film", lambda *given: "film")
    monkeypatch.setattr(crash, "figures", lambda scene, path, result: {"a": len(scene.bodies)})
    measured, path = Measured(), motion(android)
    names = ("head", "thorax", "bottom", "thigh", "C1", "C3", "C6")
    for name, count in (("android_simplified", 3), ("android_vertebral", 5)):
        for impact in ("front", "rear"):
            scene: Any = SimpleNamespace(name=name, bodies=[None] * count, body_index=names.index,
                                         parameters={"impact": impact})  # fmt: skip
            crashes.add_crash(measured, scene, path)
    assert measured.figures == {
        "simplified.front.a": 3,
        "simplified.rear.a": 3,
        "vertebral.front.a": 5,
        "vertebral.rear.a": 5,
    }
    for impact in ("front", "rear"):
        lines = measured.curves[f"impact from the {impact}: Head acceleration"].lines
        assert lines.keys() == {"3 bodies", "5 bodies"}
        assert f"whiplash: android_vertebral, {impact}" in measured.tables
        external = measured.curves[f"android_simplified, {impact}: External forces Q_e: x"].lines
        assert external["thorax"] == pytest.approx(results.forces.external[:, 1, 0], rel=1e-5)
    assert measured.films.keys() == {f"{n}, {i}" for n in crash.NAMES for i in crash.IMPACTS}


def test_parts_on_a_sled_stand_beside_the_cadavers_corridors(monkeypatch):
    """Within a corridor to its edges; the largest travel ahead counts, not the last nor one backward."""
    reach = {"head": 0.455, "T1": 0.2259, "T8": 0.206, "hip": 0.1}
    monkeypatch.setattr(crash, "finished", lambda scene: scene.name)
    short = {crash.SIMPLIFIED: 0.0, crash.VERTEBRAL: 1.0}
    monkeypatch.setattr(crash, "forward", lambda scene, path: {part: x - short[path] for part, x in reach.items()})
    rows = crashes.sled_rows()
    assert [row["simplified"] for row in rows] == ["0.455", "0.226, outside", "0.206", "0.100, outside"]
    assert all(row["vertebral"].endswith(", outside") for row in rows)


@pytest.mark.parametrize("name", crash.NAMES)
def test_travel_ahead_is_the_largest_from_the_start(name):
    scene = scenes.make(name, **crash.PAPER)
    path = motion(scene)
    trunk, chest = ("thorax", "thorax") if name == crash.SIMPLIFIED else ("T8", "T1")
    ahead = lambda body: path.position[:, scene.body_index(body), 0]  # noqa: E731
    joint = next(j for j in scene.joints if j.name in ("thorax-neck", "T1-C6"))
    body = scene.bodies[scene.body_index(chest)]
    arm, turn = np.subtract(joint.point, body.position), path.orientation[:, scene.body_index(chest)] - body.angle
    t1 = ahead(chest) + np.cos(turn) * arm[0] - np.sin(turn) * arm[1]
    expected = {"head": ahead("head"), "T8": ahead(trunk), "hip": ahead("bottom"), "T1": t1}
    assert crash.forward(scene, path) == pytest.approx({part: (x - x[0]).max() for part, x in expected.items()})


def test_a_run_of_an_android(monkeypatch, android):
    gaps = np.array([[0.0, 0.0], [0.1, 2e-5], [0.15, 7e-4], [0.2, 1e-5]])
    path = motion(android, steps=50, rejected_steps=7, rhs_calls=99, events=3, step_compliance=gaps,
                  timing=Timing(build_s=9.0, loop_s=0.5))  # fmt: skip
    stopped = replace(path, status=Status.COMPLIANCE, message="|C| > h")
    monkeypatch.setattr(androids, "with_test", lambda scene, settings, tested: (path, stopped, 3e-6))
    measured = Measured()
    androids.add_run(measured, android, androids.Settings(method="rk4", step=1e-4))
    (row,) = measured.tables["runs"]
    expected = {"android": "android_simplified, front", "method": "rk4, h = 1e-4 s", "end": "reached 0.2 s",
                "error": 3e-6, "compliance": 7e-4, "steps": 50, "rejected": 7, "rhs_calls": 99, "events": 3,
                "loop_s": 0.5, "test": "|C| > h", "switches": None}  # fmt: skip
    assert row == expected
    assert measured.figures == {"androids.rk4.compliance": 7e-4}
    (line,) = measured.curves.values()
    assert (line.x, line.lines["|C|"]) == ((0.1, 0.15, 0.2), (2e-5, 7e-4, 1e-5))


def test_rows_of_trust_and_figures_of_claims():
    ways = [{"way": "at once", "differ": 3, "largest": 2e-5}, {"way": "two threads", "differ": 2, "largest": None},
            {"way": "another order", "differ": 0, "largest": 0.0}]  # fmt: skip
    row = trust._repeated({"engine": "e", "method": "m", "runs": 4, "ways": ways})
    assert row == {"engine": "e", "method": "m", "runs": 4, "at once": "3: 2e-05", "two threads": "2: 0",
                   "another order": "none"}  # fmt: skip
    given = (999.4, 1000.4, 54321.0, 999999.0, 1e6, 0.01234, "words")
    assert [document.figure(x) for x in given] == ["999", "1000", "54321", "999999", "1.00e6", "0.0123", "words"]
    assert [document.figure(-x) for x in given[:-1]] == [f"-{document.figure(x)}" for x in given[:-1]]


def test_plots_of_a_page_have_their_titles_and_labels(monkeypatch):
    line = contact._line({str(n): 1.0 / n for n in contact.STEPS})
    monkeypatch.setattr(document, "_named", lambda held, wanted, figures: {"the name": ("The title", line)})
    (shown,) = document.KINDS["plots"](Measured(), {"plots": ()}, None)  # type: ignore[arg-type]
    assert (shown["title"], shown["label"]) == ("The title", "the name")


def test_a_study_that_fails_says_how_and_is_measured_again_where_engines_change(monkeypatch):
    def fails(*given):
        raise ZeroDivisionError("why")

    assert study._made(fails, ("a", None, False)) == "ZeroDivisionError: why"
    asked: list[Any] = []
    space = study.every()["space"]
    monkeypatch.setattr(study, "every", lambda: {"space": space})
    monkeypatch.setattr(study, "digest_of", lambda facts: asked.append(facts) or "key")
    monkeypatch.setattr(study, "recall", lambda *given: Measured())
    for engines in (["1"], ["2"]):
        study.measure_all(None, {}, engines, lambda *given: None)  # type: ignore[arg-type]
    assert [facts[:3] for facts in asked] == [["study", "space", ["1"]], ["study", "space", ["2"]]]


def test_paths_of_two_methods_are_compared_at_their_largest_distance(monkeypatch, android):
    one, other = motion(android), motion(android)
    one.position[3] += 10.0
    monkeypatch.setattr(androids, "truth_for", lambda scene, times: None)
    monkeypatch.setattr(androids, "off_truth", lambda scene, path: None)
    monkeypatch.setattr(androids.ladder, "grid", lambda scene: TIMES)
    monkeypatch.setattr(androids, "constraint_residual", lambda scene, path: np.array([[0.1, -0.3], [0.2, 0.0]]))
    measured = Measured()
    row = androids.add_convergence(measured, android, dict(zip(androids.UNLIKE, (one, other), strict=True)))
    (curve,) = measured.curves.values()
    assert curve.x == pytest.approx(TIMES[1:], rel=1e-5)
    for name, body in androids.WATCHED.items():
        apart = (one.position - other.position)[1:, android.body_index(body)]
        assert row[name] == pytest.approx(max(math.hypot(*gap) for gap in apart))
        assert curve.lines[name] == pytest.approx([math.hypot(*gap) for gap in apart], rel=1e-5)
    assert [row[method] for method in androids.UNLIKE] == [0.3, 0.3]


def test_a_matrix_has_the_headings_of_its_columns():
    block = {"corner": "what", "matrix": {"RK4": "rk4", "Euler": "euler"}, "rows": {"error": "of @", "time": "for @"}}
    (shown,) = document._matrix(Measured(), block, {})
    assert shown["head"] == ["what", "RK4", "Euler"]
    assert shown["rows"] == [["error", "of rk4", "of euler"], ["time", "for rk4", "for euler"]]


def test_the_series_of_lsodar_shows_how_far_the_test_lets_it_go(monkeypatch, android):
    ends = iter([2, 3, 5, 4, 6])
    paths = {}

    def with_test(scene: Any, settings: Any) -> tuple[Trajectory, Trajectory, float]:
        paths[settings.rtol] = motion(android, next(ends), status=Status.COMPLIANCE)
        return motion(android), paths[settings.rtol], 7e-4

    monkeypatch.setattr(crash_figures, "with_test", with_test)
    measured = lessons.lsodar_series()
    reached = [path.times[-1] for path in paths.values()]
    assert [measured.figures[f"lsodar.{rtol:g}.until"] for rtol in lessons.TOLERANCES] == reached
    (line,) = measured.curves.values()
    assert line.lines["until"] == pytest.approx(reached, rel=1e-5)
    assert {measured.figures[f"lsodar.{rtol:g}.test"] for rtol in lessons.TOLERANCES} == {"fails"}


def test_the_energy_error_of_long_steps_is_the_largest(monkeypatch):
    monkeypatch.setattr(space, "_rk4", lambda *given, **more: SimpleNamespace(ok=True))
    monkeypatch.setattr(space, "_turned_away", lambda scene, path: 0.1)
    monkeypatch.setattr(space.observables, "kinetic_energy", lambda scene, path: np.array([2.0, 2.2, 1.5, 2.1]))
    assert space._long_steps()["space.energy_error"] == 0.25


def test_clocks_and_light_time_of_frames(monkeypatch):
    """UT1 = TDB - (TDB - UTC) + (UT1 - UTC); light time needs iterations, and is part of aberration."""
    path = SimpleNamespace(times=np.array([0.0, 43200.0]), position=np.zeros((2, 2, 3)))
    astropy: Any = SimpleNamespace(clocks=lambda jd: (63.0, 0.5), in_frame=None, apparent=None)
    monkeypatch.setattr(frames, "simulate", lambda scene, settings: path)
    monkeypatch.setattr(frames, "turned", lambda places, ut1, level, moved: ut1)
    monkeypatch.setattr(frames, "seen", lambda package, source, body, jd, steps, moving: (steps > 0, moving))
    monkeypatch.setattr(frames, "_row", lambda name, unit, ours, theirs: (name, ours))
    rows = dict(frames._rows(astropy))
    days = (rows["ground track of a satellite, ITRS: and UT1 - UTC"]() - frames.START) * frames.DAY
    assert days == pytest.approx([-62.5, 43200.0 - 62.5], abs=1e-4)
    mars = [rows[f"Mars from the Earth: {name}"]() for name in ("geometric", "light time", "and aberration")]
    assert mars == [(False, False), (True, False), (True, True)]


@pytest.mark.parametrize(("gaps", "shown"), [([2e-5, 7e-4, np.inf], None), ([2e-5, np.nan], None), ([2e-5], 2e-5)])
def test_a_compliance_that_is_not_finite_is_unknown_and_its_curve_ends(monkeypatch, android, gaps, shown):
    held = np.array([[0.0, 0.0], *([0.1 * (k + 1), gap] for k, gap in enumerate(gaps))])
    path = motion(android, step_compliance=held)
    monkeypatch.setattr(androids, "with_test", lambda scene, settings, tested: (path, path, 3e-6))
    measured = Measured()
    androids.add_run(measured, android, androids.Settings(method="rk4", step=1e-4))
    assert measured.tables["runs"][0]["compliance"] == shown
    (line,) = measured.curves.values()
    assert line.lines["|C|"] == tuple(gap for gap in gaps if np.isfinite(gap))


def test_the_head_and_the_hip_are_each_their_own_body(monkeypatch, android):
    """The hip is the bottom."""
    paths = [motion(android), motion(android)]
    apart = np.zeros((len(paths[0].times), len(android.bodies), 4))
    apart[0] = 9.0  # at the start they are where the scene has them
    apart[1, android.body_index("head"), 0], apart[-1, android.body_index("bottom"), 0] = 0.25, 0.5
    monkeypatch.setattr(androids, "distances", lambda scene, one, other: apart)
    monkeypatch.setattr(androids, "truth_for", lambda *given: None)
    monkeypatch.setattr(androids, "off_truth", lambda *given: None)
    monkeypatch.setattr(androids.ladder, "grid", lambda scene: paths[0].times)
    row = androids.add_convergence(Measured(), android, dict(zip(androids.UNLIKE, paths, strict=True)))
    assert (row["head"], row["hip"]) == (0.25, 0.5)
