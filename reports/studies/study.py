"""The studies, by listing this folder, and their measurements: each in a process of its own, with its facts stored.

A study is a package with a study.toml; its `measure()` returns a Measured. It may offer `parts()`, which are computed
side by side before: by `measure_part(part)`, in place of `measure`, whose facts are stored one by one and joined; or by
`make(part)`, which makes runs that the store holds for `measure()` to read. A study that leaves out what costs most has
`fuller = true` there, and these functions have `full` as their last parameter.
"""

import pkgutil
import tomllib
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from importlib.resources import files
from itertools import chain
from typing import Any

from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import Report, each
from cross_checks.records.store import Store, code_of, default_path, digest_of
from reports import studies
from reports.facts.curves import Measured
from reports.facts.stored import engine_keys, keep, recall, remembered
from reports.studies.document import Document

LONGEST = 1800.0  # s for one study, on a machine however busy


@cache
def every() -> dict[str, Document]:
    """Return every study's document by its folder's name, in the order of the pages."""
    names = [module.name for module in pkgutil.iter_modules(studies.__path__) if module.ispkg]
    texts = {name: (files("reports.studies") / name / "study.toml").read_text(encoding="utf-8") for name in names}
    result = {name: Document(name, **tomllib.loads(text)) for name, text in texts.items()}
    return dict(sorted(result.items(), key=lambda item: (item[1].page, item[1].place)))


def stored() -> dict[str, Measured]:
    """Return the studies that present tables of the source tree, which a quick report shows, too."""
    return {name: measure(name) for name, document in every().items() if document.stored}


def measure(name: str, full: bool = False) -> Measured:
    """Measure a study, or join its parts: for a process of its own."""
    module = import_module(f"reports.studies.{name}")
    if not hasattr(module, "measure_part"):
        return module.measure(*_fuller(name, full))
    return _joined(_measured_part(name, part, full) for part in module.parts())


def _joined(parts: Iterable[Measured]) -> Measured:
    """Return the facts of all parts; rows of a table that several have follow one another."""
    whole = Measured()
    for part in parts:
        for kind in ("figures", "curves", "films"):
            getattr(whole, kind).update(getattr(part, kind))
        for name, rows in part.tables.items():
            whole.tables[name] = (*whole.tables.get(name, ()), *rows)
    return whole


def _measured_part(name: str, part: Any, full: bool) -> Measured:
    """Return the facts of a part, stored or measured."""
    module, fuller = import_module(f"reports.studies.{name}"), _fuller(name, full)
    key = digest_of(["part of a study", name, part, *fuller, engine_keys(), *_sources(name)])
    with Store(default_path()) as store:
        return remembered(store, key, Measured, lambda: module.measure_part(part, *fuller))


def make(name: str, part: Any, full: bool = False) -> None:
    """Compute one of a study's parts, which the store keeps."""
    module = import_module(f"reports.studies.{name}")
    if hasattr(module, "measure_part"):
        _measured_part(name, part, full)
    else:
        module.make(part, *_fuller(name, full))


def _fuller(name: str, full: bool) -> list[bool]:
    """Return `full` for a study that it makes a difference to."""
    return [full] if every()[name].fuller else []


def parts(name: str) -> list[Any]:
    """Return the parts of a study that may be computed side by side before it is measured; most have none."""
    module = import_module(f"reports.studies.{name}")
    return list(module.parts()) if hasattr(module, "parts") else []


def _sources(name: str) -> list[str]:
    """Return what a study's facts depend on: the digest of its code, and its data files but what presents them."""
    data = [file for file in (files("reports.studies") / name).iterdir() if file.name.endswith(".toml")]
    texts = {file.name: file.read_text(encoding="utf-8") for file in data if file.name != "study.toml"}
    return [code_of(f"reports.studies.{name}"), *(texts[file] for file in sorted(texts))]


def measure_all(
    store: Store, result: dict[str, Measured], depends: Any, report: Report, full: bool = False
) -> list[str]:
    """Add to `result` the facts of every study, stored or measured on all cores; return what failed and why.

    Facts are measured again where their code changes or what they depend on: the engines and their adapters. With
    `full` nothing is left out for its cost.
    """
    listed = every()
    keys = {name: digest_of(["study", name, depends, *_fuller(name, full), *_sources(name)]) for name in listed}
    for name in listed.keys() - result.keys():
        if (held := recall(store, keys[name], Measured)) is not None:
            result[name] = held
    missing, failed = [name for name in listed if name not in result], []
    # First studies without parts, which take longest, and the parts of others; then studies that read those parts;
    # studies that measure times are last, one at a time.
    parted = {name: own for name in missing if (own := parts(name))}
    whole = [(name, None, full) for name in missing if not listed[name].alone]
    first = [task for task in whole if task[0] not in parted]
    first += [(name, part, full) for name, own in parted.items() for part in own]
    reading = [task for task in whole if task[0] in parted]
    last = [(name, None, full) for name in missing if listed[name].alone]
    steps = chain(each(first, _made, timeout=LONGEST), each(reading, _made, timeout=LONGEST),
                  each(last, _made, 1, LONGEST))  # fmt: skip
    for done, ((name, part, _), facts) in enumerate(steps, 1):
        if isinstance(facts, str):
            failed.append(f"section {name}: {facts}")
        elif facts is not None:
            result[name] = keep(store, keys[name], Measured, facts)
        what = f"study of {name}" if part is None else f"runs for the study of {name}"
        report(done, len(first) + len(reading) + len(last), what)
    return failed


def _made(call: Caller, task: tuple[str, Any, bool]) -> Measured | str | None:
    """Return a study's facts, or the sentence why there are none; nothing of one of its parts."""
    name, part, full = task
    try:
        return call(measure, name, full) if part is None else call(make, name, part, full)
    except Exception as error:  # raised in a process of its own: it costs this study alone, where `measure` raises it
        return f"{type(error).__name__}: {error}" if part is None else None
