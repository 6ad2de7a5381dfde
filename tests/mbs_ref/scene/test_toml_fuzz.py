"""The scene file reader under a coverage-guided fuzzer: it refuses with its own error, or gives a valid scene."""

from __future__ import annotations

import pytest

from tests.mbs_ref.scene.toml_fuzzer import Findings, fuzz

NIGHT = 60.0  # s


def report(found: Findings) -> str:
    return "\n\n".join(f"{why}\n---\n{text[:2000]}" for why, text in found.failures[:5])


def test_a_few_hundred_mutants():
    found = fuzz(seed=1, most=200)
    assert not found.failures, report(found)
    assert found.lines > 300
    assert len(found.shapes) > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_a_minute_of_mutants(seed, capsys):
    found = fuzz(seed, most=10**9, seconds=NIGHT)
    with capsys.disabled():
        print(f"\nscene file fuzzing, seed {seed}: {found}")
    assert not found.failures, report(found)
