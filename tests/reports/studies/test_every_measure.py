"""What a study measures is all that its pieces return, each made from its own scene and setting.

Pieces that run scenes or engines are replaced by ones that note what they are given, and return what is theirs alone.
"""

from __future__ import annotations

import math
import random
from contextlib import nullcontext
from dataclasses import replace
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.contact.by_figure import Obtained
from cross_checks.contact.tosses import Summary
from cross_checks.engine.method import Method
from cross_checks.judge.vocabulary import OURS, Cell, TargetResult, Verdict
from cross_checks.records.numbers import in_words, order_of
from cross_checks.records.record import Error, Record
from mbs_ref import scenes
from mbs_ref.scene import SpringDamper
from mbs_ref.scenes.solar_system import julian_date
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing, Trajectory
from reports.facts.curves import Curves, Measured
from reports.studies import androids, contact, crash, crashes, models, pairs, papers, sky, space
from reports.studies.papers import lessons, track_figures
from reports.studies.sky import frames


def piece(name: str) -> Measured:
    """Return figures, tables, curves and films under a name of their own."""
    line = Curves((0.0,), {name: (1.0,)}, name)
    return Measured({name: 1.0}, {name: ({"a": name},)}, {name: line}, {name: name})  # type: ignore[dict-item]


def merged(*names: str) -> Measured:
    """Return what pieces of these names are together."""
    whole, parts = Measured(), [piece(name) for name in names]
    for part in parts:
        for kind in ("figures", "tables", "curves", "films"):
            getattr(whole, kind).update(getattr(part, kind))
    return whole


def method_of(name: str, kind: Any = "adaptive") -> Method:
    return Method(name, kind, 4, "about")


# --- contact -----------------------------------------------------------------------------------------------


def test_the_study_of_contact(monkeypatch):
    """Tosses by each engine, ours first; few of them unless all are asked for; the others by their own pieces."""
    tosses, asked = list(range(10)), []
    summary = Summary("x", "m", 7, 1, None, "", "", 0.25, 1e-4, "why")
    monkeypatch.setattr(contact, "models", lambda: ({"x": 1, "y": 2}, ["absent"]))
    monkeypatch.setattr(contact, "with_contact", lambda: {"s": 1, "t": 2})
    monkeypatch.setattr(contact, "stored", lambda: tosses)
    monkeypatch.setattr(contact, "predict", lambda *given, engine: asked.append((*given, engine)) or ["predicted"])
    known = Summary("y", "n", 5, 0, 2e-3, "1e-3 to 3e-3", "q", 0.5, 1e-4, "")
    monkeypatch.setattr(contact, "summaries", lambda predicted: [summary, known] if predicted == ["predicted"] else [])
    assert contact.parts() == [
        *(("tosses", one) for one in (OURS, "x", "y")), ("vehicle",), ("laws",), ("engines", "s"), ("engines", "t")
    ]  # fmt: skip
    for full, shown in ((False, tosses[::4]), (True, tosses)):
        found = contact.measure_part(("tosses", "x"), full)
        assert asked.pop() == (shown, {"x": 1, "y": 2}, contact.TOSSES_STEP, "x")
        assert found.figures == {"tosses.shown": len(shown), "tosses.stored": 10}
        unknown, whole = found.tables["tosses"]
        assert (unknown["error"], unknown["share"], unknown["failed"]) == ("why", "", 1)
        assert (whole["error"], whole["share"], whole["interval"]) == (2e-3, 0.5, "1e-3 to 3e-3")
    rows = [Obtained("s", "x", "rk4", 1e-3, "depth, m", 0.1, 1e-3, 0.2, 0.01),
            Obtained("s", "y", "rk4", 1e-3, "depth, m", 0.1, 1e-3, reason="stopped"),
            Obtained("s", "z", "rk4", 1e-3, reason="refused")]  # fmt: skip
    monkeypatch.setattr(contact, "compare", lambda *given: asked.append(given) or rows)
    first, second, third = contact.measure_part(("engines", "bouncing_ball")).tables["engines"]
    ((able, cases, step),) = asked
    assert (able, list(cases), step) == ({"x": 1, "y": 2}, ["bouncing_ball"], contact.ENGINES_STEP)
    assert cases["bouncing_ball"].name == "bouncing_ball"
    columns = ("engine", "figure", "requested", "obtained", "change")
    assert [first[name] for name in columns] == ["x", "depth, m", 0.1, 0.2, 0.01]
    assert [second[name] for name in columns] == ["y", "depth, m", 0.1, "stopped", None]
    assert [third[name] for name in columns] == ["z", "refused", "", "", ""]


