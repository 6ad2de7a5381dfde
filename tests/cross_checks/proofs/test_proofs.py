"""Proofs hold, and nothing false passes: doctored logs, wrong equations, truths with a wrong digit."""

from __future__ import annotations

import copy
import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

pytest.importorskip("flint", reason="proofs need python-flint: pip install 'mbs-ref[proofs]'")

from flint import arb, fmpq  # pyright: ignore[reportMissingImports]

from cross_checks.truths import seek_truth
from cross_checks.truths.proofs.certified import as_truth
from cross_checks.truths.proofs.checker.balls import Refused, precision
from cross_checks.truths.proofs.checker.formulas import Formulas, roots
from cross_checks.truths.proofs.checker.proof import check
from cross_checks.truths.proofs.derivation import NotCovered
from cross_checks.truths.proofs.integrate import prove
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.observables.distance import farthest, unmasked_distances
from reports.cli import main

TIMES = [0.0, 0.1, 0.2]  # s
COVERED = {
    "double_pendulum": {},
    "pendulum_chain": {"links": 4},
    "slider_crank": {},
    "spring_pendulum": {"damping": 0.3},
    "kepler": {},
    "spherical_pendulum": {},
    "torque_free_top": {},
    "spatial_slider_crank": {},
}


def proven(name: str, times: list[float] = TIMES, **parameters: Any) -> Any:
    return prove(scenes.make(name, **parameters), times)


@pytest.fixture(scope="module")
def proofs() -> dict[str, Any]:
    return {name: proven(name, **given) for name, given in COVERED.items()}


@pytest.fixture(scope="module")
def logs(proofs) -> dict[str, dict[str, Any]]:
    """Return logs as files hold them."""
    return {name: json.loads(json.dumps(one.log)) for name, one in proofs.items()}


@pytest.mark.parametrize("name", COVERED)
def test_a_proof_is_checked_and_holds_the_truth(name, proofs, logs):
    checked, enclosures = check(logs[name])
    assert checked.radius < 1e-15
    assert len(enclosures) == len(TIMES)
    scene = scenes.make(name, **COVERED[name])
    truth = seek_truth(scene, np.array(TIMES))
    assert isinstance(truth, Truth)
    proof = as_truth(scene, enclosures)
    assert max(farthest(scene, truth, proof)[:2]) <= truth.uncertainty + proof.uncertainty
    rates = unmasked_distances(truth, proof, None)[..., 2:].max((1, 2))
    assert (rates <= truth.rate_uncertainty + proof.rate_uncertainty).all()


def test_an_enclosure_holds_a_finer_one():
    coarse, fine = proven("double_pendulum").proof, prove(scenes.make("double_pendulum"), TIMES, 1e-40).proof
    assert fine.radius < 1e-40 < coarse.radius
    with precision(400):
        pairs = zip(coarse.enclosures[-1], fine.enclosures[-1], strict=True)
        assert all(a.contains(b) for first, second in pairs for a, b in zip(first, second, strict=True))


def test_free_fall_is_exact():
    at_rest = scenes.make("double_pendulum")
    body = at_rest.bodies[0].model_copy(update={"velocity": (1.0, 2.0), "angular_velocity": 3.0})
    end = prove(at_rest.model_copy(update={"bodies": (body,), "joints": ()}), [0.0, 0.5]).proof.enclosures[-1][0]
    height = Fraction(body.position[1]) + 1 - Fraction(9.81) / 8
    with precision(400):
        assert end[1].contains(arb(fmpq(height.numerator, height.denominator)))
        assert end[2].contains(arb(1.5))


DOCTORED = {
    "a coefficient": lambda log: log["steps"][1][2][0].__setitem__(1, log["steps"][1][2][0][1] + (1 << 110)),
    "a start": lambda log: log["steps"][0][2][0].__setitem__(0, log["steps"][0][2][0][0] + (1 << 110)),
    "a longer step": lambda log: log["steps"][2].__setitem__(0, log["steps"][2][0] * 2),
    "a negative step": lambda log: log["steps"][2].__setitem__(0, -log["steps"][2][0]),
    "a missing step": lambda log: log["steps"].pop(2),
    "a missing end": lambda log: log["steps"].pop(),
    "a smaller radius": lambda log: log.__setitem__("radius", log["radius"] / 2),
    "a missing row": lambda log: log["steps"][0][2].pop(),
    "a start value": lambda log: log["system"]["starts"].__setitem__(0, [1, 1 << 60]),
    "a heavier body": lambda log: log["scene"]["bodies"][0].__setitem__("mass", 1.000000000001),
    "no formulas": lambda log: log["system"].__setitem__("lines", []),
    "a word for a number": lambda log: log["steps"][0].__setitem__(1, "one"),
    "times backward": lambda log: log["times"].reverse(),
    "a singular unit": lambda log: log["system"].__setitem__("units", ["0", "1", "1"]),
}  # fmt: skip


@pytest.mark.parametrize("what", DOCTORED)
def test_a_doctored_log_is_refused(what, logs):
    log = copy.deepcopy(logs["double_pendulum"])
    DOCTORED[what](log)
    with pytest.raises(Refused):
        check(log)


def _rates(log: dict[str, Any]) -> list[arb]:
    """Return y' by a log's formulas at one point."""
    with precision(1000):
        formulas = Formulas(log["system"])
        y = [arb(k * k + 3) / 7 for k in range(formulas.n)]
        value = formulas.run(formulas.plan(formulas.f), y, roots(formulas, y))
        return [value[place] for place in formulas.f]


@pytest.mark.parametrize("name", ["double_pendulum", "slider_crank", "spherical_pendulum", "torque_free_top"])
def test_a_wrong_equation_is_refused(name, logs):
    """One operation of the equations is another: minus for plus, or a constant that differs in its last bit."""
    right, wrong = _rates(logs[name]), 0
    lines = logs[name]["system"]["lines"]
    signs = [k for k, line in enumerate(lines) if line[0] in "+-"]
    numbers = [k for k, line in enumerate(lines) if line[0] == "c" and line[2] > 2]
    for k in (*signs[:: len(signs) // 8], *numbers[-2:]):
        log = copy.deepcopy(logs[name])
        operation, first, second = log["system"]["lines"][k]
        log["system"]["lines"][k] = {"+": ["-", first, second], "-": ["+", first, second]}.get(
            operation, [operation, first + 1, second]
        )
        try:
            if all(abs(float(a - b)) < 1e-100 for a, b in zip(right, _rates(log), strict=True)):
                continue  # a line on which the motion does not depend
        except Refused:
            continue  # no acceleration fulfils it
        wrong += 1
        with pytest.raises(Refused):
            check(log)
    assert wrong >= 3


def test_contact_is_not_covered():
    with pytest.raises(NotCovered, match="contacts"):
        prove(scenes.make("bouncing_ball"), TIMES)


def test_a_limit_of_time_states_how_far_the_proof_reaches():
    stopped = prove(scenes.make("pendulum_chain", links=3), [0.0, 5.0], limit=1.0)
    assert 0.0 < stopped.reached < 5.0
    assert "limit" in stopped.reason


def test_the_command_proves_and_checks(tmp_path):
    file = str(tmp_path / "log.gz")
    done = CliRunner().invoke(main, ["prove", "pendulum", "--t-end", "0.2", "-o", file, "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["radius"] < 1e-15
    checked = CliRunner().invoke(main, ["prove", "--check", file])
    assert checked.exit_code == 0, checked.output
    (tmp_path / "log.gz").write_bytes(b"nothing")
    assert CliRunner().invoke(main, ["prove", "--check", file]).exit_code == 1
