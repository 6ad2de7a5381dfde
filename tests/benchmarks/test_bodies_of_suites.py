"""Bodies of the benchmark suites, with toys in place of engines and clocks that move only when a toy runs."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass, field
from statistics import median
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.suites import bench_batch, bench_growth, bench_peers, bench_rhs, bench_timing
from benchmarks.trees.regression import Finding
from cross_checks.engine import Method
from cross_checks.prices.timing import Pace, Sample
from cross_checks.records.record import Error, Record
from mbs_ref import Settings, scenes
from mbs_ref.cores.system import Poses


@dataclass
class Bench:
    """The benchmark fixture as the suites use it; `least` is the least time (s) of its rounds."""

    least: float = 0.0
    extra_info: dict[str, Any] = field(default_factory=dict)

    @property
    def stats(self) -> Any:
        return SimpleNamespace(stats=SimpleNamespace(min=self.least, max=9.0 * self.least))

    def pedantic(self, run: Callable, args: tuple = (), rounds: int = 1, warmup_rounds: int = 0) -> Any:
        return [run(*args) for _ in range(warmup_rounds + rounds)][-1]


class Clock:
    """A wall clock and a processor's clock (s), which drawn spans move."""

    def __init__(self, seed: int = 0) -> None:
        self.wall, self.cpu, self.chance = 5.0, 3.0, np.random.default_rng(seed)
        self.spent: dict[str, list[tuple[float, float]]] = {}

    def spend(self, what: str) -> None:
        wall, cpu = self.chance.uniform(0.1, 2.0, 2).tolist()
        self.wall, self.cpu = self.wall + wall, self.cpu + cpu
        self.spent.setdefault(what, []).append((wall, cpu))

    def perf_counter(self) -> float:
        return self.wall

    def process_time(self) -> float:
        return self.cpu


def ratios(first: Iterator | list, second: Iterator | list) -> list[float]:
    """Return the medians, of wall and of processor time, of pairwise ratios."""
    pairs = list(zip(first, second, strict=True))
    return [median(one[k] / other[k] for one, other in pairs) for k in (0, 1)]


# bench_batch


@pytest.mark.parametrize(("lanes", "word"), [(False, "threads"), (True, "lanes")])
def test_a_batch_is_compared_with_ten_times_a_tenth_of_its_starts(monkeypatch, capsys, lanes, word):
    """The first round of either compiles and does not count; the batch's last three are those of the table."""
    clock, asked = Clock(), []
    starts, settings = Poses(*np.arange(4000.0).reshape(4, 1000, 1)), Settings(samples=7, estimate="off")

    def single(scene: Any, chosen: Settings, start: Poses) -> None:
        asked.append((scene is bench_batch.SCENE, chosen, [part.tolist() for part in start]))
        clock.spend("single")

    def batch(scene: Any, given: Poses, chosen: Settings, threads: int, lanes: bool) -> None:
        assert (scene, given, chosen, threads) == (bench_batch.SCENE, starts, settings, 2)
        clock.spend(f"batch {lanes}")

    for name, value in (("time", clock), ("simulate", single), ("simulate_starts", batch)):
        monkeypatch.setattr(bench_batch, name, value)
    benchmark = Bench()
    bench_batch.test_batch_against_single_runs(benchmark, starts, settings, lanes)
    every_tenth = [(True, settings, [[[k]], [[k + 1000]], [[k + 2000]], [[k + 3000]]]) for k in range(0, 1000, 10)]
    assert asked == every_tenth * 6
    runs, batches = clock.spent["single"], clock.spent[f"batch {lanes}"]
    assert len(clock.spent) == 2
    tenths = [tuple(map(sum, zip(*runs[k : k + 100], strict=True))) for k in range(100, 600, 100)]
    wall, cpu = ratios(tenths, batches[1:6])
    assert benchmark.extra_info == pytest.approx({"throughput": 10.0 * wall, "cpu": 10.0 * cpu})
    assert capsys.readouterr().out.startswith(f"7 outputs, estimate off, {word}: {{'throughput'")


