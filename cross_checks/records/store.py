"""The store of runs: one SQLite file in which each run is stored once, for everything that judges or shows runs.

A run is written in one transaction: a crash loses at most the run that is being written. Files of several machines or
shards are merged by `merge`. Samples are stored compressed beside the record: errors against any truth, and distances
between runs, are queries to the store.
"""

import hashlib
import importlib
import io
import json
import os
import pkgutil
import sqlite3
import threading
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks import truths
from cross_checks.engine import Engine
from cross_checks.records.lines import adapter
from cross_checks.records.record import Record
from cross_checks.truths import of
from cross_checks.truths.stored_poses import file_of, physics_of
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.kernels.jit import source_digest, sources_of
from mbs_ref.trajectory import POSES

MEASURING = "cross_checks.judge.measure"  # whose changes make records anew
LISTED_BY = {"mbs_ref.integrators": "mbs_ref.integrators.methods", "cross_checks.metrics": "cross_checks.metrics"}
LISTING = frozenset(LISTED_BY)  # packages that import what lies in a folder by listing it


def run_name(scene: Scene, engine: Engine, settings: Settings, times: np.ndarray) -> str:
    """Return the key of a run; the same wherever and whenever it runs, and whatever the scene is called."""
    facts = {
        "physics": physics_of(scene),
        "times": hashlib.sha256(np.ascontiguousarray(times, dtype=float).tobytes()).hexdigest(),
        "engine": engine_key(engine),
        "settings": settings.model_dump(mode="json", exclude_none=True),
        "measured by": code_of(MEASURING),
    }
    return digest_of(facts)


def engine_key(engine: Engine) -> list[str]:
    """Return what a result of an engine depends on: its name, version, adapter and the contract's code."""
    codes = [code_of(type(engine).__module__), code_of(Engine.__module__), engine.made_of]
    return [engine.name, engine.version(), *filter(None, codes)]


def truth_name(scene: Scene, times: np.ndarray) -> str:
    """Return the key of a truth: the scene's physics, the times, the code of the truths, and its stored poses."""
    code = [source_digest(name) for name in sorted(_modules_in(of.__name__))]
    file = file_of(scene)
    poses = hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else ""
    known = [physics_of(scene), poses, np.asarray(times, dtype=float).tolist()]
    return digest_of([*known, code, source_digest(truths.__name__)])


def digest_of(facts: Any) -> str:
    """Return a digest of plain data."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


@cache
def code_of(module: str) -> str:
    """Return a digest of an adapter, of the modules of its own folder, and of all that they import of this project."""
    made = importlib.import_module(module)
    inner = [info.name for info in pkgutil.iter_modules(getattr(made, "__path__", []), f"{module}.")]
    listed = [name for folder in sources_of(module) & LISTING for name in _modules_in(LISTED_BY[folder])]
    return digest_of([source_digest(name) for name in sorted({module, *inner, *listed})])


def _modules_in(package: str) -> list[str]:
    return [info.name for info in pkgutil.iter_modules(importlib.import_module(package).__path__, f"{package}.")]


SAMPLES = ("times", *POSES)
TABLES = """
CREATE TABLE IF NOT EXISTS runs (key TEXT PRIMARY KEY, record TEXT NOT NULL, samples BLOB);
CREATE TABLE IF NOT EXISTS timings (key TEXT, host TEXT, loops TEXT NOT NULL, PRIMARY KEY (key, host));
CREATE TABLE IF NOT EXISTS arrays (key TEXT PRIMARY KEY, facts TEXT NOT NULL, data BLOB NOT NULL);
"""
UNREADABLE = (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error)  # of damaged bytes
PATIENCE = 60.0  # s to wait for another process that writes


@dataclass(frozen=True)
class Run:
    """A record without an error, which depends on the truth, and the samples that it summarises."""

    record: Record
    path: Trajectory | None  # None where nothing came back
    host: str = ""  # the machine (cross_checks.records.record.machine) that executed it just now

    def _repr_html_(self) -> str:
        return self.record._repr_html_()


def default_path() -> Path:
    """Return the file of the machine's store: MBS_REF_STORE, else runs.sqlite in the cache folder."""
    named = os.environ.get("MBS_REF_STORE")
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(named) if named else Path(root) / "mbs-ref" / "runs.sqlite"


