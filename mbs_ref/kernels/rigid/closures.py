"""The arrays of loop closures, in the plane and in space: where the rows of each run, and which others they meet.

`mbs_ref.kernels.rigid.elimination` tells what is done with them, `mbs_ref.cores.loops` how they come about.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats, Ints, empty


class Loops(NamedTuple):
    """Closures in their order of elimination; the last ones close on ground.

    A path leads from a closure's body to its apex, the apex left out: the closest common ancestor of both bodies. The
    rows have a place in `Closures.passed` at every body of their paths, and at the apex.
    """

    slot: Annotated[Ints, "n_closures"]
    count: Annotated[Ints, "n_closures"]  # rows
    most: Annotated[Ints, "n_closures"]  # of them that can be independent of each other and of those before
    place: Annotated[Ints, "n_closures + 1"]  # first of its places
    start: Annotated[Ints, "n_closures", 2]  # place of each side's rows, -1 for ground
    summit: Annotated[Ints, "n_closures"]  # place at the apex, -1 for ground
    first: Annotated[Ints, "n_closures + 1"]  # in `met`, of the later ones that it meets: by a shared body or by fill
    met: Annotated[Ints, "n_met"]  # the closure that is met, in rising order
    above: Annotated[Ints, "n_met"]  # place of the met one at this one's apex, -1 for ground
    closed: Annotated[Ints, "n + 1", 2]  # closures whose apex a body is: from, up to
    entry: Annotated[Ints, "n + 1"]  # first of the paths through a body
    passing: Annotated[Ints, "n_entries"]  # closure of a path through a body, in rising order
    here: Annotated[Ints, "n_entries"]  # its place at the body
    next: Annotated[Ints, "n_entries"]  # and at the body's parent, -1 for ground


class Closures(NamedTuple):
    """Scratch; `rates` is 3 in the plane and 6 in space, of a body and as many rows as a closure can have."""

    passed: Annotated[Floats, "n_places", "rates", "rates"]  # P^T, the rows as they reach a body, one a column
    column: Annotated[Floats, "n_places", "rates", "rates"]  # B P^T: the body's answer to each, its parent at rest
    joint: Annotated[Floats, "n_places", "rates", "rates"]  # multipliers of the body's joint in that answer
    own: Annotated[Floats, "n_closures", "rates", "rates"]  # D of a closure's rows, then its factors
    coupling: Annotated[Floats, "n_met", "rates", "rates"]  # D of its rows with those of one that it meets
    inverse: Annotated[Floats, "n_closures", "rates"]  # of the pivots
    order: Annotated[Ints, "n_closures", "rates"]  # row behind each pivot
    scale: Annotated[Floats, "n_closures", "rates"]  # mobility of each row without joints
    rhs: Annotated[Floats, "n_closures", "rates"]
    mu: Annotated[Floats, "n_closures", "rates"]
    empty: Annotated[Ints, "n_closures"]  # 1 for an open contact, whose row is empty
    # `Loops.passing` and `Loops.met` without the empty ones: which places of them, body by body and closure by closure
    entry: Annotated[Ints, "n + 1"]
    passing: Annotated[Ints, "n_entries"]
    first: Annotated[Ints, "n_closures + 1"]
    met: Annotated[Ints, "n_met"]
    rank: Annotated[Ints, "n_closures"]  # pivots of each
    regularity: Annotated[Floats, 1]  # smallest accepted pivot, relative; 1 far from any singular pose


def closure_scratch(loops: Loops, rates: int) -> Closures:
    """Allocate the scratch of these closures."""
    n_entries, n_met = len(loops.passing), len(loops.met)
    lengths = {"n_closures": len(loops.slot), "n_places": int(loops.place[-1]), "n_met": n_met}
    every = {"entry": loops.entry.copy(), "passing": np.arange(n_entries), "first": loops.first.copy()}
    return empty(Closures, **lengths, rates=rates)._replace(regularity=np.ones(1), met=np.arange(n_met), **every)
