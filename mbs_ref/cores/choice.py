"""Select the core of a scene; only that core is compiled."""

import numpy as np

from mbs_ref.cores.particles import ParticleSystem
from mbs_ref.cores.planar import PlanarSystem
from mbs_ref.cores.relative import RelativePlanarSystem, RelativeSpatialSystem
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import Scales, is_celestial
from mbs_ref.scene.traits import Coordinates

_CORES = {  # by the coordinates and the scene's dimension
    "cartesian": {2: PlanarSystem, 3: SpatialSystem},
    "relative": {2: RelativePlanarSystem, 3: RelativeSpatialSystem},
}


def compile_scene(scene: Scene, coordinates: Coordinates = "cartesian") -> System:
    """Return the scene compiled for the core of its bodies, in the requested coordinates.

    Raises ValueError if relative coordinates are requested and the scene is no tree of joints that they support.
    """
    return _core(scene, coordinates)(scene)


def core_name(scene: Scene, coordinates: Coordinates = "cartesian") -> str:
    """Return the name of the core a scene runs on: particles, planar, spatial, relative_planar or relative_spatial."""
    return _core(scene, coordinates).CORE


def state_units(scene: Scene, scales: Scales, coordinates: Coordinates = "cartesian") -> np.ndarray:
    """Return what each entry of a scene's state counts in (n_state,): L, 1 rad, and the same over T."""
    return _core(scene, coordinates).state_units(scene, scales)


def _core(scene: Scene, coordinates: Coordinates) -> type[System]:
    if is_celestial(scene):
        return ParticleSystem  # free particles have no joints, so that both kinds of coordinates are these
    return _CORES[coordinates][scene.dimension]
