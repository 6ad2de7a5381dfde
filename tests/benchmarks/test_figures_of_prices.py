"""What a choice states, and loop times, computed again from random runs and clocks in a few lines of their own."""

from __future__ import annotations

import math
import random
import re
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np
import pytest

from benchmarks.record_changes import Move, alone, changes, median_ratio, overall
from cross_checks.judge.vocabulary import OURS
from cross_checks.prices import pick as confirm
from cross_checks.prices import timing
from cross_checks.prices.pick import RIVAL, Bounds, Choice, basis, contenders, of_engines, pick, setting, shipped
from cross_checks.prices.timing import Comparison, Pace, Sample
from cross_checks.records.record import BUSY_NOTE, Error, Record
from cross_checks.records.store import Store
from mbs_ref import Settings, scenes


def made(chance: random.Random, engine: str, method: str) -> Record:
    error = Error(
        10 ** chance.uniform(-9, -4), "exact", 10 ** chance.uniform(-10, -9), None, length=chance.uniform(2, 9)
    )
    given = {chance.choice(("step", "rtol")): 10 ** chance.uniform(-6, -1)}
    opened = 10 ** chance.uniform(-9, -4) if chance.random() < 0.8 else None  # an engine may not report its motion
    return Record("pendulum", {"length": 2.0}, engine, method, given, "success", error=error,
                  times={"loop_s": 10 ** chance.uniform(-4, 0), "build_s": 9.0},
                  measures={"compliance_position": opened})  # fmt: skip


def runs_of(seed: int) -> list[Record]:
    chance = random.Random(seed)
    return [made(chance, engine, method) for engine in (OURS, "quick", "slow") for method in "ab" for _ in range(4)]


def worst(run: Record) -> float:
    assert run.error
    return run.error.value + run.error.uncertainty


def gap(run: Record) -> float:
    known = run.measures["compliance_position"]
    return math.inf if known is None else known


def loop(run: Record) -> float:
    return run.times["loop_s"]


def said(run: Record) -> str:
    """Return the words of a run's error, computed here."""
    assert run.error
    return f"{worst(run):.1e} of the scene ({worst(run) * run.error.length:.1e} m)"


def priced(run: Record) -> str:
    return f"{1000.0 * loop(run):.3g} ms"


def test_a_setting_in_words():
    run = runs_of(0)[0]
    given = ({"step": 0.123456789}, {"rtol": 3.4e-7}, {}, {"step": 0.5, "rtol": 1e-3})
    words = [setting(replace(run, settings=one)).removeprefix(f"{OURS} a ") for one in given]
    assert words == ["step=0.123457", "rtol=3e-07", "its defaults", "step=0.5"]


@pytest.mark.parametrize("budget", [None, 0.05])
@pytest.mark.parametrize("tight", [None, 1e-6])
@pytest.mark.parametrize("seed", range(6))
def test_a_choice(seed, tight, budget):
    runs, error = runs_of(seed), 3e-6
    found = pick(runs, error, tight, budget)
    reach = [r for r in runs if worst(r) <= error and (tight is None or gap(r) <= tight)]
    fits = sorted((r for r in reach if budget is None or loop(r) <= budget), key=loop)
    assert contenders(runs, Bounds(error, tight)) == [r for r in reach if loop(r) <= RIVAL * min(map(loop, reach))]
    if not fits:
        assert found.best is None
        if reach:
            cheapest = min(reach, key=loop)
            assert found.sentence == f"none within 50 ms; the cheapest is {setting(cheapest)} at {priced(cheapest)}"
        elif tight:
            close = sum(worst(r) <= error for r in runs)
            assert found.sentence.startswith(f"{close} settings reach 3.0e-06, but none keeps") or not close
        return
    assert found.best == fits[0]
    others = [r for r in fits if r.engine != fits[0].engine] or [r for r in fits if r.method != fits[0].method]
    assert found.runner_up == (others[0] if others else None)
    whose = ", this project's own solver," if fits[0].engine == OURS else ""
    text = f"{setting(fits[0])}{whose} reaches {said(fits[0])} in {priced(fits[0])}"
    if others:
        assert found.margin == pytest.approx(loop(others[0]) / loop(fits[0]))
        text += f", {found.margin:.3g} times cheaper than {setting(others[0])} ({priced(others[0])})."
    else:
        text += "; no other engine or method reaches it."
    cheaper = [r for r in runs if loop(r) < loop(fits[0])]
    loose = [r for r in cheaper if worst(r) <= error]
    rough = [r for r in cheaper if tight is None or gap(r) <= tight]
    if loose:
        near = min(loose, key=gap)
        is_known = math.isfinite(gap(near))
        by = f"opens the joints by {gap(near):.1e}" if is_known else "is not known to keep the joints closed"
        text += f" The compliance limits it: for {priced(near)} {setting(near)} {by}."
    elif rough:
        near = min(rough, key=worst)
        text += f" The error limits it: for {priced(near)} the nearest is {setting(near)} with {said(near)}."
    assert found.sentence == text
    assert (found.limit.cheaper if found.limit else None) == (near if loose or rough else None)


