"""The equations of motion of a scene in joint coordinates: accelerations and multipliers are z, the rest is y.

A tree of joints states every body's motion; the joints that remain close loops. A residual of g is the power balance
of one joint: what the bodies beyond it need, along its freedom. Closures enter by their second derivatives, so that
the start alone decides where they are closed.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import compress
from typing import Any

import numpy as np

from cross_checks.truths.proofs.coverage import DRIVES, complaints
from cross_checks.truths.proofs.derivation import LEVELS, Derivation, Exact, NotCovered, Units
from cross_checks.truths.proofs.kinematics import Frame, plane_turn, product, space_turn
from cross_checks.truths.proofs.loads import LAWS, impact
from cross_checks.truths.proofs.tape import Formula, Vector, rate
from mbs_ref.scene import GROUND

IDENTICAL = 1e-12  # of a closure in units of the scene's length that holds at any angle; the checker decides
NO_COORDINATES = ("distance", "universal", *DRIVES)  # joints that close a loop wherever they are
LOOPS = ("revolute", "spherical", *NO_COORDINATES)


def derive(scene: Any, exact: Exact, units: Units) -> dict[str, Any]:
    """Return the tape of a scene, the lines of y', g and every body's state, and start values.

    Raises NotCovered with every reason.
    """
    if reasons := list(complaints(scene)):
        raise NotCovered("; ".join(reasons))
    work = Derivation(scene, exact, units, parallel=True)
    loops = _tree(work)
    if not (loops and work.shared and _is_closed(work, loops)):
        work = Derivation(scene, exact, units)
        loops = _tree(work)
    for body in scene.bodies:
        work.wrench[body.name] = _inertial(work, body)
    for load in scene.loads:
        LAWS[load.type](work, load)
    for joint in () if work.shared else loops:
        _close(work, joint)
    _balance(work)
    _leave_rates_to_closures(work)
    contacts = [impact(work, contact) for contact in scene.contacts]
    return {
        "lines": work.tape.lines,
        "f": [rate.place for rate in work.unknowns.rates],
        "g": [residual.place for residual in work.residuals],
        "z": work.unknowns.z_count,
        "clock": work.clock, "free": work.free, "contacts": contacts,
        "starts": [None if start is None else start.place for start in work.unknowns.starts],
        "outputs": [[one.place for one in _output(work, body)] for body in scene.bodies],
        "units": [str(units.length), str(units.time), str(units.mass)],
    }  # fmt: skip


def _tree(work: Derivation) -> list[Any]:
    """State the frames of all bodies from ground outward; return the joints that close loops."""
    scene, remaining = work.scene, [joint for joint in work.scene.joints if joint.type not in NO_COORDINATES]
    queue, free, used = deque([GROUND]), deque(body.name for body in scene.bodies), set()

    def add(parent: str, name: str, joint: Any) -> None:
        work.frames[name] = _ADD["free" if joint is None else joint.type](work, parent, name, joint)
        work.order.append((parent, name, joint))
        queue.append(name)

    while queue or free:
        if not queue:
            name = free.popleft()
            if name not in work.frames:
                add(GROUND, name, None)
            continue
        here = queue.popleft()
        for joint in remaining:
            if joint.name in used or here not in joint.ends:
                continue
            there = joint.body_b if here == joint.body_a else joint.body_a
            if there not in work.frames:
                used.add(joint.name)
                add(here, there, joint)
    loops = [joint for joint in scene.joints if joint.name not in used]
    for joint in loops:
        if joint.type not in LOOPS:
            raise NotCovered(f"joint {joint.name} ({joint.type}) closes a loop, which is not covered")
    return loops


def _is_closed(work: Derivation, loops: list[Any]) -> bool:
    """Return whether the joints of loops hold at any angles, so that the motion of the tree is one of the scene."""
    joints = [*loops, *(joint for *_, joint in work.order)]
    kinds = {(getattr(joint, "type", None), getattr(joint, "axis", None)) for joint in joints}
    if [kind for kind, _ in kinds] != ["revolute"]:
        return False
    return np.abs(work.somewhere([x for joint in loops for x in np.subtract(*work.marks(joint))])).max() < IDENTICAL


def _free(work: Derivation, parent: str, name: str, joint: Any) -> Frame:
    position, (speed, _) = work.bodies[name].position, work.rate(name)
    starts = zip(work.vector(position, work.units.length), speed, range(len(position)), strict=False)
    place = [work.unknowns.motion(x, u) for x, u, _ in starts]
    return replace(_spinning(work, name), place=np.array([*place, *[work.tape.number(0)] * (3 - len(place))]))


def _spinning(work: Derivation, name: str) -> Frame:
    """Return the turn of a body whose orientation is free; a particle has none."""
    base, body, unknowns, tape = work.frames[GROUND], work.bodies[name], work.unknowns, work.tape
    _, spin = work.rate(name)
    if body.type == "point_mass":
        return base
    zero, moving = tape.number(0), [x for x in spin if x.constant != 0]
    if work.parallel and not moving:
        return base
    if work.parallel and tuple(spin) not in work.shared:
        work.shared[tuple(spin)] = unknowns.motion(zero, moving[0])
    if body.type == "planar":
        angle = work.shared[tuple(spin)] if work.parallel else unknowns.motion(zero, spin[2])
        return replace(base, turn=plane_turn(tape, angle), spin=np.array([zero, zero, angle.rate]), angle=angle, e=())
    if work.parallel:
        axis = np.array([tape.number(int(rate in moving)) for rate in spin])
        return _turning(base, axis, work.shared[tuple(spin)])
    e = tuple(unknowns.state(tape.number(int(k == 0))) for k in range(4))
    w = np.array([unknowns.state(x) for x in spin])
    for one, change in zip(e, product((zero, *w), e), strict=True):
        unknowns.follow(one, change * Fraction(1, 2))
    for one in w:
        unknowns.follow(one, unknowns.dependent())
    return replace(base, turn=space_turn(e), spin=w, angle=None, e=e)


def _turning(base: Frame, axis: Vector, angle: Formula) -> Frame:
    """Return a turn about an axis of `base`."""
    s, c = (angle * Fraction(1, 2)).sin_cos()
    e = product(base.e, (c, *(axis * s)))
    spin = base.spin + base.along(axis) * angle.rate
    return replace(base, turn=space_turn(e), spin=spin, angle=None, e=e)


def _hung(work: Derivation, parent: str, name: str, point: Any, own: Frame) -> Frame:
    """Return the frame of a body that turns as `own` about a point of its parent."""
    return replace(own, place=work.mark(parent, point) - own.along(work.offset(name, point)))


def _spherical(work: Derivation, parent: str, name: str, joint: Any) -> Frame:
    return _hung(work, parent, name, joint.point, _spinning(work, name))


def _revolute(work: Derivation, parent: str, name: str, joint: Any) -> Frame:
    if joint.axis is None or work.parallel:
        return _spherical(work, parent, name, joint)
    base = work.frames[parent]
    axis = work.unit(joint.axis)
    speed = axis @ (work.rate(name)[1] - work.rate(parent)[1])
    own = _turning(base, axis, work.unknowns.motion(work.tape.number(0), speed))
    return _hung(work, parent, name, joint.point, own)


def _prismatic(work: Derivation, parent: str, name: str, joint: Any) -> Frame:
    start, axis = work.bodies[name].position, work.unit(joint.axis)
    (va, wa), (vb, _) = work.rate(parent), work.rate(name)
    along = axis @ (vb - va - np.cross(wa, work.offset(parent, start)))
    slide = work.unknowns.motion(work.tape.number(0), along)
    base = work.frames[parent]
    return replace(base, place=work.mark(parent, start) + base.along(axis) * slide)


def _weld(work: Derivation, parent: str, name: str, joint: Any) -> Frame:
    return replace(work.frames[parent], place=work.mark(parent, work.bodies[name].position))


_ADD: dict[str, Callable[[Derivation, str, str, Any], Frame]] = {
    "free": _free, "spherical": _spherical, "revolute": _revolute, "prismatic": _prismatic, "weld": _weld,
}  # fmt: skip


def _inertial(work: Derivation, body: Any) -> tuple[Vector, Vector]:
    """Return what a body's acceleration needs beyond its weight: force, and moment about the origin."""
    units, frame, tape = work.units, work.frames[body.name], work.tape
    weight = work.vector(work.scene.gravity, units.length / units.time**2)
    force = (rate(rate(frame.place)) - weight) * work.number(body.mass, units.mass)
    unit = units.mass * units.length**2
    if body.type == "point_mass":
        moment = work.frames[GROUND].place
    elif body.type == "planar":
        moment = np.array([tape.number(0), tape.number(0), frame.spin[2].rate * work.number(body.inertia, unit)])
    else:
        inertia = _inertia_at_start(work, body, unit)

        def momentum(w: Vector) -> Vector:
            return frame.turn @ (inertia @ (frame.turn.T @ w))

        moment = momentum(rate(frame.spin)) + np.cross(frame.spin, momentum(frame.spin))
    return force, moment + np.cross(frame.place, force)


