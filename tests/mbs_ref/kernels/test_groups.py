"""Arrays that are not what their group declares are refused before compiled code reads them."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref.kernels.border.groups import check, empty
from mbs_ref.kernels.border.handles import make_handle
from mbs_ref.kernels.rigid.model import Bodies, Forces


def forces(**changes: np.ndarray) -> Forces:
    return empty(Forces, k=2, dimension=2, turns=1)._replace(**changes)


def test_an_empty_group_has_the_lengths_that_are_given():
    bodies = empty(Bodies, n=3)
    assert (bodies.mass.shape, bodies.mass.dtype) == ((3,), np.float64)
    assert (bodies.parent.shape, bodies.parent.dtype) == ((3,), np.int64)
    assert empty(Forces, dimension=2).point.shape == (0, 2)
    check(bodies)


@pytest.mark.parametrize(
    "wrong",
    [
        {"torque": np.zeros(3)},  # another length than the group's other arrays
        {"force": np.zeros((2, 3))},  # a vector of space in the plane
        {"point": np.zeros(2)},
        {"body": np.zeros(2)},  # floats for integers
        {"force": np.zeros((2, 4))[:, ::2]},
    ],
)
def test_an_array_that_is_not_as_declared_is_refused(wrong):
    (name,) = wrong
    with pytest.raises(ValueError, match=rf"Forces\.{name}"):
        make_handle([forces(**wrong)])


def test_arrays_as_declared_are_taken():
    make_handle([forces()])
