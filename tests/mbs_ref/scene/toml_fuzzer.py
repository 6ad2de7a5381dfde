"""A coverage-guided fuzzer of the scene file reader: mutate what reached a new line, and keep what does again.

Lines are seen through sys.monitoring, each reported once in all, so that watching costs next to nothing. The
shapes of complaints, names and numbers taken out, count like lines.
"""

from __future__ import annotations

import math
import random
import re
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType
from typing import Any

import tomli_w

from cross_checks.truths.oracle.random_scenes import random_scene
from mbs_ref import scenes
from mbs_ref.scene import toml as scene_file
from mbs_ref.scene.toml import SceneFileError, dumps, loads

WATCHED = str(Path(scene_file.__file__).parent)  # our own lines, not pydantic's
TOOL = sys.monitoring.PROFILER_ID  # debuggers and coverage have their own
LONGEST = 20_000  # characters of a mutant
SLOWEST = 10.0  # s for one file of that length on a busy machine
WORDS = (
    "nan", "inf", "-inf", "1e400", "-0.0", "5e-324", "9" * 30, "true", "[]", "{}", '""', '"ground"', "1979-05-27",
    "[[bodies]]\n", "[[joints]]\n", "[[loads]]\n", "[[contacts]]\n", "[parameters]\n", "type = ", "name = ", "\x00",
    '"\\u0000"', '"\\n"', '"<script>"', '"\u202e"', "'''", '"""', "#", "=", ".", "[", "]", "[" * 200, "0x", "_", ",",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    0, -1, 1e308, 5e-324, math.nan, math.inf, 2**63, True, "", "ground", "b0", "<script>alert(1)</script>", "a\nb",
    "\x1b[31m", "x" * 300, [], [[]], {}, {"type": "constant"}, [0, 0], [1.0, 2.0, 3.0], [0.0] * 7, [[1, 0, 0]] * 3,
)  # fmt: skip


@dataclass
class Findings:
    """What a fuzzing session saw."""

    tried: int = 0
    accepted: int = 0  # read as scenes
    lines: int = 0  # of the package, reached
    shapes: set[str] = field(default_factory=set)  # of complaints
    corpus: list[str] = field(default_factory=list)
    failures: list[tuple[str, str]] = field(default_factory=list)  # what went wrong, and the file

    def __str__(self) -> str:
        return (f"{self.tried} files, {self.accepted} of them scenes, {self.lines} lines and {len(self.shapes)} "
                f"kinds of complaint reached, {len(self.corpus)} kept, {len(self.failures)} failures")  # fmt: skip


def fuzz(seed: int, most: int, seconds: float = math.inf) -> Findings:
    """Read up to `most` mutants within `seconds`; the same seed gives the same files."""
    rng, found = random.Random(seed), Findings()
    end = time.monotonic() + seconds
    with _watched(found):
        for text in _seeds():
            _try(text, found)
            found.corpus.append(text)
        while found.tried < most and time.monotonic() < end:
            text = _mutant(rng, found.corpus)
            before = found.lines + len(found.shapes)
            _try(text, found)
            if found.lines + len(found.shapes) > before:
                found.corpus.append(text)
    return found


def _seeds() -> list[str]:
    small = [scenes.make(name) for name in ("slider_crank", "bouncing_ball", "satellite", "kepler", "driven_pendulum")]
    return [dumps(scene) for scene in (*small, *(random_scene(seed, most=8) for seed in range(12)))]


# --- the trial ------------------------------------------------------------------------------------


def _try(text: str, found: Findings) -> None:
    """Read a text: a scene that reads back equal, or the reader's own error with clean lines; else a failure."""
    found.tried += 1
    began = time.monotonic()
    try:
        complaint = _read(text, found)
    except Exception as error:  # whatever it is, it is what this test is for
        complaint = f"{type(error).__name__}: {error}"
    if time.monotonic() - began > SLOWEST:
        complaint = f"took {time.monotonic() - began:.1f} s"
    if complaint:
        found.failures.append((complaint, text))


