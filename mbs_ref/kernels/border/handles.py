"""Pass many arrays to compiled code as one: a handle holds every array's address and shape.

Passing a hundred arrays by value through every call makes compilation take minutes and each call from
Python cost microseconds. A model or workspace is instead the address of one integer array, its handle;
in compiled code `model.bodies` is one group of it as views, at the price of a few loads. It is a bare address because
compiled code counts the references of an array it is given, atomically, at every call.
"""

import ctypes
from collections import namedtuple
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic
from numba.np.arrayobj import make_array, populate_array

from mbs_ref.kernels.algebra.lanes import BYTES, LANES
from mbs_ref.kernels.border.groups import absent, check, declared, members

QUESTIONS = 48  # a handle's first words: where the answers to questions are (mbs_ref.kernels.border.calls)
WORDS = 5  # then, per array: address, then up to four lengths
_PADDING = [(0,) * (WORDS - 1 - n) for n in range(WORDS)]  # behind the lengths of an array of n dimensions
_Byte, _NOTHING = ctypes.c_char, np.zeros(1)
_DTYPES = {np.dtype(np.float64): types.float64, np.dtype(np.int64): types.int64}


_owned: dict[type, tuple[type, dict[str, int]]] = {}  # class of a handle -> its groups and known lengths
_SIZES = {types.float64: 8, types.int64: 8, LANES: BYTES}  # bytes of a number in an array


class Model(NamedTuple):
    """What compiled code receives of a scene, whichever core it belongs to."""

    address: int  # of a handle that the system keeps alive


class Work(NamedTuple):
    """What compiled code receives of the scratch of a run."""

    address: int


class ModelInLanes(NamedTuple):
    """A model of several runs side by side, whose floats are lanes (mbs_ref.kernels.algebra.lanes)."""

    address: int


class WorkInLanes(NamedTuple):
    """The scratch of such runs."""

    address: int


ModelInLanes.NUMBER = WorkInLanes.NUMBER = LANES  # type: ignore[attr-defined]
_GENERAL = (Model, Work, ModelInLanes, WorkInLanes)
_intrinsic: Any = intrinsic  # what it makes is called without the typing context


def make_handle(groups: Any, checked: bool = False) -> np.ndarray:
    """Return the handle of a named tuple of groups of arrays, which must be what the groups declare.

    `checked` are those that are copies of others. The handle does not own the memory: whoever holds it must keep
    `groups` alive.
    """
    words = [0] * QUESTIONS
    for group in groups:
        if group is absent(type(group)):
            words += _words_of_absent(type(group))
            continue
        if not checked:
            check(group)
        words += _words(group)
    return np.array(words, dtype=np.int64)


@cache
def _words_of_absent(group: type) -> list[int]:
    return _words(absent(group))


def _words(group: Any) -> list[int]:
    """Return address and lengths of each array of a group; without entries it has some address that may be read."""
    words: list[int] = []
    for part in group:
        try:  # NumPy's own attributes take three times as long
            address = ctypes.addressof(_Byte.from_buffer(part if part.size else _NOTHING))
        except TypeError:  # not contiguous, or not to be written to
            address = part.ctypes.data
        words += (address, *part.shape, *_PADDING[part.ndim])
    return words


def handle_class(module: str, name: str, groups: type, **lengths: int) -> Any:
    """Return a class of handles: of which named tuple of groups, and which words of their shapes are these numbers.

    It is to stand under its name in its module. The type of a handle is what compiled code knows of it: two cores that
    have a group of one name each differ by it.
    """
    handle = namedtuple(name, ["address"], module=module)
    _owned[handle] = groups, lengths
    return handle


def handle_in_lanes(of: type) -> Any:
    """Return the class of handles to the same groups whose floats are lanes, to stand in the same module."""
    handle = handle_class(of.__module__, f"{of.__name__}InLanes", _owned[of][0], **_owned[of][1])
    handle.NUMBER, handle.ALONE = LANES, of
    return handle


@_intrinsic
def alone(context, handle, address):
    """Return the handle at an address, of the core of a handle in lanes, of one run."""
    kind = types.NamedUniTuple(types.int64, 1, handle.instance_class.ALONE)
    return kind(handle, types.int64), lambda context, builder, sig, args: context.make_tuple(builder, kind, args[1:])


def is_handle(kind: Any) -> bool:
    """Return whether a Numba type is one of handles."""
    return isinstance(kind, types.NamedUniTuple) and kind.instance_class in (*_GENERAL, *_owned)


class _Group(NamedTuple):
    """A group of arrays as compiled code sees it."""

    kind: Any  # Numba's type
    first: int  # place of its first array in the handle
    known: list[list[int | None]]  # lengths of each array that the group's or the handle's declaration states


def _group(owner: Any, name: str) -> _Group | None:
    """Return the group of a handle's class with this name; None where it has none."""
    groups, lengths = _owned.get(owner.instance_class, (None, {}))
    kinds = members(groups) if groups else {}
    if name not in kinds:
        return None
    fields = list(kinds)
    first = sum(len(declared(kinds[field])) for field in fields[: fields.index(name)])
    arrays = list(declared(kinds[name]).values())
    kinds_of = _DTYPES | {np.dtype(np.float64): getattr(owner.instance_class, "NUMBER", types.float64)}
    array_types = [types.Array(kinds_of[x.dtype], len(x.shape), "C") for x in arrays]
    known = [[lengths.get(n) if isinstance(n, str) else n for n in x.shape] for x in arrays]
    return _Group(types.NamedTuple(array_types, kinds[name]), first, known)


@infer_getattr
class _GroupOfHandle(AttributeTemplate):
    """Types model.bodies, and every other group of what a handle's class was declared for."""

    key = types.NamedUniTuple

    def generic_resolve(self, owner: Any, name: str) -> Any:
        group = _group(owner, name)
        return None if group is None else group.kind


@lower_getattr_generic(types.NamedUniTuple)
def _lower_group(context, builder, owner, value, name):
    """Return a group of a handle as views of its arrays, or an ordinary field of another named tuple.

    Lengths that are numbers, in the group's declaration or in the handle's, are known to the compiler, and so is where
    an entry lies.
    """
    group = _group(owner, name)
    if group is None:
        return impl_ret_borrowed(context, builder, owner[0], builder.extract_value(value, owner.fields.index(name)))
    places = enumerate(zip(group.kind.types, group.known, strict=True), group.first)
    return context.make_tuple(builder, group.kind, [_view(context, builder, value, k, *array) for k, array in places])


def _view(context, builder, owner, index, array_type, known):
    """Build array `index` of the owner's handle from its address and lengths, where they are not known."""
    word = ir.IntType(64)
    handle = builder.inttoptr(builder.extract_value(owner, 0), word.as_pointer())

    def load(offset):
        place = builder.gep(handle, [ir.Constant(word, QUESTIONS + index * WORDS + offset)])
        return builder.load(place)

    result = make_array(array_type)(context, builder)
    itemsize = context.get_constant(types.intp, _SIZES[array_type.dtype])
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