def test_every_scene_of_the_study_of_contact_is_compared(monkeypatch):
    """Scenes that are not in the library, too."""
    compared: list[str] = []
    monkeypatch.setattr(contact, "models", lambda: ({}, []))
    monkeypatch.setattr(contact, "compare", lambda able, cases, step: compared.extend(cases) or [])
    for part in contact.parts():
        if part[0] == "engines":
            contact.measure_part(part)
    assert compared == [*contact.with_contact()]


def test_laws_and_the_vehicle_of_the_study_of_contact(monkeypatch):
    monkeypatch.setattr(contact, "ladder", lambda law, way: {"law": law, "events": way, "order": f"{law} {way}"})
    monkeypatch.setattr(contact, "_restitution", lambda law: {"law": law})
    monkeypatch.setattr(contact, "_line", lambda row: row["order"])
    found = contact.measure_part(("laws",))
    ways = list(product(("spring_damper", "progressive"), ("none", "located")))
    assert found.figures == {f"order.{law}.{way}": f"{law} {way}" for law, way in ways}
    assert found.curves == {f"order: {law}, events {way}": f"{law} {way}" for law, way in ways}
    assert [row["law"] for row in found.tables["restitutions"]] == list(contact.LAWS)
    assert [(row["law"], row["events"]) for row in found.tables["orders"]] == ways
    path = SimpleNamespace(times=np.array([0.0, 2.0]))
    energy = contact.Balance(np.array([0.0, 0.1]), np.array([5.0, 9.0, 4.0]), np.array([0.0, 3.0, -2.5]), 8.0)
    made = SimpleNamespace(name="tracked_vehicle", description="of steel")
    monkeypatch.setattr(contact.scenes, "make", {made.name: made}.__getitem__)  # making the whole one takes seconds
    monkeypatch.setattr(contact, "finished", lambda scene, settings: path)
    monkeypatch.setattr(contact, "balance", lambda scene, settings, longest: energy)
    monkeypatch.setattr(contact, "vehicle_curves", lambda *given: {"a": given[1] is path and given[2] is energy})
    monkeypatch.setattr(contact, "film", lambda scene, path, every: f"{scene.name} every {every}")
    found = contact.measure_part(("vehicle",))
    assert found.figures == {
        "vehicle.description": "of steel", "vehicle.t_end": 2.0,
        "vehicle.energy_end": 0.1, "vehicle.exchanged": 8.0, "vehicle.drift": pytest.approx(1.5)}  # fmt: skip
    assert (found.curves, found.films) == ({"vehicle: a": True}, {"vehicle": f"tracked_vehicle every {contact.FILMED}"})


# --- androids ----------------------------------------------------------------------------------------------


def test_the_study_of_the_androids(monkeypatch):
    """Each crash by our methods and by every entrant of its own, each android's stable steps once."""
    offered = {("android_simplified", "front"): ["a", "b"], ("android_vertebral", "rear"): ["c"]}
    key = lambda scene: (scene.name, scene.parameters["impact"])  # noqa: E731
    monkeypatch.setattr(
        androids, "entrants", lambda scene: [("exudyn", method_of(name)) for name in offered.get(key(scene), [])]
    )
    crashes_ = list(product(crash.NAMES, crash.IMPACTS))
    assert androids.parts() == [
        *(("methods", *one) for one in crashes_), *(("stable", name) for name in crash.NAMES),
        *(("engines", *one, "exudyn", name) for one in crashes_ for name in offered.get(one, ()))]  # fmt: skip
    seen: list[Any] = []
    runs = [(Settings(method=method, rtol=rtol), f"{method} {rtol:g}")
            for method in ("dop853", "radau", "lsodar") for rtol in (1e-4, 1e-9)]  # fmt: skip
    monkeypatch.setattr(androids, "add_numerics", lambda measured, scene: seen.append(key(scene)) or runs)
    monkeypatch.setattr(androids, "add_convergence", lambda measured, scene, paths: seen.append(paths))
    monkeypatch.setattr(androids, "add_stable", lambda measured, scene: seen.append(scene.parameters["model"]))
    measured = androids.measure_part(("methods", "android_simplified", "rear"))
    assert measured.tables == {"engines": ()}
    assert seen == [("android_simplified", "rear"), {name: f"{name} 1e-09" for name in androids.UNLIKE}]
    androids.measure_part(("stable", "android_vertebral"))
    assert seen.pop() == "paper"
    monkeypatch.setattr(androids, "Store", lambda path: nullcontext("store"))
    monkeypatch.setattr(androids, "Runs", lambda store, longest: (store, longest))
    monkeypatch.setattr(androids.engines, "get", lambda name: SimpleNamespace(method=lambda own: f"{name} {own}"))
    monkeypatch.setattr(androids, "longest", lambda full: 7.0 + full)
    monkeypatch.setattr(androids, "peer", lambda runs, scene, engine, method: {"row": (runs, key(scene), method)})
    for full in (False, True):
        found = androids.measure_part(("engines", "android_simplified", "rear", "exudyn", "rk4"), full)
        row = (("store", 7.0 + full), ("android_simplified", "rear"), "exudyn rk4")
        assert found.tables == {"engines": ({"row": row},)}


