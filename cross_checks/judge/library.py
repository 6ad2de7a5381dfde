"""Runs and verdicts for a program: what `mbs-ref simulate` and `check` do, returned instead of printed."""

from collections.abc import Sequence
from typing import Any

from pydantic import ValidationError

from cross_checks.judge.answers import check as check_all
from cross_checks.judge.one_run import judged_run
from cross_checks.judge.runs import NOT_COMPARED, Runs, against
from cross_checks.judge.vocabulary import Cell
from cross_checks.records.store import Run, Store, default_path
from mbs_ref import Scene, Settings
from mbs_ref.display import listing
from mbs_ref.scene.messages import sentences


class Cells(list[Cell]):
    """Verdicts, shown as a table."""

    def _repr_html_(self) -> str:
        head = ("scene", "engine", "method", "verdict", "error of the scene", "setting", "reason")
        rows = [(c.scene, c.engine, c.method, str(c.verdict), c.error, c.setting, c.reason) for c in self]
        return listing("Verdicts", head, rows, most=len(rows))


def run(scene: Scene, engine: str = "mbs_ref", *, judged: bool = True, **settings: Any) -> Run:
    """Run a scene with an engine; return its record, compared with the scene's truth, and the samples.

    `settings` are those of mbs_ref.Settings: method, step (s) or rtol, t_end (s), samples, ... Failures are statuses
    of the record with a sentence. `judged = False` leaves the truth out, which may take a minute to make for the first
    time. ValueError names an unknown engine, method or setting and what is allowed.
    """
    try:
        chosen = Settings(**settings)
    except ValidationError as error:
        raise ValueError(sentences(error, Settings, settings)) from None
    run = Run(*judged_run(scene, engine, chosen, truth=NOT_COMPARED))
    if run.path is None or not judged:
        return run
    with Store(default_path()) as store:
        return Run(against(scene, run, Runs(store).truth(scene, run.path.times)), run.path)


def check(scene: Scene, engines: Sequence[str] | None = None) -> Cells:
    """Return the verdict on every method of the engines, all that are known unless named; the store holds the runs.

    ValueError where an engine is unknown.
    """
    with Store(default_path()) as store:
        return Cells(check_all(Runs(store), [scene], engines))
