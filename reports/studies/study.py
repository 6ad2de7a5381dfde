"""The studies, by listing this folder, and their measurements: each in a process of its own, with its facts stored.

Beside a study's study.toml stands measure.py, whose `measure()` returns a Measured. It may offer `parts()` and
`make(part)`: runs that the store holds once they are computed, in any order and side by side, for `measure()` to read.
"""

import pkgutil
import tomllib
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.resources import files
from itertools import chain
from typing import Any

from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import Report, each
from cross_checks.records.store import Store, code_of, digest_of
from reports import studies
from reports.facts.curves import Measured
from reports.facts.stored import keep, recall
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


def measure(name: str) -> Measured:
    """Measure a study: for a process of its own."""
    return import_module(f"reports.studies.{name}.measure").measure()


def make(name: str, part: Any) -> None:
    """Compute one of a study's parts."""
    import_module(f"reports.studies.{name}.measure").make(part)


def parts(name: str) -> list[Any]:
    """Return the parts of a study that may be computed side by side before it is measured; most have none."""
    module = import_module(f"reports.studies.{name}.measure")
    return list(module.parts()) if hasattr(module, "parts") else []


def _sources(name: str) -> list[str]:
    """Return what a study's facts depend on: the digest of its code, and its data files but what presents them."""
    data = [file for file in (files("reports.studies") / name).iterdir() if file.name.endswith(".toml")]
    texts = {file.name: file.read_text(encoding="utf-8") for file in data if file.name != "study.toml"}
    return [code_of(f"reports.studies.{name}.measure"), *(texts[file] for file in sorted(texts))]


def measure_all(store: Store, result: dict[str, Measured], depends: Any, report: Report) -> list[str]:
    """Add to `found` the facts of every study, stored or measured on all cores; return what failed and why.

    Facts are measured again where their code changes or what they depend on: the engines and their adapters.
    """
    listed = every()
    keys = {name: digest_of(["study", name, depends, *_sources(name)]) for name in listed}
    for name in listed.keys() - result.keys():
        if (held := recall(store, keys[name], Measured)) is not None:
            result[name] = held
    missing, failed = [name for name in listed if name not in result], []
    # compute the parts of studies on all cores; one that fails does so again, with its reason, in `measure`
    tasks = [(name, part) for name in missing for part in parts(name)]
    for done, (task, _) in enumerate(each(tasks, _made, timeout=LONGEST), 1):
        report(done, len(tasks), f"runs for the study of {task[0]}")
    together, alone = ([name for name in missing if listed[name].alone is apart] for apart in (False, True))
    for name, facts in chain(each(together, _measured, timeout=LONGEST), each(alone, _measured, 1, LONGEST)):
        if isinstance(facts, str):
            failed.append(f"section {name}: {facts}")
        else:
            result[name] = keep(store, keys[name], Measured, facts)
        report(len(result) + len(failed), len(listed), f"study of {name}")
    return failed


def _made(call: Caller, task: tuple[str, Any]) -> None:
    with suppress(Exception):  # raised in a process of its own
        call(make, *task)


def _measured(call: Caller, name: str) -> Measured | str:
    """Return a study's facts, or the sentence why there are none."""
    try:
        return call(measure, name)
    except Exception as error:  # raised in a process of its own: whatever it is, it costs this study alone
        return f"{type(error).__name__}: {error}"
