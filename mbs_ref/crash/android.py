"""Sourced data -> scene: the planar crash occupants of Fox 1999 on their seat.

The data in mbs_ref/data carry the provenance of every number. Body points are in body axes from the
centre of mass; angles of contact surfaces and belts follow from the two seat bodies.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Annotated, Any, Literal

from pydantic import Field

from mbs_ref.scene import (
    GROUND,
    CoordinateDrive,
    Force,
    Joint,
    Load,
    PlanarBody,
    PointBushing,
    Revolute,
    Scene,
    SpringDamper,
    TorsionSpring,
    Weld,
)
from mbs_ref.scene.base.part import NonNegative
from mbs_ref.scene.contact import CircleOnLine, Contact, ContactLaw, ProgressiveLaw, SpringDamperLaw
from mbs_ref.scene.signals import Constant, HalfSine, Signal, Table

Point = tuple[float, float]
DURATION = 0.2  # s, the longest crash of Fox 1999 eqs 34-35
TABLE_POINTS = 41  # of the pulse as a breakpoint table
PAPER = "Fox 1999 (the mechanism, forces and pulse); parameters and their origin in mbs_ref/crash/data/{}.json"


@dataclass(frozen=True)
class Crash:
    """What may be chosen about a crash; see the scenes android_simplified and android_vertebral."""

    peak_force: float  # N
    speed_change_km_h: float
    impact: Literal["front", "rear"]
    mass: float  # kg
    belts: bool
    belt_stiffness: float  # times the sourced stiffness and damping
    law: Literal["progressive", "spring_damper"]
    seat: Literal["fixed", "driven"]
    pulse: Literal["half_sine", "table"]
    lift: float  # m

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
belt_stiffness; contact law; seat fixed with mass-proportional forces, or driven; lift (m) off the seat."""


def scene_builder(name: str, summary: str | None, description: str) -> Callable[..., Scene]:
    """Return the `build` of the scene with the android of mbs_ref/crash/data/<name>.json."""

    def build(
        *,
        peak_force: Annotated[float, Field(ge=500.0, le=100_000.0)] = 15_000.0,
        speed_change_km_h: Annotated[float, Field(gt=0.0, le=200.0)] = 50.0,
        impact: Literal["front", "rear"] = "front",
        mass: Annotated[float, Field(ge=50.0, le=100.0)] = 75.0,
        belts: bool = True,
        belt_stiffness: NonNegative = 1.0,
        law: Literal["progressive", "spring_damper"] = "progressive",
        seat: Literal["fixed", "driven"] = "fixed",
        pulse: Literal["half_sine", "table"] = "half_sine",
        lift: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0,
    ) -> Scene:
        crash = Crash(peak_force, speed_change_km_h, impact, mass, belts, belt_stiffness, law, seat, pulse, lift)
        return android(name, description, crash)

    build.__doc__ = f"{summary}\n\n{PARAMETERS}"
    return build


def android(name: str, description: str, crash: Crash) -> Scene:
    """Return the android of mbs_ref/crash/data/<name>.json in a crash."""
    data: dict[str, Any] = json.loads((files("mbs_ref.crash") / "data" / f"{name}.json").read_text(encoding="utf-8"))
    model = _Model(data, crash)
    return Scene(
        name=name,
        description=" ".join((description, *_consequences(crash))),
        source=PAPER.format(name),
        duration=DURATION,
        gravity=(0.0, -data["gravity"]),
        bodies=(*model.bodies(data["bodies"]), *model.bodies(data["seat_bodies"])),
        joints=(*model.revolutes(), *model.seat_joints()),
        loads=(*model.torsion_springs(), *model.bushings(), *model.belts(), *model.crash_forces()),
        contacts=(*model.seat_contacts(), *model.floor_contacts()),
    )


