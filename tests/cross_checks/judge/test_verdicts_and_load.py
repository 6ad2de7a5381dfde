"""Verdicts and the machine: cells are the same beside busy loops and with nothing compiled beforehand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from cross_checks.records.store import default_path

# Every core (planar, spatial, particles), contact, loops, stiffness, and every engine. What is asked together compiles
# what it shares once.
SCENES = {
    "chain": ("pendulum_chain", "-p", "links=3"),
    "chain in space": ("spatial_chain", "-p", "links=3"),
    "others": ("n_four_bar", "heavy_top", "bouncing_ball", "kepler", "spring_pendulum", "bricard"),
}
TIMES = ("loop_s",)  # the figures of a cell that belong to the machine
BUSY = "while True: pass"


def cells(asked: tuple[str, ...], store: Path, **environment: str) -> list[dict]:
    """Return what `mbs-ref check` says of some scenes, from a store of its own; without times."""
    command = [sys.executable, "-m", "reports.cli", "check", *asked, "--json", "--store", str(store)]
    answer = subprocess.run(command, env=os.environ | environment, stdout=subprocess.PIPE, check=False)
    assert answer.returncode in (0, 1), asked  # 1: a method is wrong, which is a verdict
    return without_times(json.loads(answer.stdout))


def without_times[T](plain: T) -> T:
    """Return plain data without what a clock measured."""
    if isinstance(plain, dict):
        return {key: without_times(value) for key, value in plain.items() if key not in TIMES}  # type: ignore[return-value]
    return [without_times(value) for value in plain] if isinstance(plain, list) else plain  # type: ignore[return-value]


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Run endless loops meanwhile."""
    with ExitStack() as stack:
        for _ in range(count):
            loop = subprocess.Popen([sys.executable, "-c", BUSY])
            stack.callback(loop.wait)
            stack.callback(loop.kill)
        yield


def differences(first: list[dict], second: list[dict]) -> list[str]:
    """Return the cells that are not the same, with the fields that differ."""
    assert [_name(cell) for cell in first] == [_name(cell) for cell in second]
    pairs = zip(first, second, strict=True)
    return [f"{_name(a)}: {', '.join(k for k in a if a[k] != b[k])}" for a, b in pairs if a != b]


def _name(cell: dict) -> str:
    return f"{cell['scene']} {cell['engine']} {cell['method']}"


@pytest.mark.slow
@pytest.mark.parametrize("asked", SCENES.values(), ids=SCENES)
def test_cells_depend_neither_on_load_nor_on_the_cache(asked, tmp_path):
    """Both at once: each could change them, and neither does. The other runs are those that all tests share."""
    plain = cells(asked, default_path())
    with busy(os.cpu_count() or 1):
        cold = cells(asked, tmp_path / "cold.sqlite", MBS_REF_CACHE=str(tmp_path / "cache"))
    assert differences(plain, cold) == []
    assert differences(plain, cells(asked, default_path())) == []  # the same store asked twice
