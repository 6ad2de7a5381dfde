"""Commands on a dask cluster of two workers, of which one is killed under way: the results are those of one machine."""

from __future__ import annotations

import json
import os
import signal
import threading
import time
from collections.abc import Iterator

import pytest
from click.testing import CliRunner

from reports import gather
from reports.cli import main

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore"),  # a killed worker's sockets and loops complain on their way out
]


@pytest.fixture
def cluster() -> Iterator[str]:
    """Yield the address of two workers; the first that makes a call is killed meanwhile."""
    distributed = pytest.importorskip("distributed")
    local = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with local as made, distributed.Client(made) as client:
        killed = threading.Thread(target=_kill_one, args=(client,), daemon=True)
        killed.start()
        yield made.scheduler_address
        killed.join(timeout=60.0)
        assert not killed.is_alive(), "no worker made a call"


def _kill_one(client) -> None:
    while not (busy := [worker for worker, calls in client.processing().items() if calls]):
        time.sleep(0.02)
    os.kill(client.run(os.getpid, workers=busy[:1])[busy[0]], signal.SIGKILL)


def run(*words: str) -> str:
    result = CliRunner().invoke(main, list(words))
    assert result.exit_code == 0, result.output
    return result.stdout


def test_a_sweep(cluster, tmp_path):
    words = ("sweep", "pendulum", "--engine", "mbs_ref", "--method", "rk4", "--method", "dop853", "--json")
    far, near = (
        [json.loads(line) for line in run(*words, "--store", str(tmp_path / name), *more).splitlines()]
        for name, more in (("far.sqlite", ("--scheduler", cluster)), ("near.sqlite", ()))
    )
    assert [(one["settings"], one["final"]) for one in far] == [(one["settings"], one["final"]) for one in near]
    assert all("loop_runs" in one["times"] for one in far)


def test_an_ensemble(cluster):
    words = ("ensemble", "double_pendulum", "--vary", "gravity.y=-10..-9", "-n", "40", "--t-end", "1.0", "--json")
    far, near = (json.loads(run(*words, *more)) for more in (("--scheduler", cluster), ()))
    different = {"wall_s", "runs_per_s"}
    assert {k: v for k, v in far.items() if k not in different} == {k: v for k, v in near.items() if k not in different}


def test_extremes(cluster):
    words = ("extremes", "--only", "overflow", "--engine", "mbs_ref", "--json")
    far = [json.loads(line) for line in run(*words, "--scheduler", cluster).splitlines()]
    assert {one["engine"] for one in far} == {"mbs_ref"}
    assert all(one["points"] for one in far if one["fate"] != "cannot")


def test_a_report(cluster, tmp_path, monkeypatch):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "runs.sqlite"))
    monkeypatch.setattr(gather, "QUICK", (("pendulum", {}),))
    monkeypatch.setattr(gather, "preparations", lambda store: [])
    ours, tasks = ("rk4", "dop853", "radau"), gather.tasks
    monkeypatch.setattr(
        gather, "tasks", lambda _: [one for one in tasks(["mbs_ref"]) if one[1] and one[1].name in ours]
    )
    run("report", "--quick", "--scheduler", cluster, "-o", str(tmp_path / "out"))
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert {cell["method"]: cell["verdict"] for cell in data["cells"]} == dict.fromkeys(ours, "agrees")
