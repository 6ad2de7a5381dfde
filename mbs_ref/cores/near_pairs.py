"""Contact pairs -> the balls by which near ones are found."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.contact.near_pairs import NearPairs

FROM_PAIRS = 100  # a scene with fewer looks at all of them: that is cheaper than keeping a list
SKIN = 0.5  # of the mean ball's radius


class Ball(NamedTuple):
    """What a shape lies in."""

    body: int
    center: tuple[float, ...]  # m, in the body
    reach: float  # m


def near_pairs(sides: list[tuple[Ball, Ball | None]], dimension: int) -> NearPairs:
    """Return the list for pairs of balls; None stands for a shape without bounds."""
    bounded = [k for k, (_, other) in enumerate(sides) if other is not None]
    every = empty(NearPairs, dimension=dimension)._replace(
        pair=np.arange(len(sides)), count=np.array([len(sides)]), flag=np.zeros(len(sides), dtype=np.int64)
    )
    if len(sides) < FROM_PAIRS or not bounded:
        return every
    reach: dict[tuple[int, tuple[float, ...]], float] = {}
    for k in bounded:
        for ball in sides[k]:
            assert ball is not None
            reach[ball[:2]] = max(ball.reach, reach.get(ball[:2], 0.0))
    number = {mark: s for s, mark in enumerate(reach)}
    ends = np.array([[number[ball[:2]] for ball in sides[k] if ball is not None] for k in bounded])
    keys = ends.min(axis=1) * len(number) + ends.max(axis=1)
    by_key = np.argsort(keys, kind="stable")
    places = np.full((len(number), dimension), np.nan)
    return every._replace(
        stale=np.ones(1, dtype=np.int64),
        skin=np.array([SKIN * float(np.mean(list(reach.values())))]),
        body=np.array([body for body, _ in number], dtype=np.int64),
        center=np.array([center for _, center in number]),
        reach=np.array(list(reach.values())),
        travel=np.zeros(len(reach)),
        place=places,
        built=places.copy(),
        last=places.copy(),
        order=np.arange(len(number)),
        low=np.zeros(len(number)),
        key=keys[by_key],
        keyed=np.array(bounded)[by_key],
        always=np.array(sorted(set(range(len(sides))) - set(bounded)), dtype=np.int64),
    )
