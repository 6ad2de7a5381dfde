"""Broad phase: which pairs are near enough to be looked at, by sorted bounds along one axis (sweep and prune).

Every shape lies in a ball. A pair is near while the balls are within a skin of each other; the list is
rebuilt when a shape has left its half of the skin, now or at any time of the step that ends here. So no pair that is
left out can touch in that step: what is computed, and in which order, is what it would be without the list.
"""

from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.contact.laws import MODE_OPEN, MODE_PLAIN
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rows import copy_rows


class NearPairs(NamedTuple):
    """Pairs that are looked at, and the balls they are chosen by."""

    pair: Annotated[Ints, "n_pairs"]  # the first `count`, ascending
    count: Annotated[Ints, 1]
    stale: Annotated[Ints, 1]  # 1 where modes were set from outside
    skin: Annotated[Floats, 1]  # m; 0 keeps every pair in the list
    body: Annotated[Ints, "s"]  # of each ball
    center: Annotated[Floats, "s", "dimension"]  # m, in the body
    reach: Annotated[Floats, "s"]  # m, radius
    place: Annotated[Floats, "s", "dimension"]  # m, world, now; the core fills it
    built: Annotated[Floats, "s", "dimension"]  # m, when the list was built
    last: Annotated[Floats, "s", "dimension"]  # m, when it was last looked at
    travel: Annotated[Floats, "s"]  # m, longest way of the step that ends here; the core fills it
    order: Annotated[Ints, "s"]  # by lower bound
    low: Annotated[Floats, "s"]  # m, lower bound along the axis
    key: Annotated[Ints, "k"]  # ascending: first ball times s plus second ball
    keyed: Annotated[Ints, "k"]  # the pair of each key
    always: Annotated[Ints, "a"]  # pairs with a side that has no bounds
    flag: Annotated[Ints, "n_pairs"]


@jit
def _has_moved(near):
    """Return whether a shape may have left its half of the skin in the step that ends here; note the places."""
    moved = False
    for s in range(near.body.shape[0]):
        since = 0.0
        step = 0.0
        for c in range(near.place.shape[1]):
            d = near.place[s, c] - near.built[s, c]
            since += d * d
            d = near.place[s, c] - near.last[s, c]
            step += d * d
            near.last[s, c] = near.place[s, c]
        if np.sqrt(step) > near.travel[s]:  # not where it was never looked at
            near.travel[s] = np.sqrt(step)
        if not np.sqrt(since) + near.travel[s] <= 0.5 * near.skin[0]:
            moved = True
    return moved


@jit
def _widest_axis(near):
    best = 0
    widest = -1.0
    for c in range(near.place.shape[1]):
        low = near.place[0, c]
        high = low
        for s in range(near.place.shape[0]):
            low = min(low, near.place[s, c])
            high = max(high, near.place[s, c])
        if high - low > widest:
            widest = high - low
            best = c
    return best


@jit
def _sort(near):
    """Insertion: the order hardly changes from one list to the next."""
    for i in range(1, near.order.shape[0]):
        s = near.order[i]
        j = i
        while j > 0 and near.low[near.order[j - 1]] > near.low[s]:
            near.order[j] = near.order[j - 1]
            j -= 1
        near.order[j] = s


@jit
def _flag_key(near, wanted):
    """Flag the pairs of two balls, by bisection."""
    first = np.searchsorted(near.key, wanted)
    while first < near.key.shape[0] and near.key[first] == wanted:
        near.flag[near.keyed[first]] = 1
        first += 1


@jit
def _sweep(near):
    """Flag every pair whose balls, and the ways they have come, are within the skin of each other."""
    skin = near.skin[0]
    shapes = near.body.shape[0]
    axis = _widest_axis(near)
    for s in range(shapes):
        near.low[s] = near.place[s, axis] - near.reach[s] - near.travel[s]
    _sort(near)
    for i in range(shapes):
        s = near.order[i]
        high = near.low[s] + 2.0 * (near.reach[s] + near.travel[s]) + skin
        for j in range(i + 1, shapes):
            r = near.order[j]
            if near.low[r] > high:
                break
            apart = near.reach[s] + near.travel[s] + near.reach[r] + near.travel[r] + skin
            square = 0.0
            for c in range(near.place.shape[1]):
                d = near.place[s, c] - near.place[r, c]
                square += d * d
            if square <= apart * apart:
                _flag_key(near, min(s, r) * shapes + max(s, r))


@jit
def refresh(near, modes):
    """Renew the list where it is stale or a shape has moved; return whether it is new. near.place holds the places."""
    if near.skin[0] == 0.0:
        return False
    moved = _has_moved(near)
    if not moved and near.stale[0] == 0:
        return False
    near.stale[0] = 0
    for k in range(near.flag.shape[0]):
        near.flag[k] = 0 if modes.mode[k] in (MODE_OPEN, MODE_PLAIN) else 1
    for k in near.always:
        near.flag[k] = 1
    _sweep(near)
    copy_rows(near.place, near.built)
    count = 0
    for k in range(near.flag.shape[0]):
        if near.flag[k] == 1:
            near.pair[count] = k
            count += 1
    near.count[0] = count
    return True
