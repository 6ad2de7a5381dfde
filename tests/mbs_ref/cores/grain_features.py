"""What touches among granules, from world poses alone: a second formulation.

The pairs of features and their signs are those of mbs_ref.kernels.rigid.granules, evaluated for all grains at once.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from mbs_ref.scene.base.part import unit
from mbs_ref.scene.contact import Granules
from mbs_ref.scene.euler_parameters import rotation_matrices


class Touching(NamedTuple):
    """What touches at one moment."""

    ends: np.ndarray  # (n, 2) bodies a and b, -1 for a wall
    gap: np.ndarray  # (n,) m
    normal: np.ndarray  # (n, dimension) from b to a
    place: np.ndarray  # (n, dimension) m, of the core of a
    sign: np.ndarray  # (n,) -1 where the force is subtracted


class Shapes:
    """Cores in world axes."""

    def __init__(self, part: Granules, position: np.ndarray, turned: np.ndarray) -> None:
        self.position, self.turned, dimension = position, turned, position.shape[1]
        self.radius, self.half = part.shapes(*position.shape)
        self.reach = self.radius + np.linalg.norm(self.half, axis=1)
        self.extended = self.reach > self.radius
        signs = np.array(list(product((-1.0, 1.0), repeat=dimension)))
        self.is_corner = np.all((self.half[:, None] > 0.0) | (signs < 0.0), axis=2)
        self.corner = position[:, None] + np.einsum("nij,ncj->nci", turned, signs * self.half[:, None])
        first = [np.flatnonzero(signs[:, k] < 0.0) for k in range(dimension)]
        along = np.swapaxes(turned, 1, 2)  # (n, axis, dimension)
        length = [np.where(self.is_corner[:, f], self.half[:, k, None], 0.0) for k, f in enumerate(first)]
        self.length = np.concatenate(length, axis=1)  # (n, edges), half of it
        self.along = np.repeat(along, len(signs) // 2, axis=1)
        self.middle = self.corner[:, np.concatenate(first)] + self.length[..., None] * self.along

    def from_core(self, j: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances (p, c), negative inside, of points (p, c, dimension) from cores j (p,), and directions."""
        y = np.einsum("pij,pci->pcj", self.turned[j], x - self.position[j, None])
        half = self.half[j, None]
        beyond, away = np.abs(y) - half, y - np.clip(y, -half, half)
        distance, most = np.linalg.norm(away, axis=2), beyond.max(axis=2)
        face = np.sign(y) * (beyond == most[..., None])
        inside = most < 0.0
        away = np.where(inside[..., None], face, away / np.maximum(distance, 1e-300)[..., None])
        return np.where(inside, most, distance), np.einsum("pij,pcj->pci", self.turned[j], away)

    def corners(self, i: np.ndarray, j: np.ndarray) -> Touching:
        """Return corners of i (p,) on the cores j."""
        distance, normal = self.from_core(j, self.corner[i])
        gap = distance - (self.radius[i] + self.radius[j])[:, None]
        pair, c = np.nonzero(self.is_corner[i] & (gap < 0.0))
        ends = np.column_stack((i, j))[pair]
        return Touching(ends, gap[pair, c], normal[pair, c], self.corner[i[pair], c], np.ones(len(pair)))

    def points(self, i: np.ndarray, j: np.ndarray, x: np.ndarray, y: np.ndarray, sign: float) -> Touching:
        """Return pairs of points x, y (n, dimension) of cores i, j (n,)."""
        distance = np.linalg.norm(x - y, axis=1)
        gap = distance - self.radius[i] - self.radius[j]
        touch, normal = gap < 0.0, (x - y) / np.maximum(distance, 1e-300)[:, None]
        ends = np.column_stack((i, j))
        return Touching(*(each[touch] for each in (ends, gap, normal, x, np.full(len(i), sign))))

    def both_corners(self, i: np.ndarray, j: np.ndarray) -> Touching:
        """Return corners of i on corners of j, subtracted."""
        pair, c, d = np.nonzero(self.is_corner[i][:, :, None] & self.is_corner[j][:, None])
        return self.points(i[pair], j[pair], self.corner[i[pair], c], self.corner[j[pair], d], -1.0)

    def edges(self, i: np.ndarray, j: np.ndarray) -> list[Touching]:
        """Return edges whose nearest points lie between their ends, and of each the nearest end, subtracted."""
        u, v, g, h = self.along[i], self.along[j], self.length[i][:, :, None], self.length[j][:, None]
        w = self.middle[i][:, :, None] - self.middle[j][:, None]
        c, d, e = np.einsum("pei,pfi->pef", u, v), np.einsum("pei,pefi->pef", u, w), np.einsum("pfi,pefi->pef", v, w)
        sine = np.maximum(1.0 - c * c, 1e-12)
        s, t = (c * e - d) / sine, (e - c * d) / sine
        pair, a, b = np.nonzero((sine > 1e-12) & (np.abs(s) < g) & (np.abs(t) < h))
        c, d, e, g, h, s, t = (each[pair, a, b] for each in np.broadcast_arrays(c, d, e, g, h, s, t))
        i, j, u, v, w = i[pair], j[pair], u[pair, a], v[pair, b], w[pair, a, b]
        m, o = self.middle[i, a], self.middle[j, b]
        found = self.points(i, j, m + s[:, None] * u, o + t[:, None] * v, 1.0)
        touch = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1) < self.radius[i] + self.radius[j]
        inside = self.from_core(found.ends[:, 1], found.place[:, None])[0][:, 0] < 0.0
        depth = -found.gap - self.radius[found.ends].sum(axis=1)  # minus the distance
        gap = np.where(inside, depth - self.radius[found.ends].sum(axis=1), found.gap)
        found = found._replace(gap=gap, normal=np.where(inside[:, None], -1.0, 1.0) * found.normal)
        p = np.stack((-g, g, np.clip(-c * h - d, -g, g), np.clip(c * h - d, -g, g)))
        q = np.stack((np.clip(e - c * g, -h, h), np.clip(e + c * g, -h, h), -h, h))
        x, y = m + p[..., None] * u, o + q[..., None] * v
        nearest = np.argmin(np.linalg.norm(x - y, axis=2), axis=0), np.arange(len(i))
        return [found, self.points(i[touch], j[touch], x[nearest][touch], y[nearest][touch], -1.0)]


