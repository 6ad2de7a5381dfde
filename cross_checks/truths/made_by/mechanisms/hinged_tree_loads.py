"""What acts on a tree of planar bodies, evaluated from the scene's own parts: no code of the solver takes part."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cross_checks.truths.truth import OutsideDomainError
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.scene import Force, PlanarBody, PointBushing, Scene, SpringDamper, TorsionSpring
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, ProgressiveLaw, SpringDamperLaw
from mbs_ref.scene.signals import piece_at

COLUMNS = 8  # of the numbers of a pair


class Pairs(NamedTuple):
    """Parts between body a and body b; the number of bodies stands for ground."""

    a: np.ndarray  # (m,)
    b: np.ndarray  # (m,)
    point_a: np.ndarray  # (m, 2) m, in body axes from the centre of mass
    point_b: np.ndarray  # (m, 2) m; of a contact the middle of a line or the centre of a circle
    # (m, COLUMNS) stiffness, damping, rest length or angle or sum of radii, kind; then of a spring its limit (N), of a
    # contact the line's direction (2) in b's axes, half its length and its thickness (m)
    numbers: np.ndarray


class Arrays(NamedTuple):
    """All that acts, for compiled code."""

    gravity: np.ndarray  # (2,) m/s^2
    pushes: np.ndarray  # (m, 3) N: world vector of a force at a centre of mass, and its factor's number
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
    signals = list({repr(x.factor): x.factor for x in pushes}.values())
    of_time = [signal.segments() for signal in signals]
    numbers = [[*x.vector, [repr(s) for s in signals].index(repr(x.factor))] for x in pushes]

    def table(kind: Any, row: Callable) -> Pairs:
        parts = [x for x in (*scene.loads, *scene.contacts) if isinstance(x, kind)]
        return _pairs([row(scene, free, x) for x in parts])

    arrays = Arrays(
        np.array(scene.gravity), np.array(numbers, dtype=float).reshape(-1, 3),
        np.array([free.index(x.body) for x in pushes], dtype=np.int64),
        table(SpringDamper, _spring), table(PointBushing, _bushing), table(TorsionSpring, _torsion),
        table(CircleOnLine | CircleOnCircle, _contact),
    )  # fmt: skip
    return Loads(arrays, lambda t: np.array([piece_at(f, t).value(t) for f in of_time]))


def _is_known(contact) -> bool:
    law = contact.law
    lawful = isinstance(law, ProgressiveLaw) or (isinstance(law, SpringDamperLaw) and law.release == "force")
    shaped = isinstance(contact, CircleOnCircle) or (isinstance(contact, CircleOnLine) and contact.extent != "segment")
    return lawful and shaped and contact.friction is None


def _pairs(rows: list[tuple]) -> Pairs:
    columns = list(zip(*rows, strict=True)) or [[], [], [], [], []]
    a, b = (np.array(x, dtype=np.int64) for x in columns[:2])
    point_a, point_b = (np.array(x, dtype=float).reshape(-1, 2) for x in columns[2:4])
    numbers = np.zeros((len(a), COLUMNS))
    for row, given in zip(numbers, columns[4], strict=True):
        row[: len(given)] = given
    return Pairs(a, b, point_a, point_b, numbers)


def planar(scene: Scene, name: str) -> PlanarBody:
    """Return a body that has an angle; OutsideDomainError where it has none."""
    body = scene.bodies[scene.body_index(name)]
    if not isinstance(body, PlanarBody):
        raise OutsideDomainError(f"body {name!r} is a {body.type}; only planar bodies are known here")
    return body


def mark(scene: Scene, free: list[str], name: str, point) -> tuple[int, np.ndarray]:
    """Return a body's number and a point, world at t = 0, in its axes; of what is fixed as it is in the world."""
    if name not in free:
        return len(free), np.array(point)
    body = planar(scene, name)
    c, s = np.cos(body.angle), np.sin(body.angle)
    x, y = np.subtract(point, body.position)
    return free.index(name), np.array([c * x + s * y, c * y - s * x])


def _spring(scene: Scene, free: list[str], x: SpringDamper) -> tuple:
    (a, pa), (b, pb) = mark(scene, free, x.body_a, x.point_a), mark(scene, free, x.body_b, x.point_b)
    rest = float(np.hypot(*np.subtract(x.point_b, x.point_a))) if x.rest_length is None else x.rest_length
    return a, b, pa, pb, (x.stiffness, x.damping, rest, float(x.tension_only), x.limit or np.inf)


def _bushing(scene: Scene, free: list[str], x: PointBushing) -> tuple:
    (a, pa), (b, pb) = (mark(scene, free, end, at) for end, at in zip(x.ends, x.marks, strict=True))
    return a, b, pa, pb, (x.stiffness, x.damping, 0.0, 0.0)


