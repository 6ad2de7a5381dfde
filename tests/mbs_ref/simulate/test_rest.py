"""Contact without rebound lasts, and opens when its force would pull."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

GRAVITY, OMEGA, AMPLITUDE, HEIGHT, RADIUS = 9.81, 12.0, 0.1, 0.2, 0.05


def ball_over_table(dimension: int) -> Scene:
    """A ball falls on a table that vibrates, y = A (1 - cos(omega t)), without rebound."""

    def point(*values: float) -> tuple[float, ...]:
        return (*values, *(0.0,) * (dimension - len(values)))

    up = (0.0, 1.0, 0.0)[:dimension]
    table, ball = {"name": "table", "mass": 5.0, "position": point(0.0)}, {"name": "ball", "mass": 1.0}
    ball |= {"type": "point_mass", "position": point(0.0, RADIUS + HEIGHT), "velocity": point(0.0)}
    kind = (
        {"type": "planar", "inertia": 1.0}
        if dimension == 2
        else {"type": "spatial", "inertia": (1.0,) * 3 + (0.0,) * 3}
    )
    motion = {"type": "harmonic", "amplitude": -AMPLITUDE, "omega": OMEGA, "phase": math.pi / 2, "offset": AMPLITUDE}
    guide = {
        "type": "prismatic",
        "name": "guide",
        "body_a": "table",
        "body_b": "ground",
        "point": point(0.0),
        "axis": up,
    }
    drive = {"type": "coordinate_drive", "name": "drive", "body": "table", "coordinate": "y", "motion": motion}
    touch = {"name": "touch", "body_a": "ball", "body_b": "table", "radius": RADIUS, "center": ball["position"]}
    touch |= {"law": {"type": "rigid_law", "restitution": 0.0}}
    flat = {"type": "circle_on_line", "point_1": (-1.0, 0.0), "point_2": (1.0, 0.0)}
    plane = {"type": "sphere_on_plane", "point": point(0.0), "normal": up}
    return Scene.model_validate({
        "name": "ball_over_table", "duration": 0.8, "gravity": tuple(-GRAVITY * x for x in up),
        "bodies": [table | kind, ball], "joints": [guide, drive],
        "contacts": [touch | (flat if dimension == 2 else plane)],
    })  # fmt: skip


def table(t: float) -> float:
    return AMPLITUDE * (1.0 - math.cos(OMEGA * t))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_ball_rides_a_vibrating_table_until_its_force_would_pull(dimension):
    """It parts where the table's acceleration, A omega^2 cos(omega t), is -g, with the table's speed."""
    run = simulate(ball_over_table(dimension), Settings(rtol=1e-12, estimate="off"))
    assert run.ok, run.message
    assert run.event_times is not None
    lands = brentq(lambda t: HEIGHT - 0.5 * GRAVITY * t**2 - table(t), 0.1, 0.15, xtol=1e-14)
    parts = math.acos(-GRAVITY / (AMPLITUDE * OMEGA**2)) / OMEGA
    speed = AMPLITUDE * OMEGA * math.sin(OMEGA * parts)
    up = lambda t: table(parts) + speed * (t - parts) - 0.5 * GRAVITY * (t - parts) ** 2  # noqa: E731
    again = brentq(lambda t: up(t) - table(t), 0.4, 0.6, xtol=1e-14)
    exact = [lands, parts, again, parts + 2.0 * math.pi / OMEGA]
    assert np.abs(run.event_times[:, 0] - exact).max() < 1e-10


@pytest.mark.parametrize(("balls", "gap"), [(2, 1e-3), (5, 1e-3), (6, 0.0)])
def test_a_row_without_rebound_moves_on_together(balls, gap):
    run = simulate(scenes.make("newtons_cradle", restitution=0.0, balls=balls, gap=gap), Settings(estimate="off"))
    assert run.ok, run.message
    assert np.abs(run.velocity[-1, :, 0] - 1.0 / balls).max() < 1e-12