@pytest.mark.parametrize("packages", [True, False])
def test_every_android_is_run_by_its_own_methods(monkeypatch, packages):
    """Fixed steps of the android, tolerances of the crash, and no method whose package is absent."""
    monkeypatch.setattr(androids, "find_spec", lambda name: packages or None)
    monkeypatch.setattr(androids, "add_run", lambda measured, scene, settings: settings.method)
    need = {name for name, method in androids.integrators().items() if method.package}
    for impact, own in (("front", "android_simplified, front"), ("rear", "others")):
        scene, measured = scenes.make("android_simplified", impact=impact, **crash.PAPER), Measured()
        runs = androids.add_numerics(measured, scene)
        stated = [*androids.RUNS["fixed"][scene.name], *androids.RUNS["adaptive"][own]]
        stated = [one for one in stated if packages or one["method"] not in need]
        assert [(s.method, s.step, s.rtol) for s, _ in runs] == [
            (one["method"], one.get("step"), one.get("rtol")) for one in stated]  # fmt: skip
        assert [path for _, path in runs] == [one["method"] for one in stated]
        assert measured.tables == {"androids": ({"android": f"android_simplified, {impact}"},)}


def test_another_engines_method_is_judged_and_its_joint_forces_compared(monkeypatch):
    """At the setting that speaks for the method; the first crash has every method, the others those of a list."""
    scene = scenes.make("android_simplified", impact="front", **crash.PAPER)
    able = {"exudyn": ["tree_dopri5", "other"], "mbs_ref": ["rk4"], "pinocchio": ["dop853"]}
    engines = [SimpleNamespace(name=name, able=lambda scene, own=own: [method_of(one) for one in own])
               for name, own in able.items()]  # fmt: skip
    monkeypatch.setattr(androids.engines, "installed", lambda: engines)
    others = [(name, method) for name, own in able.items() for method in own if name != "mbs_ref"]
    assert [(name, one.name) for name, one in androids.entrants(scene)] == others
    rear = scenes.make("android_simplified", impact="rear", **crash.PAPER)
    listed = androids.RUNS["engines"]["android_simplified, rear"]
    assert [f"{name} {one.name}" for name, one in androids.entrants(rear)] == [
        f"{name} {method}" for name, method in others if f"{name} {method}" in listed]  # fmt: skip
    records = {k: Record(scene.name, {}, "exudyn", "m", {"method": "m", "step": 0.1 / k}, "success") for k in (1, 2, 4)}
    cell = Cell(scene.name, {}, "exudyn", "m", Verdict.CONVERGING, "because", error=3e-5, order=2.1, documented_order=2,
                setting="step=0.05", loop_s=0.7)  # fmt: skip
    asked: list[Any] = []
    monkeypatch.setattr(androids, "search", lambda *given: asked.append(given) or (SimpleNamespace(records=records), 1))
    monkeypatch.setattr(androids, "cell_of", lambda tried, answers: cell if tried.records and answers == 1 else None)
    monkeypatch.setattr(androids, "_ours", lambda *given: given)

    def again(scene: Any, engine: str, settings: Settings, times: Any, truth: Any, reference: Any) -> Any:
        asked.append((engine, settings.step, reference))
        return SimpleNamespace(measure={"reaction_error": 0.25}.get), None

    monkeypatch.setattr(androids, "judged_run", again)
    runs: Any = SimpleNamespace(truth=lambda scene: "truth")
    for kind in ("adaptive", "fixed"):
        row = androids.peer(runs, scene, "exudyn", method_of("m", kind))
        assert row == {
            "android": "android_simplified, front", "method": "exudyn m", "verdict": f"{cell.verdict} {cell.code}",
            "error": 3e-5, "order": order_of(2.1, 2), "setting": in_words("step=0.05"), "loop_s": 0.7, "forces": 0.25,
            "reason": "because",
        }  # fmt: skip
        assert asked[-2][4:] == ("truth", androids.PEER_TARGETS[kind])
        assert asked[-1] == ("exudyn", 0.05, ("android_simplified", "front"))
    monkeypatch.setattr(androids, "cell_of", lambda tried, answers: Cell("s", {}, "e", "m", Verdict.LOST, "why"))
    row = androids.peer(runs, scene, "exudyn", method_of("m"))
    assert [row[name] for name in ("order", "setting", "forces", "error")] == ["–", "–", None, None]


# --- crashes, the sky, space and models --------------------------------------------------------------------


