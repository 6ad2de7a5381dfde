"""Which defects of given sources do given tests overlook? Defects live in memory, thousands in minutes.

    python -m tests.mutants.survey SOURCE... --tests FOLDER... [--each N | --statements N] [--seed S] [--out FILE]

Tests are collected once, and run once to learn which of them execute which line. Each defect is then compiled into
a child process, which runs the tests that execute its line, the quickest first, until one fails. Defects outside
functions and in what tests start by command are out of reach: `tests.mutants.run` judges those.
"""

from __future__ import annotations

import argparse
import ast
import gc
import importlib
import json
import os
import pickle
import random
import resource
import signal
import sys
import time
import types
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from tests.mutants.defect import ROOT, Defect, read
from tests.mutants.operators import defects_of

MOST = 3.0  # s of tests for one defect
LOUD = ("arguments exchanged",)  # mostly noticed by an exception
TOOL = 3  # the number under which lines are watched


class Lines:
    """A plugin that notes the lines which each test, and each shared fixture, executes, and the time of each test."""

    def __init__(self, sources: set[str]) -> None:
        self.sources = sources
        self.current: set[tuple[str, int]] = set()
        self.of_tests: dict[str, set[tuple[str, int]]] = {}
        self.of_fixtures: dict[tuple[str, str], set[tuple[str, int]]] = defaultdict(set)
        self.seconds: dict[str, float] = {}
        self.failed: list[str] = []

    def watch(self) -> None:
        """Begin to watch the lines."""
        watching = sys.monitoring
        watching.use_tool_id(TOOL, "lines")
        watching.register_callback(TOOL, watching.events.LINE, self._line)
        watching.set_events(TOOL, watching.events.LINE)

    def _line(self, code: types.CodeType, line: int) -> Any:
        if code.co_filename in self.sources:
            self.current.add((code.co_filename, line))
        return sys.monitoring.DISABLE

    def _into(self, lines: set[tuple[str, int]]) -> None:
        self.current = lines
        sys.monitoring.restart_events()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        own = self.of_tests.setdefault(item.nodeid, set())
        self._into(own)
        begun = time.process_time()
        yield
        self.seconds[item.nodeid] = time.process_time() - begun

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any, request: Any) -> Iterator[None]:
        before = self.current
        if fixturedef.scope != "function":
            self._into(self.of_fixtures[fixturedef.argname, request.node.nodeid.split("::")[0]])
        yield
        if fixturedef.scope != "function":
            self._into(before)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed.append(report.nodeid)


def session_of(tests: list[str]) -> pytest.Session:
    """Return a session that has collected tests."""
    from _pytest.config import _prepareconfig

    options = ["-p", "no:terminal", "-p", "no:cacheprovider", "-p", "no:xdist", *tests]
    config = _prepareconfig(options)
    config._do_configure()
    session = pytest.Session.from_config(config)
    config.hook.pytest_sessionstart(session=session)
    session.perform_collect()
    return session


def run(session: pytest.Session, items: list[pytest.Item], plugin: Any) -> None:
    """Run tests of a session."""
    session.items = items
    session.config.pluginmanager.register(plugin)
    with suppress(session.Failed, session.Interrupted):
        session.config.hook.pytest_runtestloop(session=session)


def in_child(do: Any, cpu_s: float) -> Any:
    """Return what a function returns in a forked process; None where that process dies."""
    inlet, outlet = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()
        os.close(inlet)
        limit = int(cpu_s) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 2))
        signal.signal(signal.SIGXCPU, lambda *_: os._exit(1))
        signal.signal(signal.SIGALRM, lambda *_: os._exit(1))
        signal.alarm(6 * limit)
        null = os.open(os.devnull, os.O_RDWR)
        for shown in (1, 2):
            os.dup2(null, shown)
        try:
            answer = pickle.dumps(do())
            with os.fdopen(outlet, "wb") as pipe:
                pipe.write(answer)
        finally:
            os._exit(0)
    os.close(outlet)
    with os.fdopen(inlet, "rb") as pipe:
        answer = pipe.read()
    os.waitpid(child, 0)
    return pickle.loads(answer) if answer else None


