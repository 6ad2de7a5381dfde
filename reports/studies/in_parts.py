"""Studies whose facts are those of parts, which are measured side by side and stored one by one."""

from collections.abc import Callable, Iterable, Sequence

from cross_checks.records.store import Store, default_path, digest_of
from reports.facts.curves import Measured
from reports.facts.stored import engine_keys, remembered
from reports.studies.study import sources


def measured_part(study: str, part: Sequence[str], full: bool, measure: Callable[[], Measured]) -> Measured:
    """Return the facts of a part of a study, stored or measured."""
    key = digest_of(["part of a study", study, list(part), full, engine_keys(), *sources(study)])
    with Store(default_path()) as store:
        return remembered(store, key, Measured, measure)


def joined(parts: Iterable[Measured]) -> Measured:
    """Return the facts of all parts; rows of a table that several have follow one another."""
    whole = Measured()
    for part in parts:
        for kind in ("figures", "curves", "films"):
            getattr(whole, kind).update(getattr(part, kind))
        for name, rows in part.tables.items():
            whole.tables[name] = (*whole.tables.get(name, ()), *rows)
    return whole
