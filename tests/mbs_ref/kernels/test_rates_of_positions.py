"""The rates that rates of positions mean are the inverse of those of positions, in every core."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.answers import EVENTS
from mbs_ref.kernels.border.questions import position_rate, rate_from
from mbs_ref.kernels.jit import jit
from mbs_ref.scene import Scene


@jit
def there_and_back(model, y, rate, moved, out):
    position_rate(model, y, rate, moved)
    rate_from(model, y, moved, out)


def two_bodies(dimension: int) -> Scene:
    kind = (
        {"type": "planar", "inertia": 1.0}
        if dimension == 2
        else {"type": "spatial", "inertia": (1.0, 2.0, 2.5, 0, 0, 0)}
    )
    point, axis = (0.3, 0.1, 0.2)[:dimension], {} if dimension == 2 else {"axis": (0.0, 0.6, 0.8)}
    free = {"orientation": (0.5, 0.5, -0.5, 0.5)} if dimension == 3 else {}
    hinge = {"type": "revolute", "name": "hinge", "body_a": "a", "body_b": "ground", "point": point}
    bodies = [
        {"name": name, "mass": 1.0, "position": (float(k), 0.0, 0.0)[:dimension]} | kind for k, name in enumerate("ab")
    ]
    event = {"type": "coordinate_event", "name": "event", "body": "b", "coordinate": "x", "value": 9.0}
    return Scene.model_validate({
        "name": "two", "gravity": (0.0,) * dimension, "bodies": [bodies[0], bodies[1] | free],
        "joints": [hinge | axis], "events": [event],
    })  # fmt: skip


@pytest.mark.parametrize("coordinates", ["cartesian", "relative"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_rates_come_back(dimension, coordinates):
    system = compile_scene(two_bodies(dimension), coordinates)
    system.prepare(EVENTS)
    y = system.reduced(system.redundant.initial_state())
    n = system.n_positions
    rate = np.random.default_rng(0).normal(size=len(y) - n)
    moved, out = np.zeros(n), np.zeros(len(rate))
    there_and_back(system.model, y, rate, moved, out)
    assert out == pytest.approx(rate, abs=1e-14)