def test_a_run_afresh_has_the_settings_of_its_record():
    run = replace(runs_of(0)[0], settings={"method": "rk4", "step": 0.123})
    _, *asked = confirm.afresh(scenes.make("pendulum"), run, "truth", call=lambda *given: given)  # type: ignore[arg-type]
    assert asked == [scenes.make("pendulum"), run.engine, Settings(method="rk4", step=0.123), "truth"]


def test_why_there_is_no_choice():
    runs = runs_of(2)
    far = [replace(r, error=replace(r.error, uncertainty=0.0)) for r in runs if r.error]
    nearest = min(far, key=worst)
    words = f"the nearest is {setting(nearest)} with {said(nearest)}"
    assert pick(far, 1e-12).sentence == f"none reached 1.0e-12 of the scene; {words}"
    coarse = [replace(r, error=replace(r.error, uncertainty=1e-3 * (k + 1))) for k, r in enumerate(runs[:3]) if r.error]
    assert pick(coarse, 1e-4).sentence == "the truth of this scene resolves no error below 3.0e-03 of it"
    failed = [replace(runs[0], status="crashed", message=text, engine=engine)
              for engine, text in (("x", "a long one"), ("x", "short"), ("y", "other"), ("x", "middling"))]  # fmt: skip
    assert pick(failed, 1.0).sentence == "no run with a known error was measured; x: short; y: other"
    unknown = replace(runs[0], error=None, notes=("another note", "no error: they part"))
    assert pick([unknown, *failed], 1.0).sentence == "no run with a known error was measured; no error: they part"
    with pytest.raises(ValueError, match="2 scenes"):
        pick([runs[0], replace(runs[1], parameters={"length": 3.0})], 1.0)
    with pytest.raises(ValueError, match="budget = 0"):
        pick(runs, 1.0, budget=0.0)


def test_each_installed_engine_has_a_sentence():
    chance = random.Random(3)
    mine, slow = made(chance, OURS, "a"), made(chance, "slow", "b")
    absent = replace(mine, engine="absent", status="engine-missing", message="not here", error=None)
    refused = replace(mine, engine="other", status="cannot", message="it has no motor", error=None)
    runs = [mine, absent, refused, slow]
    found = of_engines(runs, Bounds(2.0 * worst(mine)))
    assert found[0] == f"{setting(mine)}, {said(mine)} in {priced(mine)}".replace(OURS, f"{OURS}:")
    assert found[1] == "other does not run it: it has no motor"
    assert len(found) == 3
    far = of_engines(runs, Bounds(0.5 * worst(slow)))[2]
    assert far.startswith(f"slow: none within the bounds; the nearest is b {setting(slow).split()[-1]}, {said(slow)}")


def test_what_the_errors_are_from_and_what_an_engine_does_as_it_comes():
    runs = runs_of(3)
    known = [r.error.uncertainty for r in runs if r.error]
    assert basis(runs) == f"Errors are from a truth known to {min(known):.1e} of the scene: exact."
    assert basis([replace(runs[0], error=None)]) == "No truth is known yet."
    run = runs[0]
    how = f"{OURS} as it comes ({setting(run).removeprefix(OURS).strip()})"
    assert shipped(run) == f"{how}: {said(run)} in {priced(run)}"
    assert shipped(replace(run, error=None)) == f"{how}: no known error in {priced(run)}"
    assert shipped(replace(run, status="crashed", message="bad")) == f"{how} ends with crashed: bad"


