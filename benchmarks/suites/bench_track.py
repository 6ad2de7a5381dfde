"""The tracked vehicle: twice as many links, and contacts on constraints; the runs of a pair take turns."""

from functools import partial

from cross_checks.prices.timing import interleaved
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

ROUNDS = 5
DRIVE = Settings(method="dop853", rtol=1e-6, t_end=0.1, samples=2)
LINKS, ASKED = (50, 100), 2.5  # largest ratio: 2 is linear
PAPERS = Settings(method="rk4", step=5e-5, t_end=0.5, samples=2, estimate="off")
HELD = 3.0  # largest ratio of wheels held on the links by constraints (Fox 2001) to wheels on springs


def in_turns(benchmark, settings: Settings, *parameters: dict) -> list[float]:
    """Return the least time (s) of the loop for each choice of the scene's parameters."""
    runs = [
        partial(simulate, scenes.make("tracked_vehicle", model="paper", **chosen), settings) for chosen in parameters
    ]
    paths = benchmark.pedantic(interleaved, args=(runs, ROUNDS), rounds=1, warmup_rounds=1)
    assert all(path.ok for built in paths for path in built)
    return [min(path.timing.loop_s for path in built) for built in paths]


def test_the_cost_of_a_track_grows_linearly(benchmark):
    short, long = in_turns(benchmark, DRIVE, *({"links": links} for links in LINKS))
    benchmark.extra_info |= {"links": LINKS, "loop_s": (short, long), "ratio": long / short, "asked": ASKED}
    assert long / short <= ASKED


def test_contacts_on_constraints_cost_little_more_than_on_springs(benchmark):
    soft, held = in_turns(benchmark, PAPERS, {"law": "spring_damper"}, {"law": "constraint"})
    benchmark.extra_info |= {"loop_s": (soft, held), "ratio": held / soft, "asked": HELD}
    assert held / soft <= HELD