def covered(session: pytest.Session, sources: set[str]) -> tuple[dict[str, set[tuple[str, int]]], dict[str, float]]:
    """Return the lines of sources that each test executes, and the time of each test."""

    def watched() -> Any:
        lines = Lines(sources)
        lines.watch()
        session.config.option.maxfail = 0
        run(session, list(session.items), lines)
        for item in session.items:
            for name in getattr(item, "fixturenames", ()):
                lines.of_tests[item.nodeid] |= lines.of_fixtures.get((name, item.nodeid.split("::")[0]), set())
        return lines.of_tests, lines.seconds, lines.failed

    answer = in_child(watched, 3000.0)
    if answer is None:
        raise RuntimeError("the tests ended their process")
    found, seconds, failed = answer
    print(f"{len(found)} tests, {sum(seconds.values()):.0f} s; failed without a defect: {failed}", flush=True)
    return {test: lines for test, lines in found.items() if test not in failed}, seconds


def functions() -> dict[str, list[types.FunctionType]]:
    """Return every function in memory by the file that it is written in."""
    by_file: dict[str, list[types.FunctionType]] = defaultdict(list)
    gc.unfreeze()  # frozen objects are not listed
    for each in gc.get_objects():
        if isinstance(each, types.FunctionType):
            by_file[each.__code__.co_filename].append(each)
    return by_file


def codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Yield a code object and those within it."""
    yield code
    for part in code.co_consts:
        if isinstance(part, types.CodeType):
            yield from codes(part)


def plant(defect: Defect, source: str, own: list[types.FunctionType]) -> None:
    """Put the code of a wrong source in place of the functions' own."""
    path = str(ROOT / defect.file)
    wrong = compile(source.replace(defect.old, defect.new), path, "exec", dont_inherit=True)
    by_name = {(code.co_qualname, code.co_firstlineno): code for code in codes(wrong)}
    for function in own:
        code = by_name.get((function.__code__.co_qualname, function.__code__.co_firstlineno))
        if code is not None and code.co_freevars == function.__code__.co_freevars:
            function.__code__ = code


def lines_of(defect: Defect, source: str) -> set[int]:
    """Return the lines which a defect's text spans."""
    first = source[: source.index(defect.old)].count("\n") + 1
    return set(range(first, first + defect.old.count("\n") + 1))


def drawn(files: list[Path], each: int, seed: int) -> list[Defect]:
    """Return so many defects of each function, spread over kinds."""
    chance, found = random.Random(seed), []
    for file in files:
        groups: dict[str, list[Defect]] = defaultdict(list)
        for defect in {d.name: d for d in defects_of(file)}.values():
            if not defect.breaks.endswith(LOUD):
                groups[defect.breaks.split(":")[0]].append(defect)
        for own in groups.values():
            chance.shuffle(own)
            kinds = {d.breaks: d for d in own}
            found += (
                (list(kinds.values()) + own)[:each] if len(kinds) < each else chance.sample(list(kinds.values()), each)
            )
    return list({d.name: d for d in found}.values())


def at_statements(files: list[Path], count: int, seed: int) -> list[Defect]:
    """Return one defect at each of so many statements, drawn from all that can have one: each is as likely."""
    chance, pool = random.Random(seed), defaultdict(list)
    for file in files:
        source = file.read_text()
        spans = [
            (node.lineno, node.end_lineno or node.lineno)
            for node in ast.walk(ast.parse(source))
            if isinstance(node, ast.stmt) and not isinstance(node, ast.FunctionDef | ast.ClassDef)
        ]
        for defect in {d.name: d for d in defects_of(file)}.values():
            line = min(lines_of(defect, source))
            within = [span for span in spans if span[0] <= line <= span[1]]
            first, _ = min(within, key=lambda span: (span[1] - span[0], -span[0]), default=(line, line))
            pool[defect.file, first].append(defect)
    found = []
    for place in chance.sample(sorted(pool), count):
        kinds: dict[str, list[Defect]] = defaultdict(list)
        for defect in sorted(pool[place], key=lambda d: d.name):
            kinds[defect.breaks.split(": ", 1)[1]].append(defect)
        found.append(chance.choice(kinds[chance.choice(sorted(kinds))]))
    return found


