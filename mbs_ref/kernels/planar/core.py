"""The planar core: its handles, and what it supplies to the kernels of `rigid`."""

from __future__ import annotations

from typing import NamedTuple

from mbs_ref.kernels.border.handles import handle_of
from mbs_ref.kernels.border.supplies import supply
from mbs_ref.kernels.planar import contacts, dynamics, grips, joints, loads, marks, tree, vectors
from mbs_ref.kernels.planar.model import PlanarGroups, PlanarScratch
from mbs_ref.kernels.rigid import geometry


@handle_of(PlanarGroups, dimension=2, tangents=1, axes=0, turns=1, moments=1)
class PlanarModel(NamedTuple):
    address: int


@handle_of(PlanarScratch, rates=3)
class PlanarWork(NamedTuple):
    address: int


supply((PlanarModel, PlanarWork), geometry, (contacts, dynamics, grips, joints, loads, marks, tree, vectors))
