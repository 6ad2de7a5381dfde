"""A small scene for every kind of joint, drive and load, so that an engine is asked for whatever it declares.

Two bodies in generic places, about generic axes: the joint that is asked for holds both; a load or a drive that is
asked for acts on bodies that hinges hold. The truth shares no equation with any engine, ours among them: the dense
oracle, which reads forces and constraints from the shared judge alone, is integrated by SciPy's DOP853.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cross_checks.conformance.bounces import bounce_truth, bounces
from cross_checks.truths.oracle.dense_oracle import Moment, augmented, consistent
from cross_checks.truths.truth import Truth
from mbs_ref import scene as parts
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.euler_parameters import product
from mbs_ref.scene.signals import Harmonic

DURATION = 0.2  # s
TOLERANCES = (1e-10, 1e-11)  # of the runs whose difference is what the truth is known to

type Place = Any  # three coordinates; in the plane the first two of these
HUNG: Place = (0.1, 0.2, -0.1)  # m, on ground
LINKED: Place = (0.5, -0.1, 0.3)  # m, between the bodies
HELD: Place = (-0.2, 0.6, 0.4)  # m, on ground, aside
FIRST: Place = (0.3, 0.1, 0.1)  # m, a body's centre
SECOND: Place = (0.9, -0.3, 0.2)  # m, the other's
AXES: tuple[Place, Place] = ((1.0, 2.0, 2.0), (2.0, -2.0, 1.0))  # perpendicular
ALONG: Place = (1.0, 0.0, -1.0)  # of a driven point; along its hinge's axis AXES[0] it could not move
GRAVITY: Place = (1.0, -9.0, 3.0)  # m/s^2
NEAR: Place = (0.05, -0.1, 0.07)  # m, from a centre to where loads and rods take hold


PLACES = (HUNG, LINKED)
SWAY = Harmonic(amplitude=0.05, omega=6.0, phase=0.5)  # m, rad
ENDS: tuple[dict[str, Any], ...] = (
    {"name": "one", "body_a": GROUND, "body_b": "a"}, {"name": "two", "body_a": "a", "body_b": "b"},
)  # fmt: skip


@cache
def probes() -> dict[tuple[str, int], Scene]:
    """Return the scenes, by the part's type and the dimension."""
    scenes = (*_in_dimension(2), *_in_dimension(3), *bounces())
    return {(kind, scene.dimension): scene for kind, scene in scenes}


def _in_dimension(d: int) -> Iterator[tuple[str, Scene]]:
    """Yield two of each joint, each drive and load on bodies that two hinges hold, and particles, welds, bushings."""
    bodies, joints = (_body("a", FIRST, d), _body("b", SECOND, d)), _joints(d)
    hinges = joints["revolute"]
    for kind, pair in joints.items():
        yield kind, _scene(kind, bodies, pair)
    for kind, drive in _drives(d).items():
        yield kind, _scene(kind, bodies, (*hinges, drive))
    for kind, load in _loads(d).items():
        yield kind, _scene(kind, bodies, hinges, (load,))
    bob = parts.PointMass(name="b", mass=0.5, position=SECOND[:d], velocity=(0.3, 0.2, 0.1)[:d])
    rod = parts.Distance(**ENDS[1], point_a=_mark(FIRST)[:d], point_b=SECOND[:d])
    yield "point_mass", _scene("point_mass", (bodies[0], bob), (hinges[0], rod))
    yield "weld", _scene("weld", bodies, (hinges[0], parts.Weld(**ENDS[1], point=LINKED[:d])))
    if d == 2:
        soft = parts.PointBushing(
            name="load", body_a="a", body_b="b", point=LINKED[:2], stiffness=60.0, damping=1.0
        )  # fmt: skip
        yield "point_bushing", _scene("point_bushing", bodies, hinges[:1], (soft,))
    else:
        soft = parts.Bushing(
            name="load", body_a=GROUND, body_b="a", point=HUNG, stiffness=(40.0, 50.0, 60.0, 2.0, 3.0, 4.0),
            damping=(1.0, 0.8, 0.6, 0.1, 0.05, 0.08),
        )  # fmt: skip
        yield "bushing", _scene("bushing", bodies[:1], (), (soft,))


def _mark(centre: Place) -> Place:
    return tuple(np.add(centre, NEAR).tolist())


def _body(name: str, place: Place, d: int) -> Any:
    if d == 2:
        return parts.PlanarBody(name=name, mass=1.5, inertia=0.05, position=place[:2], angular_velocity=2.0)
    inertia = (0.06, 0.05, 0.04, 0.01, -0.005, 0.008)  # kg m^2
    return parts.SpatialBody(name=name, mass=1.5, inertia=inertia, position=place, angular_velocity=(0.5, -1.0, 2.0))


