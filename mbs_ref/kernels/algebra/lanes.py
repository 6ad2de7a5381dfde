"""Numbers of several runs side by side: one arithmetic operation on them is one packed instruction.

To Numba a value of `LANES` is a number like a float: kernels that are written for floats take it as it is, and what
they do with it is an LLVM vector's operation. Arrays of floats (..., WIDTH) are read as arrays of such numbers (...) by
`in_lanes`. A float among them stands for itself in every lane.

Cosine and sine of an angle bring it within pi/4 by multiples of pi/2 that are subtracted in three parts (W. J. Cody,
W. Waite, Software Manual for the Elementary Functions, 1980, ch. 8), then both are polynomials: those of FreeBSD's
k_sin.c and k_cos.c (Sun Microsystems, 1993), whose error is below 2^-58. Up to 1e5 rad both are within 2^-52 of the
truth; beyond, what is lost grows with the angle.
"""

import itertools
import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_cast, models, register_model

from mbs_ref.kernels.border.supplies import intrinsic_of, resolved
from mbs_ref.kernels.jit import bare

WIDTH = 8  # runs side by side: doubles in the widest registers there are
BYTES = 8 * WIDTH
_DOUBLES = ir.VectorType(ir.DoubleType(), WIDTH)
_WORDS = ir.VectorType(ir.IntType(64), WIDTH)
_FLAGS = ("contract",)  # as mbs_ref.kernels.jit has them


class Lanes(types.Type):
    """A number of each of WIDTH runs."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{WIDTH}")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, types.Float | types.Integer) else None


LANES = Lanes()
_intrinsic: Any = intrinsic  # what it makes is called without the typing context
_lower: Any = lower_builtin
_infer: Any = infer_global


@register_model(Lanes)
class _Vector(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _DOUBLES)


def _in_all(builder: Any, value: Any) -> Any:
    """Return a vector that holds a float in every lane."""
    none = ir.Constant(_DOUBLES, ir.Undefined)
    first = builder.insert_element(none, value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _cast(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return _in_all(builder, context.cast(builder, value, given, types.float64))


def _is_number(kind: Any) -> bool:
    return isinstance(kind, Lanes | types.Float | types.Integer)


def _of_lanes(operands: int) -> Callable[[Any, Any, Any], Any]:
    """Return how a function of so many lanes, or lanes among floats, is typed."""

    def typed(self: Any, args: Any, kws: Any) -> Any:
        fits = len(args) == operands and LANES in args and all(map(_is_number, args))
        return signature(LANES, *[LANES] * operands) if fits else None

    return typed


def _teach(name: str, instruction: str, operands: int) -> None:
    """Let an operator take lanes, and lanes among floats."""

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args, flags=_FLAGS)

    for one in {getattr(operator, name), getattr(operator, f"i{name}", getattr(operator, name))}:
        _infer(one)(type(f"_Lanes_{one.__name__}", (AbstractTemplate,), {"generic": _of_lanes(operands)}))
        _lower(one, *[LANES] * operands)(lowered)


for _name, _instruction, _operands in (
    ("add", "fadd", 2), ("sub", "fsub", 2), ("mul", "fmul", 2), ("truediv", "fdiv", 2), ("neg", "fneg", 1),
):  # fmt: skip
    _teach(_name, _instruction, _operands)


def llvm_function(name: str) -> Callable:
    """Return the lowering of a function of one number that LLVM knows by name."""

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(_DOUBLES, [_DOUBLES])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), args)

    return lowered


for _function, _name in ((abs, "fabs"), (np.sqrt, "sqrt"), (math.sqrt, "sqrt")):
    _typed = type(f"_Lanes_{_name}", (AbstractTemplate,), {"generic": _of_lanes(1)})
    _infer(_function)(_typed)
    _lower(_function, LANES)(llvm_function(_name))


@_intrinsic
def nearest_in_lanes(context, x):
    """Return the nearest whole numbers."""
    return LANES(LANES), llvm_function("rint")


def _view(array: Any, number: Any, size: int, axes: int) -> tuple[Any, Any]:
    """Return how an array's memory is seen as numbers of another size (bytes), along one axis more or less."""
    seen = types.Array(number, axes, "C")

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        given = context.make_array(sig.args[0])(context, builder, args[0])
        view = context.make_array(seen)(context, builder)
        ends = (given.shape, WIDTH), (given.strides, size)
        shape, strides = ([*cgutils.unpack_tuple(builder, part), context.get_constant(types.intp, last)][:axes]
                          for part, last in ends)  # fmt: skip
        context.populate_array(
            view, data=builder.bitcast(given.data, view.data.type), meminfo=given.meminfo, parent=given.parent,
            shape=cgutils.pack_array(builder, shape), strides=cgutils.pack_array(builder, strides),
            itemsize=context.get_constant(types.intp, size),
        )  # fmt: skip
        return impl_ret_borrowed(context, builder, seen, view._getvalue())

    return seen(array), lowered


