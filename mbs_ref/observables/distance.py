"""How far two motions of a scene are apart, and how far one goes, in position, orientation and their rates.

`distances` is the one measure of every verdict, study, check and page. A quantity that is unknown is NaN, never 0: a
particle has no orientation, and a motion may lack rates. `relative` divides by the scene's own length L and time T:
metres by L, m/s by L/T and rad/s by 1/T; radians stay as they are.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.euler_parameters import conjugate, product, rotation_vector, turn_size
from mbs_ref.scene.scales import Scales, scales_of

NAMES = ("position", "orientation", "velocity", "angular velocity")
UNITS = ("m", "rad", "m/s", "rad/s")


class Motion(Protocol):
    """World poses and rates of every body at sample times; None where the motion lacks a quantity."""

    @property
    def position(self) -> np.ndarray | None: ...  # (..., n_t, n_bodies, dimension) m
    @property
    def orientation(self) -> np.ndarray | None: ...  # (..., n_t, n_bodies) rad, or (..., n_t, n_bodies, 4)
    @property
    def velocity(self) -> np.ndarray | None: ...  # (..., n_t, n_bodies, dimension) m/s
    @property
    def angular_velocity(self) -> np.ndarray | None: ...  # (..., n_t, n_bodies) or (..., n_t, n_bodies, 3) rad/s


class Partial(NamedTuple):
    """A motion of which some quantities are known; shapes as in `Motion`."""

    position: np.ndarray | None = None
    orientation: np.ndarray | None = None
    velocity: np.ndarray | None = None
    angular_velocity: np.ndarray | None = None


def distances(scene: Scene, first: Motion, second: Motion, missing: float = np.nan) -> np.ndarray:
    """Return how far two motions are apart (..., n_t, n_bodies, 4): m, rad, m/s, rad/s; NaN where unknown.

    Vectors differ by their Euclidean length and orientations by the angle of the turn between them, in [0, pi]; whole
    turns in the plane do not count. The samples are those that both motions have. An infinite number is infinitely far.
    `missing` replaces every NaN but those of particles' orientations: pass inf for runs, which lack nothing.
    """
    return np.stack(_components(scene, first, second, missing), axis=-1)


def _components(scene: Scene, first: Motion, second: Motion, missing: float) -> list[np.ndarray]:
    """Return the four distances (..., n_t, n_bodies) of `distances`: NumPy reduces long axes alone quickly."""
    particles = [isinstance(body, PointMass) for body in scene.bodies]
    parts = _unmasked_components(first, second, None if all(particles) else not scene.planar)
    for k, part in enumerate(parts):
        unknown = np.isnan(part)
        if unknown.any():
            parts[k] = np.where(unknown, missing, part)
        if k % 2 and any(particles):
            parts[k] = np.where(particles, np.nan, parts[k])
    return parts


def unmasked_distances(first: Motion, second: Motion, in_space: bool | None) -> np.ndarray:
    """Return the distances of any bodies, with those of particles' orientations among them.

    Turns are vectors in space and numbers in the plane; None for particles alone.
    """
    return np.stack(_unmasked_components(first, second, in_space), axis=-1)


def _unmasked_components(first: Motion, second: Motion, in_space: bool | None) -> list[np.ndarray]:
    with np.errstate(all="ignore"):  # overflow is infinitely far
        parts = [
            _size(_between(first.position, second.position, True), True),
            _turn_size(first.orientation, second.orientation, in_space),
            _size(_between(first.velocity, second.velocity, True), True),
            _size(_between(first.angular_velocity, second.angular_velocity, in_space), in_space),
        ]
    shape = next((part.shape for part in parts if part is not None), ())
    return [np.full(shape, np.nan) if part is None else part for part in parts]


def units_of(scales: Scales) -> np.ndarray:
    """Return the unit of each component (4,): m, rad, m/s, rad/s."""
    return np.array([scales.length, 1.0, scales.speed, 1.0 / scales.time])


def largest(sizes: np.ndarray, axis: int | None = None) -> np.ndarray:
    """Return the largest known size over an axis, or over all; NaN where none is known."""
    return np.fmax.reduce(sizes, axis=axis)


def relative(
    scene: Scene, first: Motion, second: Motion, missing: float = np.nan, scales: Scales | None = None
) -> np.ndarray:
    """Return the largest distances over bodies (..., n_t, 4), over the scene's scales."""
    parts = [largest(part, -1) for part in _components(scene, first, second, missing)]
    return np.stack(parts, axis=-1) / units_of(scales or scales_of(scene))


def point_distances(scene: Scene, first: Motion, second: Motion) -> np.ndarray:
    """Return distances of centres of mass, or of points a radius of gyration away if larger: m and m/s (..., 2)."""
    sizes = distances(scene, first, second)
    arms = np.array([[body.gyration_radius] for body in scene.bodies])
    return np.fmax(sizes[..., ::2], arms * sizes[..., 1::2])


def farthest(scene: Scene, first: Motion, second: Motion) -> list[float]:
    """Return the largest distances over samples and bodies: m, rad, m/s, rad/s; NaN where unknown."""
    return largest(distances(scene, first, second).reshape(-1, 4), 0).tolist()