@pytest.mark.parametrize(("lanes", "word"), [(False, "threads"), (True, "lanes")])
def test_a_batch_and_a_rollout_are_compared_where_both_reach_the_error(monkeypatch, capsys, lanes, word):
    clock, asked = Clock(2), []

    def batch(starts: Any, settings: Settings, lanes: bool) -> Any:
        asked.append((settings, lanes))
        clock.spend("ours")
        return starts, settings.rtol

    def coarsest(name: str, answer: Any) -> None:
        monkeypatch.setattr(bench_batch, name, lambda *given: asked.append(given) or answer)

    ours = bench_batch.LEAN.model_copy(update={"rtol": 3e-7})
    for name, value in (("time", clock), ("_batch", batch), ("_ends", lambda paths: ("ends", paths))):
        monkeypatch.setattr(bench_batch, name, value)
    coarsest("_coarsest_of_ours", ours)
    coarsest("_coarsest_of_theirs", (0.005, lambda: clock.spend("theirs")))
    benchmark, starts, times = Bench(), object(), object()
    bench_batch.test_batch_against_rollout(benchmark, times, starts, lanes)
    (fine, with_lanes), (*own, own_lanes), theirs, *rest = asked
    assert (fine.rtol, fine.samples, fine.t_end, fine.estimate, fine.reactions) == (1e-12, 2, 1.0, "off", False)
    assert not with_lanes
    assert (own, theirs, own_lanes) == ([starts, ("ends", (starts, 1e-12))], (times, own[1]), lanes)
    assert set(map(str, rest)) == {str((ours, lanes))}
    wall, cpu = ratios(clock.spent["ours"][1:6], clock.spent["theirs"])
    assert benchmark.extra_info == pytest.approx({"wall_ratio": wall, "cpu_ratio": cpu, "rtol": 3e-7, "step": 0.005})
    line = f"{word} at 1e-06 m, ours over rollout: wall {wall:.3f}, CPU {cpu:.3f}; rtol 3e-07, step 0.005 s\n"
    assert capsys.readouterr().out == line


def test_starts_of_a_batch_lie_on_mujocos_own_steps(monkeypatch):
    times = bench_batch.times.__wrapped__()  # type: ignore[attr-defined]
    assert (times[0], times[-1], len(times)) == (0.0, 1.0, 1000)
    assert 1e4 * times == pytest.approx(np.rint(1e4 * times), abs=1e-9)
    assert np.abs(times - np.arange(1000) / 999.0).max() <= 0.5e-4 + 1e-12
    path = SimpleNamespace(position="p", orientation="o", velocity="v", angular_velocity="w")
    asked: list[Any] = []
    monkeypatch.setattr(bench_batch, "simulate", lambda *given: asked.append(given) or path)
    assert bench_batch.starts.__wrapped__("times") == tuple("povw")  # type: ignore[attr-defined]
    ((scene, settings, at),) = asked
    assert (scene, settings, at) == (
        bench_batch.SCENE, Settings(rtol=1e-12, estimate="off", reactions=False), "times"
    )  # fmt: skip


def test_a_run_of_a_batch_ends_at_its_last_sample():
    paths: Any = [SimpleNamespace(position=np.array([[k], [10.0 + k]])) for k in range(3)]
    assert bench_batch._ends(paths).tolist() == [[10.0], [11.0], [12.0]]


@dataclass
class Planned:
    """What of a plan the rollout reads."""

    step: float
    times: np.ndarray


@pytest.mark.parametrize("factor", [1.0, 1.01])
def test_the_coarsest_step_of_a_rollout_reaches_the_error_in_bodies_of_all_starts(monkeypatch, factor):
    """Ends are off by 1600 steps' share of the error at most; 1 % more, and twice the steps are needed."""
    truth, built = np.zeros((3, 10, 2)), SimpleNamespace(model="model")
    plans: list[Any] = []

    def planned(engine: Any, step: float, times: Any) -> Any:
        plans.append((step, np.array(times).tolist()))
        return Planned(step, times), built

    def poses(own: Any, plan: Planned, after: tuple) -> tuple[np.ndarray, None]:
        model, states, steps, threads = after
        assert (own, model, states, threads) == (built, "model", "states", 2)
        assert plan.times.tolist() == [0.0] * 1000
        assert plan.step * steps == pytest.approx(1.0)
        ends = truth.copy()
        ends[2, 4, 1] = factor * 1600.0 / steps * bench_batch.ERROR
        return ends, None

    toy = SimpleNamespace(advance=lambda own, plan: SimpleNamespace(states="states"), poses=poses)
    monkeypatch.setattr(bench_batch, "MuJoCo", lambda: toy)
    monkeypatch.setattr(bench_batch, "_planned", planned)
    monkeypatch.setattr(bench_batch, "rolled_out", lambda *given: given)
    step, work = bench_batch._coarsest_of_theirs(np.array([0.0, 0.25]), truth)
    steps = 1600 if factor == 1.0 else 3200
    assert (step, work()) == (1.0 / steps, ("model", "states", steps, 2))
    assert plans[0] == (1e-4, [0.0, 0.25])
    assert plans[1:] == [(1.0 / n, [0.0, 1.0]) for n in (100, 200, 400, 800, 1600, 3200) if n <= steps]
    monkeypatch.setattr(bench_batch, "farthest", lambda *given: [1.0])
    with pytest.raises(AssertionError, match="no step"):
        bench_batch._coarsest_of_theirs(np.array([0.0, 0.25]), truth)
    assert [1.0 / one for one, _ in plans[-7:]] == pytest.approx([100.0 * 2**k for k in range(7)])


