"""Ladders of models, each rung run by the same method: what it costs and what it buys."""

import tomllib
from collections.abc import Callable, Sequence
from importlib.resources import files
from typing import Any

import numpy as np

from cross_checks.metrics.metric import off_truth
from cross_checks.prices.timing import Sample, least_times
from mbs_ref import Scene, Settings, Trajectory, scenes
from mbs_ref.crash.results import crash_results
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import rolling_slip
from mbs_ref.observables.distance import farthest
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured
from reports.studies.crash import deepest, finished, largest_gap
from reports.studies.models.choice import Ladder, Rung
from reports.studies.sky import observed

LADDERS: dict[str, Any] = tomllib.loads((files(__package__) / "ladders.toml").read_text(encoding="utf-8"))
Model = tuple[str, Scene, Settings]
# what is shown of a rung, and its accuracy: from its scene and path, and those of the last one
Rule = Callable[[Scene, Trajectory, Scene, Trajectory], tuple[dict[str, float], float | None]]


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
