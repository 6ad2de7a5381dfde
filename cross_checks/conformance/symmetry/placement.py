"""A scene seen from elsewhere: turned, mirrored and shifted space, other units, other order and names.

Or from another time: it starts where a motion of another has ended, or goes back from there.
"""

import math
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np
from pydantic import BaseModel

from mbs_ref import Scene, Trajectory
from mbs_ref.files import package_data
from mbs_ref.scene.euler_parameters import from_matrix, rotation_matrices
from mbs_ref.simulate.equilibrium import restated

TABLES = package_data(__name__, "placement.toml")
KINDS = {field: kind for kind, fields in TABLES["kinds"].items() for field in fields}
POWERS = {field: (0, 1, 0) for field in TABLES["kinds"]["point"]} | TABLES["powers"]  # of kg, m and s


@dataclass(frozen=True)
class Placement:
    """x -> length (Q x + shift), t -> time t, with bodies in another order under other names."""

    matrix: np.ndarray  # (d, d) Q, orthogonal
    shift: np.ndarray  # (d,) m
    mass: float = 1.0  # what one kilogram becomes
    length: float = 1.0  # what one metre becomes
    time: float = 1.0  # what one second becomes
    order: tuple[int, ...] = ()  # of the new scene's bodies among the old; all in order unless given
    names: dict[str, str] = field(default_factory=dict)

    @property
    def sense(self) -> float:
        """1 for turned space, -1 for a mirror image."""
        return round(float(np.linalg.det(self.matrix)))

    @property
    def angle(self) -> float:
        """The image of the x axis, rad (plane)."""
        return math.atan2(self.matrix[1, 0], self.matrix[0, 0])

    def unit(self, powers: tuple[float, float, float]) -> float:
        """Return what one unit of these powers of kg, m, s becomes."""
        return self.mass ** powers[0] * self.length ** powers[1] * self.time ** powers[2]

    def points(self, x: np.ndarray) -> np.ndarray:
        """Return where points (..., d) go."""
        return self.length * (x @ self.matrix.T + self.shift)


def kind(part: str, field: str) -> str:
    """Return "point", "polar", "axial", "angle", "sense" or "scalar"."""
    return KINDS.get(f"{part}.{field}") or KINDS.get(field, "scalar")


def dimension(part: Any, field: str) -> tuple[float, float, float]:
    """Return the powers of kg, m and s of a field of a part; zeros where it is a number."""
    if part.type in TABLES["parts"]["power_laws"] and field in ("stiffness", "damping"):
        return (1, 1 - part.exponent, -2) if field == "stiffness" else (1, -part.exponent, -1)
    if field in ("cohesive", "frictional"):  # Bekker's moduli, N/m^(n + 1) and N/m^(n + 2)
        return (1, -part.exponent - (field == "frictional"), -2)
    return POWERS.get(f"{part.type}.{field}") or POWERS.get(field, (0, 0, 0))


def obstacle(scene: Scene, placement: Placement) -> str:
    """Return why the scene has no such image, or nothing."""
    singled_out = sorted({load.type for load in _parts(scene)} & {*TABLES["parts"]["not_free"]})
    if singled_out:
        return f"{', '.join(singled_out)}: singles out a place, a direction or a date"
    poles = [load for load in scene.loads if getattr(load, "pole", "fixed") != "fixed"]
    if poles:
        return "the Earth's pole singles out a direction"
    varies = any(getattr(x, name, None) not in (None,) and getattr(x, name).type != "constant"
                 for x in _parts(scene) for name in ("factor", "motion"))  # fmt: skip
    scaled = (placement.mass, placement.length, placement.time) != (1.0, 1.0, 1.0)
    if scaled and (varies or any(load.type == "bushing" for load in scene.loads)):
        return "signals and bushings are not rescaled"
    return ""


def _parts(scene: Scene) -> list[Any]:
    return [*scene.bodies, *scene.joints, *scene.loads, *scene.contacts, *scene.events]


def image(scene: Scene, placement: Placement) -> Scene:
    """Return the scene as it is seen from there; it has no name that promises a truth."""
    order = placement.order or tuple(range(len(scene.bodies)))
    bodies = tuple(_part(scene.bodies[k], placement) for k in order)
    groups = {group: tuple(_part(x, placement) for x in getattr(scene, group)) for group in ("joints", "contacts")}
    loads = tuple(_reordered(_part(x, placement), order) for x in scene.loads)
    gravity = placement.unit((0, 1, -2)) * (placement.matrix @ np.array(scene.gravity))
    return scene.model_copy(
        update={"name": "image", "parameters": {}, "duration": scene.duration * placement.time, "bodies": bodies,
                "gravity": tuple(gravity.tolist()), "loads": loads, "events": (), **groups},
    )  # fmt: skip


