"""Which core a scene needs: it pays for that one alone."""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.particles.system import ParticleSystem
from mbs_ref.cores.planar.system import PlanarSystem
from mbs_ref.cores.spatial.system import SpatialSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import Scales
from mbs_ref.scene.units import is_celestial

_CORES = {2: PlanarSystem, 3: SpatialSystem}  # by the scene's dimension


def compile_scene(scene: Scene) -> System:
    """Return the scene compiled for the core its bodies call for."""
    return _core(scene)(scene)


def core_name(scene: Scene) -> str:
    """Return the name of the core a scene runs on: particles, planar or spatial."""
    return _core(scene).CORE


def state_units(scene: Scene, scales: Scales) -> np.ndarray:
    """Return what each entry of a scene's state counts in (n_state,): L, 1 rad, and the same over T."""
    return _core(scene).state_units(scene, scales)


def _core(scene: Scene) -> type[ParticleSystem] | type[PlanarSystem] | type[SpatialSystem]:
    return ParticleSystem if is_celestial(scene) else _CORES[scene.dimension]
