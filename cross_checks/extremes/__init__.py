"""Extreme scenes along an axis from mild to hopeless, as `extremes.toml` describes them.

An entry with a `case` describes the places of its axis, too: a scene of the library with `parameters`, its end `t_end`
(s), and its `measure`: "invariants", or a solver in cross_checks.truths with the motion's `size` (m; how far its own
bodies go unless given). `step`, `rtol` and `max_steps` are those of a Case, `samples` and `every` (s) of its times. A
text that begins with "=" is a formula of `value`, the place on the axis; "none" leaves out what there is by default.
Other entries belong to the file of `families` under which they stand, whose CASES have them.
"""

from functools import cache, lru_cache, partial
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.extremes.extreme import STEP, Axis, Case, Extreme, by_truth, grid, invariants
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.files import package_data
from mbs_ref.scene.base.expression import evaluate
from mbs_ref.scene.parameters import FORMULA

DATA = package_data(__name__, "extremes.toml")
LISTED, QUICK = DATA["extremes"], DATA["quick"]
MAP = Path(str(files(__name__))) / "data" / "map.jsonl"  # the cells of the last dated runs


@cache
def every() -> tuple[Extreme, ...]:
    """Return all extremes in the order of the file."""
    modules = {family: import_module(f"{__name__}.families.{family}") for family in LISTED}
    return tuple(_described(modules[family], entry) for family, entries in LISTED.items() for entry in entries)


def _described(module: ModuleType, entry: dict[str, Any]) -> Extreme:
    """Return an extreme; an axis of labels has their numbers for values."""
    labels, full, name = tuple(entry.get("labels", ())), tuple(entry.get("full", ())), entry["name"]
    values = tuple(entry.get("values", map(float, range(len(labels)))))
    axis = Axis(entry["axis"], entry.get("unit", ""), values, labels, full)
    case = partial(_case, entry["case"]) if "case" in entry else module.CASES[name]
    return Extreme(name, entry["family"], entry["title"], axis, case, getattr(module, "ENGINE", engines.get))


def _case(described: dict[str, Any], value: float) -> Case:
    """Return the case of an entry at a place on its axis."""
    given: dict[str, Any] = {"step": STEP, "samples": 21} | _filled(described, value)
    scene, step = scenes.make(given["scene"], **given.get("parameters", {})), given["step"]
    times = grid(given["t_end"], given.get("every", step or STEP), given["samples"])
    solver, measure = given["measure"], invariants
    if solver != "invariants":
        parameters = tuple(scene.parameters.items())
        measure = by_truth(lambda _, at: _solved(solver, scene.name, parameters, (*at,)), given.get("size"))
    more = {name: given[name] for name in ("rtol", "max_steps") if name in given}
    return Case(scene, times, measure, step, **more)


def _filled(described: Any, value: float) -> Any:
    """Return an entry with numbers in place of formulas, and None in place of "none"."""
    if isinstance(described, dict):
        return {name: _filled(part, value) for name, part in described.items()}
    if isinstance(described, str) and described.startswith(FORMULA):
        return evaluate(described.removeprefix(FORMULA), {"value": value})
    return None if described == "none" else described


@lru_cache(maxsize=4)
def _solved(solver: str, name: str, parameters: tuple, times: tuple[float, ...]) -> Truth | NoTruth:
    """Solve a scene of the library once where an axis asks the same at every place."""
    module, _, function = solver.rpartition(".")
    solve = getattr(import_module(f"cross_checks.truths.{module}"), function)
    return solve(scenes.make(name, **dict(parameters)), np.array(times))


def named(name: str) -> Extreme:
    """Return the extreme of that name; ValueError lists what there is."""
    for extreme in every():
        if extreme.name == name:
            return extreme
    raise ValueError(f"extreme = {name!r} is unknown; allowed: {', '.join(e.name for e in every())}")
