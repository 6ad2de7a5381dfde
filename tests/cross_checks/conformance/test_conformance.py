"""The conformance suite through its command, on the small engine of the docs and on spoiled copies of it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[3] / "docs" / "your-engine.md"


def small_engine() -> str:
    (code,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    return code


def examine(tmp_path: Path, code: str):
    file = tmp_path / "small_.py"
    file.write_text(code)
    main = "from reports.cli import main; main()"
    return subprocess.run([sys.executable, "-c", main, "conformance", str(file)], capture_output=True, text=True)


def test_the_engine_of_the_docs_conforms(tmp_path):
    done = examine(tmp_path, small_engine())
    assert done.returncode == 0, done.stdout + done.stderr
    assert "failed" not in done.stdout


@pytest.mark.parametrize(
    ("right", "wrong", "found"),
    [
        ("2 * k2 + 2 * k3 + k4)", "2 * k2 + 3 * k3)", "test_the_documented_order_is_observed"),
        ("np.dot(tangent, gravity) / length", "1.01 * np.dot(tangent, gravity) / length", "test_it_agrees_with_every"),
    ],
)
def test_a_mistake_is_found(tmp_path, right, wrong, found):
    assert right in small_engine()
    done = examine(tmp_path, small_engine().replace(right, wrong))
    assert done.returncode == 1
    assert found in done.stdout