def test_the_study_of_the_crashes(monkeypatch):
    """Bare androids with curves and tables, believable ones with figures of their own kind."""
    seen: list[Any] = []
    key = lambda scene: (scene.name, scene.parameters["impact"], scene.parameters["model"])  # noqa: E731
    monkeypatch.setattr(crash, "finished", lambda scene: ("path", key(scene)))
    monkeypatch.setattr(crashes, "add_crash", lambda measured, scene, path: seen.append((key(scene), path)))
    monkeypatch.setattr(
        crashes, "add_figures", lambda measured, scene, path, kind: seen.append((key(scene), path, kind))
    )
    monkeypatch.setattr(crashes, "sled_rows", lambda: "rows")
    found, whole = crashes.measure(), scenes.make("android_simplified").parameters["model"]
    expected: list[Any] = []
    for impact, name in product(("front", "rear"), crash.NAMES):
        bare, solid = (name, impact, "paper"), (name, impact, whole)
        expected += [(bare, ("path", bare)), (solid, ("path", solid), ".solid")]
    assert seen == expected
    assert found.tables == {"sled": "rows"}


def test_the_study_of_the_sky(monkeypatch):
    seen: dict[str, Any] = {}
    noted = lambda name: lambda measured, *given: seen.setdefault(name, []).append(given)  # noqa: E731
    monkeypatch.setattr(sky, "observed", lambda scene, engine, settings: (dict(scene.parameters), engine, settings))
    for name in ("add_levels", "add_formulations", "add_splitting", "add_orbits"):
        monkeypatch.setattr(sky, name, noted(name))
    monkeypatch.setattr(sky, "comparisons", lambda: "frames")
    monkeypatch.setattr(sky, "by_sgp4", lambda: "sgp4")
    monkeypatch.setattr(sky.ephemerides, "figures", lambda version, jd: {"version": version, "jd": jd})
    scene = scenes.make("solar_system", model="newton")
    year = SimpleNamespace(position=np.random.default_rng(1).normal(size=(3, len(scene.bodies), 3)))
    asked: list[Any] = []
    monkeypatch.setattr(sky.engines, "get", lambda name: SimpleNamespace(
        run=lambda scene, settings: asked.append((name, scene.parameters["model"], settings)) or year))  # fmt: skip
    found = sky.measure()
    ((levels,),), ((rows,),) = seen["add_levels"], seen["add_formulations"]
    assert [one["model"] for one, _, _ in levels] == list(sky.LEVELS)
    assert {(engine, settings.method, settings.rtol) for _, engine, settings in levels} == {("mbs_ref", "gauss", 1e-16)}
    plain = scene.parameters["formulation"]
    kinds = [(plain, False), ("euler_parameters", False), ("euler_parameters", True)]
    assert [(one["days"], one["formulation"], one["spin"]) for one, _, _ in rows] == [
        (days, kind, spin) for days in (200.0, 360.0) for kind, spin in kinds
    ]
    assert {settings.method for _, _, settings in rows} == {"dop853"}
    assert len(seen["add_splitting"]) == 1
    jd = julian_date("1998-01-01") + 360.0
    assert found.tables == {
        "figures: Other ephemerides at the same time": tuple(
            {"name": name, "version": version, "jd": jd} for version, name in sky.EPHEMERIDES.items()),
        "frames": "frames", "sgp4": "sgp4"}  # fmt: skip
    ((engine, model, settings),) = asked
    assert (engine, model, settings.samples) == ("mbs_ref", "newton", 361)
    ((paths,),) = seen["add_orbits"]
    assert list(paths) == scene.body_names
    assert all(np.array_equal(path, year.position[:, k]) for k, path in enumerate(paths.values()))


def test_a_satellite_by_sgp4_after_an_hour_a_day_and_a_week(monkeypatch):
    """A sample each ten minutes; the first place and velocity are what SGP4 starts from."""
    rng, asked = np.random.default_rng(6), []
    runs = {}

    def run(scene: Any, settings: Settings) -> Any:
        times = np.linspace(0.0, scene.duration, settings.samples)
        path = SimpleNamespace(times=times, position=rng.normal(size=(len(times), 2, 3)),
                               velocity=rng.normal(size=(len(times), 2, 3)))  # fmt: skip
        runs[scene.parameters["orbit"]] = path
        return path

    off = lambda times: np.stack((times, 2.0 * times, -2.0 * times), axis=1)  # noqa: E731
    propagated = lambda place, rate, times: asked.append((place, rate)) or off(times) + current().position[:, 1]  # noqa: E731
    current = lambda: list(runs.values())[-1]  # noqa: E731
    monkeypatch.setattr(frames, "simulate", run)
    monkeypatch.setattr(frames, "import_module", lambda name: SimpleNamespace(propagated=propagated))
    monkeypatch.setattr(frames, "find_spec", lambda name: name)
    rows = frames.by_sgp4()
    assert [row["orbit"] for row in rows] == ["leo", "sun_synchronous", "gps"] == list(runs)
    for row, path, (place, rate) in zip(rows, runs.values(), asked, strict=True):
        assert np.array_equal(place, path.position[0, 1])
        assert np.array_equal(rate, path.velocity[0, 1])
        for hours in (1, 24, 168):
            assert row[f"after_{hours}"] == pytest.approx(3.0 * 3600.0 * hours)
    monkeypatch.setattr(frames, "find_spec", lambda name: None)
    assert frames.by_sgp4() == ()


