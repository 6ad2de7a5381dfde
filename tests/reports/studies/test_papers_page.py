"""The papers' claims: their verdicts follow the measured figures, and the page shows every one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from reports.facts.curves import Curves, Measured
from reports.page.render import pages, render
from reports.studies.document import NAME, Claim
from reports.studies.papers import SINGULAR, euler_angles, multipliers
from reports.studies.papers.lessons import block_inversion, orders
from reports.studies.study import every, measure
from tests.reports.page.synthetic_report import report_data

HALF_ORDER = 0.5
PAPERS = every()["papers"]
CLAIMS = PAPERS.claims()


def test_a_verdict_follows_the_figures():
    claim = Claim(
        "g", "1999", "Sec. I", "a is small", "{a} m", (("a", "<", 1.0), ("a", "<", "b"), ("word", "=", "yes"))
    )
    good = {"a": 0.5, "b": 2.0, "word": "yes"}
    assert claim.decided(good) == "reproduced"
    assert claim.decided(good | {"a": 1.5}) == "not reproduced"
    assert claim.decided(good | {"b": 0.1}) == "not reproduced"
    assert claim.decided(good | {"word": "no"}) == "not reproduced"
    assert claim.decided(good | {"a": "stopped"}) == "not reproduced"
    assert claim.decided({"word": "yes"}) == "not measured"
    assert claim.shown(good)["result"] == "0.5 m"
    assert claim.shown({})["result"] == "(not measured) m"


def test_every_claim_has_a_verdict_and_a_page():
    files = {page.file for page in pages(report_data())}
    for claim in CLAIMS:
        assert bool(claim.criteria) != (claim.verdict != "not measured"), claim.statement
        assert not claim.link or claim.link in files, claim.link
    assert {claim.paper for claim in CLAIMS} == {"1999", "2001"}
    for figure in ("Fig. 1", "Fig. 2", "Fig. 3", "Fig. 4", "Fig. 5"):
        assert any(figure in claim.where.replace("Figs.", "Fig.") for claim in CLAIMS)


def test_the_page_tells_measured_and_missing_figures():
    arm = {"time": 0.025, "kind": "arm", "x1": 0.1, "y1": 0.2, "x2": 0.3, "y2": 0.4, "radius": 0.05}
    line = Curves((0.0, 0.1), {"head": (0.0, 1.0)}, "x, N")
    figures = {"simplified.front.seats_imbalance": 2e-12, "simplified.rk4.test": "keeps"}
    facts = Measured(figures, {"outlines: rear, bare": (arm,)}, {"Fig. 3, x": line})
    page = render(replace(report_data(), studies={"papers": facts}))["papers.html"].decode()
    assert "2.00e-12 N" in page
    assert "(not measured)" in page
    assert 'y1="-0.2"' in page
    assert 'stroke-width="0.1"' in page
    assert page.count("not reproduced") >= 1
    assert all(claim.where in page for claim in CLAIMS)


def test_differences_of_mu_lose_two_orders_and_grow_with_roundoff():
    found = multipliers()
    double = [float(found[f"multiplier.mu.float64.{h:g}"]) for h in (1e-2, 1e-3, 1e-4)]
    solved = [float(found[f"multiplier.index1.float64.{h:g}"]) for h in (1e-2, 1e-3)]
    assert double[0] / double[1] == pytest.approx(1e2, rel=0.1)
    assert solved[0] / solved[1] > 10 ** (4 - HALF_ORDER)
    single = [float(found[f"multiplier.mu.float32.{h:g}"]) for h in (1e-3, 1e-4)]
    assert single[1] > 5.0 * single[0]


def test_eulers_angles_stop_at_the_pole_with_a_name():
    near, at = euler_angles(0.1), euler_angles(1e-8)
    assert near["status"] == "success"
    assert at["status"] == SINGULAR
    assert at["until"] == pytest.approx(1.0, abs=1e-3)  # s: the axis starts a radian from the pole and turns at 1 rad/s
    assert float(euler_angles(1e-3)["calls"]) > 2.0 * float(near["calls"])


def test_a_singular_block_is_not_inverted():
    """Of a body in Euler parameters A has rank 3 of 4; the whole matrix gives Euler's equations to roundoff."""
    found = block_inversion()
    assert found["block.rank"] == 3.0
    assert float(found["block.whole_error"]) < 1e-14
    assert isinstance(found["block.error"], str) or found["block.error"] > 1e-6


def test_local_errors_are_of_one_order_more_than_global_ones():
    found = orders()
    for method, order in (("rk4", 4.0), ("euler", 1.0)):
        assert found[f"errors.{method}.global"] == pytest.approx(order, abs=HALF_ORDER)
        assert found[f"errors.{method}.local"] == pytest.approx(order + 1.0, abs=HALF_ORDER)


@pytest.mark.slow
def test_every_figure_that_a_claim_names_is_measured():
    figures = [measure(name).figures for name in ("papers", "crashes", "contact")]
    known = {name for own in figures for name in own}
    words = {"keeps", "fails", "success", "singular"}
    for claim in CLAIMS:
        named = {*(place[1] for place in NAME.finditer(claim.result)), *(name for name, _, _ in claim.criteria)}
        assert named <= known, claim.statement
        for _, _, other in claim.criteria:
            assert not isinstance(other, str) or other in words or other in known
