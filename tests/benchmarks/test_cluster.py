"""The matrix is the same serially, in shards, and on a cluster that loses a worker."""

from __future__ import annotations

import os
import signal
from dataclasses import replace

import pytest

from benchmarks.cluster import plan, serial, shard
from benchmarks.scaling import makespan

TIMEOUT = 300.0  # s; far beyond the longest run, because a timeout depends on the machine


def test_shards_are_disjoint_and_complete():
    tasks = plan(quick=True, engines=["mbs_ref"])
    parts = [shard(tasks, k, 3) for k in (1, 2, 3)]
    assert sorted(map(str, tasks)) == sorted(str(task) for part in parts for task in part)
    with pytest.raises(ValueError, match="shard = 4/3"):
        shard(tasks, 4, 3)


def but_times(record):
    return replace(record, times={}, notes=())


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # a killed worker's sockets and loops complain on their way out
def test_a_lost_worker_costs_only_time():
    distributed = pytest.importorskip("distributed")
    from benchmarks.dask_matrix import gather

    tasks = plan(quick=True)
    alone = dict(serial(tasks, TIMEOUT))
    found = {}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        for task, record in gather(client, tasks, TIMEOUT):
            found[task] = record
            if len(found) == len(tasks) // 2:
                pids = list(client.run(os.getpid).values())
                os.kill(pids[0], signal.SIGKILL)
    assert found.keys() == alone.keys()
    assert {task: but_times(run.record) for task, run in found.items()} == {
        task: but_times(run.record) for task, run in alone.items()
    }


def test_the_makespan_is_between_its_bounds():
    seconds = [3.0, 1.0, 1.0, 1.0]
    assert makespan(seconds, 1) == 6.0
    assert makespan(seconds, 2) == 3.0
    assert makespan(seconds, 1000) == 3.0
