"""Every pair: both at the same target errors, relative to the scene, and timed in interleaved runs.

Each engine enters every method that it offers for a scene; its row is that of its cheapest. No run starts that cannot
be that: none for a verdict alone, and none that would take longer than the cheapest so far at every target. Places in
the sky are compared with the ephemeris that Astropy contains, without any download.
"""

import importlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge.bounds import longest
from cross_checks.judge.cell import judged, tasks
from cross_checks.judge.ladder import grid
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import ANSWERS, OURS, Cell
from cross_checks.prices.timing import Sample, least_times, stored_times
from cross_checks.records.numbers import duration, metres, setting, short
from cross_checks.records.record import Record, is_busy, loop_time
from cross_checks.records.store import Store, default_path
from mbs_ref import Scene, Settings, scenes
from mbs_ref.files import package_data
from mbs_ref.kernels.particles.directions import moon_place, sun_place
from mbs_ref.scenes.solar_system import julian_date
from mbs_ref.simulate import simulate
from reports.facts.curves import Curves, Measured, Row, Value
from reports.facts.report_data import NEAR, Entry, ReportData, entries, near, reaching

Tables = dict[str, tuple[Row, ...]]

BUILTIN = "astropy_builtin"
START = "1998-01-01"
DAYS = (200.0, 360.0)  # after START, of the planets
J2000 = 2_451_545.0  # JD TDB
SATELLITE_DAYS = (0.0, 100.0, 200.0, 300.0)  # after J2000
FINE = Settings(method="gauss", rtol=1e-16, estimate="off")
CHEAPEST, MARKS = "★ ", "lines+markers"
WORK = 200_000  # steps times bodies that a run may take: the papers' 4000 steps of the android of 48 bodies are within


def sky_places() -> Tables:
    """Return a table of bodies by title: how far apart, and the figures shared. None where astropy is not installed."""
    try:
        astropy = importlib.import_module("cross_checks.ephemerides.astropy_")
    except ModuleNotFoundError:
        return {}
    planets, moons = "planets of our run against Astropy's built-in ephemeris", "Sun and Moon of the satellites' forces"
    tables = {f"places: {planets}, day {days:g}": _compared(_planets(astropy, days)) for days in DAYS}
    return tables | {
        f"places: {moons} against Astropy's, day {days:g}": _compared(_sun_and_moon(astropy, days), by_angle=True)
        for days in SATELLITE_DAYS
    }


def _compared(places: dict[str, tuple[np.ndarray, np.ndarray]], by_angle: bool = False) -> tuple[Row, ...]:
    """Return a row for each body: the distance of our place from theirs, both (3,), m, or the angle between them."""
    rows = []
    for name, (ours, theirs) in places.items():
        gap, size = np.linalg.norm(ours - theirs), np.linalg.norm(theirs)
        cosine = ours @ theirs / (np.linalg.norm(ours) * size)
        apart = f"{short(float(np.arccos(min(cosine, 1.0))))} rad" if by_angle else metres(gap)
        rows.append({"body": name, "apart": apart, "figures": float(-np.log10(gap / size))})
    return tuple(rows)


def _planets(astropy: Any, days: float) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the planets at the end of our run from DE440's start, from the Sun; the Moon from the Earth."""
    scene = scenes.make("solar_system", days=days, start=START)
    ends, jd = simulate(scene, FINE, grid(scene)[[0, -1]]).position[-1], julian_date(START) + days
    ours, places = dict(zip(scene.body_names, ends, strict=True)), {}
    for name in (name for name in ours if name not in ("sun", "pluto")):
        center = "earth" if name == "moon" else "sun"
        with suppress(KeyError):  # a body that the ephemeris lacks
            theirs = astropy.place(BUILTIN, name, jd) - astropy.place(BUILTIN, center, jd)
            places[name] = ours[name] - ours[center], theirs
    return places


def _sun_and_moon(astropy: Any, days: float) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the Sun's and the Moon's place in the satellites' forces, from the Earth."""
    earth, result = astropy.place(BUILTIN, "earth", J2000 + days), {}
    for name, place in (("sun", sun_place), ("moon", moon_place)):
        place(days, ours := np.zeros(3))
        result[name] = ours, astropy.place(BUILTIN, name, J2000 + days) - earth
    return result