def motion_size(scene: Scene, scales: Scales, run: tuple[np.ndarray, ...], times: np.ndarray) -> np.ndarray:
    """Return how far a motion goes from its start in position and orientation, and its largest rates (..., 4).

    The run is its positions, orientations, velocities and angular velocities. All sizes are over the scene's scales.
    Samples once a period show bodies near their start alone: positions go at least as far as the speeds allow, up to
    the extent of all positions, and bodies turn at least as far as the integral of their rates, up to half a turn.
    """
    position, in_space, steps = run[0], not scene.planar, times[1:] - times[:-1]
    here = (slice(None),) * (position.ndim - 3) + (slice(1),)
    start = (np.broadcast_to(part[here], part.shape) for part in run[:2])
    still = (np.broadcast_to(0.0, part.shape) for part in run[2:])
    parts = _components(scene, Partial(*run), Partial(*start, *still), np.nan)
    with np.errstate(all="ignore"):
        way = np.nansum(steps * np.max(parts[2], axis=-1)[..., 1:], axis=-1)
        finite = [part if np.isfinite(np.max(part)) else np.where(np.isfinite(part), part, 0.0) for part in parts]
        size = np.stack([np.max(part, axis=(-2, -1)) for part in finite], axis=-1)
        rates = run[3] if finite[3] is parts[3] else np.nan_to_num(run[3])
        rates = np.moveaxis(rates, -3, 0) if in_space else np.moveaxis(rates, -2, 0)
        steps = steps.reshape(-1, *(rates.ndim - 1) * (1,))
        turned = np.cumsum(0.5 * (rates[1:] + rates[:-1]) * steps, axis=0)
        turn = np.max(_length(turned) if in_space else np.abs(turned), axis=(0, -1), initial=0.0)
    size[..., 0] = np.maximum(size[..., 0], np.minimum(way, _extent(position)))
    size[..., 1] = np.maximum(size[..., 1], np.minimum(turn, np.pi))
    return size / units_of(scales)


def coordinate_size(scales: Scales, position: np.ndarray) -> float:
    """Return the largest finite coordinate over the scene's length, at least 1: the unit of a relative tolerance."""
    return max(float(np.max(np.abs(position), where=np.isfinite(position), initial=0.0)) / scales.length, 1.0)


def turn_between(first: np.ndarray | None, second: np.ndarray | None, in_space: bool | None) -> np.ndarray | None:
    """Return the turn (rad) from the second to the first orientation over their common samples, None where unknown.

    The shape is (..., n_t, n_bodies), in [-pi, pi), or (..., n_t, n_bodies, 3) in space: rotation vectors, world axes.
    """
    if in_space:
        return _between(first, second, in_space, lambda p, q: rotation_vector(product(p, conjugate(q))))
    return _between(first, second, in_space, _angle_between)


def _turn_size(first: np.ndarray | None, second: np.ndarray | None, in_space: bool | None) -> np.ndarray | None:
    """Return the length of `turn_between`."""
    if in_space:
        return _between(first, second, in_space, lambda p, q: turn_size(product(p, conjugate(q))))
    return _size(turn_between(first, second, in_space), in_space)


def _angle_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the difference of angles (rad) in [-pi, pi); the remainder, which is slow, is for whole turns alone."""
    angle = first - second + np.pi
    return np.remainder(angle, 2.0 * np.pi, out=angle, where=(angle < 0.0) | (angle >= 2.0 * np.pi)) - np.pi


def _between(
    first: np.ndarray | None, second: np.ndarray | None, of_vectors: bool | None, minus: Callable = np.subtract
) -> np.ndarray | None:
    """Return the difference over the common samples; None where one is unknown or lacks Euler parameters."""
    if first is None or second is None or of_vectors is None or first.ndim != second.ndim:
        return None
    rest = (slice(None),) * (2 if of_vectors else 1)
    n = min(part.shape[-1 - len(rest)] for part in (first, second))
    return minus(first[(..., slice(n), *rest)], second[(..., slice(n), *rest)])


def _size(difference: np.ndarray | None, of_vectors: bool | None) -> np.ndarray | None:
    if difference is None:
        return None
    return _length(difference) if of_vectors else np.abs(difference)


def _length(vectors: np.ndarray) -> np.ndarray:
    """Return the length (...,) of vectors (..., n): NumPy sums over a short last axis many times more slowly."""
    total = vectors[..., 0] * vectors[..., 0]
    for k in range(1, vectors.shape[-1]):
        total += vectors[..., k] * vectors[..., k]
    return np.sqrt(total)


def _extent(position: np.ndarray) -> np.ndarray:
    """Return the diagonal (..., m) of the box around all bodies at all times."""
    finite = np.isfinite(position)
    known = finite.all(axis=-1, keepdims=True) if not finite.all() else True  # a mask makes NumPy slow
    low = np.min(np.min(position, axis=-3, where=known, initial=np.inf), axis=-2)
    high = np.max(np.max(position, axis=-3, where=known, initial=-np.inf), axis=-2)
    return _length(np.maximum(high - low, 0.0))
