"""Ladders of models: the least that is enough, what a rung tells, and the page."""

from __future__ import annotations

import json
from dataclasses import replace

from click.testing import CliRunner

from mbs_ref import scenes
from mbs_ref.settings import Settings
from reports.cli import main
from reports.page.render import render
from reports.studies.models import Ladder, Rung, built, choose, ladder, shown
from tests.reports.page.synthetic_report import report_data


def rung(name: str, seconds: float, accuracy: float | None) -> Rung:
    return Rung(name, seconds, 100, {"way, m": 1.5}, accuracy)


def test_the_least_model_is_the_cheapest_that_is_enough():
    made = Ladder("Sky", "", "gauss", "figures", (rung("a", 1.0, 4.5), rung("b", 2.0, 9.0), rung("c", 1.5, 6.0)))
    assert [made.least(k) for k in (4.0, 5.0, 9.0, 9.5)] == [made.rungs[0], made.rungs[2], made.rungs[1], None]


SKY = Ladder("Sky", "", "gauss", "figures", (rung("a", 1.0, 4.5), rung("b", 3.0, 9.0), rung("c", 1.5, 6.0)))


def test_a_choice_says_what_is_enough_and_why_nothing_less_is():
    choice = choose(SKY, 1e-5)
    assert (choice.best, choice.lesser) == (SKY.rungs[2], SKY.rungs[0])
    assert (
        "'c' is enough for 1e-05: 1e-06, 1.5 s; of the cheaper ones 'a' comes closest with 3.2e-05" in choice.sentence
    )
    assert choose(SKY, 1e-4).lesser is None
    missed = choose(SKY, 1e-10)
    assert missed.best is None
    assert "no model reaches 1e-10; 'b' comes closest with 1e-09" in missed.sentence


def test_the_model_that_others_are_held_against_is_always_enough():
    made = replace(SKY, rungs=(*SKY.rungs[:2], rung("c", 5.0, None)), reference="c")
    assert choose(made, 1e-12).best == made.rungs[2]
    assert "counted from 'c', which is no truth" in choose(made, 1e-12).sentence


def test_pick_names_the_least_model_of_a_family():
    result = CliRunner().invoke(main, ["pick", "pendulum_chain", "--models", "--error", "1e-6", "--json"])
    assert result.exit_code == 0, result.output
    told = json.loads(result.output)
    assert told["best"]["name"] in {rung["name"] for rung in told["ladder"]["rungs"]}
    assert all(rung["accuracy"] > 6.0 for rung in told["ladder"]["rungs"])  # the coordinates do not change the motion
    refused = CliRunner().invoke(main, ["pick", "heavy_top", "--models", "--error", "1e-6"])
    assert refused.exit_code == 2
    assert "knows the families of solar_system" in refused.output


def test_events_buy_digits_that_clipping_does_not_have():
    """The same steps, four runs: held against the truth of the bounce."""
    clipped, located = [built("bounces").rungs[k::2] for k in range(2)]
    for less, more in zip(clipped, located, strict=True):
        assert less.accuracy is not None
        assert more.accuracy is not None
        assert more.accuracy > less.accuracy + 1.0


def test_rungs_keep_their_order_and_tell_what_was_asked():
    models = [
        (str(n), scenes.make("pendulum_chain", links=n), Settings(method="dop853", rtol=1e-6, t_end=0.1, samples=3))
        for n in (2, 1)
    ]
    found = ladder("Chains", "", "", models, lambda scene, *_: ({"bodies": float(len(scene.bodies))}, None))
    assert [(r.name, r.shown["bodies"]) for r in found.rungs] == [("2", 2.0), ("1", 1.0)]
    assert all(r.loop_s > 0.0 and r.work > 0 for r in found.rungs)
    assert found.method == "dop853, rtol = 1e-06"


def test_planar_and_spatial_bodies_move_alike():
    """Both rungs reach the truth, so that time alone speaks for the planar core."""
    planar, spatial = built("loops").rungs
    assert planar.accuracy is not None
    assert spatial.accuracy is not None
    assert min(planar.accuracy, spatial.accuracy) > 5.0


def test_the_page_names_the_least_model_of_each_figure():
    made = Ladder("Sky", "note", "gauss", "figures", (rung("lumped", 1e-3, 2.5), rung("full", 2e-2, 4.0)))
    page = render(replace(report_data(), studies={"models": shown([made])}))["models.html"].decode()
    assert "up to 2: lumped; up to 4: full" in page
    assert "1.5" in page
    assert "20" in page