def _read(text: str, found: Findings) -> str:
    try:
        scene = loads(text, file="fuzz.toml")
    except SceneFileError as error:
        found.shapes |= {_shape(str(problem)) for problem in error.problems}
        return _unclean(error)
    found.accepted += 1
    again = loads(dumps(scene))
    return "" if repr(again) == repr(scene) else "does not read back equal"


def _unclean(error: SceneFileError) -> str:
    lines = str(error).split("\n")
    if not error.problems or not all(line.startswith("fuzz.toml: ") and len(line) > 11 for line in lines):
        return f"a complaint without its file or words: {str(error)[:300]!r}"
    if not all(line.isprintable() for line in lines):
        return f"control characters in a complaint: {str(error)[:300]!r}"
    return ""


def _shape(problem: str) -> str:
    """Return a complaint without the names and numbers in it."""
    return re.sub(r"\(.*?\)|'[^']*'|\"[^\"]*\"|-?\d[\d.e+-]*|= .*?:", "*", problem)[:120]


@contextmanager
def _watched(found: Findings) -> Iterator[None]:
    monitoring = sys.monitoring

    def line(code: CodeType, number: int) -> Any:
        if code.co_filename.startswith(WATCHED):
            found.lines += 1
        return monitoring.DISABLE

    monitoring.use_tool_id(TOOL, "scene file fuzzer")
    monitoring.register_callback(TOOL, monitoring.events.LINE, line)
    monitoring.restart_events()
    monitoring.set_events(TOOL, monitoring.events.LINE)
    try:
        yield
    finally:
        monitoring.set_events(TOOL, 0)
        monitoring.register_callback(TOOL, monitoring.events.LINE, None)
        monitoring.free_tool_id(TOOL)


# --- mutants --------------------------------------------------------------------------------------


def _mutant(rng: random.Random, corpus: list[str]) -> str:
    text = rng.choice(corpus[-200:])
    for _ in range(rng.choice((1, 1, 2, 4))):
        text = rng.choice((_data, _data, _data, _letters, _word, _lines, _spliced))(rng, text, corpus)
    return text[:LONGEST]


def _letters(rng: random.Random, text: str, corpus: list[str]) -> str:
    k = rng.randrange(len(text) + 1)
    return text[:k] + rng.choice(("", chr(rng.randrange(1, 300)))) + text[k + rng.randrange(3) :]


def _word(rng: random.Random, text: str, corpus: list[str]) -> str:
    k = rng.randrange(len(text) + 1)
    return text[:k] + rng.choice(WORDS) + text[k:]


def _lines(rng: random.Random, text: str, corpus: list[str]) -> str:
    """Drop, double or move a few lines."""
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    block = lines[k : k + rng.randrange(1, 6)]
    rest = lines[:k] + lines[k + len(block) :]
    place = rng.randrange(len(rest) + 1)
    return "\n".join(rng.choice((rest, rest[:place] + block + rest[place:], lines[:k] + block + lines[k:])))


def _spliced(rng: random.Random, text: str, corpus: list[str]) -> str:
    other = rng.choice(corpus)
    return text[: rng.randrange(len(text) + 1)] + other[rng.randrange(len(other) + 1) :]


def _data(rng: random.Random, text: str, corpus: list[str]) -> str:
    """Change a value, a name or a part where the text is TOML."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError):
        return _word(rng, text, corpus)
    places = list(_places(data))
    if not places:
        return text
    holder, key = rng.choice(places)
    change = rng.randrange(4)
    if change == 0:
        holder[key] = rng.choice(VALUES)
    elif change == 1:
        del holder[key]
    elif change == 2 and isinstance(holder, dict):
        holder[rng.choice(("type", "name", "point", "axis", "positon", "x" * 50, "<b>"))] = holder.pop(key)
    else:
        other, there = rng.choice(places)
        holder[key] = other.get(there) if isinstance(other, dict) else other[there]
    try:
        return tomli_w.dumps(data)
    except (TypeError, ValueError, RecursionError):  # None, or a value that holds itself
        return text


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    for key, value in list(data.items() if isinstance(data, dict) else enumerate(data)):
        yield data, key
        if isinstance(value, dict | list):
            yield from _places(value)
