"""A ball on a shaken seat, event by event: rest, free flight, plastic landing. Only instants are solved for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import root_scalar

from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import ConstraintLaw

LOOKS = 400  # a period: how densely a landing is looked for
GRAZING = 1e-3  # m/s: a slower landing makes its instant too uncertain
ROUNDOFF = 1e-13  # m, of some ten flights of a metre a second with instants known to 1e-16 s


@dataclass(frozen=True)
class Shaker:
    """The seat y = A sin(w t) under gravity g."""

    amplitude: float  # m
    omega: float  # rad/s
    gravity: float  # m/s^2

    def place(self, t: float) -> float:
        return self.amplitude * math.sin(self.omega * t)

    def speed(self, t: float) -> float:
        return self.amplitude * self.omega * math.cos(self.omega * t)

    def pushes(self, t: float) -> bool:
        """Return whether a resting ball needs a push: y'' > -g."""
        return self.amplitude * self.omega**2 * math.sin(self.omega * t) < self.gravity

    def lift_off(self, t: float) -> float:
        """Return the first instant after t at which y'' falls to -g."""
        ratio = self.gravity / (self.amplitude * self.omega**2)
        if ratio >= 1.0:
            return math.inf
        first, period = math.asin(ratio) / self.omega, 2.0 * math.pi / self.omega
        return first + period * max(0.0, math.ceil((t - first) / period))


@dataclass(frozen=True)
class Flight:
    """Free from t0 to t1."""

    t0: float  # s
    t1: float  # s
    height: float  # m at t0
    speed: float  # m/s at t0

    def place(self, t, gravity: float):
        return self.height + self.speed * (t - self.t0) - 0.5 * gravity * (t - self.t0) ** 2


def flights(seat: Shaker, end: float) -> list[Flight] | NoTruth:
    """Return every flight that begins before `end` (s)."""
    flown: list[Flight] = []
    t = seat.lift_off(0.0)
    while t < end:
        flight = Flight(t, math.inf, seat.place(t), seat.speed(t))
        landing = _landing(seat, flight)
        flown.append(Flight(t, landing, flight.height, flight.speed))
        approach = seat.speed(landing) - (flight.speed - seat.gravity * (landing - t))
        if approach < GRAZING:
            return NoTruth(f"the ball grazes the seat at t = {landing:.6g} s: its motion is too sensitive there")
        t = seat.lift_off(landing) if seat.pushes(landing) else landing
    return flown


def _landing(seat: Shaker, flight: Flight) -> float:
    look = 2.0 * math.pi / seat.omega / LOOKS

    def gap(t: float) -> float:
        return flight.place(t, seat.gravity) - seat.place(t)

    before = flight.t0 + look
    while gap(before + look) > 0.0:
        before += look
    return float(root_scalar(gap, bracket=(before, before + look), xtol=1e-16, rtol=1e-15).root)


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """The ball follows the seat, or flies."""
    given: Any = scene.parameters
    if not isinstance(scene.contacts[0].law, ConstraintLaw):
        return NoTruth("the closed form is of the constraint; a spring-damper contact gives way")
    seat = Shaker(given["amplitude"], given["omega"], given["gravity"])
    flown = flights(seat, float(times[-1]))
    if isinstance(flown, NoTruth):
        return flown
    under = seat.amplitude * np.sin(seat.omega * times)
    above = under.copy()
    for flight in flown:
        inside = (times > flight.t0) & (times < flight.t1)
        above[inside] = flight.place(times[inside], seat.gravity)
    position = np.zeros((len(times), 2, 2))
    position[:, 0, 1] = above + scene.bodies[0].position[1]
    position[:, 1, 1] = under
    how = "closed form of rest and flight, between instants found to roundoff"
    return Truth(position, np.zeros((len(times), 2)), ROUNDOFF, "exact", how)
