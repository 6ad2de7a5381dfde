"""Calls on a dask cluster that loses a worker: all of them come back, and what is lost is named."""

from __future__ import annotations

import os
import signal

import pytest

from cross_checks.isolation.workers import Late, Pool
from tests.cross_checks.isolation import troubles


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # a killed worker's sockets and loops complain on their way out
def test_a_lost_worker_costs_only_time():
    distributed = pytest.importorskip("distributed")
    from cross_checks.isolation.remote import Remote

    local = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with local as cluster, distributed.Client(cluster) as client, Remote(scheduler=cluster.scheduler_address) as call:
        found = {}
        with Pool[int | str, object](call, brief=troubles.BRIEF) as pool:
            pool.add("hangs", lambda call: call(troubles.hang), seconds=1e3)
            for number in range(12):
                pool.add(number, lambda call, number=number: call(troubles.add, number, 1.0))
            for name, result in pool:
                found[name] = result
                if len(found) == 6:
                    os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
    assert isinstance(found.pop("hangs"), Late)
    assert found == {number: number + 1.0 for number in range(12)}
