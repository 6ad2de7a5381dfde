"""What is measured of contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

from reports.facts.curves import Curves, Film
from reports.studies.study import Study


@dataclass(frozen=True)
class OrderLadder:
    """RK4 on the bouncing ball: error of the speed after the bounce."""

    law: str
    events: str
    steps: tuple[int, ...]
    errors: tuple[float, ...]  # m/s; the ball arrives at 1 m/s

    @property
    def order(self) -> float:
        """The slope over the whole ladder."""
        return math.log(self.errors[0] / self.errors[-1]) / math.log(self.steps[-1] / self.steps[0])


@dataclass(frozen=True)
class Restitution:
    """One law: what it is called, what it exactly returns, what a run returns."""

    law: str
    nominal: float | None
    exact: float
    found: float


@dataclass(frozen=True)
class EngineBounce:
    """The ball in another engine, judged from its poses."""

    engine: str
    method: str
    figures: dict[str, float]
    error: float | None  # over the scene's scales
    message: str


@dataclass(frozen=True)
class VehicleRun:
    """One method on the tracked vehicle."""

    setting: str
    steps: int
    events: int
    compliance: float  # m, largest over every step
    difference: float  # m, from the first run, over all bodies and samples
    loop_s: float
    status: str


@dataclass(frozen=True)
class ContactFacts:
    """All of it."""

    orders: tuple[OrderLadder, ...]
    restitutions: tuple[Restitution, ...]
    engines: tuple[EngineBounce, ...]
    runs: tuple[VehicleRun, ...]
    description: str  # of the vehicle
    t_end: float  # s
    film: Film
    curves: dict[str, Curves]
    energy_end: float  # s, how long the energy is balanced
    exchanged: float  # J, by contacts, friction and drive
    drift: float  # J, largest of energy less work


STUDY = Study("contact.html", "Contact and the tracked vehicle", ContactFacts)
