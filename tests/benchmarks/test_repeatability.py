"""What counts as the same bits, and what a row says of runs that differ."""

from __future__ import annotations

import numpy as np

from cross_checks.conformance import repeatability
from cross_checks.conformance.cases import cases
from cross_checks.conformance.repeatability import by_method, difference


def motion(value: float) -> dict[str, np.ndarray]:
    return {"times": np.array([0.0, 1.0]), "position": np.array([[[2.0, value]]])}


def test_the_same_bits_differ_by_nothing_and_any_other_by_something():
    assert difference(motion(1.0), motion(1.0)) == 0.0
    assert difference(motion(0.0), motion(-0.0)) != 0.0
    assert difference(motion(1.0), motion(np.nextafter(1.0, 2.0))) == np.spacing(1.0) / 2.0
    assert difference(motion(1.0), "it stopped") is None
    assert difference("it stopped", "it stopped") == 0.0


def test_a_run_that_another_order_changes_is_counted(monkeypatch):
    asked = [case for case in cases(["mbs_ref"]) if case.method == "rk4"][:2]

    def made(some, function, threads=1):
        found = {case.name: motion(1.5 if some[0] is not asked[0] or threads == 2 else 1.0) for case in some}
        return {name: (one, one) for name, one in found.items()} if function is repeatability.twice else found

    monkeypatch.setattr(repeatability, "_made", made)
    row = by_method(repeatability.measured(asked))[0]
    assert [(each["way"], each["differ"]) for each in row["ways"]] == [
        ("at once", 0), ("another process", 0), ("another order", 2), ("two threads", 2)
    ]  # fmt: skip
    assert row["ways"][2]["largest"] == 0.25
