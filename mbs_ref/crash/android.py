"""Sourced data -> scene: the planar crash occupants of Fox 1999 on their seat.

The data in mbs_ref/data carry the provenance of every number. Body points are in body axes from the
centre of mass; angles of contact surfaces and belts follow from the two seat bodies.
"""

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_type_hints

from pydantic import Field

from mbs_ref import scene as parts
from mbs_ref.crash.outlines import Places, Point, read_data
from mbs_ref.crash.stops import body_contacts, joint_stops
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.base.part import BELIEVABLE_ONLY, NonNegative, of_paper
from mbs_ref.scene.contact import CircleOnLine, ConstraintLaw, Contact, ContactLaw, ProgressiveLaw, SpringDamperLaw
from mbs_ref.scene.signals import Constant, HalfSine, Signal, Table

DURATION = 0.2  # s, the longest crash of Fox 1999 eqs 34-35
TABLE_POINTS = 41  # of the pulse as a breakpoint table
SOURCE = "Fox 1999 (the mechanism, forces and pulse); parameters and their origin in mbs_ref/crash/data/{}.json"


_BELTS = read_data("believable")["belts"]
# what model = "paper" has instead of the defaults, which are those of "believable"
PAPER: dict[str, Any] = {
    "slack": 0.0, "retractor": 0.0, "belt_limit": 0.0, "stops": False, "body_contacts": False, "toe_board": False,
    "head_restraint": "integral",
}  # fmt: skip
Restraint = Literal["integral", "separate", "none"]


@dataclass(frozen=True, kw_only=True)
class Crash:
    """The parameters of a crash: those of the scenes android_simplified and android_vertebral.

    ValueError where model = "paper" and a value that only the believable model has go together.
    """

    model: Literal["believable", "paper"] = "believable"
    peak_force: Annotated[float, Field(ge=500.0, le=100_000.0)] = 15_000.0  # N
    speed_change_km_h: Annotated[float, Field(gt=0.0, le=200.0)] = 50.0
    impact: Literal["front", "rear"] = "front"
    mass: Annotated[float, Field(ge=50.0, le=100.0)] = 75.0  # kg
    belts: bool = True
    belt_stiffness: NonNegative = 1.0  # times the sourced stiffness and damping
    law: Literal["progressive", "spring_damper", "constraint"] = "progressive"
    seat: Literal["fixed", "driven"] = "fixed"
    pulse: Literal["half_sine", "table"] = "half_sine"
    lift: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0  # m
    slack: Annotated[float, Field(ge=0.0, le=0.2), BELIEVABLE_ONLY] = _BELTS["slack"]  # m
    retractor: Annotated[float, Field(ge=0.0, le=0.2), BELIEVABLE_ONLY] = 0.0  # m
    belt_limit: Annotated[NonNegative, BELIEVABLE_ONLY] = _BELTS["limit"]  # N
    stops: Annotated[bool, BELIEVABLE_ONLY] = True
    body_contacts: Annotated[bool, BELIEVABLE_ONLY] = True
    toe_board: Annotated[bool, BELIEVABLE_ONLY] = True
    head_restraint: Annotated[Restraint, BELIEVABLE_ONLY] = "separate"

    def __post_init__(self) -> None:
        if self.model == "paper":
            vars(self).update(of_paper(PAPER, vars(self), vars(Crash)))

    @property
    def pulse_duration(self) -> float:
        """T (s) of a half sine whose impulse is m dv (Fox 1999 eqs 34-35): T = pi m dv / (2 F)."""
        return math.pi * self.mass * self.speed_change_km_h / 3.6 / (2.0 * self.peak_force)

    @property
    def peak_acceleration(self) -> float:
        """Signed, m/s^2: +x, out of the seat, in a frontal impact."""
        return (1.0 if self.impact == "front" else -1.0) * self.peak_force / self.mass


