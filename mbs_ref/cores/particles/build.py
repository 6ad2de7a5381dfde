"""Scene -> ParticleGroups: the arrays of the fields a scene of particles uses."""

from typing import Any, get_args

import numpy as np

from mbs_ref.kernels.border.groups import floats, ints
from mbs_ref.kernels.particles import model as arrays
from mbs_ref.scene import Scene, celestial

_FORMS = {"central": 1, "eih": 2}
_SOURCES = {"sun": 0, "moon": 1}


def build_particles(scene: Scene) -> arrays.ParticleGroups:
    """Compile a scene of particles; ValueError where a part contradicts another."""
    place = scene.body_index
    by_kind: dict[type, list[Any]] = {kind: [] for kind in get_args(celestial.CelestialLoad)}
    for load in scene.loads:
        by_kind[type(load)].append(load)
    zonals, figures, tides = by_kind[celestial.Oblateness], by_kind[celestial.LunarFigure], by_kind[celestial.Tide]
    third, lights = by_kind[celestial.ThirdBody], by_kind[celestial.RadiationPressure]
    drags = [*by_kind[celestial.Drag], *by_kind[celestial.StandardDrag]]
    relativity = _at_most_one(by_kind[celestial.Relativity])
    return arrays.ParticleGroups(
        particles=_particles(scene, by_kind),
        relativity=arrays.RelativityArrays(
            ints([_FORMS[relativity.form] if relativity else 0]), floats([relativity.c**-2 if relativity else 0.0])
        ),
        zonals=arrays.Zonals(
            ints([place(x.body) for x in zonals]), floats([x.radius for x in zonals]),
            floats([(*x.zonal, *(0.0,) * (5 - len(x.zonal))) for x in zonals], 5),
            ints([int(x.pole != "fixed") for x in zonals]), floats([x.axis for x in zonals], 3),
        ),
        figures=arrays.Figures(
            ints([place(x.body) for x in figures]), floats([x.radius for x in figures]),
            floats([x.j2 for x in figures]), floats([x.c22 for x in figures]),
        ),
        tides=arrays.Tides(
            ints([place(x.body) for x in tides]), ints([place(x.raiser) for x in tides]),
            floats([x.radius for x in tides]), floats([x.love_number for x in tides]),
            floats([x.lag for x in tides]), floats([x.spin for x in tides], 3),
        ),
        points=_ring(by_kind[celestial.Ring]),
        third_bodies=arrays.ThirdBodies(
            ints([place(x.body) for x in third]), ints([_SOURCES[x.source] for x in third]),
            floats([x.gm for x in third]),
        ),
        drags=arrays.Drags(
            ints([place(x.body) for x in drags]), ints([place(x.planet) for x in drags]),
            ints([arrays.STANDARD if isinstance(x, celestial.StandardDrag) else arrays.EXPONENTIAL for x in drags]),
            floats([(x.coefficient, *_profile(x), x.radius, x.spin) for x in drags], 6),
        ),
        lights=arrays.Lights(
            ints([place(x.body) for x in lights]), ints([place(x.planet) for x in lights]),
            floats([(x.coefficient, x.radius, x.pressure) for x in lights], 3),
        ),
    )  # fmt: skip


def _profile(drag: celestial.Drag | celestial.StandardDrag) -> tuple[float, float, float]:
    """Return density, altitude and scale height of an exponential atmosphere; the standard one has its own numbers."""
    if isinstance(drag, celestial.StandardDrag):
        return 0.0, 0.0, 1.0
    return drag.density, drag.altitude, drag.scale_height


def _at_most_one(parts: list[Any]) -> Any:
    if len(parts) > 1:
        raise ValueError(f"loads {', '.join(repr(p.name) for p in parts)} are all of type {parts[0].type}; give one")
    return parts[0] if parts else None


def _particles(scene: Scene, by_kind: dict[type, list[Any]]) -> arrays.Particles:
    n = len(scene.bodies)
    newton, epoch = _at_most_one(by_kind[celestial.Newton]), _at_most_one(by_kind[celestial.Epoch])
    gm = np.array(newton.gm if newton else np.zeros(n), dtype=float)
    radius = np.array(newton.radius if newton and newton.radius else np.zeros(n), dtype=float)
    if len(gm) != n or len(radius) != n:
        got = f"{len(gm)}, {len(radius)}"
        raise ValueError(f"load {newton.name!r}: gm and radius need {n} entries, one a body; got {got}")
    velocity = (celestial.Relativity, celestial.Tide, celestial.Drag, celestial.StandardDrag)
    seconds = (epoch.jd_tdb - celestial.J2000_JD) * celestial.DAY_S if epoch else 0.0
    return arrays.Particles(
        gm, radius, np.array(scene.gravity, dtype=float), np.array([seconds]),
        ints([int(any(by_kind[kind] for kind in velocity))]),
    )  # fmt: skip


def _ring(parts: list[Any]) -> arrays.Points:
    places = [_circle(part) for part in parts]
    return arrays.Points(
        floats([part.gm / part.count for part in parts for _ in range(part.count)]),
        np.concatenate([np.zeros((0, 3)), *places]),
    )


def _circle(part: celestial.Ring) -> np.ndarray:
    normal = np.array(part.normal) / np.linalg.norm(part.normal)
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    angle = 2.0 * np.pi * np.arange(part.count) / part.count
    return part.radius * (np.outer(np.cos(angle), first) + np.outer(np.sin(angle), np.cross(normal, first)))
