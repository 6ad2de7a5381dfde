"""When the list of near pairs is made anew: a shape may have left its half of the skin, or may with its next step."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.contact.near_pairs import NearPairs, _has_moved

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
