"""Singular poses and redundant constraints: flat parallelograms, dead centres, a driven lock, repeated hinges."""

import math

import numpy as np

from cross_checks.extremes import Case, by_positions, grid, invariants, unjudged
from cross_checks.extremes.parts import GRAVITY, INERTIA, LENGTH, ROD_RATE, hanging, pin, rod, swing, tip
from mbs_ref.scene import GROUND, CoordinateDrive, PlanarBody, Prismatic, Scene
from mbs_ref.scene.signals import Constant
from mbs_ref.scenes.slider_cranks import crank_rod_slider
from mbs_ref.scenes.slider_cranks import slider_crank as slider_crank

DOWN = -0.5 * math.pi  # rad, from the x axis


def _pins(count: float) -> Case:
    start, origin = 1.0, (0.0, 0.0)  # rad from the lowest place
    pins = tuple(pin(f"pin{k + 1}", GROUND, "rod", origin) for k in range(round(count)))
    body = rod("rod", origin, DOWN + start)
    scene = Scene(name="many_pins", gravity=(0.0, -GRAVITY), bodies=(body,), joints=pins)
    exact = by_positions(lambda times: hanging(swing(times, ROD_RATE, start), 0.5 * LENGTH))
    return Case(scene, grid(2.0), exact)


def _parallelogram(name: str, n: int, mass: float, start: float, t_end: float, **stops: bool) -> Case:
    """Let n cranks of 1 kg and a plate of `mass` (kg) go at `start` (rad from the lowest place).

    theta'' = -g (n/2 + mass) / (n/3 + mass) sin(theta).
    """
    angle = DOWN + start
    feet = [(float(k), 0.0) for k in range(n)]
    left, middle = tip(feet[0], angle), 0.5 * (n - 1)
    plate = PlanarBody(name="plate", mass=mass, inertia=mass * INERTIA, position=(left[0] + middle, left[1]))
    cranks = tuple(rod(f"crank{k + 1}", foot, angle) for k, foot in enumerate(feet))
    joints = tuple(
        joint
        for k, foot in enumerate(feet, 1)
        for joint in (
            pin(f"foot{k}", GROUND, f"crank{k}", foot),
            pin(f"head{k}", f"crank{k}", "plate", tip(foot, angle)),
        )
    )
    scene = Scene(name=name, gravity=(0.0, -GRAVITY), bodies=(*cranks, plate), joints=joints)
    rate = math.sqrt(GRAVITY * (0.5 * n + mass) / (n / 3.0 + mass))

    def exact(times: np.ndarray) -> np.ndarray:
        reach = hanging(swing(times, rate, start))
        return np.concatenate([np.array(feet) + 0.5 * reach, np.array([middle, 0.0]) + reach], axis=1)

    return Case(scene, grid(t_end), by_positions(exact), **stops)


SPEED, CRANK, START = 2.0, 0.5, 0.25  # rad/s, m, rad


def _lock(lack: float) -> Case:
    """A drive turns the crank beyond where the rod reaches: r sin(phi) = l, and no motion satisfies the joints."""
    length = CRANK * (1.0 - lack) if lack else 1.2 * CRANK
    measure = unjudged if lack else by_positions(lambda times: _prescribed(length, times))
    return Case(_driven(length), grid(1.0), measure, must_stop=bool(lack))


def _prescribed(length: float, times: np.ndarray) -> np.ndarray:
    """The motor turns evenly, so every place follows."""
    parts = [crank_rod_slider(CRANK, length, 1.0, 1.5, 2.0, START + SPEED * float(t), SPEED) for t in times]
    return np.array([[body.position for body in bodies] for bodies in parts])


def _driven(length: float) -> Scene:
    """Return a slider-crank with a motor on its crank and a rod that may be the shorter."""
    bodies = crank_rod_slider(CRANK, length, 1.0, 1.5, 2.0, START, SPEED)
    end = bodies[2].position
    joints = (
        pin("bearing", GROUND, "crank", (0.0, 0.0)),
        pin("crank_pin", "crank", "rod", (CRANK * math.cos(START), CRANK * math.sin(START))),
        pin("wrist_pin", "rod", "slider", end),
        Prismatic(name="guide", body_a=GROUND, body_b="slider", point=end, axis=(1.0, 0.0)),
        CoordinateDrive(name="motor", body="crank", coordinate="angle", motion=Constant(value=SPEED), level="velocity"),
    )
    return Scene(name="driven_lock", gravity=(0.0, -GRAVITY), bodies=bodies, joints=joints)


CASES = {
    "repeated-pins": _pins,
    "parallel-cranks": lambda count: _parallelogram("many_cranks", round(count), float(round(count)), 1.0, 2.0),
    # released at rest `gap` (rad) below flat; exactly flat, two motions are possible: refusing is right
    "near-flat-start": lambda gap: _parallelogram("near_flat", 2, 1.0, 0.5 * math.pi - gap, 0.8, may_stop=not gap),
    # the rod is longer than the crank by `excess`: at 90 degrees the rod whips from side to side
    "dead-centre": lambda excess: Case(
        slider_crank(crank_length=0.5, rod_length=0.5 + excess), grid(1.0, samples=41), invariants
    ),
    "driven-lock": _lock,
}