def _torsion(scene: Scene, free: list[str], x: TorsionSpring) -> tuple:
    a, b = (free.index(name) if name in free else len(free) for name in (x.body_a, x.body_b))
    angles = [planar(scene, name).angle if name in free else 0.0 for name in (x.body_a, x.body_b)]
    rest = angles[1] - angles[0] if x.rest_angle is None else x.rest_angle
    return a, b, (0.0, 0.0), (0.0, 0.0), (x.stiffness, x.damping, rest, 0.0)


def _contact(scene: Scene, free: list[str], x: CircleOnLine | CircleOnCircle) -> tuple:
    """Return a circle and a line, or a point with the circle about it: a line without length, whose ends are round."""
    law = x.law
    assert isinstance(law, ProgressiveLaw | SpringDamperLaw)  # every other is refused before
    law_numbers = law.stiffness, law.damping
    jumps = float(isinstance(law, SpringDamperLaw))
    if isinstance(x, CircleOnCircle):
        (a, center), (b, origin) = mark(scene, free, x.body_a, x.center_a), mark(scene, free, x.body_b, x.center_b)
        return a, b, center, origin, (*law_numbers, x.radius_a + x.radius_b, jumps, 1.0, 0.0, 0.0, np.inf)
    (a, center), (b, first) = mark(scene, free, x.body_a, x.center), mark(scene, free, x.body_b, x.point_1)
    along = 0.5 * (mark(scene, free, x.body_b, x.point_2)[1] - first)
    half = float(np.hypot(*along))
    ends = half if x.extent == "capped" else np.inf
    numbers = (*law_numbers, x.radius, jumps, *(along / half), ends, x.thickness or np.inf)
    return a, b, center, first + along, numbers


@strict_jit
def _carried(pose, rate, body, point):
    """World arm of a point and its velocity."""
    c, s = np.cos(pose[body, 2]), np.sin(pose[body, 2])
    x = c * point[0] - s * point[1]
    y = s * point[0] + c * point[1]
    return x, y, rate[body, 0] - y * rate[body, 2], rate[body, 1] + x * rate[body, 2]


@strict_jit
def _push(force, body, x, y, fx, fy):
    force[body, 0] += fx
    force[body, 1] += fy
    force[body, 2] += x * fy - y * fx


@strict_jit
def _line(pairs, k, pose, rate):
    """Arms of both points, unit vector from a to b, pull, and stretch."""
    a, b = pairs.a[k], pairs.b[k]
    ax, ay, avx, avy = _carried(pose, rate, a, pairs.point_a[k])
    bx, by, bvx, bvy = _carried(pose, rate, b, pairs.point_b[k])
    dx, dy = pose[b, 0] + bx - pose[a, 0] - ax, pose[b, 1] + by - pose[a, 1] - ay
    length = np.hypot(dx, dy)
    ex, ey = dx / length, dy / length
    stretch = length - pairs.numbers[k, 2]
    pull = pairs.numbers[k, 0] * stretch + pairs.numbers[k, 1] * (ex * (bvx - avx) + ey * (bvy - avy))
    return ax, ay, bx, by, ex, ey, pull, stretch


@strict_jit
def _within(pairs, k, pose, rate):
    """How far (m) the circle's centre is from the nearer end of the line, positive between both."""
    _, _, along, _, _, _ = _seen(pairs, k, pose, rate)
    return pairs.numbers[k, 6] - abs(along)


@strict_jit
def _seen(pairs, k, pose, rate):
    """Arm of the circle's centre on a, its place along and above the line, and the line's direction."""
    a, b = pairs.a[k], pairs.b[k]
    ax, ay, _, _ = _carried(pose, rate, a, pairs.point_a[k])
    bx, by, _, _ = _carried(pose, rate, b, pairs.point_b[k])
    tx, ty, _, _ = _carried(pose, rate, b, pairs.numbers[k, 4:6])
    x, y = pose[a, 0] + ax - pose[b, 0] - bx, pose[a, 1] + ay - pose[b, 1] - by
    return ax, ay, x * tx + y * ty, y * tx - x * ty, tx, ty


@strict_jit
def _depth(pairs, k, pose, rate, within):
    """Depth, its rate, the arms of the circle's centre on a and b, and the normal out of b; `within` both ends or not.

    The force has no friction, so that it acts anywhere on the normal alike.
    """
    a, b = pairs.a[k], pairs.b[k]
    ax, ay, along, above, tx, ty = _seen(pairs, k, pose, rate)
    across, distance = 0.0, above
    if not within:
        across = np.copysign(abs(along) - pairs.numbers[k, 6], along)
        distance = np.hypot(across, above)
        across, above = across / distance, above / distance
    else:
        above = 1.0
    nx, ny = across * tx - above * ty, across * ty + above * tx
    bx, by = pose[a, 0] + ax - pose[b, 0], pose[a, 1] + ay - pose[b, 1]
    vx = rate[a, 0] - ay * rate[a, 2] - rate[b, 0] + by * rate[b, 2]
    vy = rate[a, 1] + ax * rate[a, 2] - rate[b, 1] - bx * rate[b, 2]
    depth = pairs.numbers[k, 2] - distance
    return depth, -nx * vx - ny * vy, ax, ay, bx, by, nx, ny


