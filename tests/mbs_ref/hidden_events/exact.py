"""The exact events of a world: uniform rotations and accelerations between impulses, and roots of their distances."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tests.mbs_ref.hidden_events.roots import Bounded, Undecided, roots
from tests.mbs_ref.hidden_events.world import GROUND, NOTHING, Body, Contact, Length, Level, Mark, Watch, World

FIRST_PART = 1.0 / 128.0  # of the remaining time, searched for the next impact; each further part is twice as long
MOST_EVENTS = 400
SIGNS = {"rising": (1,), "falling": (-1,), "either": (-1, 1)}


class Event(NamedTuple):
    """What happens, and when."""

    name: str
    time: float


@dataclass(frozen=True)
class Flight:
    """The motion of a body since `start`: its place accelerates uniformly, and it turns uniformly."""

    start: float
    place: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    spin: np.ndarray
    turned: np.ndarray  # (3, 3), body axes into world axes at `start`

    def point(self, arm: np.ndarray, times: np.ndarray, order: int = 0) -> np.ndarray:
        """Return a point's position (n, 3) or its derivative of that order at the times (n,)."""
        tau = (times - self.start)[:, None]
        along_path = (
            self.place + self.velocity * tau + 0.5 * self.acceleration * tau**2,
            self.velocity + self.acceleration * tau,
            self.acceleration + 0.0 * tau,
            0.0 * tau,
        )[order]
        rate = float(np.linalg.norm(self.spin))
        arm = self.turned @ arm
        if rate == 0.0:
            return along_path + (arm if order == 0 else 0.0)
        axis = self.spin / rate
        fixed = (axis @ arm) * axis
        across = arm - fixed
        angle = rate * tau + 0.5 * np.pi * order
        turning = rate**order * (np.cos(angle) * across + np.sin(angle) * np.cross(axis, across))
        return along_path + turning + (fixed if order == 0 else 0.0)

    def bound(self, arm: np.ndarray, order: int) -> float:
        """Return a bound on the norm of a point's derivative of order 2 or 3 at all times."""
        turning = float(np.linalg.norm(self.spin)) ** order * float(np.linalg.norm(arm))
        return turning + (float(np.linalg.norm(self.acceleration)) if order == 2 else 0.0)

    def at(self, time: float, velocity: np.ndarray, spin: np.ndarray) -> Flight:
        """Return the motion that follows at a time with other rates of the place."""
        turned = Rotation.from_rotvec(self.spin * (time - self.start)).as_matrix() @ self.turned
        place = self.point(NOTHING, np.array([time]))[0]
        return Flight(time, place, velocity, self.acceleration, spin, turned)


Flights = dict[str, Flight]


def take_off(world: World) -> Flights:
    """Return the motions at t = 0, ground included."""
    rest = Flight(0.0, NOTHING, NOTHING, NOTHING, NOTHING, np.eye(3))
    falls = {"free", "point"}
    return {GROUND: rest} | {
        body.name: replace(
            rest, place=body.place, velocity=body.velocity, spin=body.spin,
            acceleration=world.gravity if body.kind in falls else NOTHING,
        )
        for body in world.bodies
    }  # fmt: skip


def gap(watch: Watch, world: World, flights: Flights, shift: float) -> Bounded:
    """Return the function whose roots are the events, every threshold moved by `shift`."""
    if isinstance(watch, Level):
        return _level(watch, next(body for body in world.bodies if body.name == watch.body), flights, shift)
    if isinstance(watch, Length):
        distance = _distance(watch.a, watch.b, watch.value + shift, flights)
        return (lambda times, half: _turned_over(*distance(times, half))) if watch.acts else distance
    radius = watch.radius_a + watch.radius_b + shift
    if watch.normal is None:
        return _distance(watch.a, watch.b, radius, flights)
    return _height(watch.a, watch.b, watch.normal, radius, flights)


