"""The examination of contacts: a restitution that is a hundredth off, and the right one."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.conformance.broken_engines import Broken, Change, Mistake
from cross_checks.conformance.ladder import climb
from cross_checks.conformance.probes import bounce_truth, probes
from cross_checks.conformance.questions import probe
from mbs_ref.scene import Scene


def off(scene: Scene) -> Scene:
    (touch,) = scene.contacts
    law = touch.law.model_copy(update={"restitution": 1.01 * touch.law.restitution})
    return scene.model_copy(update={"contacts": (touch.model_copy(update={"law": law}),)})


@pytest.mark.parametrize("kind", [
    "rigid_law", pytest.param("lankarani_nikravesh_law", marks=pytest.mark.slow), "flores_law",
])  # fmt: skip
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("change", "outcome"), [(off, "failed"), (lambda scene: scene, "passed")])
def test_a_restitution_that_is_a_hundredth_off_fails(kind: str, dimension: int, change: Change, outcome: str):
    solver = Broken(engines.get("mbs_ref"), Mistake("restitution", change=change))
    for method in solver.methods():
        findings, _ = climb(solver, method, probe(kind, dimension))
        assert [finding.outcome for finding in findings if finding.question == "contact"] == [outcome]


@pytest.mark.parametrize(
    "times",
    [
        [0.0, 0.15],
        [0.03],
        [0.0, 0.0515],
        *(pytest.param(times, marks=pytest.mark.slow) for times in ([0.0, 0.06], [0.0, 0.05, 0.1], [0.04, 0.3])),
    ],
)
def test_a_bounce_does_not_depend_on_the_other_outputs(times: list[float]):
    """Outputs before, within or after the contact alone; the last one within it."""
    for scene in (scene for scene in probes().values() if scene.contacts):
        few, every = np.array(times), np.union1d(times, np.linspace(0.0, 0.3, 31))
        truth, whole = bounce_truth(scene, few), bounce_truth(scene, every)
        rows = np.searchsorted(every, few)
        np.testing.assert_allclose(truth.position, whole.position[rows], rtol=0.0, atol=truth.uncertainty)
        assert truth.velocity is not None
        assert whole.velocity is not None
        np.testing.assert_allclose(truth.velocity, whole.velocity[rows], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("kind", "dimension"), [(kind, d) for (kind, d), scene in probes().items() if scene.contacts])
def test_the_velocity_of_a_bounce_is_the_slope_of_its_position(kind: str, dimension: int):
    """Before, within and after the contact; differences across a jump of the velocity do not count."""
    scene, step = probes()[kind, dimension], 1e-6
    middle = np.linspace(0.01, scene.duration - 0.01, 24)
    times = np.sort(np.concatenate((middle - step, middle, middle + step)))
    truth = bounce_truth(scene, times)
    assert truth.velocity is not None
    slope = (truth.position[2::3] - truth.position[::3]) / (2.0 * step)
    off = np.abs(slope - truth.velocity[1::3]).max(axis=(1, 2))
    jumps = np.abs(truth.velocity[2::3] - truth.velocity[::3]).max(axis=(1, 2)) > 0.1
    assert off[~jumps].max() < 1e-2
    assert jumps.sum() <= 1
