"""A contact as a user requests it, and the figures that follow from F = k d + c d' >= 0 and Coulomb's friction.

The law is that of a pair of bodies with one effective mass, 1/m = 1/m_a + 1/m_b for a central contact.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from cross_checks.contact.laws import LEAST_REBOUND, linear_law
from cross_checks.engine import Engine
from cross_checks.truths.of.bouncing import impact
from mbs_ref.scene.contact import ContactLaw, Friction, SpringDamperLaw

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