def _distance(a: Mark, b: Mark, value: float, flights: Flights) -> Bounded:
    """|D|^2 - value^2, its slope 2 D.D', and |2 D'.D' + 2 D.D''| bounded."""
    first, second = flights[a.body], flights[b.body]
    most = first.bound(a.arm, 2) + second.bound(b.arm, 2)

    def function(times: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        apart, rate = (first.point(a.arm, times, k) - second.point(b.arm, times, k) for k in (0, 1))
        speed = np.linalg.norm(rate, axis=1) + most * half
        reach = np.linalg.norm(apart, axis=1) + speed * half
        squared = np.einsum("ij,ij->i", apart, apart)
        return squared - value**2, 2.0 * np.einsum("ij,ij->i", apart, rate), 2.0 * (speed**2 + reach * most)

    return function


def _turned_over(value: np.ndarray, slope: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return -value, -slope, bound


def _height(a: Mark, b: Mark, normal: np.ndarray, value: float, flights: Flights) -> Bounded:
    first, second = flights[a.body], flights[b.body]
    most = first.bound(a.arm, 2) + second.bound(b.arm, 2)

    def function(times: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        height, rate = ((first.point(a.arm, times, k) - second.point(b.arm, times, k)) @ normal for k in (0, 1))
        return height - value, rate, most + 0.0 * half

    return function


def _level(watch: Level, body: Body, flights: Flights, shift: float) -> Bounded:
    flight, order = flights[watch.body], int(watch.rate)
    shift *= max(1.0, abs(watch.value)) if watch.rate else 1.0  # rates count in the largest of them

    def angle(times: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return flight.spin[2] * times - watch.value - shift, flight.spin[2] + 0.0 * times, 0.0 * half

    def coordinate(times: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        value, slope = (flight.point(body.offset, times, order + k)[:, watch.coordinate] for k in (0, 1))
        return value - watch.value - shift, slope, flight.bound(body.offset, order + 2) + 0.0 * half

    return angle if watch.coordinate == 3 else coordinate


@dataclass(frozen=True)
class Segment:
    """The motions between two impulses, and the contact whose impulse ends them."""

    start: float
    end: float
    flights: Flights
    impact: Contact | Length | None


def history(world: World, shift: float = 0.0) -> list[Segment]:
    """Return the exact motion up to the horizon, with every threshold moved by `shift`.

    Raises Undecided where roundoff decides, where two impulses coincide, and beyond MOST_EVENTS.
    """
    flights, segments, now = take_off(world), list[Segment](), 0.0
    _require_apart(world, flights, shift)
    solid = [watch for watch in world.watches if not isinstance(watch, Level) and watch.acts]
    while True:
        departing = segments[-1].impact if segments else None
        contact, until = _next_impact(solid, world, flights, shift, now, departing)
        segments.append(Segment(now, until, flights, contact))
        if contact is None:
            return segments
        if len(segments) > MOST_EVENTS or until - now < 1e-9 * world.horizon:
            raise Undecided("too many events, or two at once")
        impulsive = isinstance(contact, Contact) and contact.impulsive
        flights = flights | (_struck(contact, world, flights, until) if impulsive else _sprung(contact, flights, until))
        now = until + contact.hold
        if now > world.horizon:
            raise Undecided("touches at the end")


def solve(world: World, shift: float = 0.0) -> list[Event]:
    """Return the events up to the horizon in order of time; raises as `history`."""
    segments = history(world, shift)
    impacts = [(segment.impact, segment.end) for segment in segments if segment.impact is not None]
    events = [Event(impact.name, end) for impact, end in impacts]
    events += [Event(impact.name, end + impact.hold) for impact, end in impacts if impact.hold > 0.0]
    for watch in world.watches:
        if watch.acts:
            continue
        signs = SIGNS[getattr(watch, "crossing", "either")]
        for segment in segments:
            crossings = roots(gap(watch, world, segment.flights, shift), segment.start, segment.end)
            events += [Event(watch.name, time) for time, sign in crossings if sign in signs]
    if len(events) > MOST_EVENTS:
        raise Undecided("too many events")
    return sorted(events, key=lambda event: event.time)


def _require_apart(world: World, flights: Flights, shift: float) -> None:
    zero = np.zeros(1)
    for watch in world.watches:
        if isinstance(watch, Contact) and not gap(watch, world, flights, shift)(zero, zero)[0][0] > 0.0:
            raise Undecided(f"{watch.name} touches at the start")


def _next_impact(
    solid: list[Contact | Length],
    world: World,
    flights: Flights,
    shift: float,
    now: float,
    departing: Contact | Length | None,
) -> tuple[Contact | Length | None, float]:
    """Return the contact that touches first after `now`, and when; None and the horizon where none does."""
    first, until = None, world.horizon
    for contact in solid:
        function = gap(contact, world, flights, shift)
        start = _parted(function, now, until) if contact is departing else now
        part = FIRST_PART * (until - start)
        while start < until:
            end = min(start + part, until)
            times = [t for t, sign in roots(function, start, end) if sign < 0 and _within(contact, flights, t, shift)]
            if times:
                first, until = contact, times[0]
            start, part = end, 2.0 * part
        if isinstance(contact, Contact) and contact.edges:
            _require_no_side_entry(contact, world, flights, shift, now, until)
    return first, until


def _parted(function: Bounded, now: float, end: float) -> float:
    """Return a time until which a pair that has just parted moves apart: s = slope / bound after `now`."""
    half = 0.5 * (end - now)
    _, slope, _ = function(np.array([now]), np.zeros(1))
    bound = float(function(np.array([now + half]), np.array([half]))[2][0])
    if not slope[0] > 0.0:
        raise Undecided("an impact without separation")
    return min(end, now + float(slope[0]) / bound) if bound > 0.0 else end


def _apart(contact: Contact | Length, flights: Flights, times: np.ndarray, order: int = 0) -> np.ndarray:
    a, b = contact.a, contact.b
    return flights[a.body].point(a.arm, times, order) - flights[b.body].point(b.arm, times, order)


def _within(contact: Contact | Length, flights: Flights, time: float, shift: float) -> bool:
    if isinstance(contact, Length):
        return True
    apart = _apart(contact, flights, np.array([time]))[0]
    return all(abs(float(edge @ apart)) < contact.half + shift for edge in contact.edges)


def _require_no_side_entry(
    contact: Contact, world: World, flights: Flights, shift: float, now: float, until: float
) -> None:
    """Raise Undecided where the sphere enters a plate's region through its side and is neither above nor behind."""
    above = gap(contact, world, flights, shift)
    for edge in contact.edges:
        for side in (edge, -edge):
            for time, _ in roots(_height(contact.a, contact.b, side, contact.half + shift, flights), now, until):
                height = float(above(np.array([time]), np.zeros(1))[0][0])
                if -(contact.thickness or np.inf) * 1.001 < height < 1e-6:
                    raise Undecided("enters a plate from its side")


def _sprung(contact: Contact | Length, flights: Flights, time: float) -> Flights:
    """Return the motion of body a after half a period: its speed along the normal is reversed."""
    apart = _apart(contact, flights, np.array([time]))[0]
    normal = getattr(contact, "normal", None)
    normal = apart / np.linalg.norm(apart) if normal is None else normal
    before = flights[contact.a.body]
    along = float(normal @ before.velocity) * normal
    place = before.point(NOTHING, np.array([time]))[0] + (before.velocity - along) * contact.hold
    return {
        contact.a.body: replace(before, start=time + contact.hold, place=place, velocity=before.velocity - 2.0 * along)
    }


def _struck(contact: Contact, world: World, flights: Flights, time: float) -> Flights:
    """Return the motions after the impulse: its size is -(1 + e) n.v / sum of the mobilities along n."""
    apart, rate = (_apart(contact, flights, np.array([time]), order)[0] for order in (0, 1))
    normal = apart / np.linalg.norm(apart) if contact.normal is None else contact.normal
    touch = flights[contact.a.body].point(contact.a.arm, np.array([time]))[0] - contact.radius_a * normal
    pushes = [
        (body, flights[body.name], sign, time, touch, normal)
        for body in world.bodies
        for sign, mark in ((1.0, contact.a), (-1.0, contact.b))
        if mark.body == body.name
    ]
    mobility = sum(float(normal @ (_push(*push)[0] + _push(*push)[2])) * push[2] for push in pushes)
    assert contact.restitution is not None
    impulse = -(1.0 + contact.restitution) * float(normal @ rate) / mobility
    after = {}
    for push in pushes:
        (velocity, spin, _), flight = _push(*push), push[1]
        current = flight.point(NOTHING, np.array([time]), 1)[0]
        after[push[0].name] = flight.at(time, current + impulse * velocity, flight.spin + impulse * spin)
    return after


def _push(
    body: Body, flight: Flight, sign: float, time: float, touch: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the change of velocity, of spin, and of the touched point by turning, for a unit impulse."""
    lever = touch - flight.point(NOTHING, np.array([time]))[0]
    moment = np.cross(lever, sign * normal)
    if body.kind == "point":
        return sign * normal / body.mass, NOTHING, NOTHING
    if body.kind == "free":
        spin = moment / body.inertia
        return sign * normal / body.mass, spin, np.cross(spin, lever)
    about = body.inertia + body.mass * float(np.sum(np.cross(body.axis, body.offset) ** 2))
    spin = body.axis * float(body.axis @ moment) / about
    return NOTHING, spin, np.cross(spin, lever)


@dataclass(frozen=True)
class Truth:
    """The events, and how far each moves where every threshold moves by the resolution of the world's extent."""

    events: list[Event]
    moved: np.ndarray  # (n_events,) s


def truth(world: World, resolution: float) -> Truth:
    """Return the events where they are the same with every threshold moved by +- `resolution` of the world's extent.

    Raises Undecided where they are not: a run with errors of that size cannot know.
    """
    if resolution >= 1.0:  # thresholds moved by as much may lie beyond all of the motion, on both sides
        raise Undecided("errors as large as the world")
    low, events, high = (solve(world, sign * resolution * world.extent) for sign in (-1.0, 0.0, 1.0))
    if any(sorted(e.name for e in other) != sorted(e.name for e in events) for other in (low, high)):
        raise Undecided("which events occur depends on less than the resolution")
    if any(event.time > (1.0 - 1e-4) * world.horizon for event in (*low, *events, *high)):
        raise Undecided("an event at the end")
    ordered = [sorted(each, key=lambda event: (event.name, event.time)) for each in (low, events, high)]
    times = np.array([[event.time for event in each] for each in ordered]).reshape(3, -1)
    return Truth(ordered[1], np.maximum(np.abs(times[0] - times[1]), np.abs(times[2] - times[1])))