@pytest.mark.parametrize("pace", Pace)
def test_what_a_duel_leaves(pace):
    first, second = runs_of(4)[:2]
    duel = Comparison(pace, 0.8, 0.7, 0.9, 17, 0.0)
    found = confirm.settled(Choice(first, second, 3.0, "Before."), duel)
    is_other = pace is Pace.FASTER
    assert (found.best, found.runner_up) == ((second, first) if is_other else (first, second))
    assert found.margin == pytest.approx(1.0 / 0.8 if is_other else 0.8)
    word = {"slower": "Confirmed by", "faster": "Overturned by", "same": "A tie in", "inconclusive": "Not settled by"}
    assert found.sentence == (f"Before. {word[pace]} 17 interleaved blocks: {setting(second)} takes 0.8 [0.7, 0.9] "
                              f"times as long as {setting(first)}.")  # fmt: skip


def test_loop_times_of_a_record_and_an_interval():
    run, loops = runs_of(5)[0], [0.5, 0.2, 0.9, 0.3]
    found = timing.with_loops(replace(run, notes=("a",)), loops, "b")
    times = {"loop_s": 0.2, "loop_median_s": median(loops), "loop_most_s": 0.9, "loop_runs": 4.0, "build_s": 9.0}
    assert (found.times, found.notes) == (times, ("a", "b"))
    assert timing.with_loops(run, loops).notes == ()
    ratios = np.random.default_rng(1).lognormal(size=25)
    low, high = timing.interval(ratios, np.random.default_rng(7))
    draws = np.sort(np.median(np.random.default_rng(7).choice(ratios, (timing.RESAMPLES, 25)), axis=1))
    assert draws[24] <= low <= draws[25]  # 2.5 % of 1000
    assert draws[974] <= high <= draws[975]
    assert timing.half_width([1.0, 4.0, 2.0]) == 0.75
    assert timing.half_width([0.0, 0.0, 0.0]) == 0.0


@pytest.mark.parametrize(
    ("ratio", "low", "high", "pace"),
    [(1.06, 1.01, 1.2, "slower"), (1.06, 0.99, 1.2, "inconclusive"), (1.04, 1.01, 1.06, "inconclusive"),
     (0.94, 0.9, 0.99, "faster"), (0.94, 0.9, 1.01, "inconclusive"), (1.0, 0.96, 1.04, "same"),
     (1.0, 0.95, 1.04, "inconclusive"), (1.02, 1.01, 1.04, "same"), (1.0, 0.96, 1.06, "inconclusive"),
     (1.0, 0.96, timing.LIMIT, "inconclusive"), (1.0, 1.0 / timing.LIMIT, 1.04, "inconclusive"),
     (1.06, 1.0, 1.2, "inconclusive"), (0.94, 0.9, 1.0, "inconclusive"),
     (timing.LIMIT, 1.01, 1.2, "inconclusive"), (1.0 / timing.LIMIT, 0.9, 0.99, "inconclusive")],
)  # fmt: skip
def test_the_pace_of_an_interval(ratio, low, high, pace):
    assert timing.verdict(ratio, low, high) == pace


@pytest.mark.parametrize(
    ("loops", "enough"),
    [([1e-3] * 2, False), ([1e-3] * 3, True), ([1e-3, 2e-3, 1e-3], False), ([0.1, 0.2, 0.3, 0.2], False),
     ([0.5, 0.3, 0.3], True), ([1e-3, 2e-3, 3e-3, 4e-3, 9e-3], True)],
)  # fmt: skip
def test_a_setting_is_run_until_its_interval_is_narrow(loops, enough):
    assert timing.is_enough(loops) == enough