def _joints(d: int) -> dict[str, tuple[Any, ...]]:
    """Return two of each joint: of ground and the first body, and of both bodies."""

    def two(kind: type, **fields: tuple[Any, Any]) -> tuple[Any, ...]:
        return tuple(kind(**ENDS[k], **{name: pair[k][:d] for name, pair in fields.items()}) for k in (0, 1))

    joints = {
        "revolute": two(parts.Revolute, point=PLACES, **({"axis": AXES} if d == 3 else {})),
        "prismatic": two(parts.Prismatic, point=PLACES, axis=AXES),
        "distance": two(parts.Distance, point_a=(HELD, _mark(FIRST)), point_b=(_mark(FIRST), _mark(SECOND))),
    }
    if d == 2:
        return joints
    return joints | {
        "cylindrical": two(parts.Cylindrical, point=PLACES, axis=AXES),
        "spherical": two(parts.Spherical, point=PLACES),
        "universal": two(parts.Universal, point=PLACES, axis_a=AXES, axis_b=AXES[::-1]),
        "point_on_plane": two(parts.PointOnPlane, point=PLACES, normal=AXES),
    }


def _drives(d: int) -> dict[str, Any]:
    coordinate: Any = "angle" if d == 2 else "z"
    drives: dict[str, Any] = {
        "coordinate_drive": parts.CoordinateDrive(name="drive", body="b", coordinate=coordinate, motion=SWAY),
        "point_drive": parts.PointDrive(
            name="drive", body="a", point=_mark(FIRST)[:d], direction=ALONG[:d], motion=SWAY
        ),
    }  # fmt: skip
    turned = parts.RotationDrive(name="drive", body_a="a", body_b="b", axis=AXES[1], motion=SWAY)
    return drives | ({"rotation_drive": turned} if d == 3 else {})


def _loads(d: int) -> dict[str, Any]:
    spring = parts.SpringDamper(
        name="load", body_a=GROUND, body_b="b", point_a=HELD[:d], point_b=_mark(SECOND)[:d], stiffness=40.0,
        damping=1.0, rest_length=0.5,
    )  # fmt: skip
    torsion = parts.TorsionSpring(
        name="load", body_a="a", body_b="b", stiffness=3.0, damping=0.1, rest_angle=0.2,
        axis=AXES[1] if d == 3 else None,
    )  # fmt: skip
    force = parts.Force(name="load", body="b", point=_mark(SECOND)[:d], vector=(3.0, 2.0, -4.0)[:d], frame="body")
    loads = {"force": force, "spring_damper": spring, "torsion_spring": torsion}
    if d == 2:
        return loads | {"torque": parts.Torque(name="load", body="b", torque=0.4)}
    twist = parts.TorqueVector(name="load", body="b", vector=(0.3, -0.2, 0.4), frame="body")
    return loads | {"torque_vector": twist}


def _scene(kind: str, bodies: tuple[Any, ...], joints: tuple[Any, ...], loads: tuple[Any, ...] = ()) -> Scene:
    gravity = GRAVITY[: len(bodies[0].position)]
    return consistent(Scene(name=kind, gravity=gravity, bodies=bodies, joints=joints, loads=loads, duration=DURATION))


# --- the truth ------------------------------------------------------------------------------------


def probe_truth(scene: Scene, times: np.ndarray) -> Truth:
    """Return the truth of a probe at the times (s)."""
    if scene.contacts:
        return bounce_truth(scene, times)
    rough, fine = (_motion(scene, times, rtol) for rtol in TOLERANCES)
    apart = float(np.nanmax(farthest(scene, Partial(*rough), Partial(*fine))))
    how = f"the dense oracle at {TOLERANCES[1]:g}, from which {TOLERANCES[0]:g} differs by {apart:.1e}"
    position, orientation, _ = fine
    return Truth(position, orientation, apart, "converged", how)


def _motion(scene: Scene, times: np.ndarray, rtol: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions, orientations and rates at the times."""
    start = Moment.start(scene)
    shapes = [start.position.shape, start.orientation.shape, start.rate.shape]
    cuts = np.cumsum([int(np.prod(shape)) for shape in shapes])[:2]

    def parts(y: np.ndarray) -> list[np.ndarray]:
        return [part.reshape(shape) for part, shape in zip(np.split(y, cuts), shapes, strict=True)]

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        position, orientation, rate = parts(y)
        here = replace(start, time=t, position=position, orientation=orientation, rate=rate)
        straight, turning = rate[:, : scene.dimension], rate[:, scene.dimension :]
        turned = turning[:, 0] if scene.dimension == 2 else _turning(orientation, turning)
        return np.concatenate([straight.ravel(), turned.ravel(), augmented(here).solve().acceleration.ravel()])

    y = np.concatenate([part.ravel() for part in (start.position, start.orientation, start.rate)])
    solved = solve_ivp(slope, (0.0, times[-1]), y, "DOP853", times, rtol=rtol, atol=1e-2 * rtol)
    states = [parts(column) for column in solved.y.T]
    position, orientation, rate = (np.array(part) for part in zip(*states, strict=True))
    return position, orientation, rate


def _turning(theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return theta' (n, 4) of Euler parameters at angular velocities (n, 3) about world axes."""
    return 0.5 * product(np.concatenate((np.zeros((len(omega), 1)), omega), axis=1), theta)
