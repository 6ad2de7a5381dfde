"""Ladders of models, each rung run by the same method: what it costs, what it buys, and which is enough."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cross_checks.metrics.metric import off_truth
from cross_checks.prices.timing import Sample, least_times
from cross_checks.records.numbers import duration, short
from mbs_ref import Scene, Settings, Trajectory, scenes
from mbs_ref.crash.results import crash_results
from mbs_ref.files import package_data
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import rolling_slip
from mbs_ref.observables.distance import farthest
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, Row
from reports.studies.crash import deepest, finished, largest_gap
from reports.studies.sky import observed

LADDERS: dict[str, Any] = package_data(__name__, "ladders.toml")
Model = tuple[str, Scene, Settings]
# what is shown of a rung, and its accuracy: from its scene and path, and those of the last one
Rule = Callable[[Scene, Trajectory, Scene, Trajectory], tuple[dict[str, float], float | None]]


@dataclass(frozen=True)
class Rung:
    """One model of a scene."""

    name: str
    loop_s: float  # least of interleaved runs
    work: int  # right-hand sides
    shown: dict[str, float]  # what the model changes: words with a unit -> value
    accuracy: float | None = None  # what a reader asks for: significant figures, or -log10 of a relative error


@dataclass(frozen=True)
class Ladder:
    """The models of one family, from least to most."""

    title: str
    note: str
    method: str  # and its setting, the same on every rung
    measure: str  # what `accuracy` counts
    rungs: tuple[Rung, ...]
    reference: str = ""  # the rung that the others are compared with, where no truth is known

    def cheapest(self) -> list[str]:
        """Return the cheapest model of each whole figure of accuracy, where it changes."""
        reached = [rung.accuracy for rung in self.rungs if rung.accuracy is not None]
        most: dict[str, int] = {}
        for figures in range(1, math.floor(max(reached, default=0)) + 1):
            rung = self.least(figures)
            if rung is not None:
                most[rung.name] = figures
        return [f"up to {figures}: {name}" for name, figures in most.items()]

    def rows(self) -> tuple[Row, ...]:
        """Return what a page shows of each model."""
        return tuple(self._row(rung) for rung in self.rungs)

    def _row(self, rung: Rung) -> Row:
        accuracy = {} if rung.accuracy is None else {self.measure: f"{rung.accuracy:.1f}"}
        shown = {name: short(rung.shown.get(name), 3) for name in self.rungs[0].shown}
        return {
            "model": rung.name, "time": duration(rung.loop_s),
            "over the first": f"{rung.loop_s / self.rungs[0].loop_s:.3g}", "right-hand sides": str(rung.work),
            self.measure: None, **accuracy, **shown,
        }  # fmt: skip

    def least(self, accuracy: float) -> Rung | None:
        """Return the cheapest model that is at least so accurate, the reference included; None where none is."""
        exact = {self.reference: math.inf} if self.reference else {}
        reached = [exact.get(rung.name, rung.accuracy) for rung in self.rungs]
        enough = [rung for rung, has in zip(self.rungs, reached, strict=True) if has is not None and has >= accuracy]
        return min(enough, key=lambda rung: rung.loop_s, default=None)


def measure() -> Measured:
    """Run every ladder; a minute with compiled code at hand."""
    return shown([built(name) for name in LADDERS])


def shown(ladders: Sequence[Ladder]) -> Measured:
    """Return the ladders as tables."""
    heads = tuple(
        {
            "title": built.title, "note": f"{built.note} {built.method}." if built.method else built.note,
            "cheapest": "; ".join(built.cheapest()) or None,
        }
        for built in ladders
    )  # fmt: skip
    return Measured(tables={"ladders": heads, **{f"ladder: {built.title}": built.rows() for built in ladders}})


def built(name: str) -> Ladder:
    """Return a ladder of ladders.toml, measured."""
    stated = LADDERS[name]
    models = [
        (model["name"], scenes.make(model["scene"], **model.get("parameters", {})),
         Settings(**stated["settings"], **model.get("settings", {})))
        for model in stated["models"]
    ]  # fmt: skip
    words = (stated["title"], stated["note"], stated["measured"])
    return ladder(*words, models, SHOWS[stated["shows"]], stated.get("by_last", False))


def of_family(scene: str) -> Ladder | None:
    """Return the measured ladder that a scene belongs to; None where it belongs to none."""
    return next((built(name) for name, stated in LADDERS.items() if scene in stated["families"]), None)


def families() -> list[str]:
    """Return the scenes that belong to a ladder."""
    return [scene for stated in LADDERS.values() for scene in stated["families"]]


def _bodies(scene: Scene, *_: Any) -> tuple[dict[str, float], float | None]:
    sky = observed(scene, "mbs_ref", Settings(**LADDERS["planets"]["settings"]))
    return {"bodies": float(len(scene.bodies))}, min(sky.figures.values())


def _orbit(scene: Scene, path: Trajectory, _: Scene, fullest: Trajectory) -> tuple[dict[str, float], float | None]:
    off = farthest(scene, path, fullest)[0]
    radius = float(np.linalg.norm(scene.bodies[1].position))
    return {"off the fullest model, m": off}, -np.log10(off / radius) if off > 0.0 else None


def _error(scene: Scene, path: Trajectory, *_: Any) -> tuple[dict[str, float], float | None]:
    off = off_truth(scene, path)
    shown = {"largest |C|, m": largest_gap(path)}
    return shown, None if off is None else float(-np.log10(max(off[0] / scales_of(scene).length, 1e-16)))


def _crash(scene: Scene, path: Trajectory, last: Scene, fullest: Trajectory) -> tuple[dict[str, float], float | None]:
    result, reference = crash_results(scene, path), crash_results(last, fullest)
    travel, most = (float(np.abs(one.head_excursion[:, 0]).max()) for one in (result, reference))
    measures = {name: result.measures[name] for name in ("HIC36", "Nij")}
    measures |= {"head's travel, m": travel, "passes through, m": max(deepest(scene, path), 0.0)}
    return measures, _digits(travel, most)


def _drive(scene: Scene, path: Trajectory, last: Scene, fullest: Trajectory) -> tuple[dict[str, float], float | None]:
    slip = np.abs(rolling_slip(Motion(scene, path), "roller2"))
    way, most = (
        float(np.subtract(*run.position[[-1, 0], whole.body_index("chassis"), 0]))
        for whole, run in ((scene, path), (last, fullest))
    )
    return {
        "way, m": way, "slip of a roller, median": float(np.nanmedian(slip)),
        "hull's pitch, degrees": float(np.degrees(np.abs(path.orientation[:, scene.body_index("chassis")]).max())),
    }, _digits(way, most)  # fmt: skip


def _digits(value: float, reference: float) -> float | None:
    """Return -log10 of how far a value is off, relative; None where it is the reference."""
    off = abs(value - reference) / abs(reference)
    return -np.log10(off) if off > 0.0 else None


SHOWS: dict[str, Rule] = {"bodies": _bodies, "orbit": _orbit, "error": _error, "crash": _crash, "drive": _drive}


def ladder(title: str, note: str, measured: str, models: Sequence[Model], text: Rule, by_last: bool = False) -> Ladder:
    """Run every model once for its figures, and in randomly interleaved turns for its time.

    `by_last`: the others are compared with the last model.
    """
    paths = [finished(scene, settings) for _, scene, settings in models]
    again = [lambda scene=scene, settings=settings: simulate(scene, settings).timing.loop_s
             for _, scene, settings in models]  # fmt: skip
    best, rungs = least_times(again, [Sample(path.timing.loop_s) for path in paths]), []
    for (name, scene, _), path, seconds in zip(models, paths, best, strict=True):
        shown, accuracy = text(scene, path, models[-1][1], paths[-1])
        rungs.append(Rung(name, seconds, int(path.rhs_calls), shown, accuracy))
    reference = models[-1][0] if by_last else ""
    return Ladder(title, note, _method(models[0][2], models), measured, tuple(rungs), reference)


def _method(first: Settings, models: Sequence[Model]) -> str:
    """Return the method and setting that all rungs share; nothing where they differ."""
    if any(settings != first for _, _, settings in models):
        return ""
    return f"{first.method}, " + (f"h = {first.step:g} s" if first.step else f"rtol = {first.rtol:g}")


@dataclass(frozen=True)
class ModelChoice:
    """What is enough, and why nothing less is."""

    error: float  # largest, relative, as requested
    ladder: Ladder
    best: Rung | None
    lesser: Rung | None  # the most accurate of the cheaper models, none of which is enough
    sentence: str


def choose(ladder: Ladder, error: float) -> ModelChoice:
    """Return the cheapest model of a ladder whose relative error is at most `error`."""
    wanted = -math.log10(error)
    best = ladder.least(wanted)
    if best is None:
        known = [rung for rung in ladder.rungs if rung.accuracy is not None]
        nearest = max(known, key=lambda rung: rung.accuracy or 0.0, default=None)
        least = "" if nearest is None else f"; {nearest.name!r} comes closest with {_accuracy(nearest)}"
        return ModelChoice(error, ladder, None, nearest, f"{ladder.title}: no model reaches {error:.3g}{least}.")
    cheaper = [rung for rung in ladder.rungs if rung.loop_s < best.loop_s]
    lesser = max(cheaper, key=lambda rung: rung.accuracy or -math.inf, default=None)
    less = "" if lesser is None else f"; of the cheaper ones {lesser.name!r} comes closest with {_accuracy(lesser)}"
    text = f"{ladder.title}: {best.name!r} is enough for {error:.3g}: {_accuracy(best)}, {duration(best.loop_s)}{less}."
    by = f" Errors are counted from {ladder.reference!r}, which is no truth." if ladder.reference else ""
    return ModelChoice(error, ladder, best, lesser, text + by)


def _accuracy(rung: Rung) -> str:
    return "the model that the others are compared with" if rung.accuracy is None else f"{10.0**-rung.accuracy:.2g}"