@dataclass(frozen=True)
class Request:
    """A pair: its scenes, the engines beside ours, and the targets over the scenes' scales."""

    title: str
    note: str
    scenes: tuple[tuple[str, dict[str, Any]], ...]
    rivals: tuple[str, ...]
    targets: tuple[float, ...] = (1e-3, 1e-6)

    def built(self) -> list[Scene]:
        return [scenes.make(name, **parameters) for name, parameters in self.scenes]

    def entrants(self) -> list[tuple[str, Method | None]]:
        """Return every method of every engine; None for an engine that is not installed."""
        return tasks((OURS, *self.rivals))


PAIRS = TypeAdapter(tuple[Request, ...]).validate_python(package_data(__name__, "pairs.toml")["pairs"])


@dataclass(frozen=True)
class Result:
    """One engine at one target error, by its cheapest method, or the reason why it does not reach it."""

    scene: str
    target: float | None  # over the scene's scales; None where the scene is refused
    entry: Entry  # its loop time is the least of interleaved runs
    constrained: bool = False  # whether the scene has joints
    ratio: float | None = None  # loop time over that of our cheapest at the same target

    def shown(self) -> Row:
        """Return what a page shows: the cells after a reason are empty."""
        entry, run = self.entry, self.entry.best
        head = {"scene": self.scene, "method": f"{entry.engine} {entry.method}".rstrip(), "target": self.target}
        if run is None or run.error is None:
            rest = dict.fromkeys(("error", "compliance", "drift", "loop_s", "ratio"), "")
            return head | {"setting": f"{ANSWERS[entry.answer][0]}: {entry.reason}".rstrip(": ")} | rest
        return head | {
            "setting": setting(run.settings), "error": run.error.value,
            "compliance": run.measure("compliance_position") if self.constrained else "no rows",
            "drift": run.measure("energy_drift"), "loop_s": loop_time(run), "ratio": self.ratio,
        }  # fmt: skip


def measure(full: bool = False) -> Measured:
    """Search and time everything; the store holds the searched runs. `full` makes runs that take long, too."""
    with Store(default_path()) as store:
        rows = [pair(Runs(store, longest=longest(full)), request) for request in PAIRS]
    return shown([(request.title, request.note, own) for request, own in zip(PAIRS, rows, strict=True)], sky_places())


def shown(pairs: Sequence[tuple[str, str, Sequence[Result]]], places: dict[str, tuple[Row, ...]]) -> Measured:
    """Return the tables of pairs, each with title and note, and of places in the sky."""
    heads = tuple({"title": title, "note": note} for title, note, _ in pairs)
    tables = {f"pair: {title}": tuple(row.shown() for row in rows) for title, _, rows in pairs}
    beside = {f"beside: {title}": side_by_side(rows) for title, _, rows in pairs}
    lines = {f"pair: {title}: {scene}": line for title, _, rows in pairs for scene, line in costs(rows).items()}
    return Measured({"pairs.places": len(places)}, {"pairs": heads, **tables, **beside, **places}, lines)


def side_by_side(rows: Sequence[Result]) -> tuple[Row, ...]:
    """Return one row for each scene and engine with its time at each target, the cheapest engine marked."""
    columns: dict[float | None, str] = {target: f"within {short(target)}" for target in _targets(rows)}
    result: dict[tuple[str, str], dict[str, Value]] = {}
    first: dict[tuple[str, float | None], Result] = {}
    for row in rows:
        head: dict[str, Value] = {"scene": row.scene, "engine": row.entry.engine, **dict.fromkeys(columns.values(), "")}
        cells = result.setdefault((row.scene, row.entry.engine), head)
        run = row.entry.best
        if run is None:
            text = f"{ANSWERS[row.entry.answer][0]}: {row.entry.reason}".rstrip(": ")
        else:
            mark = CHEAPEST if first.setdefault((row.scene, row.target), row) is row else ""
            text = f"{mark}{duration(loop_time(run))}, {row.entry.method}"
        cells[columns.get(row.target, next(iter(columns.values()), "reason"))] = text
    return tuple(result.values())


def costs(rows: Sequence[Result]) -> dict[str, Curves]:
    """Return for each scene, with its cheapest engines, the loop time (s) of every engine over the target error."""
    targets = _targets(rows)
    times = {(row.scene, row.entry.engine, row.target): loop_time(row.entry.best) for row in rows if row.entry.best}
    result = {}
    for scene in dict.fromkeys(scene for scene, _, _ in times):
        at = [{name: time for (where, name, error), time in times.items() if (where, error) == (scene, target)}
              for target in targets]  # fmt: skip
        first = dict.fromkeys(min(own, key=own.__getitem__) for own in at if own)
        lines = {name: tuple(own.get(name) for own in at) for name in dict.fromkeys(name for own in at for name in own)}
        curves = Curves(targets, lines, "loop time, s", "error over the scene's scales", True, True, MARKS)
        result[f"{scene} {CHEAPEST}{', '.join(first)}"] = curves
    return result


