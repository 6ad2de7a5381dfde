"""Values with their first two derivatives by one parameter, in any precision, complex numbers included."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Jet:
    """A function of one parameter at a point: value, first and second derivative, scalars or arrays."""

    value: Any
    first: Any
    second: Any

    def __add__(self, other) -> "Jet":
        o = lift(other)
        return Jet(self.value + o.value, self.first + o.first, self.second + o.second)

    def __neg__(self) -> "Jet":
        return Jet(-self.value, -self.first, -self.second)

    def __sub__(self, other) -> "Jet":
        return self + -lift(other)

    def __mul__(self, other) -> "Jet":
        return bilinear(np.multiply, self, other)

    def __matmul__(self, other) -> "Jet":
        return bilinear(np.matmul, self, other)

    __radd__, __rmul__ = __add__, __mul__
    __array_ufunc__ = None  # an array times a jet is the jet's business

    def __getitem__(self, key) -> "Jet":
        return Jet(self.value[key], self.first[key], self.second[key])


def lift(x) -> Jet:
    """Return x as a jet; a constant has no derivatives."""
    return x if isinstance(x, Jet) else Jet(x, 0 * x, 0 * x)


def parameter(x) -> Jet:
    """Return the parameter itself at x."""
    return Jet(x, 0 * x + 1, 0 * x)


def bilinear(product, a, b) -> Jet:
    """Return a product by Leibniz' rule."""
    a, b = lift(a), lift(b)
    second = product(a.second, b.value) + 2 * product(a.first, b.first) + product(a.value, b.second)
    return Jet(product(a.value, b.value), product(a.first, b.value) + product(a.value, b.first), second)


def _chain(f, d, dd, x: Jet) -> Jet:
    return Jet(f, d * x.first, dd * x.first**2 + d * x.second)


def sin(x: Jet) -> Jet:
    s, c = np.sin(x.value), np.cos(x.value)
    return _chain(s, c, -s, x)


def cos(x: Jet) -> Jet:
    s, c = np.sin(x.value), np.cos(x.value)
    return _chain(c, -s, -c, x)


def sqrt(x: Jet) -> Jet:
    root = np.sqrt(x.value)
    return _chain(root, 0.5 / root, -0.25 / root**3, x)


def reciprocal(x: Jet) -> Jet:
    return _chain(1 / x.value, -1 / x.value**2, 2 / x.value**3, x)


def arcsin(x: Jet) -> Jet:
    root = np.sqrt(1 - x.value**2)
    return _chain(np.arcsin(x.value), 1 / root, x.value / root**3, x)


def arctan(x: Jet) -> Jet:
    square = 1 + x.value**2
    return _chain(np.arctan(x.value), 1 / square, -2 * x.value / square**2, x)


def cross(a, b) -> Jet:
    return bilinear(_cross, a, b)


def _cross(a, b):
    return a[[1, 2, 0]] * b[[2, 0, 1]] - a[[2, 0, 1]] * b[[1, 2, 0]]  # NumPy's takes ten times as long


def unit(a: Jet) -> Jet:
    """Return a / |a| without a norm that complex numbers would conjugate."""
    square = a * a
    return a * reciprocal(sqrt(Jet(square.value.sum(), square.first.sum(), square.second.sum())))


def stack(parts: list[Jet], axis: int = 0) -> Jet:
    return Jet(*(np.stack([getattr(p, key) for p in parts], axis) for key in ("value", "first", "second")))


def turn(axis, angle: Jet) -> Jet:
    """Return the rotation matrix about a unit axis by an angle (Rodrigues)."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    s, c = sin(angle), cos(angle)
    value, first, second = (getattr(s, key) * k - getattr(c, key) * (k @ k) for key in ("value", "first", "second"))
    return Jet(np.eye(3) + k @ k + value, first, second)
