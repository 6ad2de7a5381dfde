"""One robot file, read by each parser that is installed: is the same robot seen?

Asked are what a reader makes of the file before any of its integrators runs: the mass matrix, the forces that hold the
robot still, and those with its motion, at random places and rates of all hinges and slides. An adapter of a parser
in this folder offers its READER; our own takes what `mbs-ref simulate FILE` would run.
"""

import pkgutil
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from cross_checks import robots
from cross_checks.engine.plan import initial_sample
from cross_checks.robots import RobotError, root_of
from mbs_ref.observables import kinetic_energy, potential_energy

Values = dict[str, float]  # rad or m, or their rates, by joint name
NUDGE = 1e-5  # rad, m: of a central difference, whose error is its square
SAME = 1e-6  # of the largest entry: differences of our own energies leave 1e-8
OURS = "mbs_ref"


class Unreadable(ValueError):
    """A reader refuses the file; the sentence is its own."""


class Dynamics(NamedTuple):
    """What moves a robot's joints, in the order of their names: SI units."""

    mass: np.ndarray  # (n, n)
    gravity: np.ndarray  # (n,) what holds it still
    bias: np.ndarray | None  # (n,) gravity and what its motion costs; None of a reader that does not say


Reader = Callable[[Path, Values, Values], Dynamics]


class Difference(NamedTuple):
    """Where a reader departs from the first that read the file."""

    reader: str
    other: str
    quantity: str  # mass, gravity, bias
    relative: float  # over the largest entry
    joints: tuple[str, ...]  # of the entry that differs most
    here: float  # kg m^2, kg m, kg; N m, N
    there: float


class Parity(NamedTuple):
    """What the readers make of one file."""

    joints: tuple[str, ...]
    read: tuple[str, ...]  # readers that read it
    refused: dict[str, str]  # reader -> why it did not, in its own words, or that it is not installed
    apart: dict[str, dict[str, float]]  # reader -> quantity -> largest relative difference from the first
    differences: tuple[Difference, ...]  # beyond SAME, the worst of each reader and quantity


def readers() -> dict[str, Reader | str]:
    """Return the readers by name; a sentence for one whose package is not installed."""
    names = sorted(info.name for info in pkgutil.iter_modules(robots.__path__) if info.name.endswith("_"))
    return {name.removesuffix("_"): _reader(name) for name in names} | {OURS: by_us}


def _reader(name: str) -> Reader | str:
    try:
        return import_module(f"{robots.__name__}.{name}").READER
    except ModuleNotFoundError as error:
        return f"not installed: {error}"


def joints_of(path: Path) -> list[str]:
    """Return the names of the hinges and slides of a URDF or MJCF file. RobotError where it is neither, or has none."""
    readers = {"robot": _of_urdf, "mujoco": _of_mjcf}
    root = root_of(path, *readers)
    names = readers[root.tag](root)
    if not names:
        raise RobotError(f"{path}: no hinge or slide has a name, by which readers could be compared")
    return names


def _of_urdf(root: ElementTree.Element) -> list[str]:
    """A joint that mimics another has no place of its own."""
    joints = [joint for joint in root.findall("joint") if joint.get("type") in ("revolute", "continuous", "prismatic")]
    return [str(joint.get("name")) for joint in joints if joint.find("mimic") is None]


def _of_mjcf(root: ElementTree.Element) -> list[str]:
    joints = [joint for world in root.findall("worldbody") for joint in world.iter("joint")]
    moving = [joint for joint in joints if joint.get("type", "hinge") in ("hinge", "slide")]
    return [str(joint.get("name")) for joint in moving if joint.get("name")]