def _inertia_at_start(work: Derivation, body: Any, unit: Fraction) -> np.ndarray:
    """Return the inertia along world axes at t = 0; the orientation is divided by its norm, exactly."""
    xx, yy, zz, xy, xz, yz = (work.number(x, unit) for x in body.inertia)
    parameters = np.array([work.exact(x) for x in body.orientation])
    turn = space_turn(tuple(map(work.tape.number, parameters))) * (1 / (parameters @ parameters))
    return turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T


def _close(work: Derivation, joint: Any) -> None:
    """Add the multipliers of a loop's joint and the second derivatives of its closure."""
    if joint.type in DRIVES:
        _drive(work, joint)
        return
    a, b = work.marks(joint)
    gap = b - a
    if joint.type == "distance":
        pull = gap * work.unknowns.dependent()
        work.close((gap @ gap) * Fraction(1, 2))
    else:
        moved = [_is_moved(work, row) for row in gap]
        pull = np.array([work.unknowns.dependent() if k else work.tape.number(0) for k in moved])
        for row in compress(gap, moved):
            work.close(row)
    work.apply(joint.body_b, b, pull)
    work.apply(joint.body_a, a, -pull)
    for first, second in _square(joint):
        one = work.frames[joint.body_a].along(work.vector(first))
        other = work.frames[joint.body_b].along(work.vector(second))
        if not _is_moved(work, one @ other):
            continue
        couple, still = np.cross(one, other) * work.unknowns.dependent(), work.frames[GROUND].place
        work.apply(joint.body_a, still, still, couple)
        work.apply(joint.body_b, still, still, -couple)
        work.close(one @ other)


