"""Particles compiled for Taylor series."""

import itertools
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np

from mbs_ref.kernels.algebra.lanes import WIDTH, in_one_room
from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.border.handles import make_handle
from mbs_ref.kernels.particles import series as arrays
from mbs_ref.kernels.particles.series import SQUARED, ExpandedOrbits, OrbitGroups, Orbits
from mbs_ref.kernels.series import MAX_ORDER
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Epoch, Newton, Oblateness


def no_orbit_series(scene: Scene) -> Iterator[str]:
    """Yield why Taylor series of the motion of particles are not available."""
    axes = set()
    for load in scene.loads:
        if isinstance(load, Oblateness):
            axes.add(load.axis)
            if load.pole != "fixed" or any(load.zonal[1:]):
                yield f"{load.name!r} has a pole that precesses, or harmonics beyond J2"
        elif not isinstance(load, Newton | Epoch):
            yield f"{load.name!r} is a {load.type}"
    if len(axes) > 1:
        yield "bodies are oblate along different axes"


def attracting_pairs(gm: Sequence[float]) -> list[tuple[int, int]]:
    """Return the pairs of bodies of which one attracts the other."""
    return [(i, j) for i, j in itertools.combinations(range(len(gm)), 2) if gm[i] or gm[j]]


class OrbitSeries:
    """The pairs of particles that attract each other, and the arrays of their series."""

    def __init__(self, system: Any) -> None:
        self.system: Any = system
        particles, zonals = system.groups.particles, system.groups.zonals
        n, gm, bulge = len(particles.gm), particles.gm, np.zeros(len(particles.gm))
        np.add.at(bulge, zonals.body, 1.5 * zonals.harmonic[:, 0] * zonals.radius**2)
        axis = zonals.axis[0] / np.linalg.norm(zonals.axis[0]) if len(zonals.axis) else np.zeros(3)
        pairs = attracting_pairs(gm)
        first, second = np.ascontiguousarray(np.array(pairs, dtype=np.int64).reshape(-1, 2).T)
        lengths = {"n": n, "pairs": len(pairs), "orders": MAX_ORDER + 2, "WIDTH": WIDTH}
        given = empty(Orbits, **lengths)._replace(
            gm=gm, radius=particles.radius, first=first, second=second,
            bulge=bulge[first] + bulge[second], fixed=_fixed(axis, particles.gravity),
            falls=(np.count_nonzero(gm) > (gm > 0.0)).astype(np.int64), atol=np.full((n, 2, WIDTH), np.inf),
        )  # fmt: skip
        self.series = in_one_room(given)
        self._groups = OrbitGroups(self.series)
        self._handle = make_handle(self._groups)
        self.handle = ExpandedOrbits(self._handle.ctypes.data)


@cache
def _powers() -> np.ndarray:
    """Return the numbers of each lane that no scene changes."""
    rows = np.zeros((7, WIDTH))
    rows[arrays.IN_SQUARED, SQUARED], rows[arrays.RISE] = 1.0, arrays.EXPONENTS + 1.0
    for row, exponent in ((arrays.CUBE, -1.5), (arrays.FIFTH, -2.5), (arrays.SEVENTH, -3.5)):
        rows[row] = exponent == arrays.EXPONENTS
    return rows


def _fixed(axis: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """Return the numbers of each lane."""
    rows = _powers().copy()
    rows[arrays.POLE, :5], rows[arrays.GRAVITY, :5] = (*axis, 1.0, 1.0), (*gravity, *(gravity @ axis,) * 2)
    return rows
