"""Pages in a real browser: no complaint, every plot drawn, links lead somewhere, nothing wider than a phone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from mbs_ref import scenes
from reports.facts.report_data import ReportData
from reports.facts.scene_facts import scene_facts
from reports.page.build import BROWSERS, browser, publish
from tests.reports.page.chromium import Chromium
from tests.reports.page.synthetic_report import report_data

PAGES = ("index.html", "scene-pendulum.html", "engine-mujoco.html", "findings.html", "profiles.html", "method.html",
         "capabilities.html", "extremes.html")  # fmt: skip
DRAWN = """new Promise(next => { const wait = () => {
  const plots = [...document.querySelectorAll('.plot')];
  plots.every(plot => plot.querySelector('.main-svg')) ? next(plots.length) : setTimeout(wait, 50); }; wait(); })"""
WIDE = """[...document.querySelectorAll('body *')].filter(part => part.getBoundingClientRect().right > innerWidth + 1
  && !part.closest('.scroll') && !part.closest('.plot')).map(part => part.outerHTML.slice(0, 80))"""
CUT = """[...document.querySelectorAll('.scroll')].filter(part => part.scrollWidth > part.clientWidth + 1)
  .map(part => part.innerText.slice(0, 80))"""


@pytest.fixture(scope="module")
def data() -> ReportData:
    return replace(report_data(), mechanisms=(scene_facts(scenes.make("pendulum")),))


@pytest.fixture(scope="module")
def folder(data: ReportData, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    publish(data, folder, "single")
    return publish(data, folder).parent


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    if browser() is None:
        pytest.skip(f"no browser is installed; needs one of {', '.join(BROWSERS)}")
    chromium = Chromium(tmp_path_factory.mktemp("profile"))
    yield chromium
    chromium.close()


@pytest.mark.parametrize("page", [*PAGES[:3], *(pytest.param(page, marks=pytest.mark.slow) for page in PAGES[3:])])
def test_a_page_is_drawn_without_complaint_and_fits_a_phone_and_a_screen(chromium, folder, page):
    for width in (390, 1400):
        chromium.open((folder / page).as_uri(), width)
        chromium.ask("document.querySelectorAll('main details').forEach(part => { part.open = true; })")
        assert chromium.ask(WIDE) == []
        assert chromium.ask("document.documentElement.scrollWidth") <= width
    assert chromium.ask(CUT) == []
    assert (chromium.ask(DRAWN) > 0) is (page in ("index.html", "scene-pendulum.html", "profiles.html"))
    assert chromium.complaints == []


def test_a_film_is_shown_and_a_setting_is_picked(chromium, folder):
    chromium.open((folder / "scene-pendulum.html").as_uri(), 1400)
    assert chromium.ask("document.querySelector('.moving').naturalWidth") > 400
    assert "Runner-up" in chromium.ask("document.getElementById('answer').innerText")


def test_every_page_of_the_single_file_is_reached_by_its_links(chromium, folder):
    chromium.open((folder / "report.html").as_uri(), 1400)
    links = set(chromium.ask("[...document.querySelectorAll('nav a')].map(link => link.getAttribute('href'))"))
    assert set(PAGES) <= links
    chromium.ask("document.querySelector('nav a[href=\"scene-pendulum.html\"]').click()")
    chromium.ask("new Promise(next => setTimeout(next, 100))")
    assert chromium.ask("document.querySelector('h1').innerText") == "pendulum"
    assert chromium.ask(DRAWN) > 3
    assert chromium.ask("document.querySelector('.moving').naturalWidth") > 400
    chromium.open((folder / "report.html").as_uri() + "#all", 1400)
    assert chromium.ask("document.querySelectorAll('main').length") == len(links)
    assert chromium.complaints == []
