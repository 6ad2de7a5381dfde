"""`mbs-ref engines` tells a refusal once, however many parts it meets."""

from __future__ import annotations

from cross_checks.judge.capabilities import summary


def test_part_types_that_lack_are_listed_once():
    reasons = [f"'pin_{k}': e does not yet support the part type 'universal'" for k in range(40)]
    assert summary([*reasons, "e moves nothing"]) == "lacks universal; 1 more"


def test_reasons_that_differ_in_a_name_are_one():
    reasons = [f"contact 'shoe_{k}': its mass changes" for k in range(210)]
    assert summary(reasons) == "contact …: its mass changes (210 times)"
    assert summary([]) == ""
