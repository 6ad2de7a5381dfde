"""Input that is no input: numbers that are none, overflow on the way, and starts that break their own joints.

A start breaks a joint by a wrong place or speed; Euler parameters with a norm other than 1 are no rotation.
"""

import math
from typing import Any

import numpy as np

from cross_checks.extremes import Case, by_positions, by_truth, grid, in_plane, invariants
from cross_checks.extremes.parts import LENGTH, ROD_RATE, hanging, made, rod_chain, sled, swing
from cross_checks.truths.of import sky, tops
from mbs_ref import scenes
from mbs_ref.scene import Scene, UserForce

MASSES = (1.0, 1e-30, 1e30, 0.0, -1.0, math.nan, math.inf)  # kg
SPEEDS = (0.0, math.nan, math.inf)  # m/s, rad/s
SWITCH = 0.5  # s
TINY = 1e-11  # m, m/s: a smaller gap is roundoff, and nobody should stop
TOLERABLE = 1e-8  # m, m/s: a smaller gap changes nothing that anybody could measure here
SWING = by_positions(lambda times: hanging(swing(times, ROD_RATE, 0.5 * math.pi), 0.5 * LENGTH))


def _rod(name: str, **changes: Any) -> Scene:
    """Return a rod that is released level, with changes of its body that no scene would accept."""
    sound = rod_chain(name, (0.0,), (1.0,))
    return sound.model_copy(update={"bodies": (sound.bodies[0].model_copy(update=changes),)})


def _mass(kind: float) -> Case:
    """A swinging rod's motion does not depend on its mass, if it has one."""
    mass = MASSES[int(kind)]
    scene = _rod("rod_of_any_mass", mass=mass, inertia=mass / 12.0)
    return Case(scene, grid(1.0, samples=11), SWING, must_stop=not (math.isfinite(mass) and mass > 0.0))


def _start(kind: float) -> Case:
    speed = SPEEDS[int(kind)]
    scene = _rod("rod_of_any_speed", velocity=(0.0, 0.5 * speed), angular_velocity=speed)
    return Case(scene, grid(1.0, samples=11), SWING, must_stop=not math.isfinite(speed), unchecked=True)


def _orbit(kind: float) -> Case:
    """A planet's speed that is no number: N-body codes carry it along without a word."""
    speed = SPEEDS[int(kind)]
    sound = scenes.make("kepler", eccentricity=0.2, orbits=1.0)
    center, planet = sound.bodies
    moved = planet.model_copy(update={"velocity": (speed, *planet.velocity[1:])}) if speed else planet
    scene = sound.model_copy(update={"bodies": (center, moved)})
    step = 2.0 * math.pi / 200.0
    return Case(
        scene, grid(200.0 * step, step, 11), by_truth(sky.kepler), step, 1e-10,
        must_stop=not math.isfinite(speed), unchecked=True,
    )  # fmt: skip


def _overflow(force: float) -> Case:
    """x = F t^2 / 2 m with 1 kg, in 10 s; beyond 1.8e308 m there is no number for it."""
    is_sound = force < 3e306
    exact = by_positions(lambda times: in_plane(force * (0.5 * times**2), 0.0), 50.0 * force if is_sound else 1.0)
    return Case(sled("overflow", force), grid(10.0, 1e-2), exact, 1e-2, must_stop=not is_sound)


def _user(kind: float) -> Case:
    bad = (0.0, math.nan, math.inf, None)[int(kind)]

    def law(t, q, v):
        if t > SWITCH and bad is None:
            raise ZeroDivisionError("the user's law divided by zero")
        return np.full((1, 3), bad if t > SWITCH else 0.0)

    sound = _rod("rod_with_user_law")
    scene = Scene.model_validate(sound.model_copy(update={"loads": (UserForce(name="law", function=law),)}))
    return Case(scene, grid(1.0, 1e-2, 11), SWING, 1e-2, must_stop=kind > 0.0)


def _place(gap: float) -> Case:
    return _broken(made("broken_pendulum", gap=gap), gap)


def _moving(gap: float) -> Case:
    """A second rod that moves away from its hinge."""
    sound = rod_chain("broken_chain", (0.0, 0.5), (1.0, 1.0))
    first, second = sound.bodies
    moved = second.model_copy(update={"velocity": (0.6 * gap, 0.8 * gap)})
    return _broken(sound.model_copy(update={"bodies": (first, moved)}), gap)


def _broken(scene: Scene, gap: float) -> Case:
    stops = {"must_stop": gap > TOLERABLE, "may_stop": gap > TINY}
    return Case(scene, grid(0.5, samples=11), invariants, unchecked=True, **stops)


def _norm(gap: float) -> Case:
    """Refusing is right, and so is the motion of the rotation that normalising leaves."""
    sound = scenes.make("torque_free_top", turns=1.0, axis=3)
    top: Any = sound.bodies[0]
    stretched = tuple((np.array(top.orientation) * (1.0 + gap)).tolist())
    scene: Scene = sound.model_copy(update={"bodies": (top.model_copy(update={"orientation": stretched}),)})
    solve = tops.torque_free_top
    exact = by_truth(lambda _, times: solve(sound, times))
    return Case(scene, grid(0.6, samples=11), exact, may_stop=gap > TINY)


CASES = {
    "any-mass": _mass,
    "any-start": _start,
    "any-orbit": _orbit,
    "overflow": _overflow,
    "user-law": _user,
    "wrong-place": _place,
    "wrong-speed": _moving,
    "wrong-norm": _norm,
}
