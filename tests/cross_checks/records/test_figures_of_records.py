"""Figures of records, recomputed from random irregular ones; what tells two runs apart."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.records import numbers, store
from cross_checks.records import record as cost
from cross_checks.records.bands import _add
from cross_checks.records.lines import key_of
from cross_checks.records.plots import new_figure
from cross_checks.records.record import Error, Record
from cross_checks.records.store import Store
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate.many.ensemble import Coordinate, Statistics

UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0, "h": 3600.0, "days": 86400.0, "years": 31557600.0}


def made(chance: random.Random, engine: str = "quick") -> Record:
    error = Error(
        10 ** chance.uniform(-9, -4), "exact", 10 ** chance.uniform(-9, -6), None, length=chance.uniform(2, 9)
    )
    times = {"loop_s": 10 ** chance.uniform(-5, 1)}
    status = "success" if chance.random() < 0.8 else "non-finite"
    return Record(
        "pendulum", {"length": 2.0}, engine, "rk4", {"step": chance.random()}, status, error=error, times=times
    )


def test_errors():
    chance = random.Random(1)
    for _ in range(20):
        error = made(chance).error
        assert error
        assert error.metres == error.value * error.length
        assert error.bound == error.value + error.uncertainty == cost.known_error(replace(made(chance), error=error))
        assert error.is_judged == (error.value > error.uncertainty)
    runs = [made(chance) for _ in range(9)]
    assert cost.floor([*runs, replace(runs[0], error=None)]) == max(r.error.uncertainty for r in runs if r.error)
    assert cost.floor([]) == 0.0


def test_a_known_figure_is_preferred_to_its_bound():
    run = replace(made(random.Random(1)), measures={"a": 2.0, "b": None, "c": None}, bounds={"a": 7.0, "b": 3.0})
    assert [run.at_most(name) for name in "abc"] == [2.0, 3.0, None]


@pytest.mark.parametrize("seed", range(10))
def test_the_best_run_of_each_engine(seed):
    chance = random.Random(seed)
    runs = [made(chance, engine) for engine in ("a", "b", "c") for _ in range(4)]
    for best in cost.best_of_engines(runs):
        own = [r for r in runs if r.engine == best.engine and r.status == "success"]
        within = [r for r in own if r.error and r.error.value + r.error.uncertainty <= 1e-6]
        by_error = sorted(own, key=lambda r: r.error.value + r.error.uncertainty if r.error else 0.0)
        by_time = sorted(within, key=lambda r: r.times["loop_s"])
        assert best == (by_time or by_error or [[r for r in runs if r.engine == best.engine][-1]])[0]


def test_numbers_are_read_back_as_they_were():
    chance = random.Random(2)
    for _ in range(300):
        x = chance.choice((-1, 1)) * 10 ** chance.uniform(-20, 20)
        assert float(numbers.short(x)) == pytest.approx(float(f"{x:.2g}"), rel=1e-12)
        text, unit = numbers.duration(abs(x)).split(" ")
        assert float(text) == pytest.approx(float(f"{abs(x) / UNITS[unit]:.3g}"), rel=1e-12)
        assert 1.0 <= float(text) <= 1000.0 or not 1e-6 <= abs(x) < 1.0
        share = numbers.of_scene(abs(x))
        factor = 1e-2 if "% of the scene" in share else 1.0
        assert float(share.split(" ")[0]) * factor == pytest.approx(float(f"{abs(x):.2g}"), rel=1e-12)
    assert [numbers.short(x) for x in (-0.25, -1234.0, 0.0, None)] == ["-0.25", "-1200", "0", "–"]


def test_tolerances_are_named_where_they_differ():
    assert numbers.setting({"rtol": 1e-6, "atol": 1e-9}) == "rtol = 1e-6, atol = 1e-9"
    assert numbers.setting({"rtol": 1e-6, "atol": 1e-6}) == "rtol = 1e-6"


OTHER = {
    "scene": "kepler", "parameters": {"length": 3.0}, "engine": "slow", "method": "euler", "settings": {"step": 2.0},
}  # fmt: skip


@pytest.mark.parametrize("name", OTHER)
def test_whatever_tells_runs_apart_is_in_their_key(name):
    run = made(random.Random(1))
    assert key_of(replace(run, **{name: OTHER[name]})) != key_of(run)
    assert key_of(replace(run, status="timeout", times={"loop_s": 9.0}, notes=("busy",))) == key_of(run)
    pairs = {"b": 2.0, "a": 1.0}
    one, other = (replace(run, parameters=own, settings=own) for own in (pairs, dict(sorted(pairs.items()))))
    assert key_of(one) == key_of(other)


def test_timings_of_one_run_and_one_machine():
    with Store() as store:
        for k, (key, host) in enumerate((("a", "x"), ("a", "y"), ("b", "x"), ("b", "y"))):
            store.keep_timings(key, host, [float(k)])
        found = [store.timings(key, host) for key, host in (("a", "y"), ("b", "x"), ("b", "y"), ("a", "x"))]
    assert found == [[1.0], [2.0], [3.0], [0.0]]


def test_a_key_holds_the_engines_version_and_a_truths_times(monkeypatch):
    engine, scene = engines.get("mbs_ref"), scenes.make("pendulum")
    before = store.engine_key(engine)
    monkeypatch.setattr(type(engine), "version", lambda self: "99")
    assert store.engine_key(engine) != before
    times = [np.array([0.0, 1.0]), np.array([0.0, 1.5]), np.array([0.0, 0.5, 1.0])]
    assert len({store.truth_name(scene, one) for one in times}) == 3


@pytest.mark.parametrize("name", sorted(Settings.model_fields.keys() - {"method"}))
def test_every_setting_tells_runs_apart(name):
    run = made(random.Random(1))
    assert key_of(replace(run, settings=run.settings | {name: "another"})) != key_of(run)


def test_a_runs_name_holds_every_input():
    engine, scene, times = engines.get("mbs_ref"), scenes.make("pendulum"), np.array([0.0, 0.3, 1.0])
    inputs = [(scene, Settings(rtol=1e-6), times), (scenes.make("pendulum", length=0.9), Settings(rtol=1e-6), times),
              (scene, Settings(rtol=1e-6, atol=1e-3), times), (scene, Settings(rtol=1e-6), times * [1.0, 1.1, 1.0]),
              (scene, Settings(rtol=1e-6), times[[0, 2]])]  # fmt: skip
    assert len({store.run_name(one, engine, settings, when) for one, settings, when in inputs}) == len(inputs)


def test_orders_stand_in_their_order():
    assert [numbers.order_of(*pair) for pair in ((2.9, 4), (2.9, None), (None, 4))] == ["2.9 of 4", "2.9", ""]


def test_a_band_lies_between_its_quantiles_about_the_median():
    quantiles = np.sort(np.random.default_rng(1).normal(size=(3, 5, 2)), axis=0)
    low, median, high = quantiles
    result, figure = Statistics(7, low, low, quantiles, low, high, median, median), new_figure("t", "x")
    _add(figure, 0, 0, "rod", result, 1, [0.0, 1.0, 2.0, 4.0, 8.0], Coordinate("rod", "x", "m"))
    band, line = figure.data
    assert band["y"] == [*quantiles[2, :, 1], *quantiles[0, ::-1, 1]]
    assert band["x"] == [0.0, 1.0, 2.0, 4.0, 8.0, 8.0, 4.0, 2.0, 1.0, 0.0]
    assert line["y"] == quantiles[1, :, 1].tolist()


@pytest.mark.parametrize(("observed", "documented", "text"), [(None, None, ""), (None, 4, ""), (3.9876, None, "4"),
                                                              (2.1234, 4, "2.1 of 4")])  # fmt: skip
def test_an_order_beside_the_documented_one(observed, documented, text):
    assert numbers.order_of(observed, documented) == text
