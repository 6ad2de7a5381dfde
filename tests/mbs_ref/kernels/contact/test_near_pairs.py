"""The list of near pairs: which it holds, and when it is made anew."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.contact.laws import ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs, _has_moved, refresh

SKIN = 1.0  # m


@pytest.mark.parametrize(
    ("since", "step", "moved"),
    [(0.0, 0.0, False), (0.3, 0.1, False), (0.3, 0.3, True), (0.49, 0.0, False), (0.51, 0.0, True), (0.0, 0.51, True)],
)
def test_a_shape_has_moved_where_its_way_and_one_more_step_pass_half_the_skin(since, step, moved):
    """Two balls, of which one stays; the other is `since` from where the list was made and came there by `step`."""
    near = empty(NearPairs, s=2, dimension=2, n_pairs=1, k=1, a=0)
    near.skin[0] = SKIN
    near.built[:] = [[5.0, 7.0], [-2.0, 3.0]]
    near.place[:] = near.built
    near.place[1] += 0.6 * since, -0.8 * since
    near.last[:] = near.place
    near.last[1] += 0.8 * step, 0.6 * step
    assert _has_moved.py_func(near) == moved
    np.testing.assert_array_equal(near.last, near.place)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("skin", [0.02, 0.3])
def test_the_list_is_made_of_the_pairs_within_the_skin_of_each_other(dimension, skin):
    """Every two of thirty balls are a pair, told by their gaps one by one; one pair has a side without bounds."""
    shapes, random = 30, np.random.default_rng(dimension)
    one, two = np.triu_indices(shapes, 1)
    pairs = len(one)
    near = empty(NearPairs, s=shapes, dimension=dimension, n_pairs=pairs + 1, k=pairs, a=1)
    near.skin[0], near.stale[0], near.always[0] = skin, 1, pairs
    near.order[:] = np.arange(shapes)
    near.key[:], near.keyed[:] = one * shapes + two, np.arange(pairs)
    near.reach[:] = random.uniform(0.05, 0.2, shapes)
    near.place[:] = random.uniform(0.0, 1.5, (shapes, dimension))
    near.last[:] = near.place
    refresh(near, empty(ContactModes, k=pairs + 1))
    gap = np.linalg.norm(near.place[one] - near.place[two], axis=1) - near.reach[one] - near.reach[two]
    wanted = [*np.flatnonzero(gap <= skin), pairs]
    assert 5 < len(wanted) < pairs
    np.testing.assert_array_equal(near.pair[: near.count[0]], wanted)
