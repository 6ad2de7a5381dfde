"""What acts on a tree of planar bodies, evaluated from the scene's own parts: no code of the solver takes part.

Vectors of the plane are complex numbers, x + i y: a* b has their product as its real part, the moment as its imaginary.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cross_checks.truths.truth import OutsideDomainError
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.scene import Force, PlanarBody, PointBushing, Scene, SpringDamper, TorsionSpring
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, ProgressiveLaw, SpringDamperLaw
from mbs_ref.scene.signals import piece_at

COLUMNS = 6  # of the numbers of a pair


class Pairs(NamedTuple):
    """Parts between body a and body b; the number of bodies stands for ground."""

    a: np.ndarray  # (m,)
    b: np.ndarray  # (m,)
    point_a: np.ndarray  # (m,) m, in body axes from the centre of mass
    point_b: np.ndarray  # (m,) m; of a contact the middle of a line or the centre of a circle
    along: np.ndarray  # (m,) of a contact, the line's direction in b's axes
    # (m, COLUMNS) stiffness, damping, rest length or angle or sum of radii, kind; then of a spring its limit (N), of a
    # contact half the line's length and its thickness (m)
    numbers: np.ndarray


class Motion(NamedTuple):
    """The motion of all bodies, ground last."""

    place: np.ndarray  # (n + 1,) m, centres of mass
    angle: np.ndarray  # (n + 1,) rad
    velocity: np.ndarray  # (n + 1,) m/s
    spin: np.ndarray  # (n + 1,) rad/s


class Arrays(NamedTuple):
    """All that acts, for compiled code."""

    gravity: complex  # m/s^2
    pushes: np.ndarray  # (m,) N: world vector of a force at a centre of mass
    scaled: np.ndarray  # (m,) the number of its factor
    pushed: np.ndarray  # (m,) the body
    springs: Pairs  # along the line of two points; kind 1 pulls only, up to its limit
    bushings: Pairs
    torsions: Pairs
    contacts: Pairs  # kind 0: F = d (k + c d'); 1: F = k d + c d', never negative


@dataclass(frozen=True)
class Loads:
    """The parts, and the factors (n,) that vary in time."""

    arrays: Arrays
    factors: Callable[[float], np.ndarray]


def loads_of(scene: Scene, free: list[str]) -> Loads:
    """Gather what acts on the named bodies; every other body is taken as fixed.

    OutsideDomainError names the parts of other kinds.
    """
    kinds = Force | SpringDamper | PointBushing | TorsionSpring
    strange = [x.name for x in scene.loads if not isinstance(x, kinds) or (isinstance(x, Force) and x.frame != "world")]
    strange += [c.name for c in scene.contacts if not _is_known(c)]
    if strange:
        raise OutsideDomainError(f"{scene.name!r} has parts of a kind not known here: {', '.join(strange[:8])}")
    pushes = [x for x in scene.loads if isinstance(x, Force) and x.body in free]
    signals = {repr(x.factor): x.factor.segments() for x in pushes}

    def table(kind: Any, row: Callable) -> Pairs:
        return _pairs([row(scene, free, x) for x in (*scene.loads, *scene.contacts) if isinstance(x, kind)])

    arrays = Arrays(
        complex(*scene.gravity), np.array([complex(*x.vector) for x in pushes], dtype=complex),
        np.array([list(signals).index(repr(x.factor)) for x in pushes], dtype=np.int64),
        np.array([free.index(x.body) for x in pushes], dtype=np.int64),
        table(SpringDamper, _spring), table(PointBushing, _bushing), table(TorsionSpring, _torsion),
        table(CircleOnLine | CircleOnCircle, _contact),
    )  # fmt: skip
    return Loads(arrays, lambda t: np.array([piece_at(f, t).value(t) for f in signals.values()]))


def _is_known(contact) -> bool:
    law = contact.law
    lawful = isinstance(law, ProgressiveLaw) or (isinstance(law, SpringDamperLaw) and law.release == "force")
    shaped = isinstance(contact, CircleOnCircle) or (isinstance(contact, CircleOnLine) and contact.extent != "segment")
    return lawful and shaped and contact.friction is None


def _pairs(rows: list[tuple]) -> Pairs:
    a, b, *vectors, numbers = zip(*rows, strict=True) if rows else [()] * 6
    point_a, point_b, along = np.array(vectors, dtype=complex)
    padded = np.array([[*given, *[0.0] * (COLUMNS - len(given))] for given in numbers], dtype=float)
    ends = np.array(a, dtype=np.int64), np.array(b, dtype=np.int64)
    return Pairs(*ends, point_a, point_b, along, padded.reshape(-1, COLUMNS))


def planar(scene: Scene, name: str) -> PlanarBody:
    """Return a body that has an angle; OutsideDomainError where it has none."""
    body = scene.bodies[scene.body_index(name)]
    if not isinstance(body, PlanarBody):
        raise OutsideDomainError(f"body {name!r} is a {body.type}; only planar bodies are known here")
    return body


def mark(scene: Scene, free: list[str], name: str, point) -> tuple[int, complex]:
    """Return a body's number and a point, world at t = 0, in its axes; of what is fixed as it is in the world."""
    if name not in free:
        return len(free), complex(*point)
    body = planar(scene, name)
    return free.index(name), (complex(*point) - complex(*body.position)) * np.exp(-1j * body.angle)


