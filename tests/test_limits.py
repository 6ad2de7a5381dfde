"""The numbers that decide which runs, rows and digits are shown, stated a second time.

Tests elsewhere take a limit from its module, so that they hold for every value of it. A change of a value belongs here,
too: what pages and commands state about it may have to follow.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest

LIMITS: dict[str, dict[str, Any]] = {
    "reports.page.findings": {"ORDER_SLACK": 0.5, "FIRST": 6},
    "reports.page.sections.overview": {"DIGITS": 15},
    "reports.page.sections.plots": {"STRAIGHT": 0.1},
    "reports.page.sections.profiles": {"FACTORS": (1.0, 2.0, 10.0), "BEYOND": 2.0, "MOST": 10000.0},
    "reports.facts.report_data": {"NEAR": 1.5, "MIDDLE": 1e-06},
    "reports.facts.curves": {"MOST_POINTS": 201, "DIGITS": 6, "HEIGHT": 360},
    "reports.query": {"FIRST": 20.0},
    "reports.scene_summary": {"FEW": 60},
    "reports.commands.engines.doctor": {"LARGEST_ERROR": 1e-06},
    "reports.commands.judge.check": {"MOST_REASONS": 5},
    "reports.commands.maintenance.calibrate": {"MOST_BELOW": 0.01, "MOST_ABOVE": 10.0},
    "reports.commands.maintenance.nightly": {"ERROR": 1e-06},
    "reports.commands.run.ensemble": {"MOST_ROWS": 60},
    "reports.commands.run.inspect": {"SHOWN": 6},
    "reports.commands.run.simulate": {"MOST_NAMED": 6, "MOST_TIMES": 12},
    "reports.site.gallery": {"TARGETS": (0.001, 1e-06), "WORK": 50000, "TRUTH_WORK": 300000, "SECONDS": 4.0},
    "benchmarks.history": {"EFFECT": 1.05, "CHANCE": 0.01, "SHUFFLES": 500, "LEAST": 4},
    "benchmarks.calibration": {"LARGEST": 12, "SAMPLES": (5, 21, 101), "MAX_STEPS": 50000},
    "benchmarks.method_table": {
        "ASKED": (0.0001, 1e-06, 1e-08, 1e-10), "TIGHT": 1e-13, "ROUNDOFF": 1e-12, "LOST": 0.01, "SLOW": 2.0,
        "TURNS": 5, "FEW": 4, "FAR": 4.0,
    },
    "benchmarks.record_changes": {"FACTOR": 2.0, "CLOSED": 1e-11},
    "benchmarks.trees.regression": {"MOST_PAIRS": 3, "ROUNDS": 15, "SECONDS": 0.02},
    "cross_checks.records.plots": {"FLOOR": 1e-17},
    "cross_checks.records.record": {"BUSY": 0.9, "WARMED": 0.2},
    "cross_checks.conformance.clock": {"FASTEST": 5e-09, "WORK": 0.1, "LONGEST": 4.0 ** 8, "COUNTED": 0.6},
    "cross_checks.conformance.questions": {
        "SAMPLES": 51, "STEPS": (50, 100, 200, 400), "RTOLS": (0.0001, 1e-06, 1e-08, 1e-10),
    },
    "cross_checks.conformance.symmetry": {
        "NUDGE": 2.0 ** (-46), "SAMPLES": 5, "RTOL": 1e-08, "PLAIN": 30.0, "PATIENCE": 300.0,
    },
    "cross_checks.conformance.examine": {"ORDER_OFF": 0.35},
    "cross_checks.conformance.ladder": {
        "MORE": 7, "GOOD": 1e-08, "SLOPE": 1e-05, "EXPLAINED": 2.0, "SPARSE": 20, "ORDERS": (5, 7), "EDGE": 4,
    },
    "cross_checks.conformance.cases": {"STEP": 0.001, "SKY_STEPS": 2000, "LOOSER": 20.0},
    "cross_checks.metrics.contact_figures": {
        "STILL": 0.0001, "STEADY": 0.1, "MANY": 12, "PLACES": 33, "ROUNDOFF_GAP": 1e-09, "LEAST_PATH": 1e-09,
    },
    "cross_checks.metrics.drifts": {"RESOLVED": 0.1, "NEGLIGIBLE": 1e-09},
    "cross_checks.metrics.errors": {"MOST": 16.0},
    "cross_checks.trajectory_files.columns": {"MOST_ROWS": 4000, "NONE": 2 ** 62},
    "cross_checks.trajectory_files.formats": {"PART": 2 ** 18},
    "cross_checks.trajectory_files.judgement": {"MOST": 8},
    "cross_checks.trajectory_files.library": {"MOST_EXPLAINED": 1000, "DEFAULT_ERROR": 1e-06},
    "cross_checks.trajectory_files.mistakes": {
        "EXPLAINS": 10.0, "ALIKE": 3.0, "MOST": 4, "IRREGULAR": 2.0, "SPREAD": 0.001, "STRETCHES": 200,
    },
    "cross_checks.trajectory_files.mistakes.case": {
        "WINDOWS": (8, 4, 2, 1), "FEWEST": 4, "VISIBLE": 0.001, "HOPEFUL": 3.0, "EVALUATIONS": 12,
        "DIFFERENCE": 1e-05, "GAIN": 0.001,
    },
    "cross_checks.trajectory_files.mistakes.frames": {"NONE": 1e-09},
    "cross_checks.trajectory_files.mistakes.terms": {"MOST": 24, "WORK": 300000.0, "LEAST": 0.0001},
    "cross_checks.trajectory_files.motion": {"SAME_TIME": 1e-09, "UNIT": 0.001},
    "cross_checks.prices.pick": {"RIVAL": 5.0, "CLOSE": 1.5, "OUTPUTS": 11},
    "cross_checks.prices.timing": {
        "PAIRS": 5, "FEWEST_BLOCKS": 10, "MOST_BLOCKS": 40, "LIMIT": 1.05, "RESAMPLES": 1000, "AGAIN": 3,
        "FEWEST_RUNS": 3, "MOST_RUNS": 5, "NARROW": 0.05, "ENOUGH": 1.0, "ROUNDS": 3,
    },
}  # fmt: skip


@pytest.mark.parametrize("module", LIMITS)
def test_a_limit_has_the_value_that_is_stated(module):
    made = import_module(module)
    assert {name: getattr(made, name) for name in LIMITS[module]} == LIMITS[module]
