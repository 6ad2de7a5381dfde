"""Groups of arrays: a NamedTuple whose annotations alone say what each array is, Annotated[Floats, "k", 3].

A word names a length that is the same in the whole group; a number is that length. The empty group, the check of a
built one and the types that compiled code sees (mbs_ref.kernels.border.handles) all follow from the annotations.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
DTYPES = {Floats: np.dtype(np.float64), Ints: np.dtype(np.int64)}  # what an alias consists of differs among NumPy's


class Declared(NamedTuple):
    """What an annotation says."""

    dtype: np.dtype
    shape: tuple[int | str, ...]


@cache
def members(groups: type) -> dict[str, type]:
    """Return the classes of the groups that a named tuple of groups has, by their names."""
    return get_type_hints(groups)


@cache
def declared(group: type) -> dict[str, Declared]:
    """Return dtype and shape of every array of a group."""
    hints = get_type_hints(group, include_extras=True)
    arrays = {name: get_args(hint) for name, hint in hints.items()}
    return {name: Declared(DTYPES[kind], tuple(shape)) for name, (kind, *shape) in arrays.items()}


def empty(group: type, **lengths: int) -> Any:
    """Return a group of zeros; the lengths that are not given are 0."""
    arrays = declared(group).values()
    return group(
        *(np.zeros([lengths.get(n, 0) if isinstance(n, str) else n for n in x.shape], x.dtype) for x in arrays)
    )


@cache
def absent(group: type) -> Any:
    """Return the group of what a scene has none of: zeros without length, the same ones every time."""
    return empty(group)


def ints(values: Sequence[int]) -> np.ndarray:
    """Return whole numbers as an array of a group."""
    return np.array(values, dtype=np.int64)


def floats(values: Iterable[Any], *shape: int) -> np.ndarray:
    """Return numbers, or arrays of a shape, as an array of a group (n, *shape)."""
    rows = list(values)
    return np.array(rows, dtype=float).reshape(len(rows), *shape)


def joined(name: str, *kinds: Mapping[str, type], **more: type) -> Any:
    """Return a named tuple class of groups, by their names."""
    return NamedTuple(name, [(key, kind) for each in (*kinds, more) for key, kind in each.items()])  # pyright: ignore


def check(group: Any) -> None:
    """Raise ValueError where an array is not what its group declares, or not C-contiguous."""
    lengths: dict[str, int] = {}
    for (name, array), given in zip(declared(type(group)).items(), group, strict=True):
        alike = given.dtype == array.dtype and len(array.shape) == given.ndim
        for n, k in zip(array.shape, given.shape, strict=False):
            alike = alike and k == (lengths.setdefault(n, k) if isinstance(n, str) else n)
        if not alike:
            raise ValueError(
                f"{type(group).__name__}.{name} is to be {array.dtype} of shape {array.shape} with {lengths}; "
                f"got {given.dtype} of shape {given.shape}"
            )
        if not given.flags.c_contiguous:
            raise ValueError(f"{type(group).__name__}.{name} is not contiguous")
