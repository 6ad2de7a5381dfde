"""Figures for a program: of a motion, and of runs whose figures are known."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import pytest

import cross_checks
import mbs_ref
from cross_checks.records import figures
from mbs_ref.simulate.many import ensemble as ensembles

PENDULUM, TOP = mbs_ref.scenes.make("pendulum"), mbs_ref.scenes.make("heavy_top")


@pytest.fixture(scope="module")
def run():
    return cross_checks.run(PENDULUM, step=0.01, method="rk4", t_end=0.2, samples=3, estimate="off")


def test_a_motion_is_drawn_where_it_goes(run):
    (line,) = figures.motion(PENDULUM, run.path).data
    assert (line.name, line.type) == ("bob", "scatter")
    assert np.allclose(np.column_stack((line.x, line.y)), run.path.position[:, 0])


def test_a_quantity_over_time_has_its_unit_and_every_component(run):
    figure = figures.over_time(PENDULUM, run.path, "bob", "velocity")
    assert [line.name for line in figure.data] == ["x", "y"]
    assert np.allclose([line.y for line in figure.data], run.path.velocity[:, 0].T)
    assert "m/s" in figure.layout.yaxis.title.text
    assert "rad" in figures.over_time(PENDULUM, run.path, "bob", "orientation").layout.yaxis.title.text


def test_a_spread_is_drawn():
    source = ensembles.Source(PENDULUM)
    variants = ensembles.Variants(source, [source.target("bob.mass")])
    design = ensembles.design({"bob.mass": ensembles.Uniform(1.0, 2.0)}, 4)
    made = ensembles.run_ensemble(variants, design, mbs_ref.Settings(t_end=0.1, samples=3), threads=1)
    assert [line.fill for line in figures.spread(made).data] == ["toself", None] * 2


def test_what_a_run_knows_is_drawn(run):
    for draw in (figures.error, figures.energy, figures.compliance, figures.work_precision):
        assert isinstance(draw([run]), go.Figure)
    (line,) = figures.error([run]).data
    assert max(line.y) == pytest.approx(run.record.error.value)


def test_what_cannot_be_drawn_says_what_is_allowed(run):
    with pytest.raises(ValueError, match="body = 'rod' is unknown; allowed: bob"):
        figures.motion(PENDULUM, run.path, ["rod"])
    with pytest.raises(ValueError, match="quantity = 'speed' is unknown; allowed: position, "):
        figures.over_time(PENDULUM, run.path, "bob", "speed")
    unjudged = cross_checks.run(PENDULUM, step=0.01, method="rk4", t_end=0.2, samples=3, judged=False, estimate="off")
    with pytest.raises(ValueError, match="none with an error over time"):
        figures.error([unjudged])
