"""Measure the studies, each in a process of its own, and keep their facts."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from itertools import chain
from typing import Any

from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import each
from cross_checks.records.naming import code_of, digest_of
from cross_checks.records.store import Store
from reports.facts.kept import keep, recall
from reports.studies.study import Study, every, make, measurement, parts

Progress = Callable[[int, int, str], None]  # done, total, what comes next

LONGEST = 1800.0  # s for one study, on a machine however busy


def measured() -> dict[str, Study]:
    """Return the studies that measure something, by name."""
    return {name: study for name, study in every().items() if study.facts is not None}


def measure_all(store: Store, found: dict[str, Any], depends: Any, report: Progress) -> list[str]:
    """Add to `found` the facts of every study, kept or measured on all cores; return what failed and why.

    Facts are made again where their code changes or what they depend on: the engines and their adapters.
    """
    studies = measured()
    keys = {name: digest_of(["study", name, depends, code_of(f"reports.studies.{name}.measure")]) for name in studies}
    for name, study in studies.items():
        held = recall(store, keys[name], study.facts)  # type: ignore[arg-type]
        if held is not None:
            found[name] = held
    missing, failed = [name for name in studies if name not in found], []
    _ahead(missing, report)
    together, alone = ([name for name in missing if studies[name].alone is apart] for apart in (False, True))
    for name, facts in chain(each(together, _measured, timeout=LONGEST), each(alone, _measured, 1, LONGEST)):
        if isinstance(facts, str):
            failed.append(f"section {name}: {facts}")
        else:
            found[name] = keep(store, keys[name], studies[name].facts, facts)  # type: ignore[arg-type]
        report(len(found) + len(failed), len(studies), f"study of {name}")
    return failed


def _ahead(missing: list[str], report: Progress) -> None:
    """Make the parts of studies on all cores; one that fails does so again, and is told, where it is asked for."""
    asked = [(name, part) for name in missing for part in parts(name)]
    for done, (task, _) in enumerate(each(asked, _made, timeout=LONGEST), 1):
        report(done, len(asked), f"runs for the study of {task[0]}")


def _made(call: Caller, task: tuple[str, Any]) -> None:
    with suppress(Exception):  # raised in a process of its own
        call(make, *task)


def _measured(call: Caller, name: str) -> Any:
    """Return a study's facts, or the sentence why there are none."""
    try:
        return call(measure, name)
    except Exception as error:  # raised in a process of its own: whatever it is, it costs this study alone
        return f"{type(error).__name__}: {error}"


def measure(name: str) -> Any:
    """Measure a study: for a process of its own."""
    return measurement(name)()
