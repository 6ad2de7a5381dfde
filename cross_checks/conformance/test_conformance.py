"""The examination of an engine as tests: one a question, with a line for every failure.

The answers are those of `cross_checks.conformance.examine`, which runs once.
"""

from pathlib import Path

import pytest

from cross_checks import engines
from cross_checks.conformance.apart import TIMEOUT, Apart
from cross_checks.conformance.examine import QUESTIONS, examine
from cross_checks.conformance.finding import Report
from cross_checks.isolation.parent import Isolated


@pytest.fixture(scope="session")
def report(pytestconfig: pytest.Config) -> Report:
    """Return what the examination of the chosen engine shows."""
    file, name = pytestconfig.getoption("--mbs-adapter"), pytestconfig.getoption("--mbs-engine")
    if file is None and name is None:
        pytest.skip("choose an engine with --mbs-adapter FILE or --mbs-engine NAME")
    engine_name = name or Path(str(file)).stem.removesuffix("_")
    with Isolated(TIMEOUT) as ask:
        return examine(Apart(engines.get(engine_name), ask), engine_name)


@pytest.mark.parametrize("question", QUESTIONS)
def test_it_answers(report, question):
    findings = [finding for finding in report.findings if finding.question == question]
    if not findings:
        pytest.skip("no method, scene or documented order that it concerns")
    wrong = [f"{f.scene} by {f.method}: {f.detail}" for f in findings if f.outcome == "failed"]
    assert not wrong, "\n".join(wrong)