def test_a_long_loop_is_timed_once_and_a_short_one_after_a_first_that_warms_up(monkeypatch):
    clock = iter(())
    monkeypatch.setattr(timing, "sample", lambda *given: next(clock))
    clock = iter([Sample(1.5, 0.4), Sample(0.1)])
    assert timing.time_loops(*[None] * 3) == ([1.5], 0.4)  # type: ignore[arg-type]
    clock = iter([Sample(timing.WARMED, 0.1), Sample(0.5, 0.8), Sample(0.2, 1.0), Sample(0.4, 0.6), Sample(9.0)])
    loops, share = timing.time_loops(*[None] * 3)  # type: ignore[arg-type]
    assert (loops, share) == ([0.5, 0.2, 0.4], pytest.approx(0.8))
    clock = iter([Sample(0.5, 0.88), Sample(0.5, 0.88)])
    loops, share = timing.time_loops(*[None] * 3, held=[0.5])  # type: ignore[arg-type]
    assert (loops, share) == ([0.5] * 3, pytest.approx(0.88))  # what was timed before makes no busy machine idle


def test_the_least_of_the_turns_counts_and_long_runs_take_one():
    clocks = [iter((0.5, 0.3, 0.4, 0.1)), iter((2.0, 1.0, 0.5)), iter((0.6, 0.7, 0.2, 0.1))]
    runs = [lambda clock=clock: next(clock) for clock in clocks]
    assert timing.least_times(runs, [Sample(seconds, 0.8) for seconds in (0.5, 2.0, 0.6)]) == [0.3, 2.0, 0.2]
    clocks[:] = [iter((0.5, 0.6, 0.1)), iter((0.1,)), iter((0.4, 0.9, 0.1))]
    runs = [lambda clock=clock: next(clock) for clock in clocks]
    assert timing.least_times(runs, [Sample(seconds) for seconds in (0.45, 2.0, 0.6)]) == [0.45, 2.0, 0.4]


def test_disturbed_runs_are_repeated_and_counted():
    shares = iter((0.5, 0.6, 0.95, 0.2))
    assert timing._undisturbed(lambda: Sample(1.0, next(shares))).cpu_share == 0.95
    busy = timing.compare(lambda: Sample(1.0, 0.5), lambda: Sample(2.0, 0.99))
    assert (busy.pace, busy.ratio, busy.blocks, busy.disturbed) == (Pace.SLOWER, 2.0, timing.FEWEST_BLOCKS, 0.5)
    assert (busy.low, busy.high) == (2.0, 2.0)
    quick = iter(np.tile([1.0, 0.25, 3.0, 2.0, 5.0], 99))
    assert timing.compare(lambda: Sample(1.0), lambda: Sample(next(quick))).ratio == 0.25


def test_times_of_an_idle_machine_replace_those_of_a_busy_one(monkeypatch):
    monkeypatch.setattr(timing, "machine", lambda: "box")
    scene, run = scenes.make("pendulum"), replace(runs_of(6)[0], settings={"method": "rk4", "step": 0.1})
    call = lambda *given: answer  # noqa: E731
    with Store() as store:
        assert timing.stored_times(store, scene, run) is None
        answer: Any = ([0.4, 0.6], 0.5)
        busy = timing.measured(store, call, scene, run)
        assert (busy.times["loop_s"], busy.notes) == (0.4, (BUSY_NOTE,))
        again = timing.stored_times(store, scene, run)
        assert again
        assert (again.times["loop_s"], again.notes) == (0.4, (BUSY_NOTE,))
        answer = ([0.3, 0.5, 0.7], timing.BUSY)
        assert timing.timed(store, call, scene, run).notes == ()  # only times of an idle machine count
        for quiet in (timing.stored_times(store, scene, run), timing.timed(store, None, scene, run)):  # type: ignore[arg-type]
            assert quiet
            assert (quiet.times["loop_s"], quiet.notes) == (0.3, ())
        assert timing.timed(store, call, scene, replace(run, status="crashed")).times == run.times
        other = replace(run, settings={"method": "rk4", "step": 0.2})
        assert timing.stored_times(store, scene, other) is None


