"""The bodies of a scene: planar, point mass, spatial."""

import math
from functools import lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from mbs_ref.scene.base.part import Name, Part, Positive, Vector, Vector3

GROUND = "ground"  # the name that joints and loads use for the world


class PlanarBody(Part):
    """A rigid body in the plane, q = [Rx, Ry, theta] at its centre of mass (Fox 1999 eq 1)."""

    type: Literal["planar"] = "planar"
    name: Name
    mass: Positive  # kg
    inertia: Positive  # kg m^2, about the centre of mass
    position: tuple[float, float] = (0.0, 0.0)  # m, centre of mass at t = 0
    angle: float = 0.0  # rad
    velocity: tuple[float, float] = (0.0, 0.0)  # m/s
    angular_velocity: float = 0.0  # rad/s

    @property
    def gyration_radius(self) -> float:
        """The radius of gyration, m."""
        return math.sqrt(self.inertia / self.mass)


class PointMass(Part):
    """A particle; it has a position and no orientation."""

    type: Literal["point_mass"] = "point_mass"
    name: Name
    mass: Positive  # kg
    position: Vector  # m
    velocity: Vector  # m/s

    @property
    def gyration_radius(self) -> float:
        """A particle has no size."""
        return 0.0


LARGEST_NORM_GAP = 1e-9  # largest |theta^T theta - 1|: data with fewer digits are refused
SMALLEST_INERTIA_RATIO = 1e-9  # of the principal moments: below, double precision cannot hold the small one


def _six_numbers(value: Any) -> Any:
    """Turn a symmetric 3x3 matrix into xx, yy, zz, xy, xz, yz; leave everything else to be checked."""
    if not isinstance(value, list | tuple) or len(value) != 3 or not all(isinstance(r, list | tuple) for r in value):
        return value
    if any(len(row) != 3 for row in value) or any(value[r][c] != value[c][r] for r in range(3) for c in range(r)):
        raise ValueError(f"inertia = {value} is no symmetric 3x3 matrix")
    return (*(value[k][k] for k in range(3)), value[0][1], value[0][2], value[1][2])


Six = tuple[float, float, float, float, float, float]
Inertia = Annotated[Six, BeforeValidator(_six_numbers, json_schema_input_type=Six | tuple[Vector3, Vector3, Vector3])]


class SpatialBody(Part):
    """A rigid body in space, q = [R, theta0..theta3] with its Euler parameters (Fox 1999, appendix).

    theta0 = cos(angle / 2), (theta1, theta2, theta3) = axis sin(angle / 2), turning body axes into world axes.
    """

    type: Literal["spatial"] = "spatial"
    name: Name
    mass: Positive  # kg
    inertia: Inertia  # kg m^2, about the centre of mass, body axes: xx, yy, zz, xy, xz, yz, or the 3x3 matrix
    position: Vector3 = (0.0, 0.0, 0.0)  # m, centre of mass at t = 0
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)  # Euler parameters, of norm 1
    velocity: Vector3 = (0.0, 0.0, 0.0)  # m/s
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)  # rad/s, world axes

    @model_validator(mode="after")
    def _check(self) -> Self:
        norm = math.hypot(*self.orientation)
        if not abs(norm * norm - 1.0) <= LARGEST_NORM_GAP:
            raise ValueError(f"orientation = {self.orientation} has the norm {norm:.12g}; Euler parameters have 1")
        low, middle, high = _principal_moments(self.inertia)
        moments = f"inertia has the principal moments {low:.3g}, {middle:.3g}, {high:.3g} kg m^2"
        if not low > SMALLEST_INERTIA_RATIO * high:
            raise ValueError(f"{moments}; the least must exceed {SMALLEST_INERTIA_RATIO:g} of the greatest")
        if not high <= (low + middle) * (1.0 + 1e-9):
            raise ValueError(f"{moments}; no body has one that exceeds the sum of the others")
        return self

    @property
    def gyration_radius(self) -> float:
        """The largest radius of gyration, m."""
        return math.sqrt(_principal_moments(self.inertia)[-1] / self.mass)

    @property
    def inertia_matrix(self) -> np.ndarray:
        """The inertia (3, 3), kg m^2, body axes."""
        return symmetric(self.inertia)


def symmetric(six: tuple[float, ...]) -> np.ndarray:
    """Return the 3x3 matrix of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@lru_cache(1000)
def _principal_moments(six: tuple[float, ...]) -> tuple[float, ...]:
    """Return the principal moments (3,) of an inertia, kg m^2, the least first."""
    return tuple(np.linalg.eigvalsh(symmetric(six)).tolist())


def sphere_inertia(mass: float, radius: float) -> Inertia:
    """Return the inertia of a uniform sphere: 2/5 m r^2 about every axis."""
    moment = 0.4 * mass * radius**2
    return moment, moment, moment, 0.0, 0.0, 0.0


def block_inertia(mass: float, a: float, b: float, c: float) -> Inertia:
    """Return the inertia of a uniform block with the sides a, b, c (m) along x, y, z."""
    share = mass / 12.0
    return share * (b * b + c * c), share * (a * a + c * c), share * (a * a + b * b), 0.0, 0.0, 0.0


Body = Annotated[PlanarBody | SpatialBody | PointMass, Field(discriminator="type")]
