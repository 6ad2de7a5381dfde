"""The examination of contacts: a restitution that is a hundredth off, and the right one."""

from __future__ import annotations

import pytest

from cross_checks import engines
from cross_checks.conformance.broken_engines import Broken, Change, Mistake
from cross_checks.conformance.ladder import climb
from cross_checks.conformance.questions import probe
from mbs_ref.scene import Scene


def off(scene: Scene) -> Scene:
    (touch,) = scene.contacts
    law = touch.law.model_copy(update={"restitution": 1.01 * touch.law.restitution})
    return scene.model_copy(update={"contacts": (touch.model_copy(update={"law": law}),)})


@pytest.mark.parametrize("kind", ["rigid_law", "lankarani_nikravesh_law", "flores_law"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("change", "outcome"), [(off, "failed"), (lambda scene: scene, "passed")])
def test_a_restitution_that_is_a_hundredth_off_fails(kind: str, dimension: int, change: Change, outcome: str):
    solver = Broken(engines.get("mbs_ref"), Mistake("restitution", change=change))
    for method in solver.methods():
        findings, _ = climb(solver, method, probe(kind, dimension))
        assert [finding.outcome for finding in findings if finding.question == "contact"] == [outcome]