def _part(part: Any, placement: Placement) -> Any:
    """Return a part with every field turned, scaled and renamed, validated anew."""
    changed: dict[str, Any] = {}
    for name in type(part).model_fields:
        value = getattr(part, name)
        if isinstance(value, BaseModel):
            changed[name] = _part(value, placement) if name in ("law", "friction") else value
        elif name in ("name", "body", "body_a", "body_b", "raiser", "planet"):
            changed[name] = placement.names.get(value, value)
        elif value is None or isinstance(value, str | bool) or name == "type":
            changed[name] = value
        elif name == "orientation":
            turned = from_matrix(placement.sense * placement.matrix @ rotation_matrices(np.array(value)))
            changed[name] = tuple((turned / np.linalg.norm(turned)).tolist())
        else:
            changed[name] = _value(part, name, value, placement)
    if part.type == "circle_on_line" and placement.sense < 0:  # the free side is on the left, walking from 1 to 2
        changed["point_1"], changed["point_2"] = changed["point_2"], changed["point_1"]
    return type(part)(**changed)


def _value(part: Any, name: str, value: Any, placement: Placement) -> Any:
    what, unit = kind(part.type, name), placement.unit(dimension(part, name))
    number: Any = value  # in the plane a sense of rotation is a number
    vector = isinstance(value, tuple) and len(value) == len(placement.shift)
    if what == "point":
        return tuple(placement.points(np.array(value)).tolist())
    if what in ("polar", "axial") and vector:
        sign = placement.sense if what == "axial" else 1.0
        if getattr(part, "frame", "world") == "body":
            return _in_body_axes(np.array(value) * unit, what, placement)
        return tuple((sign * unit * (placement.matrix @ np.array(value))).tolist())
    if what == "angle":
        return placement.angle + placement.sense * number
    if what == "sense" or what == "axial":  # in the plane
        return placement.sense * unit * number
    if unit == 1.0 or name in ("exponent", "teeth", "flank_angle", "jd_tdb", "zonal", "level"):
        return value
    return tuple(unit * x for x in value) if isinstance(value, tuple) else value * unit


def _in_body_axes(value: np.ndarray, what: str, placement: Placement) -> tuple[float, ...]:
    """A mirrored body keeps its inertia about axes that are inverted (space) or reflected at its x axis (plane)."""
    if placement.sense > 0 or what == "axial":
        return tuple(value.tolist())
    return tuple((-value if len(value) == 3 else value * [1.0, -1.0]).tolist())


def _reordered(load: Any, order: tuple[int, ...]) -> Any:
    """Numbers that a load gives for each body follow the bodies."""
    fields = [name for name in ("gm", "radius") if load.type == "newton" and getattr(load, name)]
    return load.model_copy(update={name: tuple(getattr(load, name)[k] for k in order) for name in fields})


def moved(trajectory: Trajectory, placement: Placement) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n_t, n_bodies, d) and orientations of a motion as seen from there."""
    order = list(placement.order or range(trajectory.position.shape[1]))
    place = placement.points(trajectory.position[:, order])
    turn = trajectory.orientation[:, order]
    if turn.ndim == 2:
        return place, placement.angle + placement.sense * turn
    axes = placement.sense * placement.matrix @ rotation_matrices(turn)
    return place, np.array([[from_matrix(axis) for axis in row] for row in axes])


def cut_obstacle(scene: Scene, *, back: bool) -> str:
    """Return why a run of the scene cannot be cut (or turned back), or nothing."""
    carried, forgetful = TABLES["parts"]["carried"], TABLES["parts"]["forgetful"]
    strange = sorted({p.type for p in chain(scene.bodies, scene.joints, scene.loads, scene.contacts)} - {*carried})
    if strange:
        return f"{', '.join(strange)} are not carried over a cut"
    if any(getattr(load, "pole", "fixed") != "fixed" or getattr(load, "tension_only", False) for load in scene.loads):
        return "dates, and ropes that may be slack, are not carried over a cut"
    if any(load.type == "force" and load.factor.type != "constant" for load in scene.loads):
        return "signals are not carried over a cut"
    if any(c.law.type not in forgetful or getattr(c.friction, "type", "") == "stick_slip" for c in scene.contacts):
        return "a contact that remembers its impact or its grip is not carried over a cut"
    return _loss(scene) if back else ""


def _loss(scene: Scene) -> str:
    lossy = [load.name for load in scene.loads if getattr(load, "damping", 0.0) or load.type == "force"]
    for contact in scene.contacts:
        elastic = getattr(contact.law, "restitution", 1.0) == 1.0 and not getattr(contact.law, "damping", 0.0)
        if contact.friction is not None or not elastic:
            lossy.append(contact.name)
    return f"{', '.join(lossy)} may take energy" if lossy else ""


def continued(scene: Scene, run: Trajectory, *, back: bool) -> Scene:
    """Return the scene that starts at the run's end; with all velocities reversed if it goes `back`."""
    cut = restated(scene, run, -1.0 if back else 1.0)
    return cut.model_copy(update={"name": "cut", "parameters": {}, "events": ()})