def test_a_batch_whose_tolerances_all_miss_has_no_setting(monkeypatch):
    """Each of the tolerances, a decade apart, is tried."""
    tried: list[float] = []
    monkeypatch.setattr(bench_batch, "_batch", lambda starts, settings, lanes: tried.append(settings.rtol) or [])
    for error, rtol in ((bench_batch.ERROR, 1e-4), (1.01 * bench_batch.ERROR, None)):
        monkeypatch.setattr(bench_batch, "farthest", lambda *given, error=error: [error, 0.0])
        if rtol:
            chosen = bench_batch._coarsest_of_ours(None, np.zeros(0), False)  # type: ignore[arg-type]
            assert chosen == bench_batch.LEAN.model_copy(update={"rtol": rtol})
            continue
        with pytest.raises(AssertionError, match="no tolerance"):
            bench_batch._coarsest_of_ours(None, np.zeros(0), False)  # type: ignore[arg-type]
    assert tried == pytest.approx([1e-4, *(10.0**-k for k in range(4, 10))])


def test_a_rollout_is_planned_for_rk4_at_its_step(monkeypatch):
    monkeypatch.setattr(bench_batch, "plan_run", lambda engine, scene, settings, times: Planned(settings, times))
    monkeypatch.setattr(bench_batch, "Plan", Planned)
    engine: Any = SimpleNamespace(build=lambda scene, plan: (scene is bench_batch.SCENE, plan))
    plan, built = bench_batch._planned(engine, 0.02, "times")  # type: ignore[arg-type]
    assert plan == Planned(Settings(method="rk4", step=0.02), "times")  # type: ignore[arg-type]
    assert built == (True, plan)


# bench_growth


def test_a_chain_is_timed_at_the_choice_of_a_sweep(monkeypatch):
    """The choice is a sweep's; the least of its loops counts, and an engine without a choice takes no part."""

    def skip(why: str) -> None:
        raise ValueError(why)  # a skip would end this test, too

    best = Record("pendulum_chain", {}, "quick", "rk4", {"method": "rk4", "step": 0.02}, "success",
                  error=Error(3e-7, "exact", 1e-9, None), measures={"compliance_position": 2e-12})  # fmt: skip
    loops, asked = iter([0.9, 0.5, 0.7, 0.6, 0.8, 0.7]), []
    run = lambda *given: asked.append(given) or SimpleNamespace(timing=SimpleNamespace(loop_s=next(loops)))  # noqa: E731
    monkeypatch.setattr(bench_growth, "Isolated", lambda timeout: nullcontext(f"call of {timeout:g} s"))
    monkeypatch.setattr(bench_growth, "pytest", SimpleNamespace(skip=skip))
    monkeypatch.setattr(bench_growth, "Runs", lambda call: call)
    monkeypatch.setattr(bench_growth, "sweep", lambda *given, **more: (given, more))
    monkeypatch.setattr(bench_growth, "engines", SimpleNamespace(get=lambda name: SimpleNamespace(run=run)))
    chosen: list[Any] = [best, None]
    monkeypatch.setattr(bench_growth, "pick", lambda *given: asked.append(given) or SimpleNamespace(best=chosen.pop(0)))
    benchmark = Bench()
    bench_growth.test_chain_at_equal_error(benchmark, "quick", 3)
    (swept, error), *runs = asked
    (call, scene, names), targets = swept
    assert (call, len(scene.bodies), names) == ("call of 30 s", 3, ["quick"])
    assert (targets, error) == ({"targets": (1e-6,)}, 1e-6)
    assert len(runs) == 6
    for own, settings, times in runs:
        assert (own, settings, times[-1]) == (scene, Settings(method="rk4", step=0.02), scene.duration)
    shown = {"links": 3, "engine": "quick", "setting": "quick rk4 step=0.02", "loop_s": 0.5, "error": 3e-7,
             "truth_uncertainty": 1e-9, "compliance": 2e-12}  # fmt: skip
    assert benchmark.extra_info == shown
    with pytest.raises(ValueError, match="quick does not reach 1e-06 with 3 links"):
        bench_growth.test_chain_at_equal_error(Bench(), "quick", 3)


def test_tracks_are_timed_in_turns_and_the_least_loop_counts(monkeypatch):
    loops = {50: [0.0, 0.3, 0.2, 0.5, 0.4, 0.6], 100: [0.0, 0.9, 0.8, 0.7, 1.0, 1.1]}
    turns = {links: iter(own[1:]) for links, own in loops.items()}
    asked: list[Any] = []
    failing: list[int] = []

    def simulate(scene: tuple, settings: Settings) -> Any:
        name, chosen = scene
        asked.append((name, chosen["model"], settings))
        return SimpleNamespace(
            ok=len(asked) not in failing, timing=SimpleNamespace(loop_s=next(turns[chosen["links"]]))
        )

    monkeypatch.setattr(bench_growth, "scenes", SimpleNamespace(make=lambda name, **chosen: (name, chosen)))
    monkeypatch.setattr(bench_growth, "simulate", simulate)
    benchmark = SimpleNamespace(pedantic=lambda run, args, **more: run(*args))
    given = benchmark, bench_growth.PAPERS, {"links": 50}, {"links": 100}
    assert bench_growth.in_turns(*given) == [0.2, 0.7]
    assert asked == [("tracked_vehicle", "paper", bench_growth.PAPERS)] * 10
    turns = {links: iter(own[1:]) for links, own in loops.items()}
    failing.append(15)  # one of the ten
    with pytest.raises(AssertionError):
        bench_growth.in_turns(*given)