def _is_moved(work: Derivation, row: Formula) -> bool:
    """Return whether any motion of the tree changes a closure; without one, it needs no multiplier."""
    return abs(work.somewhere([row.rate])[0]) > IDENTICAL


def _drive(work: Derivation, joint: Any) -> None:
    """Apply a drive's multiplier, and add the derivatives of what it prescribes; at t = 0, lower ones are 0."""
    frame, zero = work.frames[joint.body], work.tape.number(0)
    unit, push, still = work.units.length, work.unknowns.dependent(), work.frames[GROUND].place
    if joint.type == "coordinate_drive" and joint.coordinate == "angle":
        work.apply(joint.body, still, still, np.array([zero, zero, push]))
        speed, unit = frame.spin[2], 1
    else:
        chosen = joint.type == "coordinate_drive"
        axis = work.unit([float(c == joint.coordinate) for c in "xyz"] if chosen else joint.direction)
        place = work.mark(joint.body, work.bodies[joint.body].position if chosen else joint.point)
        work.apply(joint.body, place, axis * push)
        speed = axis @ rate(place)
    level = LEVELS.index(joint.level)
    wanted = work.signal(joint.motion) * (work.units.time**level / unit)
    own, first = ((wanted.rate, wanted.rate.rate), (wanted, wanted.rate), (zero, wanted))[level]
    work.closing.append(speed - own)
    work.residuals.append(speed.rate - first)