PARAMETERS = """peak_force (N) and speed_change_km_h fix a half sine (or its breakpoint table) with impulse m dv; front
or rear impact; mass (kg) scales masses and inertias; belts, and their stiffness and damping times
belt_stiffness; contact law, or a constraint in its place; seat fixed with mass-proportional forces, or driven; lift
(m) off the seat. What the papers' bare model, model = "paper", does not have: slack (m) of both belts;
retractor (m), the webbing that the shoulder belt's reel pays out until it locks (UNECE R16, 6.2.5.3, permits 0.05);
belt_limit (N) of its load limiter, which caps what its strands pull by together (0: none); stops of the joints at a
person's ranges of motion; body_contacts of head, chin, chest, arms and shanks with thighs, chest and seat, by a force
whatever the law; a toe_board ahead of the feet; and a head_restraint that is separate at a gap behind the head, part of
the seat back (integral, the papers'), or none."""


def scene_builder(module: str, name: str, summary: str, description: str) -> Callable[..., Scene]:
    """Return the builder of the scene with the android of mbs_ref/crash/data/<name>.json, as a function of a module."""

    def build(**parameters: Any) -> Scene:
        return android(name, description, Crash(**parameters))

    build.__module__, build.__doc__ = module, f"{summary}\n\n{PARAMETERS}"
    build.__signature__ = inspect.signature(Crash)  # type: ignore[attr-defined]
    build.__annotations__ = {**get_type_hints(Crash, include_extras=True), "return": Scene}
    return build


def android(name: str, description: str, crash: Crash) -> Scene:
    """Return the android of mbs_ref/crash/data/<name>.json in a crash."""
    model = _Model(read_data(name), crash)
    data = model.data
    return Scene(
        name=name,
        description=" ".join((description, *_consequences(crash))),
        source=SOURCE.format(name),
        duration=DURATION,
        gravity=(0.0, -data["gravity"]),
        bodies=(*model.bodies(data["bodies"]), *model.bodies(data["seat_bodies"])),
        joints=(*model.revolutes(), *model.seat_joints()),
        loads=(*model.torsion_springs(), *model.bushings(), *model.belts(), *model.crash_forces(), *model.stops()),
        contacts=(*model.seat_contacts(), *model.floor_contacts(), *model.body_contacts()),
    )


def _consequences(crash: Crash) -> list[str]:
    has = {
        "joint stops": crash.stops, "contacts of its parts with one another": crash.body_contacts,
        "toe-board": crash.toe_board,
    }  # fmt: skip
    lacks = [what for what, there in {"friction": False, **has}.items() if not there]
    notes = [f"It has no {', no '.join(lacks)}."]
    if crash.head_restraint != "integral":
        notes.append(f"Head restraint: {crash.head_restraint}.")
    if crash.pulse_duration > DURATION:
        share = 0.5 * (1.0 - math.cos(math.pi * DURATION / crash.pulse_duration))
        notes.append(
            f"The pulse lasts {crash.pulse_duration:.3f} s and ends after the run of {DURATION} s, "
            f"which sees {100 * share:.0f} % of the speed change."
        )
    if crash.lift > 0.0:
        notes.append(
            f"The android floats {crash.lift:g} m above its seat at t = 0: it falls, and its belts are strained."
        )
    return notes


