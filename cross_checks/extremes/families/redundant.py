"""More constraints than needed: one hinge made many times over, and a plate on too many cranks."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.exact import swing
from cross_checks.extremes.extreme import Axis, Case, Extreme, grid
from cross_checks.extremes.parts import GRAVITY, INERTIA, LENGTH, ROD_RATE, rod, tip
from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene

FAMILY = "redundancy"
STEP, RTOL = 1e-3, 1e-8
DOWN = -0.5 * math.pi  # rad, from the x axis


def _pins(count: float) -> Case:
    start = 1.0  # rad from the lowest place
    body = rod("rod", (0.0, 0.0), DOWN + start)
    pins = tuple(
        Revolute(name=f"pin{k + 1}", body_a=GROUND, body_b="rod", point=(0.0, 0.0)) for k in range(round(count))
    )
    scene = Scene(name="many_pins", gravity=(0.0, -GRAVITY), bodies=(body,), joints=pins)

    def exact(times: np.ndarray) -> np.ndarray:
        theta = swing(times, ROD_RATE, start)
        return 0.5 * LENGTH * np.stack([np.sin(theta), -np.cos(theta)], axis=1)[:, None]

    return Case(scene, grid(2.0, STEP), measures.positions(exact), step=STEP, rtol=RTOL)


def _cranks(count: float) -> Case:
    """n cranks of 1 kg and a plate of n kg: theta'' = -g (n/2 + n) / (n/3 + n) sin(theta)."""
    n, start = round(count), 1.0
    feet = [(float(k), 0.0) for k in range(n)]
    top = tip((0.0, 0.0), DOWN + start)
    cranks = tuple(rod(f"crank{k + 1}", foot, DOWN + start) for k, foot in enumerate(feet))
    middle = (top[0] + 0.5 * (n - 1), top[1])
    plate = PlanarBody(name="plate", mass=float(n), inertia=n * INERTIA, position=middle)
    joints = tuple(
        joint
        for k, foot in enumerate(feet)
        for joint in (
            Revolute(name=f"foot{k + 1}", body_a=GROUND, body_b=f"crank{k + 1}", point=foot),
            Revolute(name=f"head{k + 1}", body_a=f"crank{k + 1}", body_b="plate", point=tip(foot, DOWN + start)),
        )
    )
    scene = Scene(name="many_cranks", gravity=(0.0, -GRAVITY), bodies=(*cranks, plate), joints=joints)

    def exact(times: np.ndarray) -> np.ndarray:
        theta = swing(times, math.sqrt(GRAVITY * 1.5 / (4.0 / 3.0)), start)
        reach = np.stack([np.sin(theta), -np.cos(theta)], axis=1)[:, None]
        return np.concatenate([np.array(feet) + 0.5 * reach, np.array([0.5 * (n - 1), 0.0]) + reach], axis=1)

    return Case(scene, grid(2.0, STEP), measures.positions(exact), step=STEP, rtol=RTOL)


EXTREMES = (
    Extreme("repeated-pins", FAMILY, "A rod swings on one hinge that is modelled many times over.",
            Axis("hinges", "", (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)), _pins),
    Extreme("parallel-cranks", FAMILY, "A plate swings on parallel cranks, of which two would do.",
            Axis("cranks", "", (2.0, 3.0, 4.0, 6.0, 10.0, 16.0)), _cranks),
)  # fmt: skip
