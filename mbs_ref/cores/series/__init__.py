"""Scenes compiled for Taylor series: planar trees of revolute joints, and particles that attract each other."""

from collections.abc import Iterable

from mbs_ref.cores.series.orbits import OrbitSeries, attracting_pairs, no_orbit_series
from mbs_ref.cores.series.trees import TreeSeries, no_tree_series
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import attraction, is_celestial

MOST_ANGLES = 32  # of a tree: beyond, the cube of their number in a step outweighs a recursion's stages
MOST_PAIRS = 3  # of particles: beyond, the stages of Gauss's method are evaluated in less time


def no_series(scene: Scene) -> Iterable[str]:
    """Return why Taylor series of a scene's motion are not available."""
    return no_orbit_series(scene) if is_celestial(scene) else no_tree_series(scene)


def small_system(scene: Scene) -> str:
    """Return what a scene is, of which series cost less than the steps of other methods; empty if it is no such."""
    if is_celestial(scene):
        kind, few = "few particles", len(attracting_pairs(attraction(scene))) <= MOST_PAIRS
    else:
        kind, few = "a small planar tree", len(scene.joints) <= MOST_ANGLES and not scene.loads
    return kind if few and not any(no_series(scene)) else ""


def expansion_of(system: System) -> TreeSeries | OrbitSeries:
    """Return the series of a system, built at first use."""
    if system.expansion is None:
        system.expansion = (OrbitSeries if is_celestial(system.scene) else TreeSeries)(system)
    return system.expansion