@pytest.mark.parametrize(("name", "settings", "choices", "most", "more"), [
    ("test_the_cost_of_a_track_grows_linearly", bench_growth.DRIVE, ({"links": 50}, {"links": 100}), 2.5,
     {"links": (50, 100)}),
    ("test_contacts_on_constraints_cost_little_more_than_on_springs", bench_growth.PAPERS,
     ({"law": "spring_damper"}, {"law": "constraint"}), 3.0, {}),
])  # fmt: skip
def test_a_growth_up_to_its_bound_passes(monkeypatch, name, settings, choices, most, more):
    for ratio in (most, 1.01 * most):
        seen: list[Any] = []
        loops = [2.0, 2.0 * ratio]
        monkeypatch.setattr(bench_growth, "in_turns", lambda *given, own=seen, loops=loops: own.append(given) or loops)
        benchmark = Bench()
        with nullcontext() if ratio == most else pytest.raises(AssertionError):
            getattr(bench_growth, name)(benchmark)
        assert seen == [(benchmark, settings, *choices)]
        expected = {"loop_s": (2.0, 2 * ratio), "ratio": pytest.approx(ratio), "asked": most}
        assert benchmark.extra_info == expected | more


def test_ratios_of_calls_and_of_links_are_printed(monkeypatch, capsys):
    pendulum, spatial = "pendulum_chain", "spatial_chain"
    spans = {(pendulum, 30): (0.06, 0.04), (spatial, 100): (0.5, 9.0), (spatial, 1000): (6.0, 8.0)}
    asked: list[Settings] = []
    monkeypatch.setattr(bench_growth, "times", lambda name, links, chosen: asked.append(chosen) or spans[name, links])
    bench_growth.test_default_call_over_its_loop(Bench(), "relative", 30)
    assert capsys.readouterr().out == "\nchain 30, relative: call 60 ms, 1.50 times its loop (aim 2)\n"
    bench_growth.test_growth_of_a_link(Bench())
    line = "\nspatial chain, relative: a link of 1000 costs 1.20 times one of 100 (aim 1.1)\n"
    assert capsys.readouterr().out == line
    assert asked[0] == Settings(coordinates="relative")
    assert [(one.estimate, one.reactions, one.samples, one.t_end) for one in asked[1:]] == [("off", False, 2, 0.05)] * 2


# bench_peers

END = np.array([[3.0, 4.0]])  # m, of one body


def test_a_peer_runs_a_scene_that_no_engine_has_seen(monkeypatch):
    clock, seen = Clock(), []
    scene, chosen = scenes.make("pendulum"), Settings(rtol=1e-5)
    status = iter(("success", "lost"))

    def run(given: Any, settings: Settings, times: np.ndarray) -> Any:
        seen.append(given)
        assert (given, settings, times.tolist()) == (scene, chosen, [0.0, scene.duration])
        clock.spend("run")
        path = np.array([0.0 * END, END])
        return SimpleNamespace(status=next(status), position=path, timing=SimpleNamespace(loop_s=0.25))

    monkeypatch.setattr(bench_peers, "time", clock)
    monkeypatch.setattr(bench_peers, "solver_of", lambda name: SimpleNamespace(run=run) if name == "toy" else None)
    end, times = bench_peers.loop("toy", scene, chosen)
    assert end is not None
    assert (end.tolist(), times) == (END.tolist(), (0.25, pytest.approx(clock.spent["run"][0][0])))
    assert bench_peers.loop("toy", scene, chosen)[0] is None
    assert all(one is not scene for one in seen)


def test_peers_run_at_their_best(monkeypatch):
    monkeypatch.setattr(bench_peers, "engines", SimpleNamespace(get=lambda name: f"engine {name}"))
    assert bench_peers.solver_of("mujoco") == "engine mujoco"
    for engine, name in (("pinocchio_cpp", "EveryAlgorithm"), ("heyoka", "Unrolled")):
        monkeypatch.setitem(
            sys.modules, f"cross_checks.engines.{engine}_", SimpleNamespace(**{name: lambda: "at best"})
        )
        assert bench_peers.solver_of(engine) == "at best"