@contextmanager
def _reached(path: Path | None) -> Iterator[None]:
    """Raise an OSError that names the file where the store cannot be read or written."""
    try:
        yield
    except sqlite3.Error as error:
        place = path or "the store in memory"
        raise OSError(f"{place}: {error}: name another store by --store or MBS_REF_STORE, or move it away") from error


class Store:
    """A store in a file, or in memory without one. Safe to use from several threads and processes."""

    def __init__(self, path: Path | None = None) -> None:
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        self._lock = threading.Lock()
        with _reached(path):
            self._base = sqlite3.connect(path or ":memory:", timeout=PATIENCE, check_same_thread=False)
            self._base.execute("PRAGMA journal_mode=WAL")
            self._base.execute("PRAGMA synchronous=NORMAL")
            self._base.executescript(TABLES)

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def run(self, key: str) -> Run | None:
        """Return the run that is stored under a key."""
        return self._decoded("runs", "record, samples", key, lambda row: Run(
            adapter(Record).validate_json(row[0]),
            None if row[1] is None else Trajectory(**dict[str, Any](_arrays(row[1]))),
        ))  # fmt: skip

    def keep_run(self, key: str, run: Run) -> None:
        """Store a run whole or not at all; the first one stored remains. ValueError where its record holds NaN."""
        text = json.dumps(run.record.to_dict(), allow_nan=False)
        samples = None if run.path is None else _blob({name: getattr(run.path, name) for name in SAMPLES})
        self._write("INSERT OR IGNORE INTO runs VALUES (?, ?, ?)", key, text, samples)

    def timings(self, key: str, host: str) -> list[float]:
        """Return the loop times (s) of a run on a machine."""
        row = self._one("SELECT loops FROM timings WHERE key = ? AND host = ?", key, host)
        return [] if row is None else json.loads(row[0])

    def keep_timings(self, key: str, host: str, loops: list[float]) -> None:
        """Store the loop times (s) of a run on a machine, in place of those before."""
        self._write("INSERT OR REPLACE INTO timings VALUES (?, ?, ?)", key, host, json.dumps(loops))

    def arrays(self, key: str) -> tuple[dict[str, Any], dict[str, np.ndarray]] | None:
        """Return facts and arrays stored under a key, for truths that took long to compute."""
        return self._decoded("arrays", "facts, data", key, lambda row: (json.loads(row[0]), _arrays(row[1])))

    def keep_arrays(self, key: str, facts: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        """Store facts and arrays under a key."""
        self._write("INSERT OR REPLACE INTO arrays VALUES (?, ?, ?)", key, json.dumps(facts), _blob(arrays))

    def merge(self, other: Path) -> int:
        """Add the runs of another store that this one lacks; return how many."""
        with self._lock, _reached(self.path):
            self._base.execute("ATTACH ? AS other", (str(other),))
            try:
                with self._base:
                    return self._base.execute("INSERT OR IGNORE INTO runs SELECT * FROM other.runs").rowcount
            finally:
                self._base.execute("DETACH other")

    def __len__(self) -> int:
        row = self._one("SELECT count(*) FROM runs")
        return 0 if row is None else int(row[0])

    def _decoded[T](self, table: str, columns: str, key: str, decode: Callable[[Any], T]) -> T | None:
        """Return what is stored under a key; what cannot be decoded is removed, so that it is computed again."""
        row = self._one(f"SELECT {columns} FROM {table} WHERE key = ?", key)
        try:
            return None if row is None else decode(row)
        except UNREADABLE:
            self._write(f"DELETE FROM {table} WHERE key = ?", key)
            return None

    def _one(self, query: str, *given: Any) -> Any:
        with self._lock, _reached(self.path):
            return self._base.execute(query, given).fetchone()

    def _write(self, query: str, *given: Any) -> None:
        with self._lock, _reached(self.path), self._base:
            self._base.execute(query, given)


def _blob(arrays: dict[str, np.ndarray]) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def _arrays(blob: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(blob)) as kept:
        return {name: kept[name] for name in kept.files}
