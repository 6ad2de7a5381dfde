"""Which paths the rows of loop closures take through the tree, which of them meet, and in which order they go.

Found once for a scene. Closures go with their apex, the closest common ancestor of their bodies: deeper ones first,
ground's last. Those of one apex go in an order of minimum degree (Tinney and Walker 1967), where degrees are equal one
after its neighbour: a row of loops is so taken from one end to the other, and every pivot stays what its own loop
makes of it, instead of falling with their number where two long rows meet.
"""

from heapq import heappop, heappush
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import ints
from mbs_ref.kernels.rigid.model import Loops


class Closure(NamedTuple):
    """Rows that close a loop: their slot, its bodies by elimination number (n for ground), how many they are."""

    slot: int
    bodies: tuple[int, int]
    n_rows: int


class _Paths(NamedTuple):
    """The path of a closure's rows: bodies from each side up to the apex, which is excluded."""

    sides: tuple[list[int], list[int]]
    apex: int


def loops_of_closures(parent: list[int], closures: list[Closure]) -> Loops:
    """Lay out closures over a tree of bodies; parent (n,) is n for ground."""
    n = len(parent)
    paths = [_paths(parent, closure.bodies) for closure in closures]
    order, met = _elimination(n, [path.apex for path in paths], _meeting(paths))
    rank = {k: position for position, k in enumerate(order)}
    later = [sorted(rank[other] for other in met[k]) for k in order]
    return _arranged(parent, [closures[k] for k in order], [paths[k] for k in order], later)


def _paths(parent: list[int], bodies: tuple[int, int]) -> _Paths:
    n = len(parent)
    sides: tuple[list[int], list[int]] = ([], [])
    a, b = bodies
    while a != b:  # parents have smaller numbers than their children; ground's, the largest, is an ancestor of all
        if b == n or (a != n and a > b):
            sides[0].append(a)
            a = parent[a]
        else:
            sides[1].append(b)
            b = parent[b]
    return _Paths(sides, a)


def _meeting(paths: list[_Paths]) -> list[set[int]]:
    """Return for each closure those with a body in both paths."""
    through: dict[int, list[int]] = {}
    for k, path in enumerate(paths):
        for body in (*path.sides[0], *path.sides[1]):
            through.setdefault(body, []).append(k)
    result: list[set[int]] = [set() for _ in paths]
    for clique in {tuple(group) for group in through.values()}:
        for k in clique:
            result[k].update(clique)
    for k, others in enumerate(result):
        others.discard(k)
    return result


def _elimination(n: int, apexes: list[int], near: list[set[int]]) -> tuple[list[int], list[set[int]]]:
    """Return the order of elimination, and for each closure the later ones that it meets then, by fill too."""
    groups: dict[int, list[int]] = {}
    for k, apex in enumerate(apexes):
        groups.setdefault(-1 if apex == n else apex, []).append(k)
    order: list[int] = []
    for apex in sorted(groups, reverse=True):
        _eliminate_group(groups[apex], near, order)
    return order, near


def _eliminate_group(group: list[int], near: list[set[int]], order: list[int]) -> None:
    """Append a group in order of minimum degree; `near` becomes what each meets of the later ones."""
    touched = dict.fromkeys(group, 0)  # minus the turn in which it last lost a neighbour
    heap = sorted((len(near[k]), 0, k) for k in group)
    clique: set[int] = set()  # what the one before left, who all meet each other
    while heap:
        degree, turn, k = heappop(heap)
        if touched.get(k) != turn or degree != len(near[k]):
            continue  # out of date
        del touched[k]
        order.append(k)
        fills = k not in clique or len(near[k]) >= len(clique)
        clique = near[k]
        for other in clique:
            if fills:
                near[other] |= clique - {other}
            near[other].discard(k)
            if other in touched:
                touched[other] = -len(order)
                heappush(heap, (len(near[other]), touched[other], other))


def _arranged(parent: list[int], closures: list[Closure], paths: list[_Paths], met: list[list[int]]) -> Loops:
    """Return the arrays of closures that are in order of elimination."""
    n = len(parent)
    ways = [[*path.sides[0], *path.sides[1], *([path.apex] if path.apex < n else [])] for path in paths]
    place = _starts([len(way) for way in ways])
    at = [{body: first + j for j, body in enumerate(way)} for first, way in zip(place, ways, strict=False)]
    entries = sorted((i, k) for k, path in enumerate(paths) for side in path.sides for i in side)
    return Loops(
        slot=ints([closure.slot for closure in closures]), count=ints([closure.n_rows for closure in closures]),
        most=ints([closure.n_rows for closure in closures]), place=ints(place),
        start=ints([at[k].get(i, -1) for k, closure in enumerate(closures) for i in closure.bodies]).reshape(-1, 2),
        summit=ints([at[k].get(path.apex, -1) for k, path in enumerate(paths)]),
        first=ints(_starts([len(others) for others in met])), met=ints([s for others in met for s in others]),
        above=ints([at[s].get(paths[k].apex, -1) for k, others in enumerate(met) for s in others]),
        closed=_ranges([path.apex for path in paths], n + 1),
        entry=ints(_starts(np.bincount([i for i, _ in entries], minlength=n).tolist())),
        passing=ints([k for _, k in entries]), here=ints([at[k][i] for i, k in entries]),
        next=ints([at[k].get(parent[i], -1) for i, k in entries]),
    )  # fmt: skip


def _starts(sizes: list[int]) -> list[int]:
    """Return where each of these begins that stand one after the other, and the end."""
    return [0, *accumulate(sizes)]


def _ranges(values: list[int], count: int) -> np.ndarray:
    """Return from where up to where (count, 2) each number stands in a list in which equal ones are neighbours."""
    result = np.zeros((count, 2), dtype=np.int64)
    for place, value in reversed(list(enumerate(values))):
        result[value] = place, max(place + 1, result[value, 1])
    return result
