"""What a run changes of the arrays of a system, in one piece of memory: a copy costs no more than a few arrays do."""

import itertools
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from mbs_ref.kernels.algebra.lanes import BYTES
from mbs_ref.kernels.border.groups import declared, members
from mbs_ref.kernels.border.handles import QUESTIONS, WORDS


@cache
def address_places(groups: type, names: tuple[str, ...]) -> np.ndarray:
    """Return the places in a handle of the addresses of the arrays of some groups."""
    counts = {name: len(declared(kind)) for name, kind in members(groups).items()}
    first = dict(zip(counts, itertools.accumulate(counts.values(), initial=0), strict=False))
    words = [first[name] + k for name in names for k in range(counts[name])]
    return QUESTIONS + WORDS * np.array(words, dtype=np.int64)


def without_log(group: Any) -> Any:
    """Return a copy of a group, but for the contents of its log, which a block does not take."""
    parts = zip(group._fields, group, strict=True)
    return type(group)(*(a if name == "log" or not a.size else a.copy() for name, a in parts))


class Block:
    """Groups of arrays as they are now, of which copies are cheap: each lies in one piece of memory.

    Arrays named `log` come without their contents: they are large, and nothing is written yet.
    """

    def __init__(self, groups: Sequence[Any]) -> None:
        every = [(name == "log", array) for group in groups for name, array in group._asdict().items()]
        order = sorted(range(len(every)), key=lambda k: every[k][0])  # logs last
        sizes = [-(-every[k][1].nbytes // BYTES) * BYTES for k in order]
        ends = np.cumsum(sizes, dtype=np.int64)
        self.starts, self._size = np.zeros(len(every), np.int64), int(ends[-1])
        self.starts[order[1:]] = ends[:-1]
        copied = [(array, start) for (is_log, array), start in zip(every, self.starts, strict=True) if not is_log]
        self._values = np.zeros(sum(sizes[: len(copied)]), np.uint8)
        for array, start in copied:
            self._values[start : start + array.nbytes] = array.ravel().view(np.uint8)
        arrays = iter(zip((array for _, array in every), self.starts.tolist(), strict=True))
        self._groups = [(type(group), list(itertools.islice(arrays, len(group)))) for group in groups]

    def copy(self) -> np.ndarray:
        """Return the memory of a copy, whose arrays begin at `starts`, where packed instructions may load and store."""
        memory = np.empty(self._size + BYTES, np.uint8)
        memory = memory[-memory.ctypes.data % BYTES :]
        memory[: len(self._values)] = self._values
        return memory

    def groups(self, memory: np.ndarray, part: slice) -> list[Any]:
        """Return some groups of a copy."""
        return [
            kind(*(np.ndarray(a.shape, a.dtype, memory, start) if a.size else a for a, start in arrays))
            for kind, arrays in self._groups[part]
        ]
