"""Numbers that are none: a negative, zero, NaN or infinite mass; a start at NaN; overflow and NaN on the way."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.exact import swing
from cross_checks.extremes.extreme import Axis, Case, Extreme, grid
from cross_checks.extremes.parts import LENGTH, ROD_RATE, rod_chain
from cross_checks.truths.of import sky
from mbs_ref.scene import Force, PlanarBody, Scene, UserForce
from mbs_ref.scenes.orbits import kepler as kepler

FAMILY = "bad numbers"
STEP, RTOL = 1e-3, 1e-8
MASSES = (1.0, 1e-30, 1e30, 0.0, -1.0, math.nan, math.inf)  # kg
SPEEDS = (0.0, math.nan, math.inf)  # m/s
START = 0.5 * math.pi


def _exact_rod(times: np.ndarray) -> np.ndarray:
    theta = swing(times, ROD_RATE, START)
    return 0.5 * LENGTH * np.stack([np.sin(theta), -np.cos(theta)], axis=1)[:, None]


def _mass(kind: float) -> Case:
    """A swinging rod's motion does not depend on its mass, if it has one."""
    mass = MASSES[int(kind)]
    sound = rod_chain("rod_of_any_mass", (0.0,), (1.0,))
    body = sound.bodies[0].model_copy(update={"mass": mass, "inertia": mass / 12.0})
    scene = sound.model_copy(update={"bodies": (body,)})
    fine = math.isfinite(mass) and mass > 0.0
    return Case(scene, grid(1.0, STEP, 11), measures.positions(_exact_rod), step=STEP, rtol=RTOL, must_stop=not fine)


def _start(kind: float) -> Case:
    speed = SPEEDS[int(kind)]
    sound = rod_chain("rod_of_any_speed", (0.0,), (1.0,))
    body = sound.bodies[0].model_copy(update={"velocity": (0.0, 0.5 * speed), "angular_velocity": speed})
    scene = sound.model_copy(update={"bodies": (body,)})
    return Case(
        scene, grid(1.0, STEP, 11), measures.positions(_exact_rod), step=STEP, rtol=RTOL,
        must_stop=not math.isfinite(speed), unchecked=True,
    )  # fmt: skip


def _orbit(kind: float) -> Case:
    """A planet's speed that is no number: N-body codes carry it along without a word."""
    speed = SPEEDS[int(kind)]
    sound = kepler(eccentricity=0.2, orbits=1.0)
    center, planet = sound.bodies
    moved = planet.model_copy(update={"velocity": (speed, *planet.velocity[1:])}) if speed else planet
    scene = sound.model_copy(update={"bodies": (center, moved)})
    step = 2.0 * math.pi / 200.0
    return Case(
        scene, grid(200.0 * step, step, 11), measures.truth(sky.kepler), step=step, rtol=1e-10,
        must_stop=not math.isfinite(speed), unchecked=True,
    )  # fmt: skip


FORCES = (1.0, 1e50, 1e100, 1e150, 1e200, 1e300, 1.7e308)  # N


def _overflow(force: float) -> Case:
    """x = F t^2 / 2 m with 1 kg, in 10 s; beyond 1.8e308 m there is no number for it."""
    scene = Scene(
        name="overflow",
        bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),),
        loads=(Force(name="push", body="sled", point=(0.0, 0.0), vector=(force, 0.0)),),
    )

    def exact(times: np.ndarray) -> np.ndarray:
        return np.stack([force * (0.5 * times**2), 0.0 * times], axis=1)[:, None]

    fine = force < 3e306
    size = 50.0 * force if fine else 1.0
    return Case(scene, grid(10.0, 1e-2), measures.positions(exact, size), step=1e-2, rtol=RTOL, must_stop=not fine)


KINDS = ("sound", "NaN from 0.5 s on", "infinite from 0.5 s on", "raises at 0.5 s")
SWITCH = 0.5  # s


def _user(kind: float) -> Case:
    bad = (0.0, math.nan, math.inf, None)[int(kind)]

    def law(t, q, v):
        if t > SWITCH and bad is None:
            raise ZeroDivisionError("the user's law divided by zero")
        return np.full((1, 3), bad if t > SWITCH else 0.0)

    sound = rod_chain("rod_with_user_law", (0.0,), (1.0,))
    scene = Scene.model_validate(sound.model_copy(update={"loads": (UserForce(name="law", function=law),)}))
    return Case(scene, grid(1.0, 1e-2, 11), measures.positions(_exact_rod), step=1e-2, rtol=RTOL, must_stop=kind > 0.0)


EXTREMES = (
    Extreme("any-mass", FAMILY, "A swinging rod of any mass, sensible or not, past the checks of scenes.",
            Axis("mass", "kg", tuple(float(k) for k in range(len(MASSES))), tuple(f"{m:g} kg" for m in MASSES)), _mass),
    Extreme("any-start", FAMILY, "A swinging rod whose speed at the start is not a number.",
            Axis("speed", "rad/s", (0.0, 1.0, 2.0), tuple(f"{s:g} rad/s" for s in SPEEDS)), _start),
    Extreme("any-orbit", FAMILY, "A planet whose speed at the start is not a number.",
            Axis("speed", "m/s", (0.0, 1.0, 2.0), ("as it should be", "nan m/s", "inf m/s")), _orbit, good=1e-2),
    Extreme("overflow", FAMILY, "A constant force until the place overflows.", Axis("force", "N", FORCES), _overflow),
    Extreme("user-law", FAMILY, "A user's force law that breaks in the middle of a run.",
            Axis("law", "", (0.0, 1.0, 2.0, 3.0), KINDS), _user),
)  # fmt: skip
