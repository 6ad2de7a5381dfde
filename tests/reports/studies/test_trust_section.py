"""The calibration that the tree keeps: enough runs, honest ones, and the section says its figures."""

from __future__ import annotations

from reports.commands.explore.repeatability import SAME_MACHINE
from reports.commands.maintenance.calibrate import MOST_ABOVE, MOST_BELOW
from reports.facts.report_data import ReportData
from reports.page.render import render
from reports.studies import trust
from reports.studies.study import stored


def test_the_kept_calibration_is_honest():
    row = trust.table("calibration")["table"][0]
    assert row["method"] == "all"
    assert row["runs"] >= 1500
    assert row["judged"] >= 1000
    assert row["below"] <= MOST_BELOW * row["judged"]
    assert row["overestimate_median"] < MOST_ABOVE


def test_our_solver_breaks_no_symmetry_by_more_than_it_errs():
    facts = trust.table("symmetry")
    ours = [row for row in facts["methods"] if row["engine"] == "mbs_ref"]
    assert sum(row["judged"] for row in ours) > 300
    assert all(row["beyond_error"] == 0 for row in ours)
    assert {row["engine"] for row in facts["methods"]} >= {"mbs_ref", "exudyn", "mujoco", "pinocchio", "rebound"}


def test_our_solver_gives_the_same_bits_again():
    ours = [row for row in trust.table("repeatability")["methods"] if row["engine"] == "mbs_ref"]
    assert sum(row["runs"] for row in ours) > 50
    for row in ours:
        assert not any(each["differ"] for each in row["ways"] if each["way"] in SAME_MACHINE), row


def test_the_page_shows_the_tables_even_where_nothing_is_measured():
    page = render(ReportData((), (), quick=True, studies=stored()))["trust.html"].decode()
    row = trust.table("calibration")["table"][0]
    assert f"in {row['below']} of {row['judged']} runs" in page
    assert all(f"<td>{one['method']}</td>" in page for one in trust.table("symmetry")["methods"])
    assert "bits differ" in page
