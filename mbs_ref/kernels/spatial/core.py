"""The spatial core: its handles, and what it supplies to the kernels of `rigid`."""

from __future__ import annotations

from typing import NamedTuple

from mbs_ref.kernels.border.handles import handle_of
from mbs_ref.kernels.border.supplies import supply
from mbs_ref.kernels.rigid import geometry
from mbs_ref.kernels.spatial import contacts, dynamics, grips, joints, loads, marks, orientation, tree, vectors
from mbs_ref.kernels.spatial.model import SpatialGroups, SpatialScratch


@handle_of(SpatialGroups, dimension=3, tangents=2, axes=3, turns=3, moments=6)
class SpatialModel(NamedTuple):
    address: int


@handle_of(SpatialScratch, rates=6)
class SpatialWork(NamedTuple):
    address: int


MODULES = (contacts, dynamics, grips, joints, loads, marks, orientation, tree, vectors)
supply((SpatialModel, SpatialWork), geometry, MODULES)
