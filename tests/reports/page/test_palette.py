"""An engine has one style, whatever is shown beside it."""

from __future__ import annotations

import random

from cross_checks import engines
from cross_checks.records.plots.plot import COLOURS, style_of, styles
from reports.page.render import render
from reports.page.sections.extremes import context as extremes
from reports.page.sections.profiles import context as profiles
from tests.reports.page.synthetic_report import report_data


def test_every_engine_is_told_from_every_other():
    chosen = [style_of(name) for name in engines.names()]
    assert chosen[0].colour == COLOURS[0]
    assert len({(style.colour, style.dash) for style in chosen}) == len({style.mark for style in chosen}) == len(chosen)


def test_a_style_does_not_depend_on_what_is_shown():
    records, chance = list(report_data().records), random.Random(5)
    for _ in range(20):
        few = chance.sample(records, 12)
        assert all((style.colour, style.dash) == (style_of(engine).colour, style_of(engine).dash)
                   for (engine, _), style in styles(few).items())  # fmt: skip


def test_an_engine_that_is_not_registered_keeps_its_style():
    assert style_of("somebody_s") == style_of("somebody_s")


def test_plots_and_tables_of_all_pages_agree():
    data = report_data()
    drawn = [block["plot"]["data"] for block in profiles(data)["blocks"]]
    for trace in (trace for traces in drawn for trace in traces):
        style = style_of(trace["meta"]["engine"])
        assert (trace["line"]["color"], trace["line"]["dash"]) == (style.colour, style.dash)
    rows = [row for family in extremes(data)["families"] for e in family["extremes"] for row in e["chart"]["rows"]]
    assert {row["colour"] for row in rows if row["engine"] == "mujoco"} == {style_of("mujoco").colour}
    pages = render(data)
    for name in ("index.html", "profiles.html", "capabilities.html"):
        assert f'style="{style_of("exudyn").mark}"' in pages[name].decode()
