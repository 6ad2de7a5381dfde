"""Which core a scene needs: it pays for that one alone."""

from __future__ import annotations

from mbs_ref.cores.particles.system import ParticleSystem
from mbs_ref.cores.planar.system import PlanarSystem
from mbs_ref.cores.spatial.system import SpatialSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.units import is_celestial

_CORES = {2: PlanarSystem, 3: SpatialSystem}  # by the scene's dimension


def compile_scene(scene: Scene) -> System:
    """Return the scene compiled for the core its bodies call for."""
    return ParticleSystem(scene) if is_celestial(scene) else _CORES[scene.dimension](scene)


def core_name(scene: Scene) -> str:
    """Return the name of the core a scene runs on: particles, planar or spatial."""
    if is_celestial(scene):
        return "particles"
    return "planar" if scene.dimension == 2 else "spatial"
