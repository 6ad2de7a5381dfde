"""Inertia near zero, and needles."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.exact import swing
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.extremes.parts import GRAVITY, INERTIA, LENGTH, rod, tip
from cross_checks.truths.of import tops
from mbs_ref import scenes
from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene

FAMILY = "inertia"
STEP, RTOL = 1e-3, 1e-8
THINNEST = 5e-3  # moment ratio


def _needle(ratio: float) -> Case:
    scene = scenes.make(
        "torque_free_top", spin=10.0, axis=3, tilt=0.1, turns=2.0,
        inertia_1=ratio, inertia_2=1.0, inertia_3=1.0 + 0.5 * ratio,
    )  # fmt: skip
    # thinner needles turn so fast about themselves that the truth's quadrature has too many pieces for a quick look
    measure = measures.truth(tops.torque_free_top) if ratio >= THINNEST else measures.invariants()
    return Case(scene, grid(1.256, STEP), measure, step=STEP, rtol=RTOL)


def _wheel(inertia: float) -> Case:
    """A wheel hinged at its centre to the tip of a rod does not turn: it swings as a particle does."""
    start = 1.0
    angle = start - 0.5 * math.pi
    end = tip((0.0, 0.0), angle)
    bodies = (rod("rod", (0.0, 0.0), angle), PlanarBody(name="wheel", mass=1.0, inertia=inertia, position=end))
    joints = (
        Revolute(name="pivot", body_a=GROUND, body_b="rod", point=(0.0, 0.0)),
        Revolute(name="axle", body_a="rod", body_b="wheel", point=end),
    )
    scene = Scene(name="wheel_on_rod", gravity=(0.0, -GRAVITY), bodies=bodies, joints=joints)
    rate = math.sqrt(GRAVITY * 1.5 * LENGTH / (INERTIA + 0.25 + LENGTH**2))

    def exact(times: np.ndarray) -> np.ndarray:
        theta = swing(times, rate, start)
        reach = LENGTH * np.stack([np.sin(theta), -np.cos(theta)], axis=1)[:, None]
        return np.concatenate([0.5 * reach, reach], axis=1)

    return Case(scene, grid(2.0, STEP), measures.positions(exact), step=STEP, rtol=RTOL)


EXTREMES = (
    Extreme("needle", FAMILY, "A free body with one ever smaller principal moment, spun across it.",
            Axis("moment ratio", "", (0.5, 0.1, 1e-2, THINNEST, 1e-3, 1e-4, 1e-6, 1e-8)), _needle),
    Extreme("tiny-wheel", FAMILY, "A wheel of ever smaller inertia on the tip of a swinging rod.",
            Axis("inertia", "kg m^2", decades(1e-1, 1e-17, 2.0)), _wheel),
)  # fmt: skip
