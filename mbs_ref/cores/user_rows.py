"""The rows of a user's own constraints, evaluated in Python with exact derivatives for compiled code to read."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.scene.base.taylor import Taylor


class UserRow(NamedTuple):
    """One constraint, where its row is, and the two bodies that it is given."""

    function: Callable[[Any, Any, Any], Any]
    name: str
    slot: int
    row: int
    side: int  # of body a
    bodies: tuple[int, int]  # a and b, in elimination order; the number of bodies for ground
    arms: tuple[np.ndarray, np.ndarray]  # m, from the centre of mass to the point that it is given, body axes


# Return a body's coordinates: of a body, its arm, how many directions there are, and the first of the body's own.
Coordinates = Callable[[int, np.ndarray, int, int], Sequence[Taylor]]


def variable(value: float, rate: float, second: float, size: int, place: int | None) -> Taylor:
    """Return a coordinate with its rates along the motion, and 1 along the direction `place` of its own."""
    first = np.zeros(size)
    first[0] = rate
    if place is not None:
        first[place] = 1.0
    return Taylor(value, first, second)


def write_user_rows(rows: Sequence[UserRow], coordinates: Coordinates, rates: int, t: float, into: Any) -> None:
    """Write C, C_dot, C_q and gamma of every constraint at t (s) into a core's rows.

    Along the motion C'' = C_q a + C''(a = 0), so that gamma = -C''(a = 0).
    """
    size = 1 + 2 * rates
    time = variable(t, 1.0, 0.0, size, None)
    for user in rows:
        places = [coordinates(user.bodies[k], user.arms[k], size, 1 + k * rates) for k in range(2)]
        value = user.function(time, *places)
        if not isinstance(value, Taylor):
            raise TypeError(
                f"constraint {user.name!r} is to return one number made of the coordinates that it is given; "
                f"it returned {value!r} ({type(value).__name__})"
            )
        here = user.slot, user.row
        into.residual[here], into.rate[here], into.gamma[here] = value.value, value.first[0], -value.second
        into.jacobian[user.slot, user.side, user.row] = value.first[1 : 1 + rates]
        into.jacobian[user.slot, 1 - user.side, user.row] = value.first[1 + rates :]
