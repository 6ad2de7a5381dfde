"""The layers import downward only, and an engine's package is imported in its own adapter alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = ("mbs_ref", "cross_checks", "benchmarks", "reports", "tests")  # lowest first
ENGINE_PACKAGES = frozenset({"exudyn", "pinocchio", "mujoco", "rebound", "reboundx", "heyoka", "astropy"})
FILES = sorted(path for layer in LAYERS for path in (ROOT / layer).rglob("*.py"))


def imported(path: Path) -> Iterator[str]:
    """Yield the top-level package of every import in a file, those inside functions too."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield (node.module or "").split(".")[0]


def in_adapter(path: Path) -> bool:
    """Tell whether a file is an adapter <name>_.py, or part of an adapter's package <name>_."""
    for adapters in (ROOT / "cross_checks" / "engines", ROOT / "cross_checks" / "ephemerides"):
        if path.is_relative_to(adapters):
            top = path.relative_to(adapters).parts[0].removesuffix(".py")
            return top.endswith("_") and not top.startswith("_")
    return False


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", FILES, ids=label)
def test_imports_point_downward(path):
    layer = LAYERS.index(path.relative_to(ROOT).parts[0])
    upward = set(imported(path)) & set(LAYERS[layer + 1 :])
    assert not upward, f"{label(path)} of {LAYERS[layer]} imports {upward} from above"


@pytest.mark.parametrize("path", [p for p in FILES if "tests" not in p.relative_to(ROOT).parts], ids=label)
def test_an_engine_package_is_imported_in_its_adapter_alone(path):
    engines = set(imported(path)) & ENGINE_PACKAGES
    assert not engines or in_adapter(path), f"{label(path)} imports {engines}"
    assert len(engines - {"reboundx"}) <= 1, f"{label(path)} mixes engines {engines}"


def test_every_folder_of_code_is_an_installed_package():
    missing = {path.parent for path in FILES if path.parts[len(ROOT.parts)] != "tests"}
    missing = {folder for folder in missing if not (folder / "__init__.py").exists()}
    assert not missing