def _square(joint: Any) -> list[tuple[Any, Any]]:
    """Return the directions of body a and of body b that a loop's joint keeps perpendicular."""
    if joint.type == "universal":
        return [(joint.axis_a, joint.axis_b)]
    if joint.type != "revolute" or joint.axis is None:
        return []
    main = max(range(3), key=lambda k: abs(joint.axis[k]))
    across = [[0.0] * 3 for _ in range(2)]
    for direction, k in zip(across, {0, 1, 2} - {main}, strict=True):
        direction[k], direction[main] = joint.axis[main], -joint.axis[k]
    return [(direction, joint.axis) for direction in across]


def _balance(work: Derivation) -> None:
    """Add the power balance of every joint, from the leaves inward, or of every shared angle."""
    powers = [work.tape.number(0) for _ in work.shared]
    for parent, name, joint in reversed(work.order):
        force, moment = work.wrench[name]
        mass = Fraction(2) ** round(work.exact(work.bodies[name].mass) / work.units.mass).bit_length()
        rows = [row * (1 / mass) for row in _rows(work, parent, name, joint, force, moment)]
        if not work.shared:
            work.residuals += rows
        for k, spin in enumerate(work.shared):
            turns = int(tuple(work.rate(name)[1]) == spin) - int(tuple(work.rate(parent)[1]) == spin)
            powers[k] = powers[k] + rows[0] * (mass * turns)
        if parent != GROUND:
            work.wrench[parent] = work.wrench[parent][0] + force, work.wrench[parent][1] + moment
    work.residuals += powers


def _rows(work: Derivation, parent: str, name: str, joint: Any, force: Vector, moment: Vector) -> list[Formula]:
    body, base = work.bodies[name], work.frames[parent]
    turning = {"planar": 2, "point_mass": 3}.get(body.type, 0)  # the first direction of its own turn
    if joint is None:
        about = moment - np.cross(work.frames[name].place, force)
        return [*force[: len(body.position)], *about[turning:]]
    if joint.type == "weld":
        return []
    if joint.type == "prismatic":
        return [(base.turn @ work.unit(joint.axis)) @ force]
    about = moment - np.cross(work.mark(parent, joint.point), force)
    if getattr(joint, "axis", None) is None:
        return list(about[turning:])
    return [(base.turn @ work.unit(joint.axis)) @ about]


def _leave_rates_to_closures(work: Derivation) -> None:
    """Clear the start rates that closures of loops decide: the last ones that are independent in them."""
    starts, lines, places = work.unknowns.starts, work.tape.lines, [row.place for row in work.closing]
    rates = [k for k, rate in enumerate(work.unknowns.rates) if lines[rate.place][0] == "z"]
    given = work.tape.values([start.place for start in starts if start], np.zeros(len(starts)))
    still = np.where([k in rates for k in range(len(starts))], 0.0, given)
    base, chosen = work.tape.values(places, still), []
    for k in reversed(rates if given[rates].any() or base.any() else []):
        chosen.append(work.tape.values(places, still + np.eye(len(starts))[k]) - base)
        if np.linalg.matrix_rank(chosen) == len(chosen):
            starts[k] = None
        else:
            chosen.pop()


def _output(work: Derivation, body: Any) -> list[Formula]:
    """Return place, angle in the plane, Euler parameters since t = 0, velocity and spin; a particle does not turn."""
    frame, ground = work.frames[body.name], work.frames[GROUND]
    turning = ground if body.type == "point_mass" else frame
    angle, e = (turning.angle if body.type == "planar" else None) or work.tape.number(0), turning.e
    if body.type == "planar":
        s, c = (angle * Fraction(1, 2)).sin_cos()
        e = (c, *ground.place[:2], s)
    return [*frame.place, angle, *e, *rate(frame.place), *turning.spin]