def test_changes_between_two_files():
    chance = random.Random(9)
    old = runs_of(7)
    new = [replace(r, times={"loop_s": loop(r) * chance.uniform(0.5, 3.0)}) for r in old[3:]]
    extra = [replace(r, method="c") for r in old[:2]]
    found = changes(old, [*new, *extra])
    assert [one.ratio for one in found] == pytest.approx([loop(b) / loop(a) for a, b in zip(old[3:], new, strict=True)])
    assert median_ratio(found) == pytest.approx(median(loop(b) / loop(a) for a, b in zip(old[3:], new, strict=True)))
    assert {one.move for one in found} == {Move.SAME}
    assert alone(old, [*new, *extra]) == (3, 2)
    assert found[0].run.startswith(f"pendulum {new[0].engine} {new[0].method} ")
    assert overall(found) == Move.SAME
    assert overall([]) == Move.NOT_MEASURED
    assert median_ratio([]) is None
    last = replace(old[5], times={"loop_s": 7.0})
    assert changes([old[5]], [new[2], last])[0].ratio == pytest.approx(7.0 / loop(old[5]))


@pytest.mark.parametrize(
    ("before", "after", "doubt", "move"),
    [(1e-6, 2.1e-6, 0.0, "worse"), (1e-6, 1.9e-6, 0.0, "same"), (2.1e-6, 1e-6, 0.0, "better"),
     (1e-6, 9e-6, 1e-5, "same"), (1e-6, 9e-6, 8e-6, "worse")],
)  # fmt: skip
def test_a_change_of_an_error_or_of_a_gap(before, after, doubt, move):
    run = runs_of(8)[0]
    assert run.error
    pair = [replace(run, error=replace(run.error, value=x, uncertainty=u)) for x, u in ((before, 0.0), (after, doubt))]
    (one,) = changes(*([r] for r in pair))
    assert one.move == move
    if move != "same":
        assert one.sentence == f"error {before:.2e}, then {after:.2e} of the scene"
    gaps = [replace(run, measures={"compliance_position": x}) for x in (before, after)]
    (one,) = changes(*([r] for r in gaps))
    assert one.move == ("same" if after == 1.9e-6 else "better" if after < before else "worse")
    assert not one.sentence or re.fullmatch(r"compliance \S+, then \S+ m or rad", one.sentence)


def test_a_loop_is_timed_until_its_times_agree_and_not_its_shares(monkeypatch):
    clock = iter([Sample(0.2), Sample(0.100, 0.2), Sample(0.101, 0.9), Sample(0.102, 0.5), Sample(9.0)])
    monkeypatch.setattr(timing, "sample", lambda *given: next(clock))
    assert timing.time_loops(*[None] * 3)[0] == [0.100, 0.101, 0.102]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("before", "after", "move"),
    [("crashed", "success", "better"), ("success", "crashed", "worse"), ("crashed", "failed", "same"),
     ("success", "timeout", "not measured")],
)  # fmt: skip
def test_a_change_of_status_is_stated(before, after, move):
    run = runs_of(9)[0]
    (one,) = changes([replace(run, status=before)], [replace(run, status=after, message="why")])
    assert (one.move, one.sentence) == (move, f"{before}, then {after}: why")


def test_nothing_is_chosen_so_far_before_a_truth_is_known(monkeypatch):
    from reports.commands.choose import pick as command

    best: list = []
    monkeypatch.setattr(command, "sweep_records", lambda *given, **more: best.append(more["best"]) or [])
    command._swept(scenes.make("pendulum"), (), None, Bounds(1.0), False)
    assert best[0]([replace(run, error=None) for run in runs_of(1)]) == ""
    assert best[0](runs_of(1)) == f"{pick(runs_of(1), 1.0).sentence} {basis(runs_of(1))}"