@_intrinsic
def in_lanes(context, array):
    """View an array of floats (..., WIDTH), allocated by `room_for_lanes`, as an array of lanes (...)."""
    return _view(array, LANES, BYTES, array.ndim - 1)


@_intrinsic
def in_floats(context, array):
    """View an array of lanes (...) as an array of floats (..., WIDTH)."""
    return _view(array, types.float64, BYTES // WIDTH, array.ndim + 1)


def room_for_lanes(*shape: int) -> np.ndarray:
    """Return zeros (..., WIDTH) where packed instructions may load and store."""
    count = math.prod(shape) * BYTES
    memory = np.zeros(count + BYTES, np.uint8)
    first = -memory.ctypes.data % BYTES
    return memory[first : first + count].view(np.float64).reshape(*shape, WIDTH)


def aligned(values: np.ndarray) -> np.ndarray:
    """Return a copy of floats (..., WIDTH) where packed instructions may load and store."""
    room = room_for_lanes(*values.shape[:-1])
    room[:] = values
    return room


def in_one_room(group: Any) -> Any:
    """Return a group with its arrays of floats (..., WIDTH) copied where packed instructions may load and store."""
    sizes = [part.size if part.shape[-1] == WIDTH and part.dtype == np.float64 else 0 for part in group]
    room = room_for_lanes(sum(sizes) // WIDTH).ravel()
    places = zip(group, sizes, itertools.accumulate(sizes), strict=True)
    parts = [room[end - size : end].reshape(part.shape) if size else part for part, size, end in places]
    for own, part in zip(parts, group, strict=True):
        if own is not part:
            own[...] = part
    return type(group)(*parts)


@_intrinsic
def turned_by_quarters(context, quarters, sine, cosine):
    """Return cosine and sine of an angle and so many quarter turns, a whole number below 2^51, in each lane."""

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        count, s, c = args
        # added to 1.5 2^52 a whole number stands in the lowest bits of the sum
        number = builder.bitcast(builder.fadd(count, ir.Constant(_DOUBLES, [1.5 * 2.0**52] * WIDTH)), _WORDS)
        odd = builder.icmp_unsigned("!=", builder.and_(number, _word(1)), _word(0))
        beyond = builder.add(number, _word(1))
        cosine = _negated(builder, builder.select(odd, s, c), beyond)
        sine = _negated(builder, builder.select(odd, c, s), number)
        return context.make_tuple(builder, sig.return_type, (cosine, sine))

    return types.UniTuple(LANES, 2)(LANES, LANES, LANES), lowered


def _word(value: int) -> Any:
    return ir.Constant(_WORDS, [value] * WIDTH)


def _negated(builder: Any, value: Any, number: Any) -> Any:
    """Change the sign where a whole number's second bit is set."""
    sign = builder.shl(builder.and_(number, _word(2)), _word(62))
    return builder.bitcast(builder.xor(builder.bitcast(value, _WORDS), sign), _DOUBLES)


def _selected(name: str, order: str, of: Callable[..., tuple[Any, Any]], keeps_nan: bool = False) -> Any:
    """Return the intrinsic of two numbers a and b that is `of` both, the first in lanes where a stands so to b.

    With `keeps_nan` it is the first where a is not a number, too.
    """

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        chosen = builder.fcmp_ordered(order, *args)
        if keeps_nan:
            chosen = builder.or_(chosen, builder.fcmp_unordered("!=", args[0], args[0]))
        return builder.select(chosen, *of(*args))

    def select(context, a, b):
        return LANES(LANES, LANES), lowered

    select.__name__ = name
    return _intrinsic(select)


_ONE, _ZERO = (ir.Constant(_DOUBLES, [value] * WIDTH) for value in (1.0, 0.0))
_larger = _selected("_larger", ">", lambda a, b: (a, b), keeps_nan=True)
_smaller = _selected("_smaller", "<", lambda a, b: (a, b))
_exceeds = _selected("_exceeds", ">", lambda a, b: (_ONE, _ZERO))


def holds_lanes(kind: Any) -> bool:
    """Return whether a Numba type is of lanes, an array of them, a group of such, or a handle to such groups."""
    number = getattr(getattr(kind, "instance_class", None), "NUMBER", None)
    return LANES in (kind, getattr(kind, "dtype", None), number) or any(map(holds_lanes, getattr(kind, "types", ())))


def either(call: str, of_floats: Any, of_lanes: Any) -> Any:
    """Return a function of this name and parameters: the second of two where any holds lanes, else the first."""
    return resolved(call, lambda given: of_lanes if any(map(holds_lanes, given)) else of_floats)


def lane_by_lane(call: str, function: Any) -> Any:
    """Return a function of floats that, of lanes, calls itself for each of them."""

    def of_lanes(typingctx: Any, *given: Any) -> Any:
        inner = typingctx.resolve_value_type(function)
        kind = typingctx.resolve_function_type(inner, (types.float64,) * len(given), {})

        def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            one, result = context.get_function(inner, kind), ir.Constant(_DOUBLES, ir.Undefined)
            context.add_linking_libs(getattr(one, "libs", ()))
            for w in range(WIDTH):
                place = ir.Constant(ir.IntType(32), w)
                own = one(builder, [builder.extract_element(arg, place) for arg in args])
                result = builder.insert_element(result, own, place)
            return result

        return LANES(*[LANES] * len(given)), lowered

    return either(call, function, intrinsic_of(call, of_lanes))


larger = either("larger(a, b)", bare(lambda a, b: a if a > b or a != a else b), _larger)  # a NaN where one is
smaller = either("smaller(a, b)", bare(lambda a, b: a if a < b else b), _smaller)  # b where one is not a number
# Return 1 where a > b, else 0.
exceeds = either("exceeds(a, b)", bare(lambda a, b: 1.0 if a > b else 0.0), _exceeds)


@_intrinsic
def in_every_lane(context, x):
    """Return a float in every lane."""
    return LANES(types.float64), lambda context, builder, sig, args: _in_all(builder, args[0])


# Return zero, of the type of a number.
zero_like = either("zero_like(x)", bare(lambda x: 0.0), bare(lambda x: in_every_lane(0.0)))


@_intrinsic
def lane_of(context, x, w):
    """Return lane w, a float."""

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], builder.trunc(args[1], ir.IntType(32)))

    return types.float64(LANES, types.int64), lowered