@pytest.mark.parametrize(("spans", "chosen"), [
    ((2.0, 2.0, 0.5, 0.5), 2),  # s: as long as a finer setting is tried
    ((0.1, 2.01, 0.1, 0.1), None),
    ((0.1, 0.1, 9.0, 0.1), 2),  # what reaches the error may be slow
])  # fmt: skip
def test_the_cheapest_setting_reaches_the_error_before_runs_are_too_long(monkeypatch, spans, chosen):
    """One run fails, the next is off by 2 um, the third by exactly one."""
    scene, far = scenes.make("pendulum"), 2.0**-20  # m: no rounding
    ends = [None, END + np.array([[2 * far, 0.0]]), END + np.array([[0.0, far]]), END]
    choices, asked = [Settings(step=0.1 / (k + 1)) for k in range(4)], []

    def loop(engine: str, own: Any, settings: Settings) -> Any:
        place = choices.index(settings)
        asked.append((engine, own is scene, place))
        return ends[place], (spans[place], 10.0 + place)

    monkeypatch.setattr(bench_peers, "loop", loop)
    timed = bench_peers.cheapest("toy", scene, choices, END, far)
    if chosen is None:
        assert (timed, asked) == (None, [("toy", True, 0), ("toy", True, 1)])
        return
    assert timed is not None
    assert timed() == (spans[chosen], 10.0 + chosen)
    assert asked == [("toy", True, place) for place in (*range(chosen + 1), chosen)]
    assert bench_peers.cheapest("toy", scene, choices[:2], END, far) is None


class Entrant:
    """An engine that refuses scenes or one of its methods."""

    def __init__(self, refuses: bool = False, without: tuple[str, ...] = ()) -> None:
        self.refuses, self.without = refuses, without

    def method(self, name: str) -> Method:
        return Method(name, "fixed", 4, "of a toy")

    def refusals(self, scene: Any) -> list[str]:
        return ["no"] if self.refuses else []

    def method_refusals(self, scene: Any, method: Method) -> list[str]:
        return ["no"] if method.name in self.without else []


@pytest.mark.parametrize(("name", "coordinates"), [
    ("pendulum_chain", ("cartesian", "relative")), ("n_four_bar", ("cartesian",)),
])  # fmt: skip
def test_who_runs_the_scene_and_reaches_the_error_takes_part(monkeypatch, name, coordinates):
    """Ours runs trees in either coordinates; absent engines, refusals and misses are left out."""
    known = {
        "mbs_ref": Entrant(without=("taylor", "gauss")),
        "a": Entrant(),
        "b": Entrant(refuses=True),
        "c": Entrant(),
    }
    peers = [("a", "x"), ("a", "y"), ("absent", "x"), ("b", "x"), ("c", "x")]
    asked: list[Any] = []

    def cheapest(engine: str, scene: Any, choices: list[Settings], truth: Any, error: float) -> Any:
        asked.append((engine, choices[0].method, choices, (scene.name, truth, error)))
        return None if engine == "c" else f"{engine} {choices[0].method} {choices[0].coordinates}"

    monkeypatch.setattr(bench_peers, "engines", SimpleNamespace(names=lambda: list(known)))
    monkeypatch.setattr(bench_peers, "solver_of", known.__getitem__)
    monkeypatch.setattr(bench_peers, "cheapest", cheapest)
    found = bench_peers.entrants(scenes.make(name), peers, "truth", 1e-6)  # type: ignore[arg-type]
    ours = [f"mbs_ref dop853 {one}" for one in coordinates]
    names = [*ours, "a x cartesian", "a y cartesian"]
    assert found == {one: one for one in names}
    assert [" ".join(one[:2]) for one in asked] == [*["mbs_ref dop853"] * len(ours), "a x", "a y", "c x"]
    for _, method, choices, rest in asked:
        assert rest == (name, "truth", 1e-6)
        steps = [choice.step for choice in bench_peers.settings(Entrant().method(method), scenes.make(name).duration)]
        assert [choice.step for choice in choices] == steps
        assert {(one.estimate, one.reactions, one.samples) for one in choices} == {("off", False, 2)}


def test_a_line_names_all_who_took_part_the_quickest_first(monkeypatch, capsys):
    """Times of a call and a loop are each the least of their own; peers are the first of their group."""
    first = (0.9, 0.9)
    spans = {"mbs_ref a": [first, (0.002, 0.005), (0.003, 0.004)], "mbs_ref b": [first, (0.006, 0.007), first],
             "slow": [first, (0.09, 0.1), (0.08, 0.2)], "quick": [first, (0.001, 0.02), (0.005, 0.03)]}  # fmt: skip
    turns = {who: iter(own) for who, own in spans.items()}
    asked: list[Any] = []
    monkeypatch.setattr(bench_peers, "TURNS", 2)
    monkeypatch.setattr(
        bench_peers, "STATED",
        {"cases": {"toy": {"scene": "pendulum", "parameters": {"length": 2.0}, "peers": "group", "most": 1,
                           "error": 1e-5, "aim": 0.25}},
         "peers": {"group": [["a", "x"], ["b", "y"]]}},
    )  # fmt: skip
    monkeypatch.setattr(bench_peers, "loop", lambda *given: asked.append(given) or ("truth", (1.0, 1.0)))
    monkeypatch.setattr(
        bench_peers, "entrants",
        lambda *given: asked.append(given) or {who: lambda who=who: next(turns[who]) for who in spans},
    )  # fmt: skip
    benchmark = Bench()
    bench_peers.test_over_the_best_peer(benchmark, "toy")
    (engine, scene, fine), (own, peers, truth, error) = asked
    assert (engine, fine.method, fine.rtol, fine.estimate, fine.reactions) == ("mbs_ref", "dop853", 1e-13, "off", False)
    assert scene.parameters["length"] == 2.0
    assert (own, peers, truth, error) == (scene, [["a", "x"]], "truth", 1e-5)
    least = {who: [min(one[k] for one in spans[who]) for k in (0, 1)] for who in spans}
    ratios_of = {"of_call": pytest.approx(0.2), "of_loop": pytest.approx(2.0), "aim": 0.25}
    assert benchmark.extra_info == ratios_of | least
    shown = "quick 1 (20) ms, mbs_ref a 2 (4) ms, mbs_ref b 6 (7) ms, slow 80 (100) ms"
    line = f"\ntoy: 0.20 of the best peer's call (aim 0.25), 2.00 of its loop; {shown}\n"
    assert capsys.readouterr().out == line


