"""The validation matrix with a tiny engine."""

from __future__ import annotations

import json

import pytest

from cross_checks.judge.matrix import check
from cross_checks.judge.verdict import Verdict
from mbs_ref import scenes
from tests.cross_checks.conftest import BIAS, raising


def test_every_cell_has_its_verdict(swing):
    seen = []
    cells = list(check([scenes.make("pendulum")], progress=lambda done, total, text: seen.append((done, total, text))))
    second, biased, loops, absent = cells
    assert (second.verdict, biased.verdict) == (Verdict.AGREES, Verdict.WRONG_LIMIT)
    assert (loops.verdict, absent.verdict) == (Verdict.CANNOT, Verdict.ENGINE_MISSING)
    assert second.order == pytest.approx(2.0, abs=1e-3)
    assert second.error <= 1e-6
    assert biased.error == pytest.approx(BIAS, rel=1e-3)
    assert seen[0][:2] == (0, 4)
    assert seen[-1] == (4, 4, "")
    json.dumps([cell.to_dict() for cell in cells], allow_nan=False)


def test_an_engine_that_raises_fails_its_own_cells(swing):
    swing(raising(RuntimeError("singular")))
    verdicts = {cell.method: cell.verdict for cell in check([scenes.make("pendulum")], ["swing"])}
    assert verdicts == {"second": Verdict.FAILED, "biased": Verdict.FAILED, "loops": Verdict.CANNOT}


def test_unknown_engines_are_refused(swing):
    with pytest.raises(ValueError, match="nobody"):
        list(check([scenes.make("pendulum")], ["nobody"]))
