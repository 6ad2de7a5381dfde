"""Truths of a ball on a driven seat, event by event, and on a free one, converged."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from cross_checks.truths.made_by import Formulation, agree
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene
from mbs_ref.scene.contact import ConstraintLaw, ProgressiveLaw

LOOKS_PER_PERIOD = 400  # a period: how densely a landing is looked for
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
    look = 2.0 * math.pi / seat.omega / LOOKS_PER_PERIOD

    def gap(t: float) -> float:
        return flight.place(t, seat.gravity) - seat.place(t)

    before = flight.t0 + look
    while gap(before + look) > 0.0:
        before += look
    return float(scipy.optimize.root_scalar(gap, bracket=(before, before + look), xtol=1e-16, rtol=1e-15).root)


def ball_on_driven_seat(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
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


TOUCHING, AROUND = 0, 1  # the switches: ball in contact; beyond the seat's straight part


@dataclass(frozen=True)
class Pair:
    """The two bodies, and the contact between them."""

    scene: Scene

    @property
    def contact(self) -> Any:
        return self.scene.contacts[0]

    @property
    def height(self) -> float:
        """How high (m) the surface is above the seat's centre of mass, in its axes."""
        seat: Any = self.scene.bodies[1]
        return self.contact.point_1[1] - seat.position[1]

    def depth(self, r: np.ndarray, angle, around: bool):
        """Return the ball's depth (m) in the seat at r (m) from the seat's mass centre, and the normal to the ball."""
        along = np.array([np.cos(angle), np.sin(angle)])
        above = np.array([-along[1], along[0]])
        near = r @ along
        if around:
            d = r - np.sign(near) * self.contact.point_2[0] * along - self.height * above
            distance = np.sqrt(d @ d)
            return self.contact.radius - distance, d / distance
        return self.contact.radius + self.height - r @ above, above

    def push(self, r, u, angle, seat_spin, ball_spin, on) -> tuple[np.ndarray, Any, Any]:
        """Return the force on the ball (N), and its moments about ball and seat (N m); r and u = r' from the seat."""
        nothing = np.zeros_like(r), r[0] * 0, r[0] * 0
        if not on[TOUCHING]:
            return nothing
        depth, normal = self.depth(r, angle, on[AROUND])
        arm = -self.contact.radius * normal
        lever = r + arm
        slip = u + ball_spin * _turned(arm) - seat_spin * _turned(lever)
        law, friction = self.contact.law, self.contact.friction
        damping = law.damping * (depth if isinstance(law, ProgressiveLaw) else 1)
        size = law.stiffness * depth - damping * (slip @ normal)
        tangent = -_turned(normal)
        rub = 0 if friction is None else -friction.coefficient * size * np.tanh(slip @ tangent / friction.speed)
        force = size * normal + rub * tangent
        return force, _cross(arm, force), -_cross(lever, force)

    def switches(self, r, angle) -> np.ndarray:
        along = np.array([np.cos(angle), np.sin(angle)])
        beyond = abs(r @ along) - self.contact.point_2[0]
        depth, _ = self.depth(r, angle, beyond > 0)
        return np.array([depth, beyond])


def ball_on_moving_seat(scene: Scene, times: np.ndarray) -> Truth:
    """Newton's equations by DOP853; relative motion by extrapolation with located switches."""
    ways = "Newton's in the world by DOP853", "relative motion by extrapolation, switches located"
    return agree(_world(Pair(scene)), _relative(Pair(scene)), times, ways, extended=False)


def _turned(x: np.ndarray) -> np.ndarray:
    return np.array([-x[1], x[0]])


def _cross(x: np.ndarray, y: np.ndarray):
    return x[0] * y[1] - x[1] * y[0]


def _world(pair: Pair) -> Formulation:
    """y = x, y, angle of ball and seat, then their rates."""
    bodies: Any = pair.scene.bodies
    inertia = np.array([x for body in bodies for x in (body.mass, body.mass, body.inertia)])

    def derivative(t, y):
        (p, a), (v, w) = (part.reshape(2, 3)[:, :2] for part in (y[:6], y[6:]))
        r, u = p - a, v - w
        on = pair.switches(r, y[5]) > 0
        force, ball, seat = pair.push(r, u, y[5], y[11], y[8], on)
        return np.concatenate((y[6:], np.array([*force, ball, *-force, seat]) / inertia))

    start = np.array([x for body in bodies for x in (*body.position, body.angle)]
                     + [x for body in bodies for x in (*body.velocity, body.angular_velocity)])  # fmt: skip
    return Formulation(derivative, start, lambda t, y: (y[:6].reshape(2, 3)[:, :2], y[[2, 5]]))


def _relative(pair: Pair) -> Formulation:
    """y = ball from seat (m), both angles, then their rates; the centre of mass moves on its own."""
    bodies: Any = pair.scene.bodies
    ball, seat = bodies
    share = ball.mass / (ball.mass + seat.mass)
    reduced = seat.mass * share
    places, speeds = (np.array([getattr(body, name) for body in bodies]) for name in ("position", "velocity"))
    weight = np.array([share, 1.0 - share])
    inertia = np.array([reduced, reduced, ball.inertia, seat.inertia])

    def frozen(t, y, on):
        force, on_ball, on_seat = pair.push(y[:2], y[4:6], y[3], y[7], y[6], on)
        return np.concatenate((y[4:], np.array([*force, on_ball, on_seat]) / inertia))

    def switches(t, y):
        return pair.switches(y[:2], y[3])

    def poses(t, y):
        center = weight @ places + weight @ speeds * t
        return np.array([center + (1.0 - share) * y[:2], center - share * y[:2]]), y[2:4]

    start = np.array([*(places[0] - places[1]), *(body.angle for body in bodies), *(speeds[0] - speeds[1]),
                      *(body.angular_velocity for body in bodies)])  # fmt: skip
    return Formulation(lambda t, y: frozen(t, y, switches(t, y) > 0), start, poses, frozen, switches)
