"""A world with units as a scene of mbs_ref."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np

from mbs_ref.scene import Scene
from tests.mbs_ref.hidden_events.world import GROUND, Body, Contact, Length, Level, Mark, Watch, World

WEAK = 1e-20  # stiffness, times the unit of mass over the unit of time squared: its force is below roundoff


@dataclass(frozen=True)
class Units:
    """What the world's 1 is."""

    length: float  # m
    time: float  # s
    mass: float  # kg


class _Writer:
    def __init__(self, world: World, units: Units) -> None:
        self.world, self.units = world, units
        self.speed = units.length / units.time

    def vector(self, value: np.ndarray, unit: float = 1.0) -> tuple[float, ...]:
        return tuple((unit * value[: self.world.dimension]).tolist())

    def point(self, mark: Mark) -> tuple[float, ...]:
        places = {body.name: body.place for body in self.world.bodies}
        return self.vector(places.get(mark.body, np.zeros(3)) + mark.arm, self.units.length)

    def body(self, body: Body) -> dict[str, Any]:
        units = self.units
        data: dict[str, Any] = {
            "name": body.name, "mass": body.mass * units.mass,
            "position": self.vector(body.place + body.offset, units.length),
            "velocity": self.vector(body.velocity + np.cross(body.spin, body.offset), self.speed),
        }  # fmt: skip
        if body.kind == "point":
            return data | {"type": "point_mass"}
        inertia = body.inertia * units.mass * units.length**2
        spin = body.spin / units.time
        if body.kind == "driven":
            data["velocity"] = (data["velocity"][0], *(0.0,) * (self.world.dimension - 1))
            spin = 0.0 * spin
        if self.world.dimension == 2:
            return data | {"type": "planar", "inertia": inertia, "angular_velocity": float(spin[2])}
        return data | {"type": "spatial", "inertia": (*(inertia,) * 3, 0.0, 0.0, 0.0), "angular_velocity": tuple(spin)}

    def joint(self, body: Body) -> dict[str, Any]:
        name = f"{body.name}_joint"
        if body.kind == "driven":
            phase = float(np.arctan2(body.offset[0], -body.offset[1]))
            motion = {
                "type": "harmonic", "amplitude": float(np.hypot(*body.offset[:2])) * self.units.length,
                "omega": float(body.spin[2]) / self.units.time, "phase": phase,
            }  # fmt: skip
            return {"type": "coordinate_drive", "name": name, "body": body.name, "coordinate": "x", "motion": motion}
        axis = {} if self.world.dimension == 2 else {"axis": tuple(body.axis)}
        point = self.vector(body.place, self.units.length)
        return {"type": "revolute", "name": name, "body_a": body.name, "body_b": GROUND, "point": point} | axis

    def ends(self, watch: Contact | Length, name: str) -> dict[str, Any]:
        return {
            "name": watch.name, "body_a": watch.a.body, "body_b": watch.b.body,
            f"{name}_a": self.point(watch.a), f"{name}_b": self.point(watch.b),
        }  # fmt: skip

    def stiffness(self, watch: Contact | Length) -> float:
        """Return m (pi / hold)^2 of a stiff spring, N/m."""
        masses = {body.name: body.mass for body in self.world.bodies}
        stiffness = masses[watch.a.body] * (np.pi / watch.hold) ** 2 if watch.hold else WEAK
        return stiffness * self.units.mass / self.units.time**2

    def contact(self, contact: Contact) -> dict[str, Any]:
        length = self.units.length
        law: dict[str, Any] = {"type": "rigid_law", "restitution": contact.restitution}
        if contact.restitution is None:
            law = {"type": contact.law, "stiffness": self.stiffness(contact)}
        data = self.ends(contact, "center") | {"law": law}
        flat = self.world.dimension == 2
        if contact.normal is None:
            radii = {"radius_a": contact.radius_a * length, "radius_b": contact.radius_b * length}
            return data | radii | {"type": "circle_on_circle" if flat else "sphere_on_sphere"}
        data |= {"radius": contact.radius_a * length, "center": data.pop("center_a")}
        middle = np.array(data.pop("center_b"))
        if contact.thickness is not None:
            data["thickness"] = contact.thickness * length
        if flat:
            reach = (contact.half or 1.0) * length
            along = reach * np.array([contact.normal[1], -contact.normal[0]])  # the free side is on the left
            data |= {"point_1": tuple(middle - along), "point_2": tuple(middle + along)}
            return data | {"type": "circle_on_line", "extent": "segment" if contact.edges else "line"}
        data |= {"type": "sphere_on_plane", "point": tuple(middle), "normal": tuple(contact.normal)}
        if contact.edges:
            data |= {"extent": "rectangle", "edge": tuple(contact.edges[0]), "size": (2.0 * contact.half * length,) * 2}
        return data

    def string(self, watch: Length) -> dict[str, Any]:
        return self.ends(watch, "point") | {
            "type": "spring_damper", "stiffness": self.stiffness(watch),
            "rest_length": watch.value * self.units.length, "tension_only": True,
        }  # fmt: skip

    def event(self, watch: Length | Level) -> dict[str, Any]:
        if isinstance(watch, Length):
            value = watch.value * self.units.length
            data = self.ends(watch, "point") | {"type": "distance_event"}
            return data | {"value": value, "crossing": watch.crossing}
        unit = (1.0 if watch.coordinate == 3 else self.units.length) / (self.units.time if watch.rate else 1.0)
        return {
            "type": "coordinate_event", "name": watch.name, "body": watch.body, "rate": watch.rate,
            "coordinate": ("x", "y", "z", "angle")[watch.coordinate], "value": watch.value * unit,
            "crossing": watch.crossing,
        }  # fmt: skip


def write_scene(name: str, world: World, units: Units) -> Scene:
    """Return the scene, in SI units."""
    writer = _Writer(world, units)

    def declared(watch: Watch) -> TypeGuard[Length | Level]:
        return isinstance(watch, Level) or (isinstance(watch, Length) and watch.declared)

    return Scene.model_validate({
        "name": name, "duration": world.horizon * units.time,
        "gravity": writer.vector(world.gravity, units.length / units.time**2),
        "bodies": [writer.body(body) for body in world.bodies],
        "joints": [writer.joint(body) for body in world.bodies if body.kind in ("hinged", "driven")],
        "contacts": [writer.contact(watch) for watch in world.watches if isinstance(watch, Contact)],
        "loads": [writer.string(watch) for watch in world.watches if isinstance(watch, Length) and not watch.declared],
        "events": [writer.event(watch) for watch in world.watches if declared(watch)],
    })  # fmt: skip