def survey(session: pytest.Session, defects: list[Defect], known: tuple[Any, Any], out: Path | None) -> None:
    """Judge defects and print those that survive."""
    lines, seconds = known
    items = {item.nodeid: item for item in session.items}
    by_file, counted = functions(), defaultdict(int)
    for defect in defects:
        source, path = (ROOT / defect.file).read_text(), str(ROOT / defect.file)
        if source.count(defect.old) != 1:
            verdict, by, tests = "stale", "", []
        else:
            spanned = {(path, line) for line in lines_of(defect, source)}
            own = sorted((t for t, found in lines.items() if t in items and found & spanned), key=seconds.__getitem__)
            tests, spent = [], 0.0
            for test in own:
                spent += seconds[test]
                if spent > MOST and tests:
                    break
                tests.append(test)

            def judged(defect: Defect = defect, tests: list[str] = tests, source: str = source) -> list[str]:
                plant(defect, source, by_file[str(ROOT / defect.file)])
                watched = Lines(set())
                session.config.option.maxfail = 1
                run(session, [items[test] for test in tests], _First(watched))
                return watched.failed

            failed = in_child(judged, 20.0 + 3.0 * spent) if tests else []
            verdict = "uncovered" if not tests else "noticed" if failed is None or failed else "survived"
            by = "does not end" if failed is None else failed[0] if failed else ""
        counted[verdict] += 1
        row = {**vars(defect), "verdict": verdict, "by": by, "tests": len(tests)}
        if out:
            with out.open("a") as file:
                file.write(json.dumps(row) + "\n")
        if verdict != "noticed":
            print(
                f"{verdict:9} {defect.file}: {defect.old!r} -> {defect.new!r}: {defect.breaks} [{len(tests)}]",
                flush=True,
            )
    print(json.dumps(counted))


class _First:
    """A plugin that notes the first failure."""

    def __init__(self, into: Lines) -> None:
        self.into = into

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.into.failed.append(report.nodeid)


def main() -> None:
    parser = argparse.ArgumentParser(description="Seeded defects in memory: which survive?")
    parser.add_argument("sources", nargs="+")
    parser.add_argument("--tests", nargs="+", required=True)
    parser.add_argument("--each", type=int, default=2, help="defects of each function")
    parser.add_argument("--statements", type=int, default=0, help="defects at so many random statements instead")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--defects", type=Path, help="judge the defects of a file in place of drawn ones")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--lines", type=Path, help="a file that keeps which test executes which line")
    asked = parser.parse_args()
    files = [
        f for s in asked.sources for f in (sorted((ROOT / s).rglob("*.py")) if (ROOT / s).is_dir() else [ROOT / s])
    ]
    session = session_of(asked.tests)
    for file in files:  # what a test would import first in its child could not be changed from here
        with suppress(ImportError):
            importlib.import_module(".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))
    if asked.lines and asked.lines.is_file():
        known = pickle.loads(asked.lines.read_bytes())
    else:
        known = covered(session, {str(file) for file in files})
        if asked.lines:
            asked.lines.write_bytes(pickle.dumps(known))
    if asked.defects:
        defects = read(asked.defects)
    elif asked.statements:
        defects = at_statements(files, asked.statements, asked.seed)
    else:
        defects = drawn(files, asked.each, asked.seed)
    survey(session, defects, known, asked.out)


if __name__ == "__main__":
    main()
