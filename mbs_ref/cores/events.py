"""Contact laws, springs and declared events of a scene: their arrays, and what a compiled scene reports of them."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.kernels import answers as core
from mbs_ref.kernels.border.groups import absent, floats, ints
from mbs_ref.kernels.contact import laws as shared
from mbs_ref.kernels.rigid.model import WATCH_COORDINATE, WATCH_DISTANCE, WATCH_RATE, Springs, Watches
from mbs_ref.kernels.rigid.outputs import Record, contact_forces_over, recall
from mbs_ref.scene import GROUND, PointBushing, Scene, SpringDamper
from mbs_ref.scene.base.attached import COORDINATES
from mbs_ref.scene.base.rows import Axes
from mbs_ref.scene.contact import FrictionNumbers
from mbs_ref.scene.events import CoordinateEvent, DistanceEvent
from mbs_ref.scene.scales import scales_of

NOISE = 1e-13  # of the largest coordinate or the scene's length: above what roundoff leaves of a gap
SLOW = 1e-8  # of the scene's speed, about eps^(1/2)
MOST_LOGGED = 100_000  # events of one run whose modes are stored for output

_CROSSINGS = {"either": 0, "rising": 1, "falling": -1}
RELEASES = {
    "gap": shared.RELEASE_GAP, "force": shared.RELEASE_FORCE, "rigid": shared.RELEASE_RIGID,
    "constraint": shared.RELEASE_CONSTRAINT,
}  # fmt: skip
_FRICTIONS = {"none": shared.FRICTION_NONE, "smooth": shared.FRICTION_SMOOTH, "stick_slip": shared.FRICTION_STICK_SLIP}


def contact_laws(scene: Scene, slots: dict[int, int]) -> shared.ContactLaws:
    """Return the laws and frictions; `slots` holds the row of each constraint contact, by its place."""
    if not scene.contacts:
        return absent(shared.ContactLaws)
    laws = [part.law.numbers() for part in scene.contacts]
    frictions = [part.friction.numbers() if part.friction else FrictionNumbers() for part in scene.contacts]
    numbers = [law._asdict() | friction._asdict() for law, friction in zip(laws, frictions, strict=True)]
    coded = {
        "release": [RELEASES["constraint" if k in slots else law.release] for k, law in enumerate(laws)],
        "friction": [_FRICTIONS[friction.kind] for friction in frictions],
        "slot": [slots.get(k, -1) for k in range(len(laws))],
    }
    arrays: dict[str, Any] = {name: ints(values) for name, values in coded.items()}
    plain = (name for name in shared.ContactLaws._fields if name not in coded)
    arrays |= {name: floats(row[name] for row in numbers) for name in plain}
    return shared.ContactLaws(**arrays)


def contact_noise(scene: Scene) -> np.ndarray:
    """Return how far (m, m/s, m/s^2) beyond its root an event function must be."""
    scales = scales_of(scene)
    size = max([scales.length, *(abs(x) for body in scene.bodies for x in body.position)])
    return NOISE * np.array([size, scales.speed, scales.speed / scales.time])


def event_sources(scene: Scene) -> list[str]:
    """Return what may have events, in the order of the modes: contacts, tension-only springs, declared events."""
    return [part.name for part in (*scene.contacts, *_tension_only(scene), *scene.events)]


def _tension_only(scene: Scene) -> list[SpringDamper]:
    """Return the springs that pull only, but those without stiffness and damping, which never pull."""
    springs = [load for load in scene.loads if isinstance(load, SpringDamper) and load.tension_only]
    return [load for load in springs if load.stiffness or load.damping]


def contact_modes(scene: Scene) -> shared.ContactModes:
    """Return the modes before a run has settled them: springs answer by the state until then."""
    count = len(event_sources(scene))
    noise = contact_noise(scene) if count else np.zeros(3)  # the scales take as long as the rest
    modes = shared.fresh_modes(count, noise, SLOW / NOISE * noise[1], MOST_LOGGED, scene.dimension)
    modes.mode[len(scene.contacts) : len(scene.contacts) + len(_tension_only(scene))] = shared.MODE_PLAIN
    return modes


def springs(scene: Scene, places: Axes) -> Springs:
    """Return the springs between points, and in the plane the bushings."""
    loads = [x for x in scene.loads if isinstance(x, SpringDamper | PointBushing)]
    if not loads:
        return absent(Springs)
    modes = {x.name: len(scene.contacts) + k for k, x in enumerate(_tension_only(scene))}
    given = [getattr(x, "rest_length", 0.0) for x in loads]  # a bushing is unstrained where its marks coincide
    rest = [math.dist(*x.marks) if length is None else length for length, x in zip(given, loads, strict=True)]
    point_a, point_b = (places.points([x.ends[k] for x in loads], [x.marks[k] for x in loads]) for k in range(2))
    return Springs(
        a=ints([places.body(x.body_a) for x in loads]), b=ints([places.body(x.body_b) for x in loads]),
        point_a=point_a, point_b=point_b, stiffness=floats(x.stiffness for x in loads),
        damping=floats(x.damping for x in loads), rest_length=floats(rest),
        limit=floats(getattr(x, "limit", None) or math.inf for x in loads),
        isotropic=ints([isinstance(x, PointBushing) for x in loads]),
        place=ints([modes.get(x.name, -1) for x in loads]),
    )  # fmt: skip


def watches(scene: Scene, places: Axes) -> Watches:
    """Return the declared events."""
    if not scene.events:
        return absent(Watches)
    noise, names = contact_noise(scene), COORDINATES[scene.dimension]
    ends = [e.ends if isinstance(e, DistanceEvent) else (e.body, GROUND) for e in scene.events]
    marks = [[places.points([end], [mark])[0] for end, mark in zip(e.ends, e.marks, strict=True)]
             if isinstance(e, DistanceEvent) else np.zeros((2, scene.dimension)) for e in scene.events]  # fmt: skip
    point_a, point_b = np.array(marks).swapaxes(0, 1).copy()
    return Watches(
        a=ints([places.body(a) for a, _ in ends]), b=ints([places.body(b) for _, b in ends]), point_a=point_a,
        point_b=point_b, quantity=ints([_quantity(event) for event in scene.events]),
        component=ints([names.index(getattr(event, "coordinate", "x")) for event in scene.events]),
        value=floats(event.value for event in scene.events),
        noise=floats(_watch_noise(event, noise) for event in scene.events),
        direction=ints([_CROSSINGS[event.crossing] for event in scene.events]),
        stops=ints([event.action == "stop" for event in scene.events]),
    )  # fmt: skip


def _watch_noise(event: DistanceEvent | CoordinateEvent, noise: np.ndarray) -> float:
    """Return how far beyond its value the quantity of an event must be: the value may be larger than the scene."""
    unit = noise[int(_quantity(event) == WATCH_RATE)]
    if getattr(event, "coordinate", "") == "angle":
        unit *= NOISE / noise[0]
    return max(unit, NOISE * abs(event.value))


def _quantity(event: DistanceEvent | CoordinateEvent) -> int:
    if isinstance(event, DistanceEvent):
        return WATCH_DISTANCE
    return WATCH_RATE if event.rate else WATCH_COORDINATE


class ContactSystem(System):
    """A system whose `groups` hold contact laws, modes and the list of near pairs."""

    record: Record  # of the last run

    def start_contacts(self, t: float, y: np.ndarray, located: bool) -> None:
        super().start_contacts(t, y, located)
        self._set_record()

    def _set_record(self) -> None:
        """Store the present modes as those of the start of a run."""
        groups, modes = self.groups, self.groups.contact_modes
        mode, grip, anchor, dashpot = modes.mode.copy(), modes.grip.copy(), modes.anchor.copy(), modes.dashpot.copy()
        stale, recalled = groups.near_pairs.stale, np.array([-1])
        self.record = Record(modes, mode, grip, anchor, dashpot, stale, recalled, groups.world.control)

    def spread_events(self, factor: float, lag: float = 0.0) -> None:
        modes = self.groups.contact_modes
        modes.noise[:] *= factor
        modes.first_lag[:] = lag

    @cached_property
    def event_sources(self) -> tuple[str, ...]:
        return tuple(event_sources(self.scene))

    def contact_events(self) -> np.ndarray:
        # a contact that comes to rest does so where its bounces end, a little after its last located impact
        modes = self.groups.contact_modes
        log = modes.log[: modes.logged[0]]
        log = log[np.isfinite(log[:, -1])]
        return log[np.argsort(log[:, -1], kind="stable")][:, (-1, 1)]

    def contact_oscillators(self, t: float, y: np.ndarray, speed: float) -> np.ndarray:
        laws = self.groups.contact_laws
        n, count = laws.exponent, len(laws.stiffness)
        mobility = np.array([core.call_contact_mobility(self.model, self.work, float(t), y, k) for k in range(count)])
        kw = laws.stiffness * mobility
        energy = np.divide(0.5 * (n + 1.0) * speed**2, kw, out=np.zeros(count), where=kw > 0.0)
        depth = energy ** (1.0 / (n + 1.0))  # k d^(n + 1) / (n + 1) = m v^2 / 2 with m = 1 / W
        slope = n * laws.stiffness * depth ** (n - 1.0)
        dashpot = laws.damping + laws.impact_damping * laws.stiffness / np.maximum(speed, laws.slowest)
        return np.column_stack((slope * mobility, dashpot * depth**laws.damping_exponent * mobility, slope))

    @contextmanager
    def taut_strings(self) -> Iterator[bool]:
        mode, first = self.groups.contact_modes.mode, len(self.scene.contacts)
        strings = mode[first : first + len(_tension_only(self.scene))]
        before = strings.copy()
        strings[:] = shared.MODE_CLOSED
        yield len(strings) > 0
        strings[:] = before

    def recall_modes(self, t: float) -> None:
        recall(self.record, t)

    def contact_forces(self, times: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
        # the modes of each time are replayed from the log of events, so the states must be the last run's
        self.prepare(core.REPORT)
        forces = np.zeros((len(times), len(self.scene.contacts), 1 + 2 * self.scene.dimension))
        times, states = np.ascontiguousarray(times), np.ascontiguousarray(states)
        contact_forces_over(self.model, self.work, self.record, times, states, forces)
        return {part.name: forces[:, k] for k, part in enumerate(self.scene.contacts)}
