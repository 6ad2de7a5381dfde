"""Which scenes are made of free particles."""

from __future__ import annotations

from mbs_ref.celestial import CELESTIAL_TYPES
from mbs_ref.scene import PointMass, Scene


def is_celestial(scene: Scene) -> bool:
    """Return whether the scene is made of free particles in space that celestial fields alone move."""
    return (
        scene.dimension == 3
        and not scene.joints
        and all(isinstance(body, PointMass) for body in scene.bodies)
        and all(load.type in CELESTIAL_TYPES for load in scene.loads)
    )