class _Model:
    """The data, with points turned into world axes at t = 0."""

    def __init__(self, data: dict[str, Any], crash: Crash) -> None:
        self.data, self.crash = data, crash
        self.places = Places(data, crash.lift)
        self.more = read_data("believable")
        self.scale = crash.mass / data["total_android_mass"]

    def bodies(self, entries: list[dict[str, Any]]) -> list[parts.PlanarBody]:
        bodies = []
        for entry in entries:
            scale = 1.0 if entry["name"] in self.places.seats else self.scale
            place, angle = self.places.pose(entry["name"])
            bodies.append(
                parts.PlanarBody(
                    name=entry["name"], mass=scale * entry["mass"], inertia=scale * entry["Izz"],
                    position=place, angle=angle,
                )
            )  # fmt: skip
        return bodies

    def revolutes(self) -> list[parts.Revolute]:
        at = self.places.point
        return [
            parts.Revolute(name=_pair(j), body_a=j["body_j"], body_b=j["body_i"], point=at(j["body_i"], j["point_i"]))
            for j in self.data["joints"]
        ]

    def seat_joints(self) -> list[parts.Joint]:
        """Hold the seat in the vehicle frame, or drive it by x = -double integral of a (rheonomic)."""
        if self.crash.seat == "fixed":
            return [
                parts.Weld(name=f"{s}.hold", body_a=GROUND, body_b=s, point=self.places.pose(s)[0])
                for s in sorted(self.places.seats)
            ]
        still, drives = Constant(value=0.0), []
        for seat in sorted(self.places.seats):
            drives += [
                parts.CoordinateDrive(name=f"{seat}.x", body=seat, coordinate="x",
                                motion=_pulse(self.crash, -self.crash.peak_acceleration), level="acceleration"),
                parts.CoordinateDrive(name=f"{seat}.y", body=seat, coordinate="y", motion=still),
                parts.CoordinateDrive(name=f"{seat}.angle", body=seat, coordinate="angle", motion=still),
            ]  # fmt: skip
        return drives

    def torsion_springs(self) -> list[parts.TorsionSpring]:
        """Restoring torques on theta_i - theta_j."""
        return [
            parts.TorsionSpring(
                name=f"{_pair(j)}.restoring", body_a=j["body_j"], body_b=j["body_i"],
                stiffness=j["torsion_k"], damping=j["torsion_c"], rest_angle=j["theta0"],
            )
            for j in self.data["joints"]
        ]  # fmt: skip

    def bushings(self) -> list[parts.PointBushing]:
        """Shoulder tissue and costal cartilage, free of force at t = 0."""
        return [
            parts.PointBushing(
                name=b["name"], body_a=b["body_j"], body_b=b["body_i"],
                point=self.places.point(b["body_i"], b["point_i"]), stiffness=b["k"], damping=b["c"],
            )
            for b in self.data["bushings"]
        ]  # fmt: skip

    def belts(self) -> list[parts.SpringDamper]:
        if not self.crash.belts:
            return []
        strands = [(b, *self._strand(b)) for b in self.data["belts"]]
        return [
            parts.SpringDamper(
                name=f"belt.{b['name']}", body_a=b["anchor_body"], body_b=b["body"],
                point_a=self.places.point(b["anchor_body"], b["anchor_point"]),
                point_b=self.places.point(b["body"], b["point"]),
                stiffness=factor * b["k"], damping=factor * b["c"],
                rest_length=b["rest_length"] + b["slack"] + loose, tension_only=True, limit=limit,
            )
            for b, factor, limit, loose in strands
        ]  # fmt: skip

    def _strand(self, belt: dict[str, Any]) -> tuple[float, float | None, float]:
        """Return what a belt's stiffness and damping are times the data's, its limit (N) and what is loose of it (m).

        The strands of the shoulder belt share its stiffness and its limit: as the data have it, or in the believable
        model with a fixed share for the clavicle, where there is one.
        """
        shoulder = [b for b in self.data["belts"] if b["name"].startswith("thorax")]
        if belt not in shoulder:
            return self.crash.belt_stiffness, None, self.crash.slack
        total = sum(b["k"] for b in shoulder)
        share = belt["k"] / total
        if self.crash.model == "believable" and len(shoulder) > 1:
            clavicle = self.more["belts"]["clavicle_share"]
            share = clavicle if belt["body"] == "clavicle" else (1.0 - clavicle) / (len(shoulder) - 1)
        loose = self.crash.slack + self.crash.retractor
        return self.crash.belt_stiffness * share * total / belt["k"], share * self.crash.belt_limit or None, loose

    def crash_forces(self) -> list[parts.Load]:
        """m_i a(t) on every part of the android, in the frame of a fixed seat (d'Alembert)."""
        if self.crash.seat == "driven":
            return []
        signal = _pulse(self.crash, 1.0)
        return [
            parts.Force(
                name=f"crash.{b['name']}", body=b["name"], point=self.places.pose(b["name"])[0],
                vector=(self.scale * b["mass"] * self.crash.peak_acceleration, 0.0), factor=signal,
            )
            for b in self.data["bodies"]
        ]  # fmt: skip

    def seat_contacts(self) -> list[Contact]:
        own = [c for c in self.data["contacts"] if c["body"] != "head" or self.crash.head_restraint == "integral"]
        contacts: list[Contact] = [
            self._contact(c, c["surface_body"], *self.places.seat_surface(c["surface_body"])) for c in own
        ]
        return [*contacts, *([self._head_restraint()] if self.crash.head_restraint == "separate" else [])]

    def _head_restraint(self) -> Contact:
        """A pad parallel to the seat back, at its gap behind the head."""
        first, second = self.places.seat_surface("seat_back")
        across, along = (second[k] - first[k] for k in (0, 1))
        length = math.hypot(across, along)
        out, head, pad = (-along / length, across / length), self.places.pose("head")[0], self.more["head_restraint"]
        above = out[0] * (head[0] - first[0]) + out[1] * (head[1] - first[1])
        shift = above - pad["radius"] - pad["backset"]
        ends = [(p[0] + shift * out[0], p[1] + shift * out[1]) for p in (first, second)]
        entry = {"body": "head", "point": "restraint", "radius": pad["radius"], **pad}
        return self._contact(entry, "seat_back", *ends, center=head)

    def floor_contacts(self) -> list[Contact]:
        level = [self._contact(c, GROUND, (0.0, 0.0), (1.0, 0.0)) for c in self.data["floor"]]
        return [*level, *(self._toe_board() if self.crash.toe_board else [])]

    def _toe_board(self) -> list[Contact]:
        """A plane of the vehicle that rises ahead of the feet: the ball of the foot touches it at t = 0."""
        board = self.more["toe_board"]
        slope = math.radians(board["slope_deg"])
        ball = next(c for c in self.data["floor"] if c["point"] == "ball")
        x, y = self.places.point(ball["body"], ball["point"])
        first = (x + ball["radius"] * math.sin(slope), y - ball["radius"] * math.cos(slope))
        second = (first[0] + math.cos(slope), first[1] + math.sin(slope))
        pad = board["pad"] | {"where": "toe_board"}
        return [self._contact(c | pad, "seat_base", first, second) for c in self.data["floor"]]

    def stops(self) -> list[parts.Load]:
        return [*joint_stops(self.data["joints"], self.more["stops"], self.places)] if self.crash.stops else []

    def body_contacts(self) -> list[Contact]:
        return [*body_contacts(self.more["contacts"], self.places)] if self.crash.body_contacts else []

    def _contact(
        self, entry: dict[str, Any], surface: str, first: Point, second: Point, center: Point | None = None
    ) -> CircleOnLine:
        where = entry.get("where") or ("floor" if surface == GROUND else surface)
        return CircleOnLine(
            name=f"{entry['body']}.{entry['point']}.{where}", body_a=entry["body"],
            center=center or self.places.point(entry["body"], entry["point"]), radius=entry["radius"], body_b=surface,
            point_1=first, point_2=second, law=_law(entry, self.crash.law),
        )  # fmt: skip


def _pair(joint: dict[str, Any]) -> str:
    return f"{joint['body_i']}-{joint['body_j']}"


def _law(entry: dict[str, Any], law: str) -> ContactLaw:
    if law == "constraint":
        return ConstraintLaw()
    if law == "progressive":
        return ProgressiveLaw(stiffness=entry["k"], damping=entry["c_progressive"])
    return SpringDamperLaw(stiffness=entry["k"], damping=entry["c_kv"], release="force")


def _pulse(crash: Crash, peak: float) -> Signal:
    """The pulse with the given peak; the table has the impulse of the half sine."""
    duration = crash.pulse_duration
    if crash.pulse == "half_sine":
        return HalfSine(peak=peak, duration=duration)
    n = TABLE_POINTS - 1
    sines = [0.0 if k in (0, n) else math.sin(math.pi * k / n) for k in range(TABLE_POINTS)]
    factor = 2.0 / math.pi * n / sum(sines)  # preserves the impulse
    times = tuple(duration * k / n for k in range(TABLE_POINTS))
    return Table(times=times, values=tuple(factor * peak * s for s in sines))