def _targets(rows: Sequence[Result]) -> tuple[float, ...]:
    return tuple(sorted({row.target for row in rows if row.target is not None}, reverse=True))


def pair(runs: Runs, request: Request) -> tuple[Result, ...]:
    """Return the rows of every scene of a pair, and of every engine."""
    return tuple(row for scene in request.built() for row in compared(runs, scene, request))


def compared(runs: Runs, scene: Scene, request: Request) -> Iterator[Result]:
    """Yield a row for each target and engine, the cheapest first, and one for each engine that cannot run the scene."""
    offered = [_cells(runs, scene, engine, request) for engine in (OURS, *request.rivals)]
    data = ReportData(tuple(cell for cells in offered for cell in cells), ())
    label = data.scenes[0]
    able = {cell.engine for cell in data.cells if not cell.is_refused}
    data = replace(data, records=_timed(runs.store, scene, data, request.targets))
    for target in request.targets:
        listed = [entry for entry in entries(data, label, target) if entry.engine in able]
        ours = next((loop_time(entry.best) for entry in listed if entry.best and entry.engine == OURS), None)
        for entry in listed:
            ratio = None if ours is None or entry.best is None else loop_time(entry.best) / ours
            yield Result(label, target, entry, bool(scene.joints), ratio)
    for engine in data.engines:
        if engine not in able:
            yield Result(label, None, Entry(engine, "cannot", None, data.cells_of(label, engine)[0].reason))


def _cells(runs: Runs, scene: Scene, engine: str, request: Request) -> list[Cell]:
    """Return the cell of each of an engine's methods, of the highest order first.

    Once every target is reached, a run may take what the cheapest takes at the dearest one.
    """
    truth, best, cells = runs.truth(scene), dict.fromkeys(request.targets, np.inf), list[Cell]()
    own = [method for name, method in request.entrants() if name == engine]
    for method in sorted(own, key=lambda one: -((one and one.order) or 0)):
        limited = replace(runs, longest=min(runs.longest, NEAR * max(best.values())))
        most = WORK // len(scene.bodies)
        cells.append(judged(limited, scene, engine, method, truth, request.targets, most, settle=False)[0])
        for result in cells[-1].targets:
            if result.record is not None:
                best[result.target] = min(best[result.target], loop_time(result.record))
    return cells


def _timed(store: Store, scene: Scene, data: ReportData, targets: Sequence[float]) -> tuple[Record, ...]:
    """Return the runs that may be an engine's cheapest at a target, each timed once in randomly interleaved turns.

    A long run that had a processor to itself when it was searched is not repeated.
    """
    offers = [reaching(data, data.scenes[0], engine, target) for engine in data.engines for target in targets]
    runs = list({(run.engine, str(run.settings)): run for offered in offers for run in near(offered)}.values())
    held = [stored_times(store, scene, run) for run in runs]
    first = [Sample(loop_time(own or run), float(own is not None and not is_busy(own)))
             for run, own in zip(runs, held, strict=True)]  # fmt: skip
    times = least_times([partial(_loop, scene, run) for run in runs], first)
    return tuple(replace(run, times=run.times | {"loop_s": time}) for run, time in zip(runs, times, strict=True))


def _loop(scene: Scene, run: Record) -> float:
    return engines.get(run.engine).run(scene, Settings(**run.settings), grid(scene)).timing.loop_s


def parts() -> list[tuple[int, int, str]]:
    """Return every search as a pair, a scene of it and an engine: their order does not matter."""
    every = [(k, number, request) for k, request in enumerate(PAIRS) for number in range(len(request.scenes))]
    return [(k, number, engine) for k, number, request in every for engine in (OURS, *request.rivals)]


def make(part: tuple[int, int, str], full: bool = False) -> None:
    """Search once: the store keeps the runs, among which `measure` looks for the cheapest."""
    request = PAIRS[part[0]]
    with Store(default_path()) as store:
        _cells(Runs(store, longest=longest(full)), request.built()[part[1]], part[2], request)
