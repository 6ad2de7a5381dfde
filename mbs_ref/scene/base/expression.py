"""A formula in a scene file: read as data, interpreted node by node, never run as Python.

Numbers, + - * / **, brackets, the functions of FUNCTIONS, `pi`, and the names that a reader of formulas knows.
"""

import ast
import math
from collections.abc import Callable
from functools import lru_cache
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

LONGEST = 2000  # characters
LARGEST = 1e300  # number in an expression
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": np.arctan2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "exp": np.exp, "log": np.log,
    "sqrt": np.sqrt, "hypot": np.hypot,
}  # fmt: skip
OF_NUMBERS = {name: getattr(math, name) for name in FUNCTIONS}  # the same bits on every processor
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda x, y: x + y, ast.Sub: lambda x, y: x - y, ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x / y, ast.Pow: lambda x, y: x**y,
}  # fmt: skip
_CONSTANTS = {"pi": math.pi}
_ENDS = ("a", "b")
Formula = Callable[..., Any]  # of what its names are read from
Leaf = Callable[[str], Formula | None]  # how a name is read; None of an unknown one


class Read(NamedTuple):
    """A formula and the names that it uses: "t", "a.x", ..."""

    formula: Formula
    names: frozenset[str]


def read(text: str) -> Read:
    """Return the formula of t (s) and the coordinates of two bodies; ValueError names what is not allowed in it."""
    return _Reader(text, _of_motion, FUNCTIONS, "t and coordinates such as a.x or b.angle").read()


def evaluate(text: str, known: dict[str, Any]) -> Any:
    """Return the value of a formula of named numbers, or of a name alone, whatever that is.

    ValueError names what is not allowed in it. Numbers are floats, of which no power takes long.
    """
    if text.strip() in known:
        return known[text.strip()]
    formula, names = _of_names(text, tuple(known))
    for name in names:
        if type(known[name]) not in (int, float):
            raise ValueError(f"{name} = {known[name]!r} is no number")
    return formula({name: float(known[name]) for name in names})


@lru_cache(maxsize=10_000)
def _of_names(text: str, names: tuple[str, ...]) -> Read:
    return _Reader(text, lambda name: itemgetter(name) if name in names else None, OF_NUMBERS, ", ".join(names)).read()


def _of_motion(name: str) -> Formula | None:
    end, _, coordinate = name.partition(".")
    if end in _ENDS and coordinate:
        k = _ENDS.index(end)
        return lambda t, *ends: getattr(ends[k], coordinate)
    return (lambda t, a, b: t) if name == "t" else None


class _Reader:
    """Reads the formula of one text."""

    def __init__(self, text: str, leaf: Leaf, functions: dict[str, Callable[..., Any]], allowed: str) -> None:
        self.text, self.leaf, self.functions, self.allowed = text, leaf, functions, allowed
        self.names: set[str] = set()

    def read(self) -> Read:
        if len(self.text) > LONGEST:
            raise ValueError(f"the expression has {len(self.text)} characters; at most {LONGEST} are read")
        try:
            tree = ast.parse(self.text.strip(), mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise ValueError(f"expression = {self.text!r} cannot be read: {error}") from error
        try:
            return Read(self._node(tree.body), frozenset(self.names))
        except RecursionError as error:
            raise ValueError("the expression is nested too deeply") from error

    def _node(self, node: ast.expr) -> Formula:
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                if not abs(value) <= LARGEST:
                    raise ValueError(f"{value!r} in the expression is too large")
                number = float(value)
                return lambda *_: number
            case ast.Name() | ast.Attribute(value=ast.Name()) if of_name := self.leaf(ast.unparse(node)):
                self.names.add(ast.unparse(node))
                return of_name
            case ast.Name(id=name) if name in _CONSTANTS:
                return lambda *_: _CONSTANTS[name]
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self._node(operand)
                return lambda *of: -inner(*of)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self._node(operand)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                first, second, join = self._node(left), self._node(right), _BINARY[type(op)]
                return lambda *of: join(first(*of), second(*of))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in self.functions:
                return self._call(name, [self._node(arg) for arg in args])
        allowed = f"numbers, + - * / **, {', '.join(FUNCTIONS)}, pi, {self.allowed}"
        raise ValueError(f"{ast.unparse(node)!r} is not allowed in an expression; allowed: {allowed}")

    def _call(self, name: str, args: list[Formula]) -> Formula:
        function, takes = self.functions[name], FUNCTIONS[name].nin  # type: ignore[attr-defined]
        if len(args) != takes:
            raise ValueError(f"{name} in the expression takes {takes} argument(s); it is given {len(args)}")
        return lambda *of: function(*(arg(*of) for arg in args))