# bench_rhs


def test_a_right_hand_side_is_compiled_before_it_is_timed(monkeypatch):
    calls: list[int] = []
    monkeypatch.setattr(bench_rhs, "right_hand_sides", lambda scene: (calls.append, 3))
    run = bench_rhs.loop(None)  # type: ignore[arg-type]
    assert calls == [1]
    run()
    assert calls == [1, bench_rhs.CALLS]


@pytest.mark.parametrize(
    ("along", "across", "left"), [(0.3, 0.2, 0.3), (-0.3, 0.2, 0.3), (0.1, -0.7, 0.7), (0.0, 0.0, 0.0)]
)
def test_residuals_in_the_plane_are_those_of_both_equations(monkeypatch, along, across, left):
    """Accelerations that the force misses by `along` m/s^2, and the constraint by `across`."""
    mass, jacobian, a, multiplier = np.array([2.0, 2.0, 4.0]), np.array([[0.0, 1.0, 0.5]]), [0.5, 0.25, 1.0], 3.0
    force = np.array([1.0 + 2.0 * along, 3.5, 5.5])  # M a + C_q^T lambda, and what it misses

    class System:
        def __init__(self, scene: Any) -> None: ...

        def set_mode_time(self, t: float) -> None:
            assert t == 0.0

        def initial_state(self) -> np.ndarray:
            return np.arange(6.0)

        def applied_forces(self, t: float, y: np.ndarray) -> np.ndarray:
            assert (t, y.tolist()) == (0.0, list(range(6)))
            return force[None]

        def derivative(self, t: float, y: np.ndarray) -> np.ndarray:
            assert (t, y.tolist()) == (0.0, list(range(6)))
            return np.array([7.0, 8.0, 9.0, *a])

        def mass_matrix(self) -> np.ndarray:
            return mass

        def jacobian(self, t: float, y: np.ndarray) -> np.ndarray:
            assert (t, y.tolist()) == (0.0, list(range(6)))
            return jacobian

        def multipliers(self, t: float, y: np.ndarray) -> np.ndarray:
            assert (t, y.tolist()) == (0.0, list(range(6)))
            return np.array([multiplier])

        def right_side(self) -> np.ndarray:
            return np.array([0.75 + across])

    monkeypatch.setattr(bench_rhs, "PlanarSystem", System)
    assert bench_rhs.planar_residual(None) == pytest.approx(left, abs=1e-15)  # type: ignore[arg-type]


def test_residuals_in_space_are_taken_in_axes_of_the_world(monkeypatch):
    """A body turned by a quarter about z: its angular acceleration about x is one about y in the world."""
    half = math.sqrt(0.5)
    y = np.array([0.0, 0.0, 0.0, half, 0.0, 0.0, half, 1.0, 2.0, 3.0])
    jacobian = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 2.0, 0.0]])

    class System:
        n_positions = 7

        def __init__(self, scene: Any) -> None: ...

        def set_mode_time(self, t: float) -> None:
            assert t == 0.0

        def initial_state(self) -> np.ndarray:
            return y

        def derivative(self, t: float, state: np.ndarray) -> np.ndarray:
            return np.array([*[9.0] * 7, 0.25, 0.0, 0.0, 0.5, 0.0, 0.0]) if t == 0.0 and state is y else state

        def jacobian(self, t: float, state: np.ndarray) -> np.ndarray:
            return jacobian if t == 0.0 and state is y else np.zeros((2, 6))

        def right_side(self) -> np.ndarray:
            return np.array(right_sides[-1])

    monkeypatch.setattr(bench_rhs, "SpatialSystem", System)
    right_sides: list[list[float]] = []
    for right, left in (([0.25, 4.0], 3.0), ([-1.75, 1.0], 2.0), ([0.25, 1.0], 0.0)):
        right_sides.append(right)
        assert bench_rhs.spatial_residual(None) == pytest.approx(left, abs=1e-15)  # type: ignore[arg-type]