def _spring(scene: Scene, free: list[str], x: SpringDamper) -> tuple:
    (a, pa), (b, pb) = mark(scene, free, x.body_a, x.point_a), mark(scene, free, x.body_b, x.point_b)
    rest = float(np.hypot(*np.subtract(x.point_b, x.point_a))) if x.rest_length is None else x.rest_length
    return a, b, pa, pb, 0j, (x.stiffness, x.damping, rest, float(x.tension_only), x.limit or np.inf)


def _bushing(scene: Scene, free: list[str], x: PointBushing) -> tuple:
    (a, pa), (b, pb) = (mark(scene, free, end, at) for end, at in zip(x.ends, x.marks, strict=True))
    return a, b, pa, pb, 0j, (x.stiffness, x.damping)


def _torsion(scene: Scene, free: list[str], x: TorsionSpring) -> tuple:
    a, b = (free.index(name) if name in free else len(free) for name in (x.body_a, x.body_b))
    angles = [planar(scene, name).angle if name in free else 0.0 for name in (x.body_a, x.body_b)]
    rest = angles[1] - angles[0] if x.rest_angle is None else x.rest_angle
    return a, b, 0j, 0j, 0j, (x.stiffness, x.damping, rest)


def _contact(scene: Scene, free: list[str], x: CircleOnLine | CircleOnCircle) -> tuple:
    """Return a circle and a line, or a point with the circle about it: a line without length, whose ends are round."""
    law = x.law
    assert isinstance(law, ProgressiveLaw | SpringDamperLaw)  # every other is refused before
    jumps = float(isinstance(law, SpringDamperLaw))
    if isinstance(x, CircleOnCircle):
        (a, center), (b, origin) = mark(scene, free, x.body_a, x.center_a), mark(scene, free, x.body_b, x.center_b)
        return a, b, center, origin, 1.0, (law.stiffness, law.damping, x.radius_a + x.radius_b, jumps, 0.0, np.inf)
    (a, center), (b, first) = mark(scene, free, x.body_a, x.center), mark(scene, free, x.body_b, x.point_1)
    along = 0.5 * (mark(scene, free, x.body_b, x.point_2)[1] - first)
    ends = abs(along) if x.extent == "capped" else np.inf
    numbers = law.stiffness, law.damping, x.radius, jumps, ends, x.thickness or np.inf
    return a, b, center, first + along, along / abs(along), numbers


@strict_jit
def _carried(motion, body, point):
    """World arm of a point and its velocity."""
    arm = point * np.exp(1j * motion.angle[body])
    return arm, motion.velocity[body] + 1j * motion.spin[body] * arm


@strict_jit
def _push(force, moment, body, arm, f):
    force[body] += f
    moment[body] += (np.conj(arm) * f).imag


@strict_jit
def _line(pairs, k, motion):
    """Arms of both points, unit vector from a to b, pull, and stretch."""
    a, b = pairs.a[k], pairs.b[k]
    arm_a, speed_a = _carried(motion, a, pairs.point_a[k])
    arm_b, speed_b = _carried(motion, b, pairs.point_b[k])
    gap = motion.place[b] + arm_b - motion.place[a] - arm_a
    along, stretch = gap / abs(gap), abs(gap) - pairs.numbers[k, 2]
    pull = pairs.numbers[k, 0] * stretch + pairs.numbers[k, 1] * (np.conj(along) * (speed_b - speed_a)).real
    return arm_a, arm_b, along, pull, stretch


@strict_jit
def _seen(pairs, k, motion):
    """Arm of the circle's centre on a, its place in the line's axes, and how far it is within the line's ends (m)."""
    a, b = pairs.a[k], pairs.b[k]
    arm, origin = _carried(motion, a, pairs.point_a[k])[0], _carried(motion, b, pairs.point_b[k])[0]
    place = motion.place[a] + arm - motion.place[b] - origin
    local = place * np.conj(_carried(motion, b, pairs.along[k])[0])
    return arm, local, pairs.numbers[k, 4] - abs(local.real)


