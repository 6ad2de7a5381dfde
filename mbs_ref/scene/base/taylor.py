"""Numbers with their derivatives, which evaluate a user's own constraint.

f(s) = value + first s + second s^2 / 2 along a motion, and first derivatives along further directions. Rounding aside
the derivatives are exact. Source: Griewank and Walther, Evaluating Derivatives (2nd ed., 2008), table 13.2.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin


class Taylor(NDArrayOperatorsMixin):
    """A number with its derivatives. NumPy's functions and arithmetic take it; comparisons look at the value.

    Python's `math` does not: it would drop the derivatives, and raises a TypeError instead.
    """

    __slots__ = ("first", "second", "value")

    def __init__(self, value: float, first: np.ndarray, second: float) -> None:
        self.value = value
        self.first = first  # (n_directions,); entry 0 along the motion
        self.second = second  # along the motion

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        out = options.pop("out", None)
        if method != "__call__" or options or ufunc.nout != 1:
            return NotImplemented
        result = self._answer(ufunc, inputs)
        if out is None:
            return result
        out[0][...] = result  # as np.cross requires
        return out[0]

    def _answer(self, ufunc: np.ufunc, inputs: tuple[Any, ...]) -> Any:
        if any(isinstance(x, np.ndarray) and x.ndim for x in inputs):
            return np.frompyfunc(ufunc, ufunc.nin, 1)(*map(_boxed, inputs))
        if ufunc.__name__ in COMPARISONS:
            return ufunc(*(_parts(x)[0] for x in inputs))
        if ufunc.__name__ in UNARY:
            return _chain(ufunc.__name__, inputs[0])
        return BINARY[ufunc.__name__](*inputs) if ufunc.__name__ in BINARY else NotImplemented

    def __repr__(self) -> str:
        return f"Taylor({self.value!r}, first={self.first!r}, second={self.second!r})"


def _boxed(x: Any) -> Any:
    """Return a number as an array of objects, whose elements NumPy then takes one by one."""
    box = np.empty((), dtype=object)
    box[()] = x
    return box if isinstance(x, Taylor) else x


def _parts(x: Any) -> tuple[float, Any, float]:
    return (x.value, x.first, x.second) if isinstance(x, Taylor) else (float(x), 0.0, 0.0)


def _along(first: Any) -> float:
    """Return the derivative along the motion."""
    return float(first[0]) if isinstance(first, np.ndarray) else 0.0


def add(x: Any, y: Any) -> Taylor:
    (a, a1, a2), (b, b1, b2) = _parts(x), _parts(y)
    return Taylor(a + b, a1 + b1, a2 + b2)


def subtract(x: Any, y: Any) -> Taylor:
    (a, a1, a2), (b, b1, b2) = _parts(x), _parts(y)
    return Taylor(a - b, a1 - b1, a2 - b2)


def multiply(x: Any, y: Any) -> Taylor:
    (a, a1, a2), (b, b1, b2) = _parts(x), _parts(y)
    return Taylor(a * b, a1 * b + a * b1, a2 * b + 2.0 * _along(a1) * _along(b1) + a * b2)


def divide(x: Any, y: Any) -> Taylor:
    return multiply(x, power(y, -1.0) if isinstance(y, Taylor) else 1.0 / float(y))


def power(x: Any, y: Any) -> Taylor:
    """x^y; where the exponent has derivatives, too, exp(y log x) with x > 0."""
    if isinstance(y, Taylor):
        return _chain("exp", multiply(y, _chain("log", x) if isinstance(x, Taylor) else math.log(x)))
    a, n = x.value, float(y)
    slope = n * a ** (n - 1.0) if n else 0.0
    bend = n * (n - 1.0) * a ** (n - 2.0) if n * (n - 1.0) else 0.0
    return _composed(x, a**n, slope, bend)


def hypot(x: Any, y: Any) -> Taylor:
    return power(add(multiply(x, x), multiply(y, y)), 0.5)


def arctan2(y: Any, x: Any) -> Taylor:
    (b, b1, b2), (a, a1, a2) = _parts(y), _parts(x)
    square = a * a + b * b
    across, radial = a * _along(b1) - b * _along(a1), a * _along(a1) + b * _along(b1)
    second = (a * b2 - b * a2) / square - 2.0 * across * radial / square**2
    return Taylor(math.atan2(b, a), (a * b1 - b * a1) / square, second)


def _composed(x: Taylor, value: float, slope: float, bend: float) -> Taylor:
    """Return f(x) where f, f' and f'' have these values."""
    return Taylor(value, slope * x.first, slope * x.second + bend * _along(x.first) ** 2)


def _chain(name: str, x: Taylor) -> Taylor:
    return _composed(x, *UNARY[name](x.value))


def _arcsin(x: float, sign: float, value: float) -> tuple[float, float, float]:
    return value, sign / math.sqrt(1.0 - x * x), sign * x / (1.0 - x * x) ** 1.5


def _tangent(value: float, sign: float) -> tuple[float, float, float]:
    """tan has f' = 1 + f^2, tanh f' = 1 - f^2."""
    slope = 1.0 + sign * value * value
    return value, slope, sign * 2.0 * value * slope


UNARY: dict[str, Callable[[float], tuple[float, float, float]]] = {  # f, f', f''
    "sin": lambda x: (math.sin(x), math.cos(x), -math.sin(x)),
    "cos": lambda x: (math.cos(x), -math.sin(x), -math.cos(x)),
    "tan": lambda x: _tangent(math.tan(x), 1.0),
    "arcsin": lambda x: _arcsin(x, 1.0, math.asin(x)),
    "arccos": lambda x: _arcsin(x, -1.0, math.acos(x)),
    "arctan": lambda x: (math.atan(x), 1.0 / (1.0 + x * x), -2.0 * x / (1.0 + x * x) ** 2),
    "sinh": lambda x: (math.sinh(x), math.cosh(x), math.sinh(x)),
    "cosh": lambda x: (math.cosh(x), math.sinh(x), math.cosh(x)),
    "tanh": lambda x: _tangent(math.tanh(x), -1.0),
    "exp": lambda x: (math.exp(x), math.exp(x), math.exp(x)),
    "log": lambda x: (math.log(x), 1.0 / x, -1.0 / x**2),
    "sqrt": lambda x: (math.sqrt(x), 0.5 / math.sqrt(x), -0.25 / x**1.5),
    "square": lambda x: (x * x, 2.0 * x, 2.0),
    "negative": lambda x: (-x, -1.0, 0.0),
    "positive": lambda x: (x, 1.0, 0.0),
    "absolute": lambda x: (abs(x), math.copysign(1.0, x), 0.0),
}
BINARY: dict[str, Callable[[Any, Any], Taylor]] = {
    "add": add, "subtract": subtract, "multiply": multiply, "divide": divide, "power": power, "float_power": power,
    "hypot": hypot, "arctan2": arctan2,
}  # fmt: skip
COMPARISONS = {"less", "less_equal", "greater", "greater_equal", "equal", "not_equal", "isfinite"}


# NumPy calls these methods of an object array's elements
for _name in ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"):
    setattr(Taylor, _name, lambda self, name=_name: _chain(name, self))
