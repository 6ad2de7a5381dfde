"""Particles and satellites in the terms of programs for celestial bodies."""

import math
from collections.abc import Iterator

import numpy as np

from mbs_ref import Scene
from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene.celestial import Drag, Oblateness, RadiationPressure, ThirdBody
from mbs_ref.scene.scales import attraction


def of_particles(position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return poses of particles in space from positions and velocities, each (n_t, n_bodies, 3): they never turn."""
    turn = np.zeros((*position.shape[:2], 4))
    turn[:, :, 0] = 1.0
    return position, turn, velocity, np.zeros_like(velocity)


def planet_of(scene: Scene) -> int:
    """Return the index of the body that attracts; the first of all where none does."""
    gm = attraction(scene)
    return max(range(len(gm)), key=gm.__getitem__)


def no_satellites(scene: Scene) -> Iterator[str]:
    """Yield why the scene is not one planet at rest with bodies that attract nothing, one reason a part."""
    gm = attraction(scene)
    planet = scene.bodies[planet_of(scene)]
    attracting = [body.name for body, each in zip(scene.bodies, gm, strict=True) if each > 0.0]
    if len(attracting) > 1:
        yield f"{', '.join(attracting)} attract: here one planet attracts, and satellites attract nothing"
    elif any((*planet.position, *planet.velocity)):
        yield f"{planet.name!r} is at {planet.position} and moves by {planet.velocity}; it must rest in the origin"
    if any(scene.gravity):
        yield f"gravity = {scene.gravity}: no uniform field acts between satellites and planet"
    for load in scene.loads:
        if isinstance(load, Oblateness):
            if load.body != planet.name:
                yield f"oblateness {load.name!r}: {load.body!r} does not attract"
            if load.pole != "fixed" or load.axis != (0.0, 0.0, 1.0):
                yield f"oblateness {load.name!r}: the planet's pole must be the fixed z axis"
        if isinstance(load, Drag) and load.planet != planet.name:
            yield f"drag {load.name!r}: {load.planet!r} is not the planet"
        if isinstance(load, ThirdBody | RadiationPressure):
            yield f"{load.type} {load.name!r}: the places of Sun and Moon would be messages, held through a step"
    yield from contradictions(scene)


def unsupported(scene: Scene, engine: str, j2_alone: bool = False) -> list[str]:
    """Return why an engine of free particles with fixed poles cannot run a scene; `j2_alone` about z, perhaps."""
    known = "J2 about a fixed z axis" if j2_alone else "fixed poles"
    reasons = [
        f"oblateness {load.name!r}: {engine} supports {known} alone"
        for load in scene.loads
        if isinstance(load, Oblateness)
        and (load.pole != "fixed" or (j2_alone and (load.axis != (0.0, 0.0, 1.0) or any(load.zonal[1:]))))
    ]
    if any(scene.gravity):
        reasons.append(f"gravity = {scene.gravity}: {engine} does not yet support a uniform field")
    return reasons + contradictions(scene)


def contradictions(scene: Scene) -> list[str]:
    """Return what compiling particles refuses: coincident bodies, which give NaN, and parts that contradict others."""
    try:
        compile_scene(scene)
    except ValueError as error:
        return [str(error)]
    return []


def normalized_zonals(zonal: tuple[float, ...]) -> list[float]:
    """Return the fully normalized C_n0 of n = 0, 1, 2, ...: -J_n / sqrt(2 n + 1) (Vallado 2013, eq 8-22)."""
    return [1.0, 0.0, *(-j / math.sqrt(2 * n + 1) for n, j in enumerate(zonal, start=2))]
