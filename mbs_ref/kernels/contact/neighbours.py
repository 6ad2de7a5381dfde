"""Neighbours among many grains, each in a sphere: pairs whose gap is within a skin, by a grid of hashed cells.

A cell is as wide as the largest reach of a pair, so that the neighbours of a sphere lie in its own cell and in those
around it. The list holds until some sphere is half of the skin away from where it was when the list was built: until
then no pair that is left out can touch. Pairs are in ascending order, so that forces, and the order of their sums, are
what they would be if all pairs were looked at.
"""

from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rows import copy_rows

PRIMES = (73856093, 19349663, 83492791)  # of the hash of a cell (Teschner et al., VMV 2003, sec. 4.1)


class Granules(NamedTuple):
    """Rounded cores that may all touch one another and fixed walls, by one law; and the list of near pairs."""

    body: Annotated[Ints, "n"]
    radius: Annotated[Floats, "n"]  # m, by which the core is rounded
    half: Annotated[Floats, "n", "dimension"]  # m, half of the core's lengths along the body's axes
    reach: Annotated[Floats, "n"]  # m, radius of the sphere about it; the radius where the core is a point
    unit: Annotated[Floats, "dimension", "dimension"]  # the identity
    axes: Annotated[Floats, "n", "dimension", "dimension"]  # world, of a core that is no point; the core fills them
    normal: Annotated[Floats, "w", "dimension"]  # unit vector, to the free side of each wall
    offset: Annotated[Floats, "w"]  # m, of each wall along its normal
    # one law and one friction, named as in ContactLaws and ContactModes
    stiffness: Annotated[Floats, 1]  # N/m^n
    dashpot: Annotated[Floats, 1]  # N s/m^(m + 1)
    exponent: Annotated[Floats, 1]  # n
    damping_exponent: Annotated[Floats, 1]  # m
    release: Annotated[Ints, 1]  # RELEASE_*
    coefficient: Annotated[Floats, 1]  # mu
    creep: Annotated[Floats, 1]  # m/s, v_s
    skin: Annotated[Floats, 1]  # m
    place: Annotated[Floats, "n", "dimension"]  # m, now; the core fills it
    built: Annotated[Floats, "n", "dimension"]  # m, when the list was built; NaN before
    cell: Annotated[Ints, "n", "dimension"]
    head: Annotated[Ints, "buckets"]  # lowest sphere of each bucket, -1 where it is empty; a power of two
    next: Annotated[Ints, "n"]  # next sphere in the same bucket, -1 at its end
    first: Annotated[Ints, "n + 1"]  # of each sphere, where its neighbours of higher number begin
    near: Annotated[Ints, "most"]
    overflow: Annotated[Ints, 1]  # 1 where the list has no room for all neighbours: then all pairs are looked at


@jit
def _has_moved(grains):
    """Return whether some sphere is more than half of the skin away from where it was when the list was built."""
    allowed = 0.25 * grains.skin[0] * grains.skin[0]
    far = False
    for s in range(grains.place.shape[0]):
        square = 0.0
        for c in range(grains.place.shape[1]):
            d = grains.place[s, c] - grains.built[s, c]
            square += d * d
        far |= not square <= allowed
    return far


@jit
def _bucket(grains, cell):
    """Return the bucket of a cell."""
    mixed = 0
    for c in range(grains.place.shape[1]):
        mixed ^= cell[c] * PRIMES[c]
    return mixed & (grains.head.shape[0] - 1)


@jit
def _fill_cells(grains):
    """Place every sphere in its cell; the list of a bucket is ascending."""
    width = 2.0 * np.max(grains.reach) + grains.skin[0]
    for b in range(grains.head.shape[0]):
        grains.head[b] = -1
    for s in range(grains.place.shape[0] - 1, -1, -1):
        for c in range(grains.place.shape[1]):
            grains.cell[s, c] = int(np.floor(grains.place[s, c] / width))
        b = _bucket(grains, grains.cell[s])
        grains.next[s] = grains.head[b]
        grains.head[b] = s


@jit
def _is_near(grains, i, j, cell):
    """Return whether sphere j lies in a cell and within the skin of sphere i."""
    square = 0.0
    for c in range(grains.place.shape[1]):
        if grains.cell[j, c] != cell[c]:
            return False
        d = grains.place[j, c] - grains.place[i, c]
        square += d * d
    reach = grains.reach[i] + grains.reach[j] + grains.skin[0]
    return square <= reach * reach


@jit
def _insert(grains, start, count, j):
    """Insert j into the ascending list near[start:count]."""
    place = count
    while place > start and grains.near[place - 1] > j:
        grains.near[place] = grains.near[place - 1]
        place -= 1
    grains.near[place] = j


@jit
def _find(grains):
    """List the neighbours of every sphere."""
    dimension = grains.place.shape[1]
    _fill_cells(grains)
    cell = np.empty(dimension, dtype=np.int64)
    count = 0
    grains.overflow[0] = 0
    for i in range(grains.place.shape[0]):
        start = grains.first[i] = count
        for around in range(3**dimension):
            rest = around
            for c in range(dimension):
                cell[c] = grains.cell[i, c] + rest % 3 - 1
                rest //= 3
            j = grains.head[_bucket(grains, cell)]
            while j >= 0:
                if j > i and _is_near(grains, i, j, cell):
                    if count == grains.near.shape[0]:
                        grains.overflow[0] = 1
                        return
                    _insert(grains, start, count, j)
                    count += 1
                j = grains.next[j]
    grains.first[grains.place.shape[0]] = count


@jit
def refresh_neighbours(grains):
    """Rebuild the list where the places have left what it covers."""
    if _has_moved(grains):
        copy_rows(grains.place, grains.built)
        _find(grains)
