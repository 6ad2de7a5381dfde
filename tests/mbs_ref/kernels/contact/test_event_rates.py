"""The rates of event functions against differences of the functions along the motion, beyond open ends too."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators.loop.events import event_tables
from mbs_ref.kernels.answers import call_roots
from mbs_ref.kernels.contact.laws import MODE_LEAVING, MODE_OPEN, RATE, SPEED, UNKNOWN, VALUE
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.contact import CircleOnLine, PinOnSprocket, SphereOnPlane, SpringDamperLaw

LAW = SpringDamperLaw(stiffness=1e5, damping=10.0)
STEP = 1e-5  # s


def in_the_plane(x: float) -> Scene:
    """A disc over a plate, both turning; its middle is at x, and the plate ends at 1 m."""
    moving = {"mass": 1.0, "inertia": 0.1}
    return Scene(
        name="plate", duration=1.0, gravity=(0.0, -9.81),
        bodies=(
            PlanarBody(name="disc", position=(x, 0.4), velocity=(0.7, -0.9), angular_velocity=2.0, **moving),
            PlanarBody(name="plate", position=(0.1, -0.2), velocity=(-0.4, 0.3), angular_velocity=-1.5, **moving),
        ),
        contacts=(
            CircleOnLine(
                name="rim", law=LAW, body_a="disc", center=(x, 0.3), radius=0.1, body_b="plate", point_1=(-1.0, 0.1),
                point_2=(1.0, 0.2), extent="segment",
            ),
        ),
    )  # fmt: skip


def on_a_sprocket(x: float) -> Scene:
    moving = {"mass": 1.0, "inertia": 0.1}
    return Scene(
        name="sprocket", duration=1.0, gravity=(0.0, 0.0),
        bodies=(
            PlanarBody(name="pin", position=(x, 0.3), velocity=(0.7, -0.9), angular_velocity=2.0, **moving),
            PlanarBody(name="wheel", position=(0.1, -0.2), velocity=(-0.4, 0.3), angular_velocity=-1.5, **moving),
        ),
        contacts=(
            PinOnSprocket(
                name="tooth", law=LAW, body_a="pin", center=(x, 0.25), body_b="wheel", axle=(0.0, 0.0), teeth=9,
                pitch_radius=0.5, addendum_radius=0.6, clearance=0.01,
            ),
        ),
    )  # fmt: skip


def in_space(x: float, y: float) -> Scene:
    """A sphere over a rectangle of 2 m by 1 m, both turning."""
    moving = {"mass": 1.0, "inertia": (0.1, 0.2, 0.15, 0.01, 0.02, 0.0)}
    return Scene(
        name="rectangle", duration=1.0, gravity=(0.0, 0.0, -9.81),
        bodies=(
            SpatialBody(
                name="ball", position=(x, y, 0.4), velocity=(0.7, -0.6, -0.9), angular_velocity=(2.0, 1.0, -1.0),
                **moving,
            ),
            SpatialBody(
                name="plate", position=(0.1, 0.1, -0.2), velocity=(-0.4, 0.2, 0.3), angular_velocity=(0.5, -1.5, 1.0),
                **moving,
            ),
        ),
        contacts=(
            SphereOnPlane(
                name="rim", law=LAW, body_a="ball", center=(x, y, 0.3), radius=0.1, body_b="plate",
                point=(0.0, 0.0, 0.1), normal=(0.0, 0.0, 1.0), edge=(1.0, 0.0, 0.0), size=(2.0, 1.0),
                extent="rectangle",
            ),
        ),
    )  # fmt: skip


SCENES = {
    "over the line": in_the_plane(0.3), "past its end": in_the_plane(1.6), "before its start": in_the_plane(-1.7),
    "in a tooth gap": on_a_sprocket(0.45), "out of all teeth": on_a_sprocket(1.4),
    "over the rectangle": in_space(0.3, 0.1), "past a long side": in_space(0.2, 1.2),
    "past a short side": in_space(-1.8, 0.2),
}  # fmt: skip


@pytest.mark.parametrize("mode", [MODE_OPEN, MODE_LEAVING])
@pytest.mark.parametrize("name", SCENES)
def test_the_rate_of_an_event_function_is_its_derivative_along_the_motion(name, mode):
    system = compile_scene(SCENES[name])
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    system.groups.contact_modes.mode[0] = mode
    _, table = event_tables(system.model)

    def functions(state: np.ndarray) -> np.ndarray:
        call_roots(system.model, system.work, 0.0, state, 0.0, table.new)
        return table.new[VALUE].copy()

    slope = system.derivative(0.0, y)
    difference = (functions(y + STEP * slope) - functions(y - STEP * slope)) / (2.0 * STEP)
    functions(y)
    known = table.new[RATE] != 0.0
    assert known.tolist() == [True, False, False, mode != MODE_OPEN]
    assert table.new[RATE, known] == pytest.approx(difference[known], rel=1e-7)
    assert np.all((np.abs(difference) <= table.new[SPEED] * (1.0 + 1e-7)) | (table.new[SPEED] == UNKNOWN))
