"""Particles under gravity, converged: written once more in extended precision, and solved by extrapolation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cross_checks.certify.extrapolation import extrapolate
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Epoch, Newton, Oblateness, RadiationPressure
from mbs_ref.scene.units import attraction, free_fall_time, tolerance_unit, unit_length
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

LONGEST = 4000.0  # free-fall times (600 revolutions): beyond, the second solution takes minutes
FINEST = Settings(method="gauss", rtol=1e-18, estimate="off")
STEP_IN_SHADOW = 1.0 / 400.0  # free-fall times, 2 s in a low orbit: the penumbra takes 8 s
UNLIKE_RTOL = 1e-14  # of the second method where forces are not written twice


@dataclass(frozen=True)
class Units:
    """Length and time in which the motion is of size one."""

    length: float  # m
    time: float  # s


def converge(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the motion by Gauss-Legendre collocation and by a method of another kind; their gap is the error bar.

    Under Newton's gravity and fixed zonal fields the other is extrapolation in extended precision, with the
    forces written anew, and it is believed; with other forces it is DOP853 on the same forces.
    """
    units = Units(unit_length(scene), free_fall_time(scene))
    longest = LONGEST * units.time
    if float(times[-1]) > longest:
        return NoTruth(f"the truth is converged up to {longest:.3g} s, and this run ends at {times[-1]:.3g} s")
    grid = times if times[0] == 0.0 else np.concatenate(([0.0], times))
    first = simulate(scene, FINEST, grid)
    if not first.ok:
        return NoTruth(f"no solution to compare with: {first.message}")
    if all(_is_written_twice(load) for load in scene.loads):
        best, other = _extended(scene, grid, units), first.position
        how = "Gauss-Legendre of order 16, and extrapolation in extended precision with the forces written anew"
    else:
        second = simulate(scene, _unlike(scene, units), grid)
        if not second.ok:
            return NoTruth(f"the second solution failed: {second.message}")
        best, other, how = first.position, second.position, "Gauss-Legendre of order 16, and DOP853 on the same forces"
    gap = float(np.abs(best - other).max())
    uncertainty = gap + float(np.spacing(float(np.abs(best).max())))
    kept = best[len(grid) - len(times) :].astype(float)
    return Truth(kept, _unturned(kept), uncertainty, "converged", f"{how}, which differ by {gap:.1e} m", gap)


def _unlike(scene: Scene, units: Units) -> Settings:
    """Return DOP853's settings; its error control does not notice the edge of a shadow, small steps resolve it."""
    if any(isinstance(load, RadiationPressure) for load in scene.loads):
        return Settings(method="dop853", step=STEP_IN_SHADOW * units.time, estimate="off")
    return Settings(method="dop853", rtol=UNLIKE_RTOL, atol=UNLIKE_RTOL * tolerance_unit(scene), estimate="off")


def _unturned(position: np.ndarray) -> np.ndarray:
    """Return the Euler parameters (n_t, n_bodies, 4) of bodies that do not turn."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (*position.shape[:2], 1))


def _is_written_twice(load: Any) -> bool:
    return isinstance(load, Newton | Epoch) or (isinstance(load, Oblateness) and load.pole == "fixed")


def _extended(scene: Scene, times: np.ndarray, units: Units) -> np.ndarray:
    """Return positions (n_t, n_bodies, 3), m, in extended precision."""
    real = np.longdouble
    length, time = real(units.length), real(units.time)
    place = np.array([body.position for body in scene.bodies], dtype=real) / length
    rate = np.array([body.velocity for body in scene.bodies], dtype=real) * (time / length)
    gm = np.array(attraction(scene), dtype=real) * time**2 / length**3
    fields = [_zonal(scene, load, gm, length) for load in scene.loads if isinstance(load, Oblateness)]
    uniform = np.array(scene.gravity, dtype=real) * time**2 / length

    def derivative(t: Any, y: np.ndarray) -> np.ndarray:
        x, v = y.reshape(2, -1, 3)
        pull = sum((field(x) for field in fields), _newton(gm, x) + uniform)
        return np.concatenate((v.ravel(), pull.ravel()))

    start = np.concatenate((place.ravel(), rate.ravel()))
    tolerance = 64 * float(np.finfo(real).eps)
    states = extrapolate(derivative, start, times.astype(real) / time, tolerance)
    return states[:, : start.size // 2].reshape(len(times), -1, 3) * length


def _newton(gm: np.ndarray, x: np.ndarray) -> np.ndarray:
    apart = x[None, :, :] - x[:, None, :]  # [i, j] from i to j
    square = np.sum(apart**2, axis=2)
    np.fill_diagonal(square, 1.0)
    return np.einsum("j,ij,ijk->ik", gm, square ** (x.dtype.type(-3) / 2), apart)


def _zonal(scene: Scene, load: Oblateness, gm: np.ndarray, length: Any) -> Callable[[np.ndarray], np.ndarray]:
    """Return the field whose potential is gm / r sum J_n (R/r)^n P_n(s), s the sine of the latitude.

    Its gradient is taken along the radius and along the meridian (Montenbruck and Gill 2000, sec. 3.2.1).
    """
    i = scene.body_index(load.body)
    axis = np.array(load.axis, dtype=gm.dtype)
    axis = axis / np.sqrt(np.sum(axis**2))
    basis = [np.polynomial.legendre.Legendre.basis(n + 2) for n in range(len(load.zonal))]
    powers = [b.convert(kind=np.polynomial.Polynomial).coef.astype(gm.dtype) for b in basis]
    radius = gm.dtype.type(load.radius) / length

    def field(x: np.ndarray) -> np.ndarray:
        pull = np.zeros_like(x)
        for j in range(len(gm)):
            if j == i:
                continue
            d = x[j] - x[i]
            r = np.sqrt(np.sum(d**2))
            up = d / r
            s = up @ axis
            for n, (harmonic, p) in enumerate(zip(load.zonal, powers, strict=True), start=2):
                share = harmonic * (radius / r) ** n / r**2
                value = np.polynomial.polynomial.polyval(s, p)
                slope = np.polynomial.polynomial.polyval(s, p[1:] * np.arange(1, len(p)))
                unit = share * ((n + 1) * value * up - slope * (axis - s * up))
                pull[j] += gm[i] * unit
                pull[i] -= gm[j] * unit
        return pull

    return field
