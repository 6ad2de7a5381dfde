"""Truths of a body that meets a floor.

For F = k d + c d' the contact is a linear oscillator. For F = d^n (k + c d') the phase curve is known:
d^(n+1) = (n + 1) m k / c^2 [D - u - ln((1 + D)/(1 + u))] with u = c d'/k and D = c v0/k, hence
D (1 + e) = ln((1 + D)/(1 - D e)), for every n.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from cross_checks.truths.made_by.mechanisms.unilateral import line_motion, line_of, one_sided
from cross_checks.truths.made_by.numerics.closed_forms import integral
from cross_checks.truths.truth import NoTruth, OutsideDomainError, Truth, of_one_body, unturned
from mbs_ref import Scene, scenes
from mbs_ref.scene import contact as laws
from mbs_ref.scene.contact import SpringDamperLaw

CREEPING = 10.0  # -ln(1 - e D): beyond, the end of the contact is a creep whose duration doubles do not resolve
ROUNDOFF = 1e-14  # m, of elementary functions at these magnitudes
BOUNCE_ROUNDOFF = 1e-13  # m, of a flight whose number in the series follows from a logarithm


@dataclass(frozen=True)
class Impact:
    """A free impact of mass m at speed v0."""

    restitution: float  # -
    penetration: float  # m, largest
    duration: float  # s
    doubt: float = 0.0  # s, how well the duration is known


def impact(law: Any, mass: float, speed: float) -> Impact:
    """Return the exact impact of a law without gravity."""
    if isinstance(law, laws.RigidLaw):
        return Impact(law.restitution, 0.0, 0.0)
    if isinstance(law, SpringDamperLaw):
        return _linear(law, mass, speed)
    stiffness, damping, exponent = power_law(law, speed)
    return _power(stiffness, damping, exponent, mass, speed)


def power_law(law: Any, speed: float) -> tuple[float, float, float]:
    """Return k, c and n of F = d^n (k + c d') at an impact speed."""
    if isinstance(law, laws.ProgressiveLaw):
        return law.stiffness, law.damping, 1.0
    if isinstance(law, laws.HuntCrossleyLaw):
        return law.stiffness, law.damping, law.exponent
    if isinstance(law, laws.LankaraniNikraveshLaw):
        return law.stiffness, 0.75 * (1.0 - law.restitution**2) * law.stiffness / speed, law.exponent
    assert isinstance(law, laws.FloresLaw)
    return law.stiffness, 1.6 * (1.0 / law.restitution - 1.0) * law.stiffness / speed, law.exponent


def _linear(law: SpringDamperLaw, mass: float, speed: float) -> Impact:
    """The damped oscillator with z = c / (2 sqrt(k m))."""
    omega = math.sqrt(law.stiffness / mass)
    z = law.damping / (2.0 * math.sqrt(law.stiffness * mass))
    if z >= 1.0:
        return _overdamped(law, mass, speed, omega, z)
    s = math.sqrt(1.0 - z * z)
    deepest = speed / omega * math.exp(-z / s * math.atan2(s, z))
    if law.release == "gap":
        return Impact(math.exp(-math.pi * z / s), deepest, math.pi / (omega * s))
    phase = math.pi - math.atan2(2.0 * z * s, 1.0 - 2.0 * z * z)
    return Impact(math.exp(-z / s * phase), deepest, phase / (omega * s))


def _overdamped(law: SpringDamperLaw, mass: float, speed: float, omega: float, z: float) -> Impact:
    w = math.sqrt(z * z - 1.0)
    peak = 1.0 / omega if w == 0.0 else math.atanh(w / z) / (omega * w)
    deepest = speed * math.exp(-z * omega * peak) * (peak if w == 0.0 else math.sinh(omega * w * peak) / (omega * w))
    if law.release == "gap":
        return Impact(0.0, deepest, math.inf)
    if w == 0.0:
        return Impact(math.exp(-2.0), deepest, 2.0 / omega)
    logarithm = math.log((z + w) / (z - w))
    return Impact(math.exp(-z / w * logarithm), deepest, logarithm / (omega * w))


def _power(stiffness: float, damping: float, exponent: float, mass: float, speed: float) -> Impact:
    big = damping * speed / stiffness
    power = exponent + 1.0
    if big == 0.0:
        deepest = (0.5 * power * mass * speed**2 / stiffness) ** (1.0 / power)
        half, doubt = integral(lambda s: 2.0 * s / math.sqrt(-math.expm1(power * math.log1p(-s * s))), 0.0, 1.0)
        return Impact(1.0, deepest, 2.0 * deepest / speed * half, 2.0 * deepest / speed * doubt)
    lag = _lag(big)  # D (1 + e) = ln((1 + D)/(1 - D e)) is lag(D) = lag(-D e), solved for w = -ln(1 - D e)

    def late(w: float) -> float:
        return _lag(math.expm1(-w), -w) / lag - 1.0

    w = float(scipy.optimize.root_scalar(late, bracket=(0.0, lag + 1.0), xtol=1e-300, rtol=1e-15).root)
    e = -math.expm1(-w) / big
    scale = power * mass * stiffness / damping**2
    # dt = -m dv / F along the phase curve, over d' from v0 to -e v0; the ends are integrable
    return Impact(e, (scale * lag) ** (1.0 / power), *_duration(damping, exponent, mass, w, scale, big))


def _lag(x: float, logarithm: float | None = None) -> float:
    """Return x - ln(1 + x), whose two terms cancel where x is small; the logarithm may be known."""
    if abs(x) < 0.1:
        return sum((-x) ** k / k for k in range(2, 24))
    return x - (math.log1p(x) if logarithm is None else logarithm)


def _duration(c, n, m, w, scale, big) -> tuple[float, float]:
    def between(start: float, rest: float, sign: float, span: float) -> tuple[float, float]:
        """Integrate m dv / F from u = start = rest - 1 over `span`, in distances from the end, where d = 0."""

        def slowness(x: float) -> float:  # delta = x^(n+1) takes the singularity of d^-n away
            delta = sign * x ** (n + 1.0)
            depth = (scale * (delta * start / rest - _lag(-delta / rest))) ** (1.0 / (n + 1.0))
            return (n + 1.0) * x**n * m / (depth**n * c * (rest - delta))

        return integral(slowness, 0.0, span ** (1.0 / (n + 1.0)))

    if w > CREEPING:
        return math.inf, math.inf
    out = math.expm1(-w)  # u at release, -e D
    (into, first), (away, second) = between(big, 1.0 + big, 1.0, big), between(out, math.exp(-w), -1.0, -out)
    return into + away, first + second


def bouncing_ball(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """The height of the ball before and after its one bounce, exactly."""
    ball: Any = scene.bodies[0]
    contact: Any = scene.contacts[0]
    if scene.gravity[1] != 0.0:
        return _under_gravity(scene, times)
    speed, height = -ball.velocity[1], ball.position[1] - contact.radius
    if speed == 0.0:
        return _motion(scene, np.full_like(times, ball.position[1]), ROUNDOFF, "rest: nothing acts on the ball")
    touch = height / speed
    rebound = impact(contact.law, ball.mass, speed)
    if contact.thickness is not None and rebound.penetration > contact.thickness:
        raise OutsideDomainError(f"the ball passes through the plate: it would sink {rebound.penetration:.3g} m")
    clear = touch + rebound.duration
    inside = (times > touch) & (times < clear)
    law = contact.law
    swings = isinstance(law, SpringDamperLaw) and law.damping**2 < 4.0 * law.stiffness * ball.mass
    if np.any(inside) and not swings:
        return NoTruth("the closed form gives the motion before and after contact; a requested time lies inside")
    y = np.where(times <= touch, height - speed * times, rebound.restitution * speed * (times - min(clear, times[-1])))
    if isinstance(law, SpringDamperLaw) and law.release == "force":
        y[times > touch] -= law.damping * rebound.restitution * speed / law.stiffness  # the depth where F = 0
    if np.any(inside):
        y[inside] = -_depth(law, ball.mass, speed, times[inside] - touch)
    how = "closed form of the free impact; the duration of a power law by quadrature"
    return _motion(scene, y + contact.radius, ROUNDOFF + speed * rebound.doubt, how)


def _motion(scene: Scene, height: np.ndarray, uncertainty: float, how: str) -> Truth:
    """Return the truth of a ball that does not turn, its centre at `height` (n_t,), m."""
    ball: Any = scene.bodies[0]
    return of_one_body(np.zeros_like(height), height, ball.angle, uncertainty, how)


def _under_gravity(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Rigid and linear laws bounce piece by piece until the ball rests."""
    contact: Any = scene.contacts[0]
    law = contact.law
    if isinstance(law, laws.RigidLaw) and contact.thickness is None:
        ball: Any = scene.bodies[0]
        height = ball.position[1] - contact.radius
        above = bounce_heights(law.restitution, height, ball.velocity[1], -scene.gravity[1], times)
        return _motion(scene, above + contact.radius, BOUNCE_ROUNDOFF, "parabolas whose speeds are a geometric series")
    if not isinstance(law, SpringDamperLaw) or contact.thickness is not None:
        return NoTruth("under gravity the motion is known for the linear laws alone, on an endless floor")
    y, uncertainty = line_motion(line_of(scene, 1, [one_sided(law, (1.0,), contact.radius)]), times)
    how = "flights and damped oscillations, matrix exponentials between instants found to roundoff"
    return _motion(scene, y[:, 0], uncertainty, how)


def bounce_heights(restitution: float, height: float, rate: float, gravity: float, times: np.ndarray) -> np.ndarray:
    """Return the heights (m) above a rigid floor at the times of a ball that begins at `height` with `rate` (m/s).

    Flight n lasts 2 e^n v/g; where e < 1 the ball rests from the limit of their sum on.
    """
    speed = math.sqrt(rate**2 + 2.0 * gravity * height)
    first = (rate + speed) / gravity
    result = np.where(times <= first, height + rate * times - 0.5 * gravity * times**2, 0.0)
    period, e = 2.0 * restitution * speed / gravity, restitution
    since = (times - first) / period if period > 0.0 else np.full_like(times, np.inf)
    if e < 1.0:
        left = 1.0 - since * (1.0 - e)  # of the series
        flies = (since > 0.0) & (left > 0.0)
        n = np.floor(np.log(left[flies]) / math.log(e)) if e > 0.0 else since[flies]
        since[flies] = (since[flies] - (1.0 - e**n) / (1.0 - e)) / e**n  # of flight n
        share = e**n
    else:
        flies = since > 0.0
        since[flies], share = np.mod(since[flies], 1.0), 1.0
    result[flies] = 0.5 * gravity * (share * period) ** 2 * since[flies] * (1.0 - since[flies])
    return result


def _depth(law: SpringDamperLaw, mass: float, speed: float, since: np.ndarray) -> np.ndarray:
    """Return the underdamped oscillation from d = 0 at `speed`."""
    decay = 0.5 * law.damping / mass
    turn = math.sqrt(law.stiffness / mass - decay**2)
    return speed / turn * np.exp(-decay * since) * np.sin(turn * since)


def bouncing_sphere(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """The ball moves along the normal alone and does not turn."""
    given, floor = dict(scene.parameters), scene.contacts[0]
    del given["tilt"], given["heading"]
    planar = bouncing_ball(scenes.make("bouncing_ball", **given), times)
    if isinstance(planar, NoTruth):
        return planar
    position = planar.position[:, :, 1:] * np.array(floor.normal)  # type: ignore[union-attr]
    return Truth(position, unturned(position), planar.uncertainty, planar.kind, planar.how)


def oblique_disc(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """x - x0 = u0 t - mu (y - y0 - v0 t), and the spin likewise, while the disc slides forwards."""
    disc: Any = scene.bodies[0]
    ground: Any = scene.contacts[0]
    law, friction = ground.law, ground.friction
    u0, v0 = disc.velocity
    e = impact(law, disc.mass, -v0).restitution
    lever = 1.0 + disc.mass * ground.radius**2 / disc.inertia
    if not friction.coefficient * (1.0 + e) * -v0 * lever < u0:
        return NoTruth("the disc stops sliding within the impact: the closed form is of one that slides all along")
    y, uncertainty = line_motion(line_of(scene, 1, [one_sided(law, (1.0,), ground.radius)]), times)
    y = y[:, 0]
    kick = friction.coefficient * (y - disc.position[1] - v0 * times)  # m, of the friction's impulse over the mass
    x = disc.position[0] + u0 * times - kick
    angle = disc.angle - disc.mass * ground.radius / disc.inertia * kick
    how = "closed form: a free normal impact, and Coulomb's friction that slides all along"
    return of_one_body(x, y, angle, uncertainty, how)
