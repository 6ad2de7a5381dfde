"""A contact as a user requests it, the figures that follow from F = k d + c d' >= 0 and Coulomb's friction, and laws.

The law is that of a pair of bodies with one effective mass, 1/m = 1/m_a + 1/m_b for a central contact.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal, NamedTuple

from scipy.optimize import brentq

from cross_checks.engine import Engine
from cross_checks.truths.of.bouncing import impact
from mbs_ref.scene.contact import ConstraintLaw, ContactLaw, Friction, RigidLaw, SpringDamperLaw

TEMPLATES = Path(__file__).parent / "templates"

RESTITUTION, DURATION, PENETRATION = "restitution", "duration, s", "penetration, m"
CREEP, STOP, SINK = "creep, m/s", "stop distance, m", "static sink, m"
GRAVITY = 9.81  # m/s^2
SHARE = 0.5  # of the friction cone, at which creep is measured


@dataclass(frozen=True)
class Request:
    """Figures requested of one contact; ValueError names a value that no contact has."""

    rebound: float  # -, speed after over speed before a free impact
    friction: float  # -, Coulomb's coefficient
    stiffness: float  # N/m
    mass: float  # kg, effective mass of the pair
    speed: float = 1.0  # m/s, of approach and of the start of sliding
    step: float = 1e-3  # s

    def __post_init__(self) -> None:
        allowed = {"rebound": f"from {LEAST_REBOUND:g} to 1", "friction": "at least 0"}
        for name, value in vars(self).items():
            least, most = {"rebound": (LEAST_REBOUND, 1.0), "friction": (0.0, math.inf)}.get(name, (0.0, math.inf))
            inside = least <= value <= most if name in allowed else least < value
            if not (inside and math.isfinite(value)):
                raise ValueError(f"{name} = {value:g} is not allowed; it must be {allowed.get(name, 'above 0')}")

    @cached_property
    def law(self) -> SpringDamperLaw:
        """The spring and damper that rebound as requested."""
        return linear_law(self.rebound, self.stiffness, self.mass)

    @cached_property
    def figures(self) -> dict[str, float]:
        """The requested figures, from closed forms: without friction those of the impact alone.

        The duration is that between touching and parting of the undeformed surfaces.
        """
        free = impact(self.law, self.mass, self.speed)
        parting = self.law.damping / self.stiffness  # s, from F = 0 at depth c e v/k to depth 0 at the speed e v
        figures = {RESTITUTION: self.rebound, DURATION: free.duration + parting, PENETRATION: free.penetration}
        if not self.friction:
            return figures
        stop = self.speed**2 / (2.0 * self.friction * GRAVITY)
        return figures | {CREEP: 0.0, STOP: stop, SINK: self.mass * GRAVITY / self.stiffness}


class Refused(NamedTuple):
    """A figure that an engine's documentation excludes: what it states instead, and why."""

    instead: float
    why: str


@dataclass(frozen=True)
class Translation:
    """The parameters of one engine for one pair; they hold for its effective mass alone."""

    law: ContactLaw  # and friction: the parts from which the engine's adapter sets the parameters
    friction: Friction | None
    parameters: Mapping[str, float | tuple[float, ...]]  # by the names of the engine's documentation
    snippet: str  # to paste into a model of that engine
    refused: dict[str, Refused] = field(default_factory=dict)  # by figure
    floor: ContactLaw | None = None  # for a flat surface, where it differs


@dataclass(frozen=True)
class ContactModel:
    """An engine that runs scenes with its own contact model."""

    engine: Engine
    translate: Callable[[Request], Translation]
    compared: tuple[str, ...]  # methods: with translated parameters, then as shipped


def snippet(template: str, **values: object) -> str:
    """Return a template with its {placeholders} replaced."""
    return (TEMPLATES / template).read_text(encoding="utf-8").format(**values)


LEAST_REBOUND = 1e-4  # -, corresponds to a damping ratio of 50
DAMPING_RATIOS = (1e-9, 1e3)  # between which rebounds from 1 - 1e-8 to 2.5e-7 lie
NOMINAL_SPEED = 1.0  # m/s, at which a law that is not linear is translated
STEPS_OF_IMPACT = 10  # that a rigid impact lasts, the fewest that resolve it


def rebound_of(law: ContactLaw, mass: float) -> float:
    """Return the restitution of a law, or that of a free impact at NOMINAL_SPEED of an effective mass (kg)."""
    rebound = getattr(law, "restitution", None)
    return impact(law, mass, NOMINAL_SPEED).restitution if rebound is None else rebound


def refused_of_rigid(request: Request) -> dict[str, Refused]:
    """Return the figures that a rigid contact has not."""
    soft = (DURATION, PENETRATION, *((SINK,) if request.friction else ()))
    return {label: Refused(0.0, "contacts are rigid: a step ends the impact") for label in soft}


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


def damped_by_step(law: SpringDamperLaw, step: float) -> SpringDamperLaw:
    """Return the law with the damping k h at least, h the step (s): a force of the velocity at its end has that."""
    return law.model_copy(update={"damping": max(law.damping, law.stiffness * step)})


def refused_of_step(request: Request) -> dict[str, Refused]:
    """Return the figures that a request with less damping than k h cannot have."""
    law = damped_by_step(request.law, request.step)
    if law.damping == request.law.damping:
        return {}
    free, why = impact(law, request.mass, request.speed), "a step damps as a relaxation time of its length"
    values = {RESTITUTION: free.restitution, DURATION: free.duration + law.damping / law.stiffness,
              PENETRATION: free.penetration}  # fmt: skip
    return {label: Refused(value, why) for label, value in values.items()}
