"""Singular poses: parallelograms through flat, starts next to it, dead centres, a driven lock, Bricard's loop."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.exact import swing
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.extremes.parts import GRAVITY, INERTIA, LENGTH, rod, tip
from cross_checks.truths.of import loops
from mbs_ref import scenes
from mbs_ref.scene import GROUND, CoordinateDrive, PlanarBody, Prismatic, Revolute, Scene
from mbs_ref.scene.signals import Constant
from mbs_ref.scenes.slider_cranks import crank_rod_slider
from mbs_ref.scenes.slider_cranks import slider_crank as slider_crank

FAMILY = "singular poses"
STEP, RTOL = 1e-3, 1e-8


def _loops(count: float) -> Case:
    scene = scenes.make("n_four_bar", loops=round(count))
    return Case(scene, grid(2.0, STEP), measures.truth(loops.n_four_bar), step=STEP, rtol=RTOL)


def _near_flat(gap: float) -> Case:
    """Two cranks and a coupler at rest, `gap` below flat. Exactly flat, two motions are possible: refusing is right."""
    start = 0.5 * math.pi - gap  # rad from the lowest place
    angle = start - 0.5 * math.pi  # rad from the x axis
    feet = ((0.0, 0.0), (1.0, 0.0))
    cranks = tuple(rod(f"crank{k + 1}", foot, angle) for k, foot in enumerate(feet))
    left = tip(feet[0], angle)
    coupler = PlanarBody(name="coupler", mass=1.0, inertia=INERTIA, position=(left[0] + 0.5, left[1]))
    joints = (
        *(Revolute(name=f"foot{k + 1}", body_a=GROUND, body_b=f"crank{k + 1}", point=f) for k, f in enumerate(feet)),
        Revolute(name="left", body_a="crank1", body_b="coupler", point=left),
        Revolute(name="right", body_a="coupler", body_b="crank2", point=tip(feet[1], angle)),
    )
    scene = Scene(name="near_flat", gravity=(0.0, -GRAVITY), bodies=(*cranks, coupler), joints=joints)

    def exact(times: np.ndarray) -> np.ndarray:
        """[2/3 + 1] theta'' = -2 g sin(theta) for cranks and coupler of 1 kg."""
        theta = swing(times, math.sqrt(1.2 * GRAVITY / LENGTH), start)
        reach = np.stack([np.sin(theta), -np.cos(theta)], axis=1)[:, None]
        return np.concatenate([np.array(feet) + 0.5 * reach, np.array([0.5, 0.0]) + reach], axis=1)

    return Case(scene, grid(0.8, STEP), measures.positions(exact), step=STEP, rtol=RTOL, may_stop=not gap)


def _dead_centre(excess: float) -> Case:
    """The rod is longer than the crank by `excess`: at 90 degrees the rod whips from side to side."""
    scene = slider_crank(crank_length=0.5, rod_length=0.5 + excess)
    return Case(scene, grid(1.0, STEP, 41), measures.invariants(), step=STEP, rtol=RTOL)


SPEED, CRANK, START = 2.0, 0.5, 0.25  # rad/s, m, rad


def _lock(lack: float) -> Case:
    """A drive turns the crank beyond where the rod reaches: r sin(phi) = l, and no motion satisfies the joints."""
    length = CRANK * (1.0 - lack) if lack else 1.2 * CRANK
    measure = measures.unjudged if lack else measures.positions(lambda times: _prescribed(length, times))
    return Case(_driven(length), grid(1.0, STEP), measure, step=STEP, rtol=RTOL, must_stop=bool(lack))


def _prescribed(length: float, times: np.ndarray) -> np.ndarray:
    """The motor turns evenly, so every place follows."""
    parts = [crank_rod_slider(CRANK, length, 1.0, 1.5, 2.0, START + SPEED * float(t), SPEED) for t in times]
    return np.array([[body.position for body in bodies] for bodies in parts])


def _driven(length: float) -> Scene:
    """Return a slider-crank with a motor on its crank and a rod that may be the shorter."""
    crank, link, slider = crank_rod_slider(CRANK, length, 1.0, 1.5, 2.0, START, SPEED)
    pin = (CRANK * math.cos(START), CRANK * math.sin(START))
    joints = (
        Revolute(name="bearing", body_a=GROUND, body_b="crank", point=(0.0, 0.0)),
        Revolute(name="crank_pin", body_a="crank", body_b="rod", point=pin),
        Revolute(name="wrist_pin", body_a="rod", body_b="slider", point=slider.position),
        Prismatic(name="guide", body_a=GROUND, body_b="slider", point=slider.position, axis=(1.0, 0.0)),
        CoordinateDrive(name="motor", body="crank", coordinate="angle", motion=Constant(value=SPEED), level="velocity"),
    )
    return Scene(name="driven_lock", gravity=(0.0, -GRAVITY), bodies=(crank, link, slider), joints=joints)


def _bricard(duration: float) -> Case:
    times = grid(duration, 2e-3)
    return Case(scenes.make("bricard"), times, measures.invariants(), step=2e-3, rtol=RTOL)


EXTREMES = (
    Extreme("n-four-bar", FAMILY, "Parallelogram loops in a row fall through their flat pose, where branches cross.",
            Axis("loops", "", (1.0, 2.0, 4.0, 8.0, 16.0), full=(32.0, 64.0)), _loops),
    Extreme("near-flat-start", FAMILY, "A parallelogram released at rest ever closer to flat, and flat at last.",
            Axis("angle to flat", "rad", (*decades(1e-1, 1e-15, 2.0), 0.0)), _near_flat, good=1e-2),
    Extreme("dead-centre", FAMILY, "A slider-crank whose rod is hardly longer than its crank; energy and joints.",
            Axis("excess of the rod", "m", (0.7, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)), _dead_centre, good=1e-2),
    Extreme("driven-lock", FAMILY, "A motor turns a crank further than the rod reaches: the mechanism locks.",
            Axis("lack of the rod", "", (0.0, 1e-3, 1e-2, 1e-1, 0.3)), _lock, good=1e-2),
    Extreme("bricard", FAMILY, "Bricard's overconstrained loop for ever longer; energy and joints are judged.",
            Axis("duration", "s", (0.2, 1.0, 2.0, 5.0), full=(10.0, 30.0)), _bricard, good=1e-2),
)  # fmt: skip
