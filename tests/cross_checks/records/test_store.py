"""The store of runs: what is kept comes back, a torn write loses that run alone, shards merge."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from cross_checks.records import record as machine
from cross_checks.records.record import Record
from cross_checks.records.store import Run, Store, default_path
from mbs_ref.trajectory import Trajectory

RECORD = Record("pendulum", {}, "swing", "second", {"step": 0.1}, "success", measures={"energy_drift": 1e-9})
WRITER = """
import sys
import numpy as np
from pathlib import Path
from tests.cross_checks.records.test_store import RECORD, path_of
from cross_checks.records.store import Run, Store
store = Store(Path(sys.argv[1]))
for k in range(400):
    store.keep_run(f"run {k}", Run(RECORD, path_of(k)))
    print(k, flush=True)
"""
KILLS = 20


def path_of(k: int) -> Trajectory:
    times = np.linspace(0.0, 1.0, 41)
    place = np.full((41, 3, 2), float(k)) + times[:, None, None]
    return Trajectory(times, place, place[:, :, 0], 2.0 * place, place[:, :, 1])


def test_a_run_comes_back_as_it_was():
    store = Store()
    store.keep_run("a", Run(RECORD, path_of(7)))
    kept = store.run("a")
    assert kept.record == RECORD
    np.testing.assert_array_equal(kept.path.velocity, path_of(7).velocity)
    assert store.run("b") is None
    store.keep_run("none", Run(RECORD, None))
    assert store.run("none").path is None


def test_the_first_run_kept_stays_and_nan_is_refused():
    store = Store()
    store.keep_run("a", Run(RECORD, path_of(1)))
    store.keep_run("a", Run(RECORD, path_of(2)))
    assert store.run("a").path.position[0, 0, 0] == 1.0
    spoiled = Record("pendulum", {}, "swing", "second", {}, "success", t_end=float("nan"))
    with pytest.raises(ValueError, match="not JSON compliant"):
        store.keep_run("b", Run(spoiled, None))
    assert len(store) == 1


def test_shards_merge_without_doubling(tmp_path):
    first, second = (Store(tmp_path / name) for name in ("a.sqlite", "b.sqlite"))
    first.keep_run("shared", Run(RECORD, path_of(0)))
    for key in ("shared", "own"):
        second.keep_run(key, Run(RECORD, path_of(1)))
    second.close()
    assert first.merge(tmp_path / "b.sqlite") == 1
    assert len(first) == 2


def test_timings_belong_to_a_machine():
    store = Store()
    store.keep_timings("a", "here", [1.0, 2.0])
    assert store.timings("a", "here") == [1.0, 2.0]
    assert store.timings("a", "there") == []


@pytest.mark.slow
def test_a_writer_killed_twenty_times_loses_and_doubles_nothing(tmp_path):
    file, chance = tmp_path / "runs.sqlite", random.Random(5)
    for _ in range(KILLS):
        with subprocess.Popen([sys.executable, "-c", WRITER, str(file)], stdout=subprocess.PIPE, text=True) as child:
            assert child.stdout.readline()
            time.sleep(chance.uniform(0.0, 0.4))
            os.kill(child.pid, signal.SIGKILL)
            said = [0, *(int(line) for line in child.stdout.read().split())]
        with Store(file) as store:
            assert all(store.run(f"run {k}").path.position[0, 0, 0] == k for k in said)  # what was said is there, whole
    assert subprocess.run([sys.executable, "-c", WRITER, str(file)], stdout=subprocess.DEVNULL).returncode == 0
    with Store(file) as store:
        assert len(store) == 400


def test_one_thread_at_a_time_reads_or_writes():
    store = Store()
    base, held = store._base, []

    class Watched:
        def __getattr__(self, name: str):
            held.append(store._lock.locked())
            return getattr(base, name)

        def __enter__(self):
            return base.__enter__()

        def __exit__(self, *given: object):
            return base.__exit__(*given)

    store._base = Watched()  # type: ignore[assignment]
    store.keep_timings("a", "here", [1.0])
    assert store.timings("a", "here") == [1.0]
    assert store.run("a") is None
    assert len(held) >= 3
    assert all(held)


def test_two_processors_of_one_name_are_two_machines(monkeypatch):
    names = set()
    for made in ("fast", "slow"):
        monkeypatch.setattr(machine, "processor", lambda made=made: made)
        names.add(machine.machine.__wrapped__())
    assert len(names) == 2


def test_new_times_of_a_run_replace_those_before(tmp_path):
    with Store(tmp_path / "runs.sqlite") as store:
        for loops in ([3.0, 2.0], [1.5]):
            store.keep_timings("run", "box", loops)
        store.keep_timings("run", "other", [9.0])
        assert store.timings("run", "box") == [1.5]


def test_times_replace_those_before_of_the_same_machine():
    with Store() as store:
        for key, host, loops in (("a", "x", [1.0]), ("a", "y", [2.0]), ("b", "x", [3.0]), ("a", "x", [4.0, 5.0])):
            store.keep_timings(key, host, loops)
        assert [store.timings(*of) for of in (("a", "x"), ("a", "y"), ("b", "x"), ("b", "y"))] == [
            [4.0, 5.0], [2.0], [3.0], []]  # fmt: skip


def test_the_store_is_the_file_that_is_named_else_one_of_the_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "mine"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert default_path() == tmp_path / "mine"
    monkeypatch.delenv("MBS_REF_STORE")
    assert default_path() == tmp_path / "cache" / "mbs-ref" / "runs.sqlite"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert default_path() == Path.home() / ".cache" / "mbs-ref" / "runs.sqlite"


def test_a_file_that_is_no_store_is_named(tmp_path):
    (tmp_path / "notes.txt").write_text("no database, but long enough to be looked at " * 20)
    with pytest.raises(OSError, match=r"notes\.txt: .*: name another store by --store or MBS_REF_STORE"):
        Store(tmp_path / "notes.txt")


def test_a_store_waits_for_another_process_that_writes(tmp_path):
    """A tenth of a second here; the store gives up after a minute."""
    with Store(tmp_path / "a.sqlite") as store:
        other = sqlite3.connect(tmp_path / "a.sqlite", check_same_thread=False)
        other.execute("BEGIN IMMEDIATE")
        ended = threading.Timer(0.1, other.rollback)
        ended.start()
        store.keep_timings("key", "host", [1.0, 2.0])
        ended.join()
        other.close()
        assert store.timings("key", "host") == [1.0, 2.0]
