"""Truths of bodies that touch each other: cradles, walls, stacks, and two smooth spheres."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from cross_checks.truths.made_by.mechanisms.unilateral import Unilateral, line_motion, line_of, one_sided
from cross_checks.truths.made_by.numerics.closed_forms import integral
from cross_checks.truths.truth import NoTruth, OutsideDomainError, Truth, unturned
from mbs_ref import Scene
from mbs_ref.scene.contact import RigidLaw, SpringDamperLaw

REACH, RUN_UP = 0.05 + 0.08, 0.0876543  # m, of two smooth spheres: sum of radii, and way to touch-down


def newtons_cradle(scene: Scene, times: np.ndarray) -> Truth:
    """One coordinate a ball."""
    n, contacts = len(scene.bodies), []
    for k, contact in enumerate(scene.contacts):
        row = tuple(float(j == k + 1) - float(j == k) for j in range(n))
        reach = contact.radius_a + contact.radius_b  # type: ignore[union-attr]
        contacts.append(one_sided(contact.law, row, reach))
    how = "one-sided contacts on a line, matrix exponentials between instants located to roundoff"
    return _on_line(scene, times, 0, contacts, how)


def _on_line(scene: Scene, times: np.ndarray, axis: int, contacts: list[Unilateral], how: str) -> Truth:
    """Return the truth of bodies that move along one axis and do not turn."""
    along, uncertainty = line_motion(line_of(scene, axis, contacts), times)
    position = np.tile(np.array([body.position for body in scene.bodies], dtype=float), (len(times), 1, 1))
    position[..., axis] = along
    return Truth(position, unturned(position), uncertainty, "exact", how)


def disc_between_walls(scene: Scene, times: np.ndarray) -> Truth:
    """One coordinate."""
    walls: Any = zip(scene.contacts, (1.0, -1.0), strict=True)
    contacts = [one_sided(wall.law, (sign,), sign * wall.point_1[0] + wall.radius) for wall, sign in walls]
    how = "free flight and half oscillations, matrix exponentials between instants located to roundoff"
    return _on_line(scene, times, 0, contacts, how)


def box_stack(scene: Scene, times: np.ndarray) -> Truth:
    """Heights of the boxes, each on its corners: two in the plane, four in space."""
    n = len(scene.bodies)
    rows = [tuple(float(j == k) - float(j == k - 1) for j in range(n)) for k in range(n)]
    law, height, corners = scene.contacts[0].law, 2.0 * scene.bodies[0].position[-1], len(scene.contacts) / n
    contacts = [one_sided(law, row, height if k else 0.5 * height, parallel=corners) for k, row in enumerate(rows)]
    how = "upright by symmetry: one-sided spring-dampers on a line, matrix exponentials between located instants"
    return _on_line(scene, times, scene.dimension - 1, contacts, how)


TRUTHS = {"block_stack": box_stack}
ROUNDOFF = 1e-14  # m, of elementary functions at these magnitudes


@dataclass(frozen=True)
class Encounter:
    """The relative motion over one contact, from touch-down to release."""

    duration: float  # s
    angle: float  # rad, the line of centres turns by this
    normal: float  # m/s, rate of the distance after
    tangential: float  # m/s, r phi' after
    doubt: tuple[float, float] = (0.0, 0.0)  # s and rad, how well duration and angle are known


def encounter(law: Any, reduced: float, normal: float, tangential: float) -> Encounter | NoTruth:
    """Return the contact of a reduced mass (kg) at closing speed `normal` and tangential speed (m/s)."""
    if isinstance(law, RigidLaw):
        return Encounter(0.0, 0.0, law.restitution * normal, tangential)
    if not isinstance(law, SpringDamperLaw) or law.damping != 0.0:
        return NoTruth("with damping the line of centres turns while energy is lost: no closed form")
    return _central(law.stiffness / reduced, normal, tangential)


def _central(omega2: float, normal: float, tangential: float) -> Encounter:
    """r'^2 = v_n^2 + v_t^2 (1 - R^2/r^2) - omega^2 (R - r)^2 between R and the least distance."""

    def square(r: float) -> float:
        return normal**2 + tangential**2 * (1.0 - (REACH / r) ** 2) - omega2 * (REACH - r) ** 2

    if square(1e-6 * REACH) >= 0.0:
        raise OutsideDomainError("the spheres are so soft that their centres meet: the contact does not stop them")
    least: Any = scipy.optimize.brentq(square, 1e-6 * REACH, REACH * (1.0 - 1e-15), xtol=1e-17, rtol=np.float64(1e-15))
    span = REACH - least

    def slope(r: float) -> float:
        """Return (r'^2) / (r - least), whose numerator is divided out by hand."""
        curved = tangential**2 * REACH**2 * (r + least) / (r * least) ** 2
        return curved + omega2 * (2.0 * REACH - r - least)

    def over(weight) -> tuple[float, float]:
        """Return with its error bound the integral of weight dr / r' there and back, r = least + span s^2."""

        def density(s: float) -> float:
            r = least + span * s * s
            return 4.0 * math.sqrt(span) * weight(r) / math.sqrt(slope(r))

        return integral(density, 0.0, 1.0)

    (duration, late), (angle, aside) = over(lambda r: 1.0), over(lambda r: REACH * tangential / r**2)
    return Encounter(duration, angle, normal, tangential, (late, aside))


def colliding_spheres(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Straight motion before and after; the centre of mass never changes its own."""
    a, b = (body for body in scene.bodies)
    given = scene.parameters
    obliquity, azimuth = float(given["obliquity"]), float(given["azimuth"])
    oblique = math.sin(obliquity)
    line = np.array([math.cos(obliquity), oblique * math.cos(azimuth), oblique * math.sin(azimuth)])  # of centres
    speed = float(given["speed"])
    along = np.array([speed, 0.0, 0.0])
    normal = float(along @ line)
    across = along - normal * line
    aside = across / np.linalg.norm(across) if np.any(across) else np.zeros(3)
    collision = encounter(scene.contacts[0].law, 1.0 / (1.0 / a.mass + 1.0 / b.mass), normal, float(across @ aside))
    if isinstance(collision, NoTruth):
        return collision
    touch = RUN_UP / speed
    clear = touch + collision.duration
    if np.any((times > touch) & (times < clear)):
        return NoTruth("the closed form gives the motion before and after contact; a requested time lies inside")
    # from b to a: -line at touch-down, moving towards `aside` while it turns
    c, s = math.cos(collision.angle), math.sin(collision.angle)
    outward, sideways = -c * line + s * aside, s * line + c * aside
    since = (times - clear)[:, None]
    before = -REACH * line + along * (times - touch)[:, None]
    after = REACH * outward + (collision.normal * outward + collision.tangential * sideways) * since
    apart = np.where(times[:, None] <= touch, before, after)
    share = b.mass / (a.mass + b.mass)
    middle = (1.0 - share) * (np.array(a.position) + along * times[:, None])
    position = np.stack((middle + share * apart, middle - (1.0 - share) * apart), axis=1)
    late, turned = collision.doubt
    uncertainty = ROUNDOFF + speed * late + turned * float(np.max(np.abs(after), initial=0.0))
    how = "impulse along the line of centres, or its motion by quadrature"
    return Truth(position, unturned(position), uncertainty, "exact", how)