@pytest.mark.parametrize("again", [False, True])
def test_times_of_this_machine_are_held_unless_a_setting_is_timed_again(monkeypatch, again):
    monkeypatch.setattr(timing, "machine", lambda: "box")
    scene, run, seen = scenes.make("pendulum"), replace(runs_of(6)[0], settings={"method": "rk4", "step": 0.1}), []
    with Store() as store:
        for host, loops in (("box", [0.4, 0.6]), ("another box", [0.1])):
            store.keep_timings(timing._key(scene, run), host, loops)
        timing.measured(store, lambda *given: seen.append(given) or ([0.5], 1.0), scene, run, again)
    ((function, *given),) = seen
    assert (function, given) == (timing.time_loops, [scene, run.engine, Settings(method="rk4", step=0.1),
                                                     [] if again else [0.4, 0.6]])  # fmt: skip


@pytest.mark.parametrize("side", ["error", "compliance", "budget"])
def test_a_run_that_meets_a_bound_exactly_is_within_it(side):
    run = runs_of(4)[0]
    bounds = {"error": worst(run), "compliance": gap(run), "budget": loop(run)}
    assert math.isfinite(gap(run))
    assert pick([run], **bounds).best == run
    assert pick([run], **bounds | {side: bounds[side] * (1.0 - 1e-9)}).best is None


def test_a_run_five_times_as_dear_as_the_cheapest_may_still_prove_the_cheapest():
    first, *others = (replace(runs_of(4)[0], times={"loop_s": loop_s}) for loop_s in (0.25, 1.25, 1.2501, 0.5))
    assert contenders([first, *others], Bounds(1.0)) == [first, others[0], others[2]]


@pytest.mark.parametrize(
    ("loops", "enough"),
    [([1.0], False), ([1.001], True), ([0.25, 0.5, 0.25], False), ([1.0, 0.5, 0.5], True),
     ([1.0, 1.1, 0.9], True), ([0.1] * 2, False), ([0.1, 0.111, 0.1], False), ([0.1, 0.109, 0.1], True),
     ([0.01, 0.03, 0.01, 0.03, 0.01], True), ([0.01, 0.03, 0.01, 0.03], False)],
)  # fmt: skip
def test_runs_of_a_setting_are_enough_at_these_counts_and_times(loops, enough):
    """One beyond a second; three whose interval is narrower than a twentieth, or beyond a second; else five."""
    assert timing.is_enough(loops) == enough


@pytest.mark.parametrize(("factor", "doubt", "move"), [(2.0, 0.0, "same"), (2.01, 0.0, "worse"), (0.5, 0.0, "same"),
                                                       (0.49, 0.0, "better"), (4.0, 4.0, "same"),
                                                       (4.0, 3.9, "worse")])  # fmt: skip
def test_errors_within_a_factor_of_two_or_within_the_truths_uncertainty_are_the_same(factor, doubt, move):
    run = runs_of(8)[0]
    assert run.error
    pair = [replace(run, error=replace(run.error, value=x, uncertainty=u)) for x, u in ((0.5, 0.0), (
        0.5 * factor, 0.5 * doubt))]  # fmt: skip
    (one,) = changes(*([r] for r in pair))
    assert one.move == move


def test_each_reason_for_no_choice_is_stated_with_the_run_that_comes_nearest():
    """Too dear, joints too open, too far off, in this order."""
    runs = [replace(run, measures={"compliance_position": 10.0**-k}, times={"loop_s": 0.5 * (k + 1)},
                    error=replace(run.error, value=1e-6 * (k + 1), uncertainty=0.0))
            for k, run in enumerate(runs_of(2)[:3]) if run.error]  # fmt: skip
    cheapest = f"the cheapest is {setting(runs[0])} at 500 ms"
    assert pick(runs, 1.0, budget=0.25).sentence == f"none within 250 ms; {cheapest}"
    assert pick(runs, 1.0, 1.0, 0.25).sentence == f"none within 250 ms; {cheapest}"
    tight = "2 settings reach 2.0e-06, but none keeps the constraints within 1.0e-03"
    assert pick(runs, 2e-6, 1e-3).sentence == pick(runs, 2e-6, 1e-3, 9.0).sentence == tight
    nearest = f"the nearest is {setting(runs[0])} with {said(runs[0])}"
    assert pick(runs, 1e-7).sentence == pick(runs, 1e-7, 1e-9, 1e-9).sentence == (
        f"none reached 1.0e-07 of the scene; {nearest}")  # fmt: skip
