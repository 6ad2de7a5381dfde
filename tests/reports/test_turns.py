"""Times in interleaved turns: the least of a short run's, one alone of a long run's."""

from __future__ import annotations

from cross_checks.prices.timing import ENOUGH, ROUNDS, Sample, least_times


def test_short_runs_take_every_turn_and_long_ones_one():
    taken = {"short": 0, "long": 0}

    def run(name: str, seconds: float) -> float:
        taken[name] += 1
        return seconds / taken[name]

    busy = [Sample(0.3, 0.0), Sample(2 * ENOUGH, 0.0)]
    found = least_times([lambda: run("short", 0.3), lambda: run("long", 6.0)], busy)
    assert taken == {"short": ROUNDS, "long": 1}
    assert found == [0.3 / ROUNDS, 6.0]


def test_a_run_that_had_a_processor_to_itself_is_the_first_turn():
    taken = []

    def run(name: str, seconds: float) -> float:
        taken.append(name)
        return seconds

    runs = [lambda: run("short", 0.2), lambda: run("long", 5.0)]
    assert least_times(runs, [Sample(0.3), Sample(6.0)]) == [0.2, 6.0]
    assert taken == ["short"] * (ROUNDS - 1)
