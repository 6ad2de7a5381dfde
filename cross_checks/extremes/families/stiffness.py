"""Springs from 1e2 to 1e14 N/m: quiet, where only stability is at stake, and ringing, where the motion is fast."""

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Case, grid
from mbs_ref.scene import GROUND, PlanarBody, Prismatic, Scene, SpringDamper

SOFT = 2.0 * (2.0 * math.pi) ** 2  # N/m: two masses of 1 kg swing at 1 Hz
SHIFT = 0.1  # m


def _slider(name: str, x: float) -> tuple[PlanarBody, Prismatic]:
    body = PlanarBody(name=name, mass=1.0, inertia=0.1, position=(x, 0.0))
    return body, Prismatic(name=f"guide.{name}", body_a=GROUND, body_b=name, point=(x, 0.0), axis=(1.0, 0.0))


def _spring(name: str, a: str, b: str, ends: tuple[float, float], stiffness: float) -> SpringDamper:
    return SpringDamper(
        name=name, body_a=a, body_b=b, point_a=(ends[0], 0.0), point_b=(ends[1], 0.0), stiffness=stiffness,
        rest_length=1.0,
    )  # fmt: skip


def _quiet(stiffness: float) -> Case:
    """Start in the slow mode alone: x = rest + shape cos(w t), w^2 the small root of the 2 x 2 problem."""
    large = 0.5 * (SOFT + 2.0 * stiffness + math.hypot(SOFT, 2.0 * stiffness))
    slow = SOFT * stiffness / large  # the product of the roots is known, their difference would cancel
    shape = SHIFT * np.array([1.0 - slow / stiffness, 1.0])
    rest = np.array([1.0, 2.0])
    x = rest + shape
    pairs = [_slider("a", float(x[0])), _slider("b", float(x[1]))]
    scene = Scene(
        name="stiff_coupling",
        bodies=tuple(body for body, _ in pairs),
        joints=tuple(guide for _, guide in pairs),
        loads=(
            _spring("soft", GROUND, "a", (0.0, float(x[0])), SOFT),
            _spring("stiff", "a", "b", (float(x[0]), float(x[1])), stiffness),
        ),
    )

    def exact(times: np.ndarray) -> np.ndarray:
        places = rest + shape * np.cos(math.sqrt(slow) * times)[:, None]
        return np.stack([places, np.zeros_like(places)], axis=2)

    return Case(scene, grid(2.0), measures.positions(exact, SHIFT), max_steps=200_000)


def _ringing(stiffness: float) -> Case:
    body, guide = _slider("a", 1.0 + SHIFT)
    spring = _spring("spring", GROUND, "a", (0.0, 1.0 + SHIFT), stiffness)
    scene = Scene(name="stiff_oscillator", bodies=(body,), joints=(guide,), loads=(spring,))

    exact = measures.positions(
        lambda times: measures.in_plane(1.0 + SHIFT * np.cos(math.sqrt(stiffness) * times), 0.0), SHIFT
    )
    return Case(scene, grid(1.0), exact, max_steps=200_000)


CASES = {"stiff-spring-quiet": _quiet, "stiff-spring-ringing": _ringing}
