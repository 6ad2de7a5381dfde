"""Systems (mbs_ref.cores.system) of one build side by side, WIDTH of them: handles of groups whose floats are lanes.

Systems of one build differ in their figures alone: all floats of their groups, such as masses, places and gravity.
What contacts change in a run is no figure: loads that depend on it are evaluated by each run's own system.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.kernels import answers as core
from mbs_ref.kernels.algebra.lanes import WIDTH, aligned, room_for_lanes
from mbs_ref.kernels.border.handles import ModelInLanes, WorkInLanes, make_handle
from mbs_ref.kernels.contact.laws import ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.contact.neighbours import Granules
from mbs_ref.kernels.relative.model import Redundant
from mbs_ref.kernels.rigid.model import Beside
from mbs_ref.scene import PointBushing, SpringDamper, TorsionSpring
from mbs_ref.scene.traits import traits

NOT_IN_LANES = Redundant, ContactModes, NearPairs, Granules


class SideBySide(NamedTuple):
    """Room for WIDTH systems of one build; lanes have no figures yet."""

    figures: np.ndarray  # (n_figures, WIDTH)
    beside: Beside  # addresses of what evaluates the loads of each lane
    model: ModelInLanes
    work: WorkInLanes
    kept: list[Any]  # what the handles lead to


def _parts(system: Any) -> list[Any]:
    return [system] if system.redundant is system else [system.redundant, system]


def _arrays(system: Any) -> Iterator[np.ndarray]:
    groups = [group for part in _parts(system) for group in part.groups]
    yield from (array for group in groups if not isinstance(group, NOT_IN_LANES) for array in group)


def figures_of(system: Any) -> np.ndarray:
    """Return the figures of a system (n_figures,)."""
    return np.concatenate([array.ravel() for array in _arrays(system) if array.dtype == np.float64])


def build_of(system: Any) -> bytes:
    """Return what systems must have in common to be side by side."""
    numbers = [a for a in _arrays(system) if a.dtype != np.float64]
    return system.CORE.encode() + b"".join(a.tobytes() for a in (*numbers, _pivots(system)))


def _pivots(system: Any) -> np.ndarray:
    """Return the order of the pivots of each closure at the scene's own start, which lanes do not change."""
    if not system.n_closure_rows:
        return np.zeros((0, 0), np.int64)
    system.derivative(0.0, system.initial_state())
    return system.scratch.closures.order.copy()


def handles_of(system: Any) -> tuple[int, ...]:
    """Return the addresses of a system's model and work, and those of what knows its loads and rows."""
    if _loads_depend(system):
        system.redundant.prepare(core.BESIDE)
    return tuple(part.address for own in (system, system.redundant) for part in (own.model, own.work))


def _loads_depend(system: Any) -> bool:
    """Return whether loads depend on the time or on modes, or are others than lanes evaluate."""
    return bool(system.event_sources) or not _has_springs_alone(system)


def _has_springs_alone(system: Any) -> bool:
    """Return whether all loads are springs that lanes evaluate, or that depend on modes alone."""
    return all(isinstance(load, PointBushing | SpringDamper | TorsionSpring) for load in system.scene.loads)


def _has_lasting_rows(system: Any) -> bool:
    """Return whether constraint rows depend neither on the time nor on modes."""
    return not any(contact.holds for contact in system.scene.contacts) and "rheonomic" not in traits(system.scene)


def follows_from_states(system: Any) -> bool:
    """Return whether lanes evaluate all of a tree's loads and rows, and by the state alone."""
    return not system.n_closure_rows and not _loads_depend(system) and _has_lasting_rows(system)


def side_by_side(system: Any) -> SideBySide:
    """Return arrays for systems of this one's structure."""
    figures, taken, kept = room_for_lanes(len(figures_of(system))), 0, []
    inner: list[int] = []
    loads = core.LOADS_ALONE if _loads_depend(system) else core.LANES_LOADS
    rows = core.LANES_ROWS if _has_lasting_rows(system) else core.ROWS_ALONE
    _pivots(system)  # leaves their order in the scratch

    def placed(array: np.ndarray) -> np.ndarray:
        nonlocal taken
        if array.dtype != np.float64:
            return array
        first, taken = taken, taken + array.size
        return figures[first:taken].reshape(*array.shape, WIDTH)

    for part in _parts(system):
        own = [g if isinstance(g, NOT_IN_LANES) else type(g)(*map(placed, g)) for g in part.groups]
        own = [Redundant(np.array(inner)) if isinstance(g, Redundant) else g for g in own]
        scratch = [type(group)(*map(_repeated, group)) for group in part.scratch]
        handles = [make_handle(map(_without_lanes, groups), checked=True) for groups in (own, scratch)]
        asked = (loads, core.LANES, rows, core.LOOPS if system.n_closure_rows else core.OPEN)
        asked = asked if part is system.redundant is system else asked[1:2] if part is system else asked[:1]
        for handle in handles:
            core.connected(part.CORE + core.IN_LANES, handle, asked)
        kept += [own, scratch, handles]
        inner = [handle.ctypes.data for handle in handles]
    beside = next(group for group in kept[1] if isinstance(group, Beside))  # of the redundant system
    beside.always[:] = not _has_springs_alone(system)
    return SideBySide(figures, beside, ModelInLanes(inner[0]), WorkInLanes(inner[1]), kept)


def _without_lanes(group: Any) -> Any:
    """Return a group as a handle shows it: of an array of lanes the place, and the shape without them."""
    if isinstance(group, NOT_IN_LANES):
        return group
    return [array[..., 0] if array.dtype == np.float64 else array for array in group]


def _repeated(array: np.ndarray) -> np.ndarray:
    """Return a copy of scratch, of floats in every lane."""
    return aligned(np.repeat(array[..., None], WIDTH, axis=-1)) if array.dtype == np.float64 else array.copy()
