"""The control of an accusation: is a sound method of the same order as far off at the same setting?

Where a motion amplifies errors, runs of low order are as far from one another as from the truth, at every step within
the bound on work. That they do not approach it accuses nobody where another engine's method does as badly.
"""

from __future__ import annotations

from collections.abc import Iterator

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge.ladder import settings_at
from cross_checks.judge.runs import Runs, against
from cross_checks.judge.verdict import Control
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene


def control(
    runs: Runs, scene: Scene, engine: str, method: Method, knob: float, truth: Truth | NoTruth
) -> Control | None:
    """Return how far a method of that order or more is off at a setting, of an engine that stands on another package.

    The lowest such order is asked of each engine in turn; None where none runs the scene to its end.
    """
    for name, other in _alike(scene, engine, method):
        record = against(scene, runs.run(scene, name, settings_at(other, scene, knob)), truth)
        if record.status == "success" and record.error is not None:
            return Control(f"{name} {other.name}", record.error.value)
    return None


def _alike(scene: Scene, engine: str, method: Method) -> Iterator[tuple[str, Method]]:
    if method.order is None:
        return
    for name in engines.names():
        try:
            other = engines.get(name)
        except engines.EngineMissing:
            continue
        if other.library == engines.get(engine).library or other.refusals(scene):
            continue
        able = [m for m in other.methods() if m.kind == method.kind and (m.order or 0) >= method.order]
        sound = [m for m in able if not other.method_refusals(scene, m) and not m.excused(scene)]
        if sound:
            yield name, min(sound, key=lambda m: m.order or 0)