@_intrinsic
def largest_of_lanes(context, x):
    """Return the largest lane, a float; infinite where one is not a number."""

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        name = f"llvm.vector.reduce.fmax.v{WIDTH}f64"
        reduce = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.DoubleType(), [_DOUBLES]), name)
        odd = builder.bitcast(builder.fcmp_unordered("uno", args[0], args[0]), ir.IntType(WIDTH))
        infinite = ir.Constant(ir.DoubleType(), float("inf"))
        return builder.select(builder.icmp_unsigned("!=", odd, odd.type(0)), infinite, builder.call(reduce, args))

    return types.float64(LANES), lowered


@_intrinsic
def chosen_in_lanes(context, mark, a, b):
    """Return a in the lanes where the mark is not zero, else b."""

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        zero = ir.Constant(_DOUBLES, [0.0] * WIDTH)
        return builder.select(builder.fcmp_unordered("!=", args[0], zero), args[1], args[2])

    return LANES(LANES, LANES, LANES), lowered


# Return the largest lane, or the float.
largest_of = either("largest_of(x)", bare(lambda x: x), largest_of_lanes)
# Return whether a number is zero, in every lane.
vanishes = either("vanishes(x)", bare(lambda x: x == 0.0), bare(lambda x: largest_of_lanes(abs(x)) == 0.0))


@bare
def take_lane(of, w, to):
    """Copy lane w of an array with two axes to one of floats."""
    every = in_floats(of)
    for i in range(to.shape[0]):
        for c in range(to.shape[1]):
            to[i, c] = every[i, c, w]


@bare
def put_lane(of, w, to):
    """Copy an array of floats with two axes to lane w of another."""
    every = in_floats(to)
    for i in range(of.shape[0]):
        for c in range(of.shape[1]):
            every[i, c, w] = of[i, c]


@bare
def add_lane(of, w, to):
    """Add an array of floats with two axes to lane w of another."""
    every = in_floats(to)
    for i in range(of.shape[0]):
        for c in range(of.shape[1]):
            every[i, c, w] += of[i, c]


QUARTERS = 2.0 / np.pi
# pi/2 in three parts: the first two have 33 bits, so that up to 2^20 multiples of them are exact
QUARTER = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
SINE = (-1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
        2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10)  # fmt: skip
COSINE = (4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
          -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11)  # fmt: skip


@bare
def lanes_cos_sin(angle):
    quarters = nearest_in_lanes(angle * QUARTERS)
    r = ((angle - quarters * QUARTER[0]) - quarters * QUARTER[1]) - quarters * QUARTER[2]
    z = r * r
    s = SINE[2] + z * (SINE[3] + z * (SINE[4] + z * SINE[5]))
    c = COSINE[2] + z * (COSINE[3] + z * (COSINE[4] + z * COSINE[5]))
    sine = r + r * z * (SINE[0] + z * (SINE[1] + z * s))
    cosine = (1.0 - 0.5 * z) + z * z * (COSINE[0] + z * (COSINE[1] + z * c))
    return turned_by_quarters(quarters, sine, cosine)


# Return cosine and sine of an angle (rad).
cos_sin = either("cos_sin(angle)", bare(lambda angle: (np.cos(angle), np.sin(angle))), lanes_cos_sin)
