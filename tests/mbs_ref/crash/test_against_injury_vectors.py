"""Injury measures against closed forms of analytic pulses (tests/data/injury_vectors.json)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mbs_ref.crash import injury

VECTORS = json.loads((Path(__file__).parents[2] / "data" / "injury_vectors.json").read_text())
SAMPLES = 1601
SAMPLED = 2e-5  # relative, of a pulse made linear between its samples


def pulse(vector) -> tuple[np.ndarray, np.ndarray]:
    height, length = vector["A_g"], vector["T_s"]
    times = np.linspace(0.0, length, SAMPLES)
    shapes = {
        "half_sine": np.sin(np.pi * times / length),
        "square": np.ones_like(times),
        "triangle": 1.0 - np.abs(2.0 * times / length - 1.0),
    }
    return times, height * shapes[vector["shape"]]


@pytest.mark.parametrize("vector", VECTORS["head"], ids=lambda v: f"{v['shape']}-{v['A_g']}g-{v['T_s']}s")
def test_head_measures(vector):
    times, a_g = pulse(vector)
    assert injury.hic(times, a_g, 0.015)[0] == pytest.approx(vector["HIC15"], rel=SAMPLED)
    assert injury.hic(times, a_g, 0.036)[0] == pytest.approx(vector["HIC36"], rel=SAMPLED)
    assert injury.gsi(times, a_g) == pytest.approx(vector["GSI"], rel=SAMPLED)
    assert injury.clip(times, a_g) == pytest.approx(vector["clip3ms_continuous_g"], rel=SAMPLED)


def test_hic_window():
    vector = VECTORS["head"][2]
    _, start, stop = injury.hic(*pulse(vector), 0.036)
    assert stop - start == pytest.approx(vector["HIC36_window_s"], abs=2 * vector["T_s"] / SAMPLES)


def test_viscous_criterion():
    vector = VECTORS["VC"]
    times = np.linspace(0.0, vector["T_s"], SAMPLES)
    deflection = vector["D_m"] * np.sin(np.pi * times / vector["T_s"]) ** 2
    found = injury.viscous_criterion(times, deflection, vector["depth_m"], vector["scale"])
    assert found == pytest.approx(vector["VC_exact"], rel=SAMPLED)


@pytest.mark.parametrize("vector", VECTORS["Nij"])
def test_nij(vector):
    assert injury.nij(vector["Fz_N"], vector["My_Nm"]) == pytest.approx(vector["Nij"], rel=1e-12)


def test_thoracic_trauma_index():
    v = VECTORS["TTI"]
    found = injury.thoracic_trauma_index(v["age"], v["rib_g"], v["t12_g"], v["mass"], v["mass_std"])
    assert found == pytest.approx(v["TTI"], rel=1e-12)


def test_constant_history_and_refusals():
    times = np.linspace(0.0, 0.01, 11)
    assert injury.clip(times, np.full(11, 20.0)) == pytest.approx(20.0)
    assert injury.gsi(times, np.full(11, 20.0)) == pytest.approx(20.0**2.5 * 0.01)
    with pytest.raises(ValueError, match="the clip needs"):
        injury.clip(times[:2], np.ones(2))
    with pytest.raises(ValueError, match="times must increase"):
        injury.hic(times[::-1], np.ones(11), 0.015)
