"""A track of 100 links against one of 50, per unit of simulated time; the runs take turns."""

from __future__ import annotations

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

LINKS, ROUNDS = (50, 100), 5
ASKED = 2.5  # largest ratio: 2 is linear
DRIVE = Settings(method="dop853", rtol=1e-6, t_end=0.1, samples=2)


def loop_seconds(links: int) -> float:
    run = simulate(scenes.make("tracked_vehicle", links=links), DRIVE)
    assert run.ok, run.message
    return run.timing.loop_s


def test_the_cost_of_a_track_grows_linearly(benchmark):
    times: dict[int, list[float]] = {links: [] for links in LINKS}

    def turns():
        for links in LINKS:
            times[links].append(loop_seconds(links))

    benchmark.pedantic(turns, rounds=ROUNDS, warmup_rounds=1)
    short, long = (min(times[links]) for links in LINKS)
    benchmark.extra_info |= {"links": LINKS, "loop_s": (short, long), "ratio": long / short, "asked": ASKED}
    assert long / short <= ASKED
