"""A ball on a moving, turning seat: in the world's coordinates, and as a reduced mass about the centre of mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cross_checks.certify.agreement import Formulation, agree, converged
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import ProgressiveLaw

TOUCHING, AROUND = 0, 1  # the switches: ball in contact; beyond the seat's straight part
LOOKS = 0.01  # s: how often extrapolation looks for a switch, or a long step of free flight leaps over a round end


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


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Newton's equations by DOP853; relative motion by extrapolation with located switches."""
    looks = tuple(np.arange(LOOKS, times[-1], LOOKS).tolist())
    agreement = agree(_world(Pair(scene)), _relative(Pair(scene), looks), times, extended=False)
    return converged(agreement, "Newton's in the world by DOP853", "relative motion by extrapolation, switches located")


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


def _relative(pair: Pair, looks: tuple[float, ...]) -> Formulation:
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
    return Formulation(lambda t, y: frozen(t, y, switches(t, y) > 0), start, poses, frozen, switches, looks)