def parity(path: Path, poses: int = 5, seed: int = 1, asked: dict[str, Reader | str] | None = None) -> Parity:
    """Compare the readers at `poses` random places and rates within 1 rad, 1 m, 1 rad/s, 1 m/s of the file's zero."""
    names = joints_of(path)
    dice = np.random.default_rng(seed)
    drawn = [[dict(zip(names, row, strict=True)) for row in dice.uniform(-1.0, 1.0, (2, len(names))).tolist()]
             for _ in range(poses)]  # fmt: skip
    refused: dict[str, str] = {}
    dynamics: dict[str, list[Dynamics]] = {}
    for name, reader in (readers() if asked is None else asked).items():
        try:
            if isinstance(reader, str):
                raise Unreadable(reader)
            dynamics[name] = [reader(path, q, v) for q, v in drawn]
        except (Unreadable, RobotError) as error:
            refused[name] = str(error)
    first = next(iter(dynamics), "")
    others = [name for name in dynamics if name != first]
    worst = {name: list(_worst(first, name, dynamics[first], dynamics[name], names)) for name in others}
    apart = {name: {one.quantity: one.relative for one in found} for name, found in worst.items()}
    beyond = (one for found in worst.values() for one in found if one.relative > SAME)
    return Parity(tuple(names), tuple(dynamics), refused, apart, tuple(sorted(beyond, key=lambda one: -one.relative)))


def _pairs(mine: Dynamics, theirs: Dynamics) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return by quantity what both say."""
    pairs = zip(Dynamics._fields, mine, theirs, strict=True)
    return {name: (a, b) for name, a, b in pairs if a is not None and b is not None}


def _relative(pair: tuple[np.ndarray, np.ndarray]) -> float:
    """Return by how much the two differ, over the largest entry of the first."""
    one, other = pair
    return float(np.abs(one - other).max() / (np.abs(one).max() or 1.0))


def differences(mine: Dynamics, theirs: Dynamics) -> dict[str, float]:
    """Return by how much the two differ, over the largest entry of the first; only what both say."""
    return {name: _relative(pair) for name, pair in _pairs(mine, theirs).items()}


def _worst(
    first: str, name: str, mine: list[Dynamics], theirs: list[Dynamics], names: list[str]
) -> Iterator[Difference]:
    """Yield the largest difference of each quantity over all poses."""
    every = [_pairs(*pair) for pair in zip(mine, theirs, strict=True)]
    for quantity in every[0]:
        a, b = max((pairs[quantity] for pairs in every), key=_relative)
        where = np.unravel_index(np.argmax(np.abs(a - b)), a.shape)
        joints = tuple(dict.fromkeys(names[k] for k in where))
        yield Difference(name, first, quantity, _relative((a, b)), joints, float(b[where]), float(a[where]))


def by_us(path: Path, q: Values, v: Values) -> Dynamics:
    """Return our own: the mass matrix from the kinetic energy of the scene's bodies, gravity from their height."""
    read, ignorable = _read_of(path)

    def energy(places: Values, rates: Values) -> tuple[float, float]:
        given = {**places, **{f"{name}.rate": rate for name, rate in rates.items()}, "ignore": ",".join(ignorable)}
        scene = read(path, given).scene
        scene, start = scene.model_copy(update={"loads": ()}), initial_sample(scene)
        return float(kinetic_energy(scene, start)[0]), float(potential_energy(scene, start)[0])

    names = list(q)
    one = [energy(q, {name: 1.0})[0] for name in names]
    mass = np.diag(one) * 2.0
    for i, a in enumerate(names):
        for j, b in enumerate(names[:i]):
            mass[i, j] = mass[j, i] = energy(q, {a: 1.0, b: 1.0})[0] - one[i] - one[j]
    height = [[energy(q | {name: q[name] + side * NUDGE}, {})[1] for side in (1.0, -1.0)] for name in names]
    return Dynamics(mass, np.array([(up - down) / (2.0 * NUDGE) for up, down in height]), None)


def _read_of(path: Path) -> tuple[Callable[..., Any], tuple[str, ...]]:
    """Return our reader of the format, and what it may ignore, which these figures do not contain."""
    urdf = ElementTree.parse(path).getroot().tag == "robot"
    module, name = ("pinocchio_", "read_urdf") if urdf else ("mujoco_", "read_mjcf")
    try:
        found = import_module(f"{robots.__name__}.{module}")
    except ModuleNotFoundError as error:
        raise Unreadable(f"our reader takes the parser of {module.partition('_')[0]}: {error}") from error
    return getattr(found, name), tuple(found.IGNORABLE)
