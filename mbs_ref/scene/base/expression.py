"""A formula in a scene file: read as data, interpreted node by node, never run as Python.

Numbers, + - * / **, brackets, the functions of FUNCTIONS, `pi`, `t` (s), and two bodies' coordinates: a.x, b.angle.
"""

import ast
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

LONGEST = 2000  # characters
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": np.arctan2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "exp": np.exp, "log": np.log,
    "sqrt": np.sqrt, "hypot": np.hypot,
}  # fmt: skip
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda x, y: x + y, ast.Sub: lambda x, y: x - y, ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x / y, ast.Pow: lambda x, y: x**y,
}  # fmt: skip
_CONSTANTS = {"pi": math.pi}
_ENDS = ("a", "b")
Formula = Callable[[Any, Any, Any], Any]  # of t, a, b


class Read(NamedTuple):
    """A formula and the names that it uses: "t", "a.x", ..."""

    formula: Formula
    names: frozenset[str]


def read(text: str) -> Read:
    """Return the formula of a text; ValueError names what is not allowed in it."""
    if len(text) > LONGEST:
        raise ValueError(f"the expression has {len(text)} characters; at most {LONGEST} are read")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ValueError(f"expression = {text!r} cannot be read: {error}") from error
    names: set[str] = set()
    try:
        return Read(_node(tree.body, names), frozenset(names))
    except RecursionError as error:
        raise ValueError("the expression is nested too deeply") from error


def _node(node: ast.expr, names: set[str]) -> Formula:
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            number = _finite(value)
            return lambda t, a, b: number
        case ast.Name(id="t"):
            names.add("t")
            return lambda t, a, b: t
        case ast.Name(id=name) if name in _CONSTANTS:
            return lambda t, a, b: _CONSTANTS[name]
        case ast.Attribute(value=ast.Name(id=end), attr=coordinate) if end in _ENDS:
            names.add(f"{end}.{coordinate}")
            k = _ENDS.index(end)
            return lambda t, *ends: getattr(ends[k], coordinate)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = _node(operand, names)
            return lambda t, a, b: -inner(t, a, b)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _node(operand, names)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            first, second, join = _node(left, names), _node(right, names), _BINARY[type(op)]
            return lambda t, a, b: join(first(t, a, b), second(t, a, b))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            return _call(name, [_node(arg, names) for arg in args])
    allowed = f"numbers, + - * / **, {', '.join(FUNCTIONS)}, pi, t and coordinates such as a.x or b.angle"
    raise ValueError(f"{ast.unparse(node)!r} is not allowed in an expression; allowed: {allowed}")


def _finite(value: int | float) -> float:
    if not abs(value) <= 1e300:
        raise ValueError(f"{value!r} in the expression is too large")
    return float(value)


def _call(name: str, args: list[Formula]) -> Formula:
    function: Any = FUNCTIONS[name]
    if len(args) != function.nin:
        raise ValueError(f"{name} in the expression takes {function.nin} argument(s); it is given {len(args)}")
    return lambda t, a, b: function(*(arg(t, a, b) for arg in args))