@pytest.mark.parametrize("off", [0.0, 0.5, -0.5])
def test_residuals_of_particles_are_from_newtons_sum(monkeypatch, off):
    """Figure-eight's three masses have the sum of the other two's pulls; one component is off by so much."""
    exact = bench_rhs.compile_scene

    def compiled(scene: Any) -> Any:
        system = exact(eight)

        def derivative(t: float, y: np.ndarray) -> np.ndarray:
            return system.derivative(t, y) + off * np.eye(len(y))[-1]

        return SimpleNamespace(initial_state=system.initial_state, derivative=derivative)

    monkeypatch.setattr(bench_rhs, "compile_scene", compiled)
    eight = scenes.make("figure_eight")
    seen: Any = SimpleNamespace(loads=("another load", *eight.loads))
    assert bench_rhs.particle_residual(seen) == pytest.approx(abs(off), abs=1e-12)


@pytest.mark.parametrize(("residual", "passes"), [(9e-10, True), (1e-9, False)])
def test_a_right_hand_side_is_timed_and_checked(monkeypatch, residual, passes):
    scene = SimpleNamespace(bodies="abcd")
    monkeypatch.setattr(bench_rhs, "KERNELS", {"toy": (lambda: scene, lambda own: residual if own is scene else 1.0)})
    monkeypatch.setattr(bench_rhs, "loop", lambda own: lambda: own)
    benchmark = Bench(least=4e-4)
    with nullcontext() if passes else pytest.raises(AssertionError):
        bench_rhs.test_right_hand_side(benchmark, "toy")
    assert benchmark.extra_info == pytest.approx({"loop_s": 2e-6, "ns_per_body": 500.0, "error_mps2": residual})


@pytest.mark.parametrize(("exponent", "passes"), [(1.099, True), (1.101, False)])
def test_the_growth_of_a_right_hand_side_is_an_exponent(monkeypatch, capsys, exponent, passes):
    """From the least size to the most; the one between is slower. The least of a size's rounds counts."""
    sizes, best = (10, 20, 80), {10: 2e-4, 20: 6e-4, 80: 2e-4 * 8.0**exponent}
    spans = iter([[9.0, best[n], 90.0] for n in sizes])

    def interleaved(runs: list, rounds: int) -> list[list[float]]:
        assert (len(runs), rounds) == (3, bench_rhs.ROUNDS)
        assert [run.args[0] for run in runs] == [f"loop {2 * n}" for n in sizes]
        return [sorted(next(spans))[::-1] for _ in runs]

    monkeypatch.setattr(bench_rhs, "GROWING", {"toy": (sizes, "count")})
    make = lambda name, **chosen: SimpleNamespace(bodies=range(2 * chosen["count"]))  # noqa: E731
    monkeypatch.setattr(bench_rhs, "scenes", SimpleNamespace(make=make))
    monkeypatch.setattr(bench_rhs, "loop", lambda scene: f"loop {len(scene.bodies)}")
    monkeypatch.setattr(bench_rhs, "interleaved", interleaved)
    benchmark = SimpleNamespace(extra_info={}, pedantic=lambda run, args, **more: run(*args))
    with nullcontext() if passes else pytest.raises(AssertionError):
        bench_rhs.test_growth_is_linear(benchmark, "toy")
    found = benchmark.extra_info
    per_body = {n: best[n] / (200 * 2 * n) * 1e9 for n in sizes}
    assert found.pop("ns_per_body") == pytest.approx(per_body)
    for a, b in ((10, 20), (10, 80), (20, 80)):
        assert (b / a) ** found.pop(f"exponent_{a}_{b}") == pytest.approx(best[b] / best[a])
    assert not found


# bench_timing


def test_turns_of_the_spinning_loop_follow_one_another():
    assert bench_timing.spin.py_func(1) == 0.0
    assert bench_timing.spin.py_func(3) == pytest.approx(math.sin(1.0) + math.sin(math.sin(1.0) + 2.0))


@pytest.mark.parametrize(("alarms", "hits", "passes"), [(1, 18, True), (2, 18, False), (1, 17, False)])
def test_the_protocol_may_err_in_a_twentieth_and_miss_a_tenth(monkeypatch, capsys, alarms, hits, passes):
    """Alarms are of either sign, among 40 pairs alike; slowdowns are by a tenth, in 20 pairs."""
    work = bench_timing.WORK

    def compare(first: int, second: int, seed: int) -> Any:
        assert first == work
        if second == work:
            return SimpleNamespace(pace=(Pace.FASTER, Pace.SLOWER)[seed % 2] if seed < alarms else Pace.SAME)
        assert 10 * second == 11 * work
        return SimpleNamespace(pace=Pace.SLOWER if seed < hits else Pace.INCONCLUSIVE)

    monkeypatch.setattr(bench_timing, "spin", lambda turns: None)
    monkeypatch.setattr(bench_timing, "timed", lambda turns: turns)
    monkeypatch.setattr(bench_timing, "compare", compare)
    benchmark = Bench()
    with nullcontext() if passes else pytest.raises(AssertionError):
        bench_timing.test_false_alarms_and_found_slowdowns(benchmark)
    assert benchmark.extra_info == {"false_alarms": f"{alarms}/40", "found": f"{hits}/20"}
    assert capsys.readouterr().out == f"false alarms {alarms} of 40, +10 % detected {hits} of 20\n"