def touching_granules(part: Granules, position: np.ndarray, turned: np.ndarray) -> Touching:
    """Return what touches where the centres are at `position` (n, dimension), m, with axes `turned` as columns."""
    from scipy.spatial import KDTree  # a large import for few

    shapes = Shapes(part, position, turned)
    i, j = KDTree(position).query_pairs(2.0 * float(shapes.reach.max()), output_type="ndarray").T
    near = np.linalg.norm(position[i] - position[j], axis=1) < shapes.reach[i] + shapes.reach[j]
    near &= (shapes.radius[i] > 0.0) & (shapes.radius[j] > 0.0)
    i, j = i[near], j[near]
    swapped = shapes.extended[i] & ~shapes.extended[j]  # the point presses on the other core
    i, j = np.where(swapped, j, i), np.where(swapped, i, j)
    both = shapes.extended[i]
    found = [shapes.corners(i, j), shapes.corners(j[both], i[both]), shapes.both_corners(i[both], j[both])]
    found += shapes.edges(i[both], j[both]) if position.shape[1] == 3 else []
    for wall in part.walls:
        normal, own = unit(wall.normal), shapes.is_corner & (shapes.radius > 0.0)[:, None]
        gap = (shapes.corner - wall.point) @ normal - shapes.radius[:, None]
        k, c = np.nonzero(own & (gap < 0.0))
        ends, normals = np.column_stack((k, np.full(len(k), -1))), np.broadcast_to(normal, (len(k), len(normal)))
        found.append(Touching(ends, gap[k, c], normals, shapes.corner[k, c], np.ones(len(k))))
    return Touching(*map(np.concatenate, zip(*found, strict=True)))


def axes_of(orientation: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Return the axes (n, dimension, dimension) of bodies as columns."""
    if centres.shape[1] == 3:
        return rotation_matrices(orientation)
    c, s = np.cos(orientation), np.sin(orientation)
    return np.moveaxis(np.array(((c, -s), (s, c))), -1, 0)
