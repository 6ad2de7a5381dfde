"""A fault at any place ends a command with one line and the code for incomplete; stored runs stay."""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing, nullcontext
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from cross_checks.records.store import Store
from reports.cli import main
from tests.reports.injected_faults import Gate, Place, injected

QUICK = 25  # faults of a command in every run of the tests
MOST = 1000  # in the nightly one: all places
EXIT_CODES = {"simulate": (0, 2, 4), "judge": (0, 2, 4), "check": range(6), "report": range(6), "sweep": range(6)}
COMMANDS = {
    "simulate": "simulate pendulum --samples 11 -o {out}/run.csv",
    "judge": "judge {out}/run.csv pendulum --error 1e-3",
    "check": "check pendulum --engine {out}/swing.py",
    "sweep": "sweep pendulum --engine mbs_ref --method rk4 -o {out}/sweep.jsonl",
    "report": "report --scene pendulum --engine mbs_ref -o {out}/site",
}
ADAPTER = """
from tests.cross_checks.conftest import Swing

class Right(Swing):
    def methods(self):
        return super().methods()[:1]

ENGINE = Right
"""


def run(command: str, place: Path, gate: Gate | None = None) -> Result:
    words = COMMANDS[command].format(out=place).split()
    with nullcontext() if gate is None else injected(gate):
        return CliRunner().invoke(main, words, prog_name="mbs-ref", env={"MBS_REF_STORE": str(place / "store.sqlite")})


def _rows(place: Path) -> set[tuple]:
    with closing(sqlite3.connect(place / "store.sqlite")) as base:
        return {row for table in ("runs", "arrays") for row in base.execute(f"SELECT * FROM {table}")}


@pytest.fixture(scope="module")
def filled(tmp_path_factory) -> Path:
    """A folder with a small store and the files of earlier commands."""
    place = tmp_path_factory.mktemp("filled")
    (place / "swing.py").write_text(ADAPTER)
    with Store(place / "store.sqlite") as store:
        store.keep_arrays("earlier", {"of": "a truth"}, {"numbers": np.arange(3.0)})
    for command in ("simulate", "judge"):
        done = run(command, place)  # compiles, too
        assert done.exit_code == 0, done.output
    return place


def broken(command: str, filled: Path, folder: Path, most: int) -> Iterator[tuple[Place, str]]:
    """Yield every place whose fault has another end, and what it is."""
    passed = Gate()
    assert run(command, shutil.copytree(filled, folder / "whole"), passed).exit_code == 0
    places = list(passed.passed)
    for k, at in enumerate(places[:: max(len(places) // most, 1)]):
        place = shutil.copytree(filled, folder / str(k))
        done = run(command, place, Gate(at))
        complaints = [line for line in done.stderr.splitlines() if line.startswith("Error")]
        if not isinstance(done.exception, SystemExit | None):
            yield at, repr(done.exception)
        elif done.exit_code not in EXIT_CODES[command] or (done.exit_code != 0 and len(complaints) != 1):
            yield at, f"exit code {done.exit_code}: {done.stderr}"
        elif not _rows(filled) <= _rows(place):
            yield at, "stored runs are lost"
        shutil.rmtree(place)


@pytest.mark.parametrize("command", ["simulate", "judge"])
def test_a_few_faults_end_in_a_line(command, filled, tmp_path):
    assert dict(broken(command, filled, tmp_path, QUICK)) == {}


def test_a_defect_of_our_own_is_reported_as_one(filled, monkeypatch):
    def divide(scene: object) -> float:
        return 1 / 0

    monkeypatch.setattr("reports.commands.run.simulate.summary", divide)
    done = run("simulate", filled)
    assert done.exit_code == 6
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("Error")]
    assert "defect of mbs-ref" in line
    assert f"ZeroDivisionError at {__file__}:{divide.__code__.co_firstlineno + 1}: division by zero" in line
    (file,) = [Path(word.rstrip(":")) for word in line.split() if word.endswith(".txt:")]
    assert file.parent == Path(tempfile.gettempdir())
    assert "1 / 0" in file.read_text()
    file.unlink()


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_faults_end_in_a_line_and_lose_nothing(command, filled, tmp_path):
    run(command, filled)
    assert dict(broken(command, filled, tmp_path, MOST)) == {}


def test_a_damaged_run_is_computed_again_and_a_file_that_is_no_store_is_named(filled, tmp_path):
    place = shutil.copytree(filled, tmp_path / "damaged")
    with closing(sqlite3.connect(place / "store.sqlite")) as base, base:
        base.execute("UPDATE arrays SET data = x'00'")
    with Store(place / "store.sqlite") as store:
        assert store.arrays("earlier") is None
    (place / "store.sqlite").write_text("no database at all, but a text that is long enough")
    done = run("judge", place)
    assert done.exit_code == 4
    assert "file is not a database: name another store by --store" in done.stderr