def test_other_studies_are_their_pieces(monkeypatch):
    monkeypatch.setattr(space, "_long_steps", lambda: {"long": 1.0})
    monkeypatch.setattr(space, "_cost_ratio", lambda: 2.0)
    monkeypatch.setattr(space, "_norm_drift", lambda half: {"half": half})
    found = space.measure()
    assert found.figures == {"long": 1.0, "space.cost_ratio": 2.0}
    assert found.tables == {"norm": ({"half": 0.05}, {"half": 0.1}, {"half": 0.2})}
    monkeypatch.setattr(models, "built", lambda name: f"built {name}")
    monkeypatch.setattr(models, "shown", list)
    assert models.measure() == [f"built {name}" for name in models.LADDERS]  # type: ignore[comparison-overlap]
    monkeypatch.setattr(pairs, "Store", lambda path: nullcontext("store"))
    monkeypatch.setattr(pairs, "Runs", lambda store, longest: (store, longest))
    monkeypatch.setattr(pairs, "longest", lambda full: 7.0 + full)
    monkeypatch.setattr(pairs, "pair", lambda runs, request: (runs, request.title))
    monkeypatch.setattr(pairs, "shown", lambda *given: given)
    monkeypatch.setattr(pairs, "sky_places", lambda: "places")
    for full in (False, True):
        rows = [(one.title, one.note, (("store", 7.0 + full), one.title)) for one in pairs.PAIRS]
        assert pairs.measure(full) == (rows, "places")  # type: ignore[comparison-overlap]
    observed = SimpleNamespace(figures={"earth": 3.0, "moon": 1.5, "mars": 2.0})
    asked: list[Any] = []
    monkeypatch.setattr(models, "observed", lambda *given: asked.append(given) or observed)
    scene = scenes.make("solar_system", model="newton")
    assert models._bodies(scene) == ({"bodies": float(len(scene.bodies))}, 1.5)
    stated = models.LADDERS["planets"]["settings"]
    assert (asked[0][1], asked[0][2]) == ("mbs_ref", Settings(**stated))


# --- the papers --------------------------------------------------------------------------------------------


def test_the_study_of_the_papers(monkeypatch):
    lesson = ("lesson one", "lesson two")
    monkeypatch.setattr(papers, "measure_crash", lambda: piece("crash"))
    monkeypatch.setattr(papers, "measure_track", lambda: piece("track"))
    monkeypatch.setattr(papers, "measure_lessons", lambda: tuple(map(piece, lesson)))
    others = ("measure_sky", "multipliers", "coordinates", "satellites", "_indices")
    for name in others:
        monkeypatch.setattr(papers, name, lambda name=name: {name: name})
    monkeypatch.setattr(papers, "euler_angles", lambda tilt: {"tilt": tilt})
    monkeypatch.setattr(papers, "outline_pictures", lambda: {"outlines": ()})
    found, whole = papers.measure(), merged("crash", "track", *lesson)
    angles = {f"angles.{tilt:g}.tilt": tilt for tilt in (0.1, 1e-3, 1e-8)}
    assert found.figures == whole.figures | {name: name for name in others} | angles
    assert (found.tables, found.curves, found.films) == ({"outlines": ()}, whole.curves, whole.films)
    parts = ("step_rules", "block_inversion", "orders", "leading_matrix", "counted_rows", "soles", "softer")
    for name in parts:
        monkeypatch.setattr(lessons, name, lambda name=name: {name: name})
    monkeypatch.setattr(lessons, "lsodar_series", lambda: piece("series"))
    monkeypatch.setattr(lessons, "crash_range", lambda: piece("range"))
    assert lessons.measure_lessons() == (piece("series"), piece("range"), Measured({name: name for name in parts}))


