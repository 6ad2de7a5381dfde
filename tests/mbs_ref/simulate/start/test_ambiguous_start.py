"""A start at rest where branches meet: refused, unless something tells where to go."""

from __future__ import annotations

import math

import pytest

from mbs_ref.scene import PlanarBody, Revolute, Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status


def parallelogram(turn: float = 0.0, speed: float = 0.0) -> Scene:
    """Two cranks of 1 m and a coupler of 2 m; at turn = 0 all lie on one line, where it may leave as a kite."""
    c, s = math.cos(turn), math.sin(turn)
    pins = {"a": (0.0, 0.0), "b": (c, s), "c": (2.0 + c, s), "d": (2.0, 0.0)}

    def link(name: str, p: str, q: str, spin: float) -> PlanarBody:
        (x0, y0), (x1, y1) = pins[p], pins[q]
        middle, angle = ((x0 + x1) / 2, (y0 + y1) / 2), math.atan2(y1 - y0, x1 - x0)
        velocity = (-speed * s, speed * c) if name == "coupler" else (-spin * s / 2, spin * c / 2)
        return PlanarBody(name=name, mass=1.0, inertia=0.1, position=middle, angle=angle, velocity=velocity,
                          angular_velocity=spin)  # fmt: skip

    cranks = link("left", "a", "b", speed), link("right", "d", "c", speed)
    joints = (("ground", "left", "a"), ("left", "coupler", "b"), ("coupler", "right", "c"), ("right", "ground", "d"))
    return Scene(
        name="parallelogram", gravity=(0.0, 0.0), bodies=(*cranks, link("coupler", "b", "c", 0.0)),
        joints=tuple(Revolute(name=pin, body_a=a, body_b=b, point=pins[pin]) for a, b, pin in joints),
    )  # fmt: skip


BRIEF = Settings(method="dop853", rtol=1e-8, t_end=0.01, samples=2)


def test_a_change_point_at_rest_is_refused_with_its_rank():
    run = simulate(parallelogram(), BRIEF)
    assert run.status is Status.SINGULAR
    assert "C_q has rank 7 there and more next to it" in run.message


@pytest.mark.parametrize("start", [{"turn": 0.3}, {"speed": 1.0}], ids=["elsewhere", "moving"])
def test_another_pose_or_a_speed_determines_the_motion(start):
    run = simulate(parallelogram(**start), BRIEF)
    assert run.ok, run.message
