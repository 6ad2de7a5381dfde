"""The calibration that the tree keeps: enough runs, honest ones, and the section says its figures."""

from __future__ import annotations

from reports.commands.judge.calibrate import MOST_ABOVE, MOST_BELOW
from reports.facts.report_data import ReportData
from reports.page.studies import trust


def test_the_kept_calibration_is_honest():
    row = trust.context(ReportData((), ()))["calibration"]["table"][0]
    assert row["method"] == "all"
    assert row["runs"] >= 1500
    assert row["judged"] >= 1000
    assert row["below"] <= MOST_BELOW * row["judged"]
    assert row["overestimate_median"] < MOST_ABOVE