@strict_jit
def _press(pairs, k, depth, closing):
    """The law as written, unclipped."""
    weight = 1.0 if pairs.numbers[k, 3] == 1.0 else depth
    return pairs.numbers[k, 0] * depth + pairs.numbers[k, 1] * weight * closing


@strict_jit
def measure_switches(arrays, pose, rate):
    """Positive where a spring that pulls only is taut, and below its limit; where a contact presses, and between ends.

    NaN where a circle is deeper than its surface is thick: nothing here decides from which side it came.
    """
    springs, contacts = arrays.springs, arrays.contacts
    n, m = springs.a.shape[0], contacts.a.shape[0]
    values = np.ones(2 * n + 2 * m)
    for k in range(n):
        if springs.numbers[k, 3] == 1.0:
            _, _, _, _, _, _, pull, stretch = _line(springs, k, pose, rate)
            values[k] = min(stretch, pull)
            values[n + k] = springs.numbers[k, 4] - pull
    for k in range(m):
        values[2 * n + m + k] = _within(contacts, k, pose, rate)
        depth, closing, _, _, _, _, _, _ = _depth(contacts, k, pose, rate, values[2 * n + m + k] > 0.0)
        values[2 * n + k] = depth if depth <= contacts.numbers[k, 7] else np.nan
        if contacts.numbers[k, 3] == 1.0:
            values[2 * n + k] = min(depth, _press(contacts, k, depth, closing))
    return values


@strict_jit
def apply_loads(arrays, mass, factors, pose, rate, on):
    """Forces (n + 1, 3) at the centres of mass in the branches `on`; the last row is ground's."""
    n = mass.shape[0]
    force = np.zeros((n + 1, 3))
    for i in range(n):
        force[i, 0] = mass[i] * arrays.gravity[0]
        force[i, 1] = mass[i] * arrays.gravity[1]
    for k in range(arrays.pushed.shape[0]):
        scale = factors[int(arrays.pushes[k, 2])]
        force[arrays.pushed[k], 0] += scale * arrays.pushes[k, 0]
        force[arrays.pushed[k], 1] += scale * arrays.pushes[k, 1]
    springs, bushings, torsions, contacts = arrays.springs, arrays.bushings, arrays.torsions, arrays.contacts
    taut, touching = springs.a.shape[0], 2 * springs.a.shape[0]
    within = touching + contacts.a.shape[0]
    for k in range(taut):
        if on[k]:
            ax, ay, bx, by, ex, ey, pull, _ = _line(springs, k, pose, rate)
            if not on[taut + k]:
                pull = springs.numbers[k, 4]
            _push(force, springs.a[k], ax, ay, pull * ex, pull * ey)
            _push(force, springs.b[k], bx, by, -pull * ex, -pull * ey)
    for k in range(bushings.a.shape[0]):
        _bush(force, bushings, k, pose, rate)
    for k in range(torsions.a.shape[0]):
        a, b = torsions.a[k], torsions.b[k]
        turn = pose[b, 2] - pose[a, 2] - torsions.numbers[k, 2]
        torque = torsions.numbers[k, 0] * turn + torsions.numbers[k, 1] * (rate[b, 2] - rate[a, 2])
        force[a, 2] += torque
        force[b, 2] -= torque
    for k in range(contacts.a.shape[0]):
        if on[touching + k]:
            depth, closing, ax, ay, bx, by, nx, ny = _depth(contacts, k, pose, rate, on[within + k])
            press = _press(contacts, k, depth, closing)
            _push(force, contacts.a[k], ax, ay, press * nx, press * ny)
            _push(force, contacts.b[k], bx, by, -press * nx, -press * ny)
    return force


@strict_jit
def _bush(force, pairs, k, pose, rate):
    """Both forces act at b's mark, and the damper works on what slips there."""
    a, b = pairs.a[k], pairs.b[k]
    ax, ay, _, _ = _carried(pose, rate, a, pairs.point_a[k])
    bx, by, bvx, bvy = _carried(pose, rate, b, pairs.point_b[k])
    x, y = pose[b, 0] + bx - pose[a, 0], pose[b, 1] + by - pose[a, 1]
    slip_x, slip_y = bvx - rate[a, 0] + y * rate[a, 2], bvy - rate[a, 1] - x * rate[a, 2]
    fx = pairs.numbers[k, 0] * (x - ax) + pairs.numbers[k, 1] * slip_x
    fy = pairs.numbers[k, 0] * (y - ay) + pairs.numbers[k, 1] * slip_y
    _push(force, a, x, y, fx, fy)
    _push(force, b, bx, by, -fx, -fy)
