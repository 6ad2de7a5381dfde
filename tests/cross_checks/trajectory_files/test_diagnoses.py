"""The fault of a file is named with its size, and a right file of another engine gets no diagnosis."""

import pytest

import cross_checks
from tests.cross_checks.trajectory_files.faulty_files import (
    FAULTS,
    RIGHT,
    SPRING,
    TOP,
    TWO,
    on_a_spring,
    right,
    top,
    two_rods,
)

QUICK = ("gravity upwards", "stiffness 10 % high", "inertia about the elbow", "loose tolerance")


@pytest.fixture(autouse=True)
def store(tmp_path_factory, monkeypatch):
    """Let all tests share a store of truths."""
    folder = tmp_path_factory.getbasetemp() / "diagnoses"
    folder.mkdir(exist_ok=True)
    monkeypatch.setenv("MBS_REF_STORE", str(folder / "store.sqlite"))


def named(fault: str) -> bool:
    scene, columns, words = FAULTS[fault]()
    suspicions = cross_checks.judge(scene, columns).suspicions
    return bool(suspicions) and all(word in suspicions[0] for word in words)


@pytest.mark.parametrize(("scene", "tool"), [
    pytest.param(TWO, two_rods, marks=pytest.mark.slow), (SPRING, on_a_spring), (TOP, top)],
                         ids=lambda one: getattr(one, "name", ""))  # fmt: skip
def test_the_tools_without_a_fault_agree(scene, tool):
    result = cross_checks.judge(scene, tool())
    assert (result.verdict, result.suspicions) == ("agrees", ())


@pytest.mark.parametrize("fault", QUICK)
def test_a_fault_is_named_with_its_size(fault):
    assert named(fault)


@pytest.mark.slow
@pytest.mark.parametrize("fault", sorted(FAULTS.keys() - set(QUICK)))
def test_every_fault_is_named_with_its_size(fault):
    assert named(fault)


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "engine", "settings"), RIGHT)
def test_a_right_file_gets_no_diagnosis_but_of_its_integration(scene, engine, settings):
    pytest.importorskip(engine)
    result = cross_checks.judge(scene, right(scene, engine, settings))
    assert all(sentence.startswith("the tolerance or the step") for sentence in result.suspicions), result.suspicions
    assert len(result.suspicions) <= 1
