"""A pair's attraction and a body's stages at eight instants, in vector instructions: the loops that cost the time.

The compiler does not vectorize them by itself, because it cannot know that the arrays are apart.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from mbs_ref.kernels.particles.model import LANES

_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, LANES)
_CONTRACT = ("contract",)


def _splat(builder, value):
    first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(first, ir.Constant(_VECTOR, ir.Undefined), zeros)


def _lane(builder, array, body, axis):
    """Return a pointer to array[body, axis, :]."""
    word = body.type
    row = builder.add(builder.mul(body, ir.Constant(word, 3)), ir.Constant(word, axis))
    place = builder.gep(array.data, [builder.mul(row, ir.Constant(word, LANES))])
    return builder.bitcast(place, _VECTOR.as_pointer())


def _load(builder, pointer):
    value = builder.load(pointer)
    value.align = 8
    return value


def _add_to(builder, pointer, value):
    store = builder.store(builder.fadd(_load(builder, pointer), value, flags=_CONTRACT), pointer)
    store.align = 8


def _apart(builder, delta, i, j, gap):
    """Return gap + delta[j] - delta[i], a vector an axis."""
    found = []
    for axis in range(3):
        apart = builder.fsub(
            _load(builder, _lane(builder, delta, j, axis)), _load(builder, _lane(builder, delta, i, axis))
        )
        found.append(builder.fadd(_splat(builder, gap[axis]), apart))
    return found


def _root(builder, value):
    root = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_VECTOR, [_VECTOR]), f"llvm.sqrt.v{LANES}f64")
    return builder.call(root, [value])


def _attract(context, builder, signature, args):
    """out[i] += gm_j d / r^3, out[j] -= gm_i d / r^3, d = gap + delta[j] - delta[i]."""
    kinds = signature.args
    delta, out = (make_array(kind)(context, builder, value) for kind, value in zip(kinds[:2], args[:2], strict=True))
    i, j, gap, gm_i, gm_j = args[2], args[3], args[4:7], args[7], args[8]
    d = _apart(builder, delta, i, j, gap)
    square = [builder.fmul(x, x, flags=_CONTRACT) for x in d]
    r2 = builder.fadd(builder.fadd(square[0], square[1], flags=_CONTRACT), square[2], flags=_CONTRACT)
    cube = builder.fmul(r2, _root(builder, r2))
    inverse = builder.fdiv(_splat(builder, ir.Constant(_DOUBLE, 1.0)), cube)
    on_i = builder.fmul(inverse, _splat(builder, gm_j))
    on_j = builder.fmul(inverse, _splat(builder, builder.fneg(gm_i)))
    for axis in range(3):
        _add_to(builder, _lane(builder, out, i, axis), builder.fmul(on_i, d[axis], flags=_CONTRACT))
        _add_to(builder, _lane(builder, out, j, axis), builder.fmul(on_j, d[axis], flags=_CONTRACT))
    return context.get_dummy_value()


@intrinsic
def attract(typingctx, delta, out, i, j, x, y, z, gm_i, gm_j):
    """Add the attraction of bodies i and j to `out` (n, 3, LANES); (x, y, z) is base[j] - base[i], m."""
    number = types.float64
    signature = types.void(delta, out, types.int64, types.int64, number, number, number, number, number)
    return signature, _attract


def _bulge(context, builder, signature, args):
    """out[j] += gm_i a, out[i] -= gm_j a, a = factor / r^5 [(5 (d.p)^2 / r^2 - 1) d - 2 (d.p) p]."""
    kinds = signature.args
    delta, out = (make_array(kind)(context, builder, value) for kind, value in zip(kinds[:2], args[:2], strict=True))
    i, j, gap, gm_i, gm_j, factor = args[2], args[3], args[4:7], args[7], args[8], args[9]
    pole = [
        _load(builder, builder.bitcast(make_array(kind)(context, builder, value).data, _VECTOR.as_pointer()))
        for kind, value in zip(kinds[10:], args[10:], strict=True)
    ]

    def number(value: float):
        return _splat(builder, ir.Constant(_DOUBLE, value))

    def dot(a, b):
        first, second, third = (builder.fmul(x, y) for x, y in zip(a, b, strict=True))
        return builder.fadd(builder.fadd(first, second), third)

    d = _apart(builder, delta, i, j, gap)
    r2 = dot(d, d)
    inverse, height = builder.fdiv(number(1.0), r2), dot(d, pole)
    common = builder.fmul(builder.fmul(_splat(builder, factor), inverse), inverse)
    common = builder.fdiv(common, _root(builder, r2))
    slant = builder.fmul(builder.fmul(builder.fmul(number(5.0), height), height), inverse)
    along = builder.fmul(common, builder.fsub(slant, number(1.0)))
    toward = builder.fmul(builder.fmul(number(2.0), common), height)
    for axis in range(3):
        pull = builder.fsub(builder.fmul(along, d[axis]), builder.fmul(toward, pole[axis]))
        _add_to(builder, _lane(builder, out, j, axis), builder.fmul(_splat(builder, gm_i), pull))
        _add_to(builder, _lane(builder, out, i, axis), builder.fmul(_splat(builder, builder.fneg(gm_j)), pull))
    return context.get_dummy_value()


@intrinsic
def bulge(typingctx, delta, out, i, j, x, y, z, gm_i, gm_j, factor, px, py, pz):
    """Add what J2 of body i does to body j, and its reaction, to `out` (n, 3, LANES).

    3/2 J2 R^2 / r^5 [(5 s^2 - 1) r - 2 (r.p) p]: (x, y, z) is base[j] - base[i], m, `factor` is 3/2 J2 R^2, m^2, and
    px, py, pz (LANES,) are the pole.
    """
    number = types.float64
    numbers = (number,) * 6
    return types.void(delta, out, types.int64, types.int64, *numbers, px, py, pz), _bulge


def _combination(builder, table, source, row, scale):
    """Return scale * sum_j source[row + j] * table[j, :]."""
    word = row.type
    total = ir.Constant(_VECTOR, [0.0] * LANES)
    for j in range(LANES):
        factor = builder.load(builder.gep(source.data, [builder.add(row, ir.Constant(word, j))]))
        line = builder.bitcast(builder.gep(table.data, [ir.Constant(word, j * LANES)]), _VECTOR.as_pointer())
        term = builder.fmul(_splat(builder, builder.fmul(factor, scale)), _load(builder, line), flags=_CONTRACT)
        total = builder.fadd(total, term, flags=_CONTRACT)
    return total


def _combine(context, builder, signature, args):
    """target[body, axis, :] = start + sum_j factors[j] * table[j, :]."""
    kinds = signature.args
    target, start, table, source = (
        make_array(kind)(context, builder, value) for kind, value in zip(kinds[:4], args[:4], strict=True)
    )
    body, axis, scale = args[4:]
    word = body.type
    row = builder.mul(builder.add(builder.mul(body, ir.Constant(word, 3)), axis), ir.Constant(word, LANES))
    total = _combination(builder, table, source, row, scale)
    first = builder.bitcast(builder.gep(start.data, [row]), _VECTOR.as_pointer())
    total = builder.fadd(total, _load(builder, first))
    place = builder.bitcast(builder.gep(target.data, [row]), _VECTOR.as_pointer())
    builder.store(total, place).align = 8
    return context.get_dummy_value()


@intrinsic
def combine(typingctx, target, start, table, source, body, axis, scale):
    """Set target[body, axis, :] = start[body, axis, :] + scale * source[body, axis, :] @ table (LANES, LANES)."""
    signature = types.void(target, start, table, source, types.int64, types.int64, types.float64)
    return signature, _combine


def _settle(context, builder, signature, args):
    """delta[body] = fixed[body] + scale * source[body] @ table, and the largest |change|, |delta - fixed|."""
    kinds = signature.args
    delta, fixed, table, source = (
        make_array(kind)(context, builder, value) for kind, value in zip(kinds[:4], args[:4], strict=True)
    )
    body, scale = args[4:]
    word = body.type
    zeros = ir.Constant(_VECTOR, [0.0] * LANES)
    change, size, odd = zeros, zeros, ir.Constant(ir.VectorType(ir.IntType(1), LANES), [0] * LANES)
    for axis in range(3):
        row = builder.mul(
            builder.add(builder.mul(body, ir.Constant(word, 3)), ir.Constant(word, axis)), ir.Constant(word, LANES)
        )
        here = _lane(builder, delta, body, axis)
        start = _load(builder, _lane(builder, fixed, body, axis))
        new = builder.fadd(start, _combination(builder, table, source, row, scale))
        change, apart = _larger(builder, change, builder.fsub(new, _load(builder, here)))
        size, _ = _larger(builder, size, builder.fsub(new, start))
        odd = builder.or_(odd, builder.fcmp_unordered("uno", apart, apart))
        builder.store(new, here).align = 8
    undefined = builder.icmp_unsigned("!=", builder.bitcast(odd, ir.IntType(LANES)), ir.Constant(ir.IntType(LANES), 0))
    largest = builder.select(undefined, ir.Constant(_DOUBLE, float("inf")), _most(builder, change))
    return context.make_tuple(builder, signature.return_type, [largest, _most(builder, size)])


def _larger(builder, most, value):
    """Return the larger of `most` and |value| in every lane, and |value|; NaN is passed over."""
    absolute = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(_VECTOR, [_VECTOR]), f"llvm.fabs.v{LANES}f64"
    )
    size = builder.call(absolute, [value])
    return builder.select(builder.fcmp_ordered(">", size, most), size, most), size


def _most(builder, value):
    """Return the largest lane; there is no NaN in any."""
    reduce = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(_DOUBLE, [_VECTOR]), f"llvm.vector.reduce.fmax.v{LANES}f64"
    )
    return builder.call(reduce, [value])


@intrinsic
def settle(typingctx, delta, fixed, table, source, body, scale):
    """Set delta[body] (3, LANES) = fixed[body] + scale * source[body] @ table (LANES, LANES).

    Return the largest change of an entry and the largest distance from `fixed`; the first is infinite where an entry
    is not a number.
    """
    number = types.float64
    return types.UniTuple(number, 2)(delta, fixed, table, source, types.int64, number), _settle