@strict_jit
def _depth(pairs, k, motion, within):
    """Depth, its rate, the arms of the circle's centre on a and b, and the normal out of b; `within` both ends or not.

    The force has no friction, so that it acts anywhere on the normal alike.
    """
    a, b = pairs.a[k], pairs.b[k]
    arm_a, local, inside = _seen(pairs, k, motion)
    normal, distance = 1j, local.imag
    if not within:
        beyond = np.copysign(-inside, local.real) + 1j * local.imag
        normal, distance = beyond / abs(beyond), abs(beyond)
    normal = normal * _carried(motion, b, pairs.along[k])[0]
    arm_b = motion.place[a] + arm_a - motion.place[b]
    slip = motion.velocity[a] + 1j * motion.spin[a] * arm_a - motion.velocity[b] - 1j * motion.spin[b] * arm_b
    return pairs.numbers[k, 2] - distance, -(np.conj(normal) * slip).real, arm_a, arm_b, normal


@strict_jit
def _press(pairs, k, depth, closing):
    """The law as written, unclipped."""
    weight = 1.0 if pairs.numbers[k, 3] == 1.0 else depth
    return pairs.numbers[k, 0] * depth + pairs.numbers[k, 1] * weight * closing


@strict_jit
def measure_switches(arrays, motion):
    """Positive where a spring that pulls only is taut, and below its limit; where a contact presses, and between ends.

    NaN where a circle is deeper than its surface is thick: nothing here decides from which side it came.
    """
    springs, contacts = arrays.springs, arrays.contacts
    n, m = springs.a.shape[0], contacts.a.shape[0]
    values = np.ones(2 * n + 2 * m)
    for k in range(n):
        if springs.numbers[k, 3] == 1.0:
            _, _, _, pull, stretch = _line(springs, k, motion)
            values[k] = min(stretch, pull)
            values[n + k] = springs.numbers[k, 4] - pull
    for k in range(m):
        _, _, inside = _seen(contacts, k, motion)
        depth, closing, _, _, _ = _depth(contacts, k, motion, inside > 0.0)
        values[2 * n + m + k] = inside
        values[2 * n + k] = depth if depth <= contacts.numbers[k, 5] else np.nan
        if contacts.numbers[k, 3] == 1.0:
            values[2 * n + k] = min(depth, _press(contacts, k, depth, closing))
    return values


@strict_jit
def apply_loads(arrays, mass, factors, motion, on):
    """Forces (n + 1,) and moments (n + 1,) at the centres of mass in the branches `on`; the last ones are ground's."""
    n = mass.shape[0]
    force, moment = np.zeros(n + 1, dtype=np.complex128), np.zeros(n + 1)
    force[:n] = mass * arrays.gravity
    for k in range(arrays.pushed.shape[0]):
        force[arrays.pushed[k]] += factors[arrays.scaled[k]] * arrays.pushes[k]
    springs, bushings, torsions, contacts = arrays.springs, arrays.bushings, arrays.torsions, arrays.contacts
    taut, touching = springs.a.shape[0], 2 * springs.a.shape[0]
    within = touching + contacts.a.shape[0]
    for k in range(taut):
        if on[k]:
            arm_a, arm_b, along, pull, _ = _line(springs, k, motion)
            pull = pull if on[taut + k] else springs.numbers[k, 4]
            _push(force, moment, springs.a[k], arm_a, pull * along)
            _push(force, moment, springs.b[k], arm_b, -pull * along)
    for k in range(bushings.a.shape[0]):  # both forces act at b's mark, and the damper works on what slips there
        a, b = bushings.a[k], bushings.b[k]
        arm_b, speed = _carried(motion, b, bushings.point_b[k])
        arm_a = motion.place[b] + arm_b - motion.place[a]
        slip = speed - motion.velocity[a] - 1j * motion.spin[a] * arm_a
        gap = arm_a - _carried(motion, a, bushings.point_a[k])[0]
        f = bushings.numbers[k, 0] * gap + bushings.numbers[k, 1] * slip
        _push(force, moment, a, arm_a, f)
        _push(force, moment, b, arm_b, -f)
    for k in range(torsions.a.shape[0]):
        a, b = torsions.a[k], torsions.b[k]
        turn = motion.angle[b] - motion.angle[a] - torsions.numbers[k, 2]
        torque = torsions.numbers[k, 0] * turn + torsions.numbers[k, 1] * (motion.spin[b] - motion.spin[a])
        moment[a] += torque
        moment[b] -= torque
    for k in range(contacts.a.shape[0]):
        if on[touching + k]:
            depth, closing, arm_a, arm_b, normal = _depth(contacts, k, motion, on[within + k])
            press = _press(contacts, k, depth, closing) * normal
            _push(force, moment, contacts.a[k], arm_a, press)
            _push(force, moment, contacts.b[k], arm_b, -press)
    return force, moment
