"""Ladders of models: the least that is enough, what a rung tells, and the page."""

from __future__ import annotations

from dataclasses import replace

from mbs_ref import scenes
from mbs_ref.settings import Settings
from reports.page.render import render
from reports.studies.models.facts import Ladder, ModelsFacts, Rung
from reports.studies.models.measure import ladder, loops
from tests.reports.page.synthetic_report import report_data


def rung(name: str, seconds: float, accuracy: float | None) -> Rung:
    return Rung(name, seconds, 100, {"way, m": 1.5}, accuracy)


def test_the_least_model_is_the_cheapest_that_is_enough():
    made = Ladder("Sky", "", "gauss", "figures", (rung("a", 1.0, 4.5), rung("b", 2.0, 9.0), rung("c", 1.5, 6.0)))
    assert [made.least(k) for k in (4.0, 5.0, 9.0, 9.5)] == [made.rungs[0], made.rungs[2], made.rungs[1], None]


def test_rungs_keep_their_order_and_tell_what_was_asked():
    models = [
        (str(n), scenes.make("pendulum_chain", links=n), Settings(method="dop853", rtol=1e-6, t_end=0.1, samples=3))
        for n in (2, 1)
    ]
    found = ladder("Chains", "", "", models, lambda scene, path: ({"bodies": float(len(scene.bodies))}, None))
    assert [(r.name, r.shown["bodies"]) for r in found.rungs] == [("2", 2.0), ("1", 1.0)]
    assert all(r.loop_s > 0.0 and r.work > 0 for r in found.rungs)
    assert found.method == "dop853, rtol = 1e-06"


def test_planar_and_spatial_bodies_move_alike():
    """Both rungs reach the truth, so that time alone speaks for the planar core."""
    planar, spatial = loops().rungs
    assert planar.accuracy is not None
    assert spatial.accuracy is not None
    assert min(planar.accuracy, spatial.accuracy) > 5.0


def test_the_page_names_the_least_model_of_each_figure():
    made = Ladder("Sky", "note", "gauss", "figures", (rung("lumped", 1e-3, 2.5), rung("full", 2e-2, 4.0)))
    page = render(replace(report_data(), studies={"models": ModelsFacts((made,))}))["models.html"].decode()
    assert "up to 2: lumped; up to 4: full" in page
    assert "1.5" in page
    assert "20" in page
