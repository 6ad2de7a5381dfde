"""Which core a scene needs: it pays for that one alone."""

from __future__ import annotations

from mbs_ref.particle_scene import is_celestial
from mbs_ref.particle_system import ParticleSystem
from mbs_ref.planar_system import PlanarSystem
from mbs_ref.scene import Scene
from mbs_ref.system import System


def compile_scene(scene: Scene) -> System:
    """Return the scene compiled for the core its bodies call for; ValueError where there is none."""
    if is_celestial(scene):
        return ParticleSystem(scene)
    if scene.dimension == 2:
        return PlanarSystem(scene)
    raise ValueError(f"scene {scene.name!r} is spatial; mbs_ref has no core for it yet")


def core_name(scene: Scene) -> str:
    """Return the name of the core a scene runs on: particles, planar or spatial."""
    if is_celestial(scene):
        return "particles"
    return "planar" if scene.dimension == 2 else "spatial"