def test_a_folder_is_compared_with_this_tree_by_ten_pairs_of_processes(monkeypatch, tmp_path):
    asked: list[Any] = []

    def regressions(*given: Any, seed: int) -> Iterator[int]:
        asked.append(given)
        yield seed

    monkeypatch.setattr(bench_timing, "regressions", regressions)
    assert bench_timing.verdicts(tmp_path) == list(range(10))
    assert asked == [(bench_timing.HERE, tmp_path, [bench_timing.CASE])] * 10


@pytest.mark.parametrize(("name", "due"), [("test_an_unchanged_copy_is_called_same", "same"),
                                           ("test_a_slowed_kernel_is_called_slower", "slower")])  # fmt: skip
@pytest.mark.parametrize("odd", [False, True])
def test_every_verdict_on_a_known_tree_is_the_due_one(monkeypatch, capsys, tmp_path, name, due, odd):
    asked: list[Any] = []
    found = [Finding("case", "inconclusive" if odd and k == 3 else due, f"because {k}", 1e-6) for k in range(10)]
    monkeypatch.setattr(bench_timing, "verdicts", lambda folder: asked.append(folder) or found)
    monkeypatch.setattr(bench_timing, "calibrate", lambda *given: asked.append(given) or (321, 0.1475))
    benchmark = Bench()
    with pytest.raises(AssertionError) if odd else nullcontext():
        getattr(bench_timing, name)(benchmark, tmp_path)
    counts = {due: 9, "inconclusive": 1} if odd else {due: 10}
    facts = {"share": 0.1475} if due == "slower" else {}
    assert benchmark.extra_info == {"verdicts": counts} | facts
    assert asked == [*([(tmp_path, bench_timing.CASE, 0.15)] if facts else []), tmp_path]
    line = "slowed by 14.8% with 321 square roots a right-hand side"
    assert (line in capsys.readouterr().out) == bool(facts)


@pytest.mark.parametrize(("ratio", "passes"), [(1.019, True), (1.02, False)])
def test_the_overhead_is_that_of_an_engines_loop_over_the_integrators_own(monkeypatch, capsys, ratio, passes):
    """The bare loop takes what the clock shows while the integrator advances; every run begins at the start."""
    clock, begun = Clock(), []

    def advance(system: Any, options: Any, run: Any, y: np.ndarray, times: np.ndarray) -> None:
        begun.append((options, y.tolist(), times.tolist()))
        y += 7.0
        clock.spend("bare")

    def compare(bare: Callable[[], Sample], harness: Callable[[], Sample], limit: float) -> Any:
        assert limit == 1.02
        assert bare() == Sample(pytest.approx(clock.spent["bare"][-1][0]))  # type: ignore[arg-type]
        assert harness() == Sample(0.75)
        return SimpleNamespace(ratio=ratio, low=0.9, high=1.1)

    scene, grid = SimpleNamespace(name="chain"), [0.0, 0.5, 1.0]
    system = SimpleNamespace(initial_state=lambda: np.zeros(2), set_mode_time=lambda t: None)
    engine = SimpleNamespace(
        run=lambda *given: begun.append(given) or SimpleNamespace(timing=SimpleNamespace(loop_s=0.75))
    )
    make = lambda name, links: {("pendulum_chain", 10): scene}[name, links]  # noqa: E731
    patched = {
        "time": clock, "compare": compare, "scenes": SimpleNamespace(make=make),
        "ladder": SimpleNamespace(grid=lambda own: grid), "engines": SimpleNamespace(get=lambda name: engine),
        "integration_options": lambda *given: given, "compile_scene": lambda own: system,
        "integrators": lambda: {"rk4": SimpleNamespace(advance=advance)},
    }  # fmt: skip
    for name, value in patched.items():
        monkeypatch.setattr(bench_timing, name, value)
    benchmark = Bench()
    with nullcontext() if passes else pytest.raises(AssertionError):
        bench_timing.test_overhead(benchmark)
    assert benchmark.extra_info == {"ratio": ratio, "low": 0.9, "high": 1.1}
    assert f"harness {ratio:.4f} times the bare loop [0.9000, 1.1000]" in capsys.readouterr().out
    settings = Settings(method="rk4", step=1e-3, reactions=False)
    assert begun == [((scene, settings, grid), [0.0, 0.0], grid), (scene, settings, grid)] * 2