def _consequences(crash: Crash) -> list[str]:
    notes = []
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
        self.seats = {b["name"] for b in data["seat_bodies"]}
        self.body = {b["name"]: b for b in (*data["bodies"], *data["seat_bodies"])}
        self.scale = crash.mass / data["total_android_mass"]

    def bodies(self, entries: list[dict[str, Any]]) -> list[PlanarBody]:
        bodies = []
        for entry in entries:
            scale = 1.0 if entry["name"] in self.seats else self.scale
            place, angle = self._pose(entry["name"])
            bodies.append(
                PlanarBody(
                    name=entry["name"], mass=scale * entry["mass"], inertia=scale * entry["Izz"],
                    position=place, angle=angle,
                )
            )  # fmt: skip
        return bodies

    def _pose(self, body: str) -> tuple[Point, float]:
        x, y, angle = self.body[body]["q0"]
        return (x, y + (0.0 if body in self.seats else self.crash.lift)), angle

    def _world(self, body: str, local: tuple[float, float]) -> Point:
        (x, y), angle = self._pose(body)
        c, s = math.cos(angle), math.sin(angle)
        return x + c * local[0] - s * local[1], y + s * local[0] + c * local[1]

    def _point(self, body: str, point: str) -> Point:
        return self._world(body, self.body[body]["points"][point])

    def revolutes(self) -> list[Revolute]:
        return [
            Revolute(
                name=_pair(j), body_a=j["body_j"], body_b=j["body_i"], point=self._point(j["body_i"], j["point_i"])
            )
            for j in self.data["joints"]
        ]

    def seat_joints(self) -> list[Joint]:
        """Hold the seat in the vehicle frame, or drive it by x = -double integral of a (rheonomic)."""
        if self.crash.seat == "fixed":
            return [Weld(name=f"{s}.hold", body_a=GROUND, body_b=s, point=self._pose(s)[0]) for s in sorted(self.seats)]
        still, drives = Constant(value=0.0), []
        for seat in sorted(self.seats):
            drives += [
                CoordinateDrive(name=f"{seat}.x", body=seat, coordinate="x",
                                motion=_pulse(self.crash, -self.crash.peak_acceleration), level="acceleration"),
                CoordinateDrive(name=f"{seat}.y", body=seat, coordinate="y", motion=still),
                CoordinateDrive(name=f"{seat}.angle", body=seat, coordinate="angle", motion=still),
            ]  # fmt: skip
        return drives

    def torsion_springs(self) -> list[TorsionSpring]:
        """Restoring torques on theta_i - theta_j."""
        return [
            TorsionSpring(
                name=f"{_pair(j)}.restoring", body_a=j["body_j"], body_b=j["body_i"],
                stiffness=j["torsion_k"], damping=j["torsion_c"], rest_angle=j["theta0"],
            )
            for j in self.data["joints"]
        ]  # fmt: skip

    def bushings(self) -> list[PointBushing]:
        """Shoulder tissue and costal cartilage, free of force at t = 0."""
        return [
            PointBushing(
                name=b["name"], body_a=b["body_j"], body_b=b["body_i"], point=self._point(b["body_i"], b["point_i"]),
                stiffness=b["k"], damping=b["c"],
            )
            for b in self.data["bushings"]
        ]  # fmt: skip

    def belts(self) -> list[SpringDamper]:
        if not self.crash.belts:
            return []
        factor = self.crash.belt_stiffness
        return [
            SpringDamper(
                name=f"belt.{b['name']}", body_a=b["anchor_body"], body_b=b["body"],
                point_a=self._point(b["anchor_body"], b["anchor_point"]), point_b=self._point(b["body"], b["point"]),
                stiffness=factor * b["k"], damping=factor * b["c"], rest_length=b["rest_length"] + b["slack"],
                tension_only=True,
            )
            for b in self.data["belts"]
        ]  # fmt: skip

    def crash_forces(self) -> list[Load]:
        """m_i a(t) on every part of the android, in the frame of a fixed seat (d'Alembert)."""
        if self.crash.seat == "driven":
            return []
        signal = _pulse(self.crash, 1.0)
        return [
            Force(
                name=f"crash.{b['name']}", body=b["name"], point=self._pose(b["name"])[0],
                vector=(self.scale * b["mass"] * self.crash.peak_acceleration, 0.0), factor=signal,
            )
            for b in self.data["bodies"]
        ]  # fmt: skip

    def seat_contacts(self) -> list[Contact]:
        contacts: list[Contact] = []
        for c in self.data["contacts"]:
            seat = self.body[c["surface_body"]]
            reach, height = seat["half_length"], seat["surface_y"]
            ends = (self._world(seat["name"], (-reach, height)), self._world(seat["name"], (reach, height)))
            contacts.append(self._contact(c, seat["name"], *ends))
        return contacts

    def floor_contacts(self) -> list[Contact]:
        return [self._contact(c, GROUND, (0.0, 0.0), (1.0, 0.0)) for c in self.data["floor"]]

    def _contact(self, entry: dict[str, Any], surface: str, first: Point, second: Point) -> CircleOnLine:
        where = "floor" if surface == GROUND else surface
        return CircleOnLine(
            name=f"{entry['body']}.{entry['point']}.{where}", body_a=entry["body"],
            center=self._point(entry["body"], entry["point"]), radius=entry["radius"], body_b=surface,
            point_1=first, point_2=second, law=_law(entry, self.crash.law),
        )  # fmt: skip


def _pair(joint: dict[str, Any]) -> str:
    return f"{joint['body_i']}-{joint['body_j']}"


def _law(entry: dict[str, Any], law: str) -> ContactLaw:
    if law == "progressive":
        return ProgressiveLaw(stiffness=entry["k"], damping=entry["c_progressive"])
    return SpringDamperLaw(stiffness=entry["k"], damping=entry["c_kv"], release="force")


def _pulse(crash: Crash, peak: float) -> Signal:
    """The pulse with the given peak; the table keeps the impulse of the half sine."""
    duration = crash.pulse_duration
    if crash.pulse == "half_sine":
        return HalfSine(peak=peak, duration=duration)
    n = TABLE_POINTS - 1
    sines = [0.0 if k in (0, n) else math.sin(math.pi * k / n) for k in range(TABLE_POINTS)]
    kept = 2.0 / math.pi * n / sum(sines)
    times = tuple(duration * k / n for k in range(TABLE_POINTS))
    return Table(times=times, values=tuple(kept * peak * s for s in sines))
