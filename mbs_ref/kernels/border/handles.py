"""Pass many arrays to compiled code as one: a handle holds every array's address and shape.

Passing a hundred arrays by value through every call makes compilation take minutes and each call from
Python cost microseconds. A model or workspace is instead the address of one integer array, its handle;
an accessor returns one group of it as views, at the price of a few loads. It is a bare address because
compiled code counts the references of an array it is given, atomically, at every call.
"""

from collections import namedtuple
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from mbs_ref.kernels.border.groups import check, declared

QUESTIONS = 40  # a handle's first words: where the answers to questions are (mbs_ref.kernels.border.calls)
_WORDS = 5  # then, per array: address, then up to four lengths
_PADDING = [(0,) * (_WORDS - 1 - n) for n in range(_WORDS)]  # behind the lengths of an array of n dimensions
_DTYPES = {np.dtype(np.float64): types.float64, np.dtype(np.int64): types.int64}


_owned: dict[type, tuple[type, dict[str, int]]] = {}  # class of a handle -> its groups and known lengths


class Model(NamedTuple):
    """What compiled code receives of a scene, whichever core it belongs to."""

    address: int  # of a handle that the system keeps alive


class Work(NamedTuple):
    """What compiled code receives of the scratch of a run."""

    address: int


def make_handle(groups: Any, checked: bool = False) -> np.ndarray:
    """Return the handle of a named tuple of groups of arrays, which must be what the groups declare.

    `checked` are those that are copies of others. The handle does not own the memory: whoever holds it must keep
    `groups` alive.
    """
    words = [0] * QUESTIONS
    for group in groups:
        if not checked:
            check(group)
        for array in group:
            words += (array.ctypes.data, *array.shape, *_PADDING[array.ndim])
    return np.array(words, dtype=np.int64)


def handle_class(module: str, name: str, groups: type, **lengths: int) -> Any:
    """Return a class of handles: of which named tuple of groups, and which words of their shapes are these numbers.

    It is to stand under its name in its module. The type of a handle is what compiled code knows of it: two cores that
    have a group of one name each differ by it.
    """
    handle = namedtuple(name, ["address"], module=module)
    _owned[handle] = groups, lengths
    return handle


def is_handle(kind: Any) -> bool:
    """Return whether a Numba type is one of handles."""
    return isinstance(kind, types.NamedUniTuple) and kind.instance_class in (Model, Work, *_owned)


def accessor(name: str) -> Any:
    """Return a compiled function (handle) -> the group `name` of what the handle's class was declared for.

    Lengths that are numbers, in the group's declaration or in the handle's, are known to the compiler, and so is where
    an entry lies.
    """

    @intrinsic
    def access(typingctx, owner):
        groups, lengths = _owned[owner.instance_class]
        kinds = get_type_hints(groups)
        fields = list(kinds)
        first = sum(len(declared(kinds[field])) for field in fields[: fields.index(name)])
        arrays = list(declared(kinds[name]).values())
        array_types = [types.Array(_DTYPES[x.dtype], len(x.shape), "C") for x in arrays]
        known = [[lengths.get(n) if isinstance(n, str) else n for n in x.shape] for x in arrays]
        group_type = types.NamedTuple(array_types, kinds[name])

        def codegen(context, builder, signature, args):
            values = [_view(context, builder, args[0], first + k, kind, known[k]) for k, kind in enumerate(array_types)]
            return context.make_tuple(builder, group_type, values)

        return group_type(owner), codegen

    return access


def _view(context, builder, owner, index, array_type, known):
    """Build array `index` of the owner's handle from its address and lengths, where they are not known."""
    word = ir.IntType(64)
    handle = builder.inttoptr(builder.extract_value(owner, 0), word.as_pointer())

    def load(offset):
        place = builder.gep(handle, [ir.Constant(word, QUESTIONS + index * _WORDS + offset)])
        return builder.load(place)

    result = make_array(array_type)(context, builder)
    itemsize = context.get_constant(types.intp, 8)
    shape = [load(1 + axis) if length is None else ir.Constant(word, length) for axis, length in enumerate(known)]
    strides = [itemsize]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    data = builder.inttoptr(load(0), result.data.type)
    populate_array(
        result,
        data=data,
        shape=cgutils.pack_array(builder, shape, word),
        strides=cgutils.pack_array(builder, strides, word),
        itemsize=itemsize,
        meminfo=None,
    )
    return result._getvalue()
