"""Systems (mbs_ref.cores.system) of one build side by side, WIDTH of them: handles of groups whose floats are lanes.

Systems of one build differ in their figures alone: all floats of their groups, such as masses, places and gravity.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.kernels import answers as core
from mbs_ref.kernels.algebra.lanes import WIDTH, aligned, room_for_lanes
from mbs_ref.kernels.border.handles import ModelInLanes, WorkInLanes, make_handle
from mbs_ref.kernels.relative.model import Redundant


class SideBySide(NamedTuple):
    """Room for WIDTH systems of one build; lanes have no figures yet."""

    figures: np.ndarray  # (n_figures, WIDTH)
    model: ModelInLanes
    work: WorkInLanes
    kept: list[Any]  # what the handles lead to


def _parts(system: Any) -> list[Any]:
    return [system] if system.redundant is system else [system.redundant, system]


def _arrays(system: Any) -> Iterator[np.ndarray]:
    groups = [group for part in _parts(system) for group in part.groups]
    yield from (array for group in groups if not isinstance(group, Redundant) for array in group)


def figures_of(system: Any) -> np.ndarray:
    """Return the figures of a system (n_figures,)."""
    return np.concatenate([array.ravel() for array in _arrays(system) if array.dtype == np.float64])


def build_of(system: Any) -> bytes:
    """Return what systems must have in common to be side by side."""
    return system.CORE.encode() + b"".join(a.tobytes() for a in _arrays(system) if a.dtype != np.float64)


def side_by_side(system: Any) -> SideBySide:
    """Return arrays for systems of this one's structure."""
    figures, taken, kept = room_for_lanes(len(figures_of(system))), 0, []
    inner: list[int] = []

    def placed(array: np.ndarray) -> np.ndarray:
        nonlocal taken
        if array.dtype != np.float64:
            return array
        first, taken = taken, taken + array.size
        return figures[first:taken].reshape(*array.shape, WIDTH)

    for part in _parts(system):
        own = [
            Redundant(np.array(inner)) if isinstance(g, Redundant) else type(g)(*map(placed, g)) for g in part.groups
        ]
        scratch = [type(group)(*map(_repeated, group)) for group in part.scratch]
        # of an array of lanes a handle has the place, and the shape without them
        shown = (
            [[a[..., 0] if a.dtype == np.float64 else a for a in group] for group in part] for part in (own, scratch)
        )
        handles = [make_handle(groups, checked=True) for groups in shown]
        asked = (core.LANES, core.LANES_LOADS, core.LOOPS if system.n_closure_rows else core.OPEN)
        asked = asked if part is system.redundant is system else asked[:1] if part is system else asked[1:2]
        for handle in handles:
            core.connected(part.CORE + core.IN_LANES, handle, asked)
        kept += [own, scratch, handles]
        inner = [handle.ctypes.data for handle in handles]
    return SideBySide(figures, ModelInLanes(inner[0]), WorkInLanes(inner[1]), kept)


def _repeated(array: np.ndarray) -> np.ndarray:
    """Return a copy of scratch, of floats in every lane."""
    return aligned(np.repeat(array[..., None], WIDTH, axis=-1)) if array.dtype == np.float64 else array.copy()