@pytest.mark.parametrize(("links", "count"), [(4, papers.CALLS // 4), (7, papers.CALLS // 7)])
def test_a_loop_of_right_hand_sides_is_timed_by_the_processor_per_body(monkeypatch, links, count):
    asked: list[Any] = []
    clock = iter((2.0, 5.5))
    started: list[Any] = []
    system = SimpleNamespace(
        model="model", work="work", initial_state=lambda: np.zeros(3),
        set_mode_time=started.append, start_contacts=lambda *given: started.append(given[2]),
    )  # fmt: skip
    monkeypatch.setattr(papers, "compile_scene", lambda scene, coordinates: asked.append(coordinates) or system)
    given = lambda model, work, y, dy, count: (model, work, y is dy) == ("model", "work", False) and count  # noqa: E731
    monkeypatch.setattr(papers, "_repeat", lambda *words: asked.append(given(*words)))
    monkeypatch.setattr(papers, "process_time", lambda: next(clock))
    timed = papers._loop(scenes.make("pendulum_chain", links=links), "relative")
    assert asked == ["relative", 1]
    assert started == [0.0, True]
    assert timed().loop_s == 3.5
    assert asked[-1] == count


class Made:
    """A scene of three bodies, wheels and a spring, and runs of it with prescribed ends."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        names = ("chassis", "idler", "roller2")
        wheels = [SimpleNamespace(body_a="idler", type="circle_on_circle", radius=9.0),
                  SimpleNamespace(body_a="roller2", type="circle_on_line", radius=0.2),
                  SimpleNamespace(body_a="idler", type="circle_on_line", radius=0.3)]  # fmt: skip
        end = {"point_a": (0.0, 0.0), "point_b": (1.0, 0.0), "stiffness": 1.0}
        spring = lambda name: SpringDamper(name=name, body_a="chassis", body_b="idler", **end)  # noqa: E731
        loads = (SimpleNamespace(name="idler.tensioner"), spring("other"), spring("idler.tensioner"))
        self.scene: Any = SimpleNamespace(body_index=names.index, contacts=wheels, loads=loads, name="made")

    def run(self, n: int = 7, **more: Any) -> Trajectory:
        shapes = (3, 2), (3,), (3, 2), (3,)
        return Trajectory(np.arange(float(n)), *(self.rng.normal(size=(n, *one)) for one in shapes), **more)

    def ride(self, path: Trajectory, pulls: np.ndarray) -> dict[str, Any]:
        """Return what a drive comes to: means over its second half."""
        half = len(path.times) // 2
        rim, speed = -0.3 * path.angular_velocity[half:, 1], path.velocity[half:, 0, 0]
        return {"travelled": path.position[-1, 0, 0] - path.position[0, 0, 0], "speed": speed[-1],
                "idler_slip": rim.mean() / speed.mean() - 1.0, "tension": -0.5 * pulls[half:].mean()}  # fmt: skip


@pytest.mark.parametrize("end", ["success", "stopped", "missing"])
def test_a_ride_by_our_contacts_and_by_an_engines_own(monkeypatch, end):
    made, pulls = Made(5), {}

    def tension(path: Trajectory, load: Any) -> np.ndarray:
        assert load.name == "idler.tensioner"
        assert isinstance(load, SpringDamper)
        return pulls.setdefault(id(path), made.rng.normal(size=len(path.times)))

    def get(name: str) -> Any:
        if end == "missing":
            raise track_figures.engines.EngineMissing("not installed")
        return SimpleNamespace(run=lambda scene, settings, times: asked.append((name, settings, times)) or theirs)

    ours, asked = made.run(), []
    theirs = made.run(status=track_figures.Status.SUCCESS if end == "success" else track_figures.Status.NON_FINITE,
                      message="NaN")  # fmt: skip
    monkeypatch.setattr(track_figures, "Motion", lambda scene, path: path)
    monkeypatch.setattr(track_figures, "tension", tension)
    monkeypatch.setattr(track_figures, "own_engine", get)
    found = track_figures._own_contacts(made.scene, ours)
    expected = {f"track.{name}": value for name, value in made.ride(ours, pulls[id(ours)]).items()}
    if end == "success":
        own = made.ride(theirs, pulls[id(theirs)])
        expected |= {f"track.mujoco.{name}": value for name, value in own.items()}
    elif end == "stopped":
        expected["track.mujoco.message"] = "NaN"
    assert found == pytest.approx(expected)
    for name, settings, times in asked:
        assert (name, settings.method, settings.step) == ("mujoco", "euler", 2e-4)
        assert np.array_equal(times, ours.times)


def test_engines_on_the_track_and_wheels_that_are_held(monkeypatch):
    """An engine's distance, message or absence; what constraints change is at the chassis and at any time."""
    made = Made(6)
    fine, path = made.run(), made.run()
    stopped = made.run(status=track_figures.Status.SINGULAR, message="singular")
    monkeypatch.setattr(track_figures, "farthest", lambda scene, one, other: [0.5, 9.0] if other is fine else [7.0])
    for given, expected in ((path, 0.5), (stopped, "singular")):
        monkeypatch.setattr(track_figures.engines, "get", lambda name, given=given: SimpleNamespace(
            run=lambda scene, settings, times: given))  # fmt: skip
        assert track_figures._engine(made.scene, "exudyn", Settings(), fine) == expected

    def absent(name: str) -> Any:
        raise track_figures.engines.EngineMissing("no")

    monkeypatch.setattr(track_figures.engines, "get", absent)
    assert track_figures._engine(made.scene, "exudyn", Settings(), fine) == "not installed"
    gap = np.random.default_rng(3).uniform(size=(7, 3, 4))
    gap[3, 0, 0] = 5.0
    steps = np.array([[0.0, 3e-9], [1.0, 1e-9]])
    for ended in (track_figures.Status.SUCCESS, track_figures.Status.SINGULAR):
        held = made.run(events=7, rhs_calls=90, step_compliance=steps, status=ended, message="stuck")
        soft = made.run(events=5, rhs_calls=30)
        law = lambda scene, *given, held=held, soft=soft: held if scene == "constraint" else soft  # noqa: E731
        monkeypatch.setattr(track_figures, "simulate", law)
        monkeypatch.setattr(track_figures.scenes, "make", lambda name, law="soft", **more: _Scene(law))
        monkeypatch.setattr(track_figures, "distances", lambda scene, one, other: gap)
        ok = ended is track_figures.Status.SUCCESS
        assert track_figures._held(np.arange(7.0)) == {
            "track.held.status": "success" if ok else "stuck", "track.held.events": 7.0, "track.soft.events": 5.0,
            "track.held.calls": 3.0, "track.held.compliance": 3e-9, "track.held.apart": 5.0 if ok else "stopped",
        }  # fmt: skip


class _Scene(str):
    def body_index(self, name: str) -> int:
        assert name == "chassis"
        return 0


@pytest.mark.parametrize("seed", range(2))
def test_a_large_libration_and_the_frequency_of_a_small_one(monkeypatch, seed):
    """A pitch that swings as a cosine of known frequency, about a place that goes round in a plane."""
    chance = random.Random(seed)
    factor, n = chance.uniform(0.9, 1.1), 401
    scene = scenes.make("librating_satellite", pitch=papers.SMALL)
    body: dict[str, Any] = scene.parameters
    share = 3.0 * (body["roll_inertia"] - body["yaw_inertia"]) / body["pitch_inertia"]
    times, turns = np.linspace(0.0, scene.duration, n), 2.0 * math.pi * body["orbits"]
    phase = turns * times / times[-1]
    angle = phase + 1e-3 * np.cos(factor * math.sqrt(share) * phase)
    place, orientation = np.zeros((n, 2, 3)), np.zeros((n, 2, 4))
    place[:, 1, :2] = 7e6 * np.stack((np.cos(phase), np.sin(phase)), axis=1)
    orientation[:, :, 0] = 1.0
    orientation[:, 1] = np.stack((np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)), axis=1)
    orientation[7, 1] *= math.sqrt(1.0 + 4e-9)
    path = Trajectory(times, place, orientation, 0.0 * place, 0.0 * place, timing=Timing())
    asked: list[float] = []
    monkeypatch.setattr(papers, "simulate", lambda scene, settings: asked.append(scene.parameters["pitch"]) or path)
    monkeypatch.setattr(papers, "off_truth", lambda scene, path: [1.0, 2e-9, 3.0, 4.0])
    found = papers.satellites()
    assert found == {"satellite.frequency": pytest.approx(factor, rel=1e-3), "satellite.off": 2e-9,
                     "satellite.norm": pytest.approx(4e-9)}  # fmt: skip
    assert asked == [papers.SMALL, papers.LARGE]
    monkeypatch.setattr(papers, "off_truth", lambda scene, path: None)
    assert papers.satellites()["satellite.off"] == "no truth"


@pytest.mark.parametrize("law", contact.LAWS)
def test_a_law_returns_its_restitution_or_that_is_noted(monkeypatch, law):
    ball = contact._ball(law).contacts[0].law
    exact = contact.impact(ball, 1.0, 1.0).restitution
    run = SimpleNamespace(velocity=np.array([[[0.0, 9.0]], [[0.0, exact]]]))
    monkeypatch.setattr(contact, "simulate", lambda scene, settings: run)
    row, nominal = contact._restitution(law), getattr(ball, "restitution", None)
    returned = nominal is None or abs(nominal - exact) <= 1e-3
    assert (row["nominal"], row["note"]) == (nominal, "" if returned else ", not returned")


def test_the_stable_steps_of_an_android_and_what_a_longer_one_does(monkeypatch):
    scene = scenes.make("android_simplified", **crash.PAPER)
    asked: list[Settings] = []
    limits = {name: method.stability for name, method in androids.integrators().items() if method.stability}
    found: Any = SimpleNamespace(
        oscillation_rule=3e-3, damping_rule=math.inf, fastest_decay=77.0, step_limit=lambda stability: stability[0],
        modes=np.array([-1.0 + 2.0j, -3.0 - 4.0j]),
    )  # fmt: skip
    monkeypatch.setattr(androids, "stiffness_at_start", lambda scene: found)

    def run(scene: Any, settings: Settings) -> Any:
        asked.append(settings)
        return SimpleNamespace(status="refused" if settings.refuse_unstable else "non-finite", message="why")

    monkeypatch.setattr(androids, "simulate", run)
    for damping in (math.inf, 4e-3):
        measured, found.damping_rule = Measured(), damping
        androids.add_stable(measured, scene)
        (row,) = measured.tables["stable"]
        rules = "1/omega = 3e-3 s" + ("" if damping == math.inf else ", m/c = 4e-3 s")
        assert (row["android"], row["decay"], row["rules"]) == (scene.name, 77.0, f" The papers' rules: {rules}.")
        assert row["limits"] == ", ".join(f"{name} {androids.short(own[0])} s" for name, own in limits.items())
        assert (row["refusal"], row["forced"]) == ("why", "non-finite: why")
        assert row["beyond"] == androids.RUNS["beyond"][scene.name] == asked[0].step == asked[1].step
        line = measured.curves[f"eigenvalues: {scene.name}"]
        assert (line.x, line.lines["eigenvalues"]) == ((-1.0, -3.0), (2.0, -4.0))


def test_a_pair_has_a_row_for_each_target_and_one_for_who_cannot_run_the_scene(monkeypatch):
    """Who cannot has none at the targets; ratios are over our cheapest, none where ours does not reach."""
    targets = (1e-3, 1e-6)
    loops = {(OURS, 1e-3): 2.0, ("x", 1e-3): 1.0, ("x", 1e-6): 5.0}
    error = lambda target: Error(0.5 * target, "exact", 0.0, None)  # noqa: E731
    runs = {key: Record("pendulum", {}, key[0], "m", {"step": key[1]}, "success", times={"loop_s": loop},
                        error=error(key[1])) for key, loop in loops.items()}  # fmt: skip

    def cells(runs_: Any, scene: Any, engine: str, request: Any) -> list[Cell]:
        if engine == "z":
            return [Cell("pendulum", {}, "z", f"m{k}", Verdict.CANNOT, why) for k, why in enumerate(("no ropes", "no"))]
        results = [TargetResult(t, "reached" if (engine, t) in runs else "not-reached", runs.get((engine, t)), "off")
                   for t in targets]  # fmt: skip
        return [Cell("pendulum", {}, engine, "m", Verdict.AGREES, "", targets=tuple(results))]

    monkeypatch.setattr(pairs, "_cells", cells)
    monkeypatch.setattr(pairs, "_timed", lambda store, scene, data, targets: tuple(runs.values()))
    request: Any = SimpleNamespace(rivals=("x", "z"), targets=targets)
    rows = list(pairs.compared(SimpleNamespace(store=None), scenes.make("pendulum"), request))  # type: ignore[arg-type]
    assert [(row.target, row.entry.engine, row.entry.answer, row.ratio) for row in rows] == [
        (1e-3, "x", "reached", 0.5), (1e-3, OURS, "reached", 1.0), (1e-6, "x", "reached", None),
        (1e-6, OURS, "not-reached", None), (None, "z", "cannot", None)]  # fmt: skip
    assert (rows[-1].entry.reason, {row.constrained for row in rows[:-1]}) == ("no ropes", {True})


def test_each_setting_that_may_be_the_cheapest_is_timed_once_and_keeps_its_other_times(monkeypatch):
    """One that was timed alone before begins with that time; two of one loop time are two runs."""
    error = Error(1e-9, "exact", 0.0, None)
    runs = {step: Record("pendulum", {}, "x", "m", {"step": step}, "success", times={"loop_s": 2.0, "build_s": 7.0},
                         error=error) for step in (0.25, 0.5)}  # fmt: skip
    offers = {1e-3: [runs[0.25], runs[0.5]], 1e-6: [runs[0.5]]}
    monkeypatch.setattr(pairs, "reaching", lambda data, scene, engine, target: offers[target])
    held = {0.25: replace(runs[0.25], times={"loop_s": 3.0}), 0.5: None}
    monkeypatch.setattr(pairs, "stored_times", lambda store, scene, run: held[run.settings["step"]])
    asked: list[Any] = []
    monkeypatch.setattr(pairs, "least_times", lambda turns, first: asked.append(([
        turn.args[1] for turn in turns], [(one.loop_s, one.cpu_share) for one in first])) or [0.5, 0.75])  # fmt: skip
    data: Any = SimpleNamespace(scenes=["pendulum"], engines=["x"])
    found = pairs._timed(None, scenes.make("pendulum"), data, (1e-3, 1e-6))  # type: ignore[arg-type]
    assert asked == [([runs[0.25], runs[0.5]], [(3.0, 1.0), (2.0, 0.0)])]
    assert [(run.settings["step"], run.times) for run in found] == [
        (0.25, {"loop_s": 0.5, "build_s": 7.0}), (0.5, {"loop_s": 0.75, "build_s": 7.0})]  # fmt: skip
