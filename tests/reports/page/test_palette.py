"""An engine has one style, whatever is shown beside it."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from cross_checks import engines
from cross_checks.records.plots import COLOURS, SYMBOLS, style_of, styles
from reports.page.render import TEMPLATES, render
from reports.page.sections.extremes import context as extremes
from reports.page.sections.profiles import context as profiles
from tests.reports.page.synthetic_report import report_data


def test_every_engine_differs_from_every_other_in_colour_and_symbol():
    chosen = [style_of(name) for name in engines.names()]
    assert chosen[0].colour == COLOURS[0]
    assert len({style.colour for style in chosen}) == len({style.symbol for style in chosen}) == len(chosen)
    css = (TEMPLATES / "style.css").read_text()
    assert [symbol for symbol in SYMBOLS if f".dot.{symbol} {{" not in css] == []


def luminance(colour: str) -> float:
    """Return the relative luminance of #rrggbb (WCAG 2.2)."""
    shares = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    linear = [s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shares]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("colour", COLOURS)
def test_a_colour_is_seen_on_light_and_on_dark_cards(colour):
    dark = luminance("#1a2027")
    assert 1.05 / (luminance(colour) + 0.05) >= 3.0
    assert (luminance(colour) + 0.05) / (dark + 0.05) >= 3.0


def test_methods_of_one_engine_differ_in_dash_or_filling():
    few = [f"m{k}" for k in range(12)]
    records = [replace(report_data().records[0], method=name) for name in few]
    assert len({(style.symbol, style.dash) for style in styles(records).values()}) == len(few)


def test_a_style_does_not_depend_on_what_is_shown():
    records, chance = list(report_data().records), random.Random(5)
    for _ in range(20):
        few = chance.sample(records, 12)
        for (engine, _), style in styles(few).items():
            own = style_of(engine)
            assert (style.colour, style.symbol.removesuffix("-open")) == (own.colour, own.symbol)


def test_an_engine_that_is_not_registered_keeps_its_style():
    assert style_of("somebody_s") == style_of("somebody_s")


def test_plots_and_tables_of_all_pages_agree():
    data = report_data()
    drawn = [block["plot"]["data"] for block in profiles(data)["blocks"]]
    for trace in (trace for traces in drawn for trace in traces):
        style = style_of(trace["meta"]["engine"])
        assert (trace["line"]["color"], trace["marker"]["symbol"]) == (style.colour, style.symbol)
    rows = [row for family in extremes(data)["families"] for e in family["extremes"] for row in e["chart"]["rows"]]
    assert {row["colour"] for row in rows if row["engine"] == "mujoco"} == {style_of("mujoco").colour}
    pages = render(data)
    for name in ("index.html", "profiles.html", "capabilities.html"):
        style = style_of("exudyn")
        assert f'class="dot {style.symbol}" style="background:{style.colour}"' in pages[name].decode()
