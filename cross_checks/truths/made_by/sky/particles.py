"""The motion of particles under all celestial forces of a scene, converged."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from cross_checks.truths.made_by.numerics.solvers import collocate, extrapolate
from cross_checks.truths.made_by.sky import Field, gravity, real, satellites
from cross_checks.truths.made_by.sky.satellites import NoAirError
from cross_checks.truths.truth import ALIKE, NoTruth, Truth, unturned
from mbs_ref.scene import Scene, celestial
from mbs_ref.scene.celestial import Newton
from mbs_ref.scene.scales import free_fall_time, unit_length

# what each part of mbs_ref.scene.celestial does; Newton's gravity acts among all, and an epoch is a date
FIELDS: dict[type, Callable[[Scene, Any], Field]] = {
    celestial.Newton: gravity.newton, celestial.Relativity: gravity.post_newtonian,
    celestial.Oblateness: gravity.zonal_harmonics, celestial.LunarFigure: gravity.lunar_figure,
    celestial.Tide: gravity.lagging_tide, celestial.Ring: gravity.fixed_ring,
    celestial.ThirdBody: satellites.third_body, celestial.Drag: satellites.drag,
    celestial.StandardDrag: satellites.standard_drag, celestial.RadiationPressure: satellites.sunlight,
}  # fmt: skip


def acceleration(scene: Scene) -> Field:
    """Return the field of all loads of a celestial scene and its uniform gravity."""
    parts = [FIELDS[type(load)](scene, load) for load in scene.loads if type(load) is not celestial.Epoch]
    uniform = real(scene.gravity)

    def total(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return sum((part(t, x, v) for part in parts), np.broadcast_to(uniform, x.shape))

    return total


LONGEST = 4000.0  # free-fall times (600 revolutions): beyond, the solutions take minutes
TOLERANCE = 64 * float(np.finfo(np.longdouble).eps)
RATES_DOUBT = 10.0  # times the gap over the free-fall time: what the two leave open of velocities
COSTLY = 1e4  # attracting pairs times free-fall times: half a minute
WAYS = (
    "collocation and extrapolation, both in extended precision, of forces written apart from the solver's, with which "
    "they share the scene's data"
)


@dataclass(frozen=True)
class Units:
    """Length and time in which the motion is of size one."""

    length: np.longdouble  # m
    time: np.longdouble  # s


class CollisionError(ArithmeticError):
    """Two bodies touch."""


def converge(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the motion by extrapolation; the error bar is ALIKE times its gap to collocation at the same tolerance.

    Both know the forces from `made_by.sky`, which shares the scene's data with the solver and no code.
    """
    units = Units(np.longdouble(unit_length(scene)), np.longdouble(free_fall_time(scene)))
    longest = LONGEST * float(units.time)
    if float(times[-1]) > longest:
        return NoTruth(f"the truth is converged up to {longest:.3g} s, and this run ends at {times[-1]:.3g} s")
    grid = times if times[0] == 0.0 else np.concatenate(([0.0], times))
    try:
        best, other, rates = _solve_twice(scene, grid.astype(np.longdouble) / units.time, units)
    except (CollisionError, NoAirError) as error:
        return NoTruth(str(error))
    gap = float(np.linalg.norm(best - other, axis=2).max())
    kept = best[len(grid) - len(times) :].astype(float)
    uncertainty = ALIKE * gap + float(np.spacing(np.abs(kept).max()))
    is_costly = len(scene.bodies) ** 2 / 2 * float(times[-1] / units.time) > COSTLY
    how = f"{WAYS}; the two differ by {gap:.1e} m"
    doubt = RATES_DOUBT * gap / float(units.time) + float(np.spacing(np.abs(rates).max()))
    return Truth(
        kept, unturned(kept), uncertainty, "converged", how, gap, is_costly,
        velocity=rates[len(grid) - len(times) :].astype(float), angular_velocity=np.zeros(kept.shape),
        rate_uncertainty=np.full(len(times), doubt),
    )  # fmt: skip


def _solve_twice(scene: Scene, times: np.ndarray, units: Units) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places (n_t, n_bodies, 3), m, by extrapolation and by collocation, and velocities; `times` in units."""
    place, rate = start(scene)
    place, rate = place / units.length, rate * (units.time / units.length)
    total, speed = acceleration(scene), units.length / units.time

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return total(t * units.time, x * units.length, v * speed) / (units.length / units.time**2)

    def derivative(t: np.longdouble, y: np.ndarray) -> np.ndarray:
        x, v = y.reshape(2, *place.shape)
        return np.concatenate((v.ravel(), field(np.array([t]), x[None], v[None]).ravel()))

    second = collocate(field, place, rate, times, TOLERANCE, _collisions(scene, units))
    states = extrapolate(derivative, np.concatenate((place.ravel(), rate.ravel())), times, TOLERANCE)
    first, rates = (part.reshape(len(times), *place.shape) for part in np.split(states, 2, axis=1))
    return first * units.length, second * units.length, rates * (units.length / units.time)


def start(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n_bodies, 3), m, and velocities, m/s, in extended precision."""
    return real([body.position for body in scene.bodies]), real([body.velocity for body in scene.bodies])


def _collisions(scene: Scene, units: Units) -> Callable[[np.ndarray], None]:
    """Return what raises CollisionError where two bodies are closer than the sum of their radii."""
    radii = next((load.radius for load in scene.loads if isinstance(load, Newton) and load.radius), ())
    pairs = [(i, j, radii[i] + radii[j]) for i, j in combinations(range(len(radii)), 2) if radii[i] + radii[j] > 0.0]

    def watch(places: np.ndarray) -> None:
        for i, j, sum_of_radii in pairs:
            if np.any(np.sum((places[:, j] - places[:, i]) ** 2, axis=-1) < (sum_of_radii / units.length) ** 2):
                raise CollisionError(f"{scene.body_names[i]!r} and {scene.body_names[j]!r} collide, which ends it")

    return watch
