"""Linear laws F = k d + c d' by their rebound: those that only push, and those that pull until the gap opens."""

import math
from typing import Literal

from scipy.optimize import brentq

from cross_checks.truths.of.bouncing import impact
from mbs_ref.scene.contact import ConstraintLaw, ContactLaw, RigidLaw, SpringDamperLaw

LEAST_REBOUND = 1e-4  # -, corresponds to a damping ratio of 50
DAMPING_RATIOS = (1e-9, 1e3)  # between which rebounds from 1 - 1e-8 to 2.5e-7 lie
NOMINAL_SPEED = 1.0  # m/s, at which a law that is not linear is translated
STEPS_OF_IMPACT = 10  # that a rigid impact lasts, the fewest that resolve it

type Release = Literal["gap", "force"]


def linear_law(rebound: float, stiffness: float, mass: float, release: Release = "force") -> SpringDamperLaw:
    """Return the law with a rebound (-) of a free impact, which no speed changes."""
    critical, logarithm = 2.0 * math.sqrt(stiffness * mass), -math.log(rebound)

    def law(ratio: float) -> SpringDamperLaw:
        return SpringDamperLaw(stiffness=stiffness, damping=ratio * critical, release=release)

    def excess(ratio: float) -> float:
        return impact(law(math.exp(ratio)), mass, 1.0).restitution - rebound

    if release == "gap" or rebound == 1.0:
        return law(logarithm / math.hypot(math.pi, logarithm))  # e = exp(-pi z/sqrt(1 - z^2))
    return law(math.exp(brentq(excess, *map(math.log, DAMPING_RATIOS), xtol=1e-14)))  # type: ignore[arg-type]


def own_law(law: ContactLaw, mass: float, step: float, release: Release) -> SpringDamperLaw:
    """Return the linear law of a release rule that rebounds like the given one.

    The stiffness of a linear law stays. A rigid impact lasts STEPS_OF_IMPACT steps (s). Others have the same
    penetration at NOMINAL_SPEED.
    """
    if isinstance(law, SpringDamperLaw) and (law.release == release or not law.damping):
        return law
    if isinstance(law, RigidLaw | ConstraintLaw):
        rebound = max(getattr(law, "restitution", 0.0), LEAST_REBOUND)
        unit = impact(linear_law(rebound, 1.0, mass, release), mass, NOMINAL_SPEED)
        return linear_law(rebound, (unit.duration / (STEPS_OF_IMPACT * step)) ** 2, mass, release)
    reference = impact(law, mass, NOMINAL_SPEED)
    rebound = max(reference.restitution, LEAST_REBOUND)
    if isinstance(law, SpringDamperLaw):
        return linear_law(rebound, law.stiffness, mass, release)
    unit = impact(linear_law(rebound, 1.0, mass, release), mass, NOMINAL_SPEED)  # depth goes as 1/sqrt(k)
    return linear_law(rebound, (unit.penetration / reference.penetration) ** 2, mass, release)
