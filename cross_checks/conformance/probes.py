"""A small scene for every kind of joint, drive and load, so that an engine is asked for whatever it declares.

Two bodies in generic places, about generic axes: the joint that is asked for holds both; a load or a drive that is
asked for acts on bodies that hinges hold. The truth shares no equation with any engine, ours among them: the dense
oracle, which reads forces and constraints from the shared judge alone, is integrated by SciPy's DOP853.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cross_checks.mechanisms.dense_oracle import Moment, augmented, consistent
from cross_checks.truths.truth import Truth
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import (
    GROUND,
    Bushing,
    CoordinateDrive,
    Cylindrical,
    Distance,
    Force,
    PlanarBody,
    PointBushing,
    PointDrive,
    PointMass,
    PointOnPlane,
    Prismatic,
    Revolute,
    RotationDrive,
    Scene,
    SpatialBody,
    Spherical,
    SpringDamper,
    Torque,
    TorqueVector,
    TorsionSpring,
    Universal,
    Weld,
)
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
GRAVITY: Place = (1.0, -9.0, 3.0)  # m/s^2
NEAR: Place = (0.05, -0.1, 0.07)  # m, from a centre to where loads and rods take hold


def _mark(centre: Place) -> Place:
    return tuple(np.add(centre, NEAR).tolist())


def _spatial(name: str, place: Place) -> SpatialBody:
    inertia = (0.06, 0.05, 0.04, 0.01, -0.005, 0.008)  # kg m^2
    return SpatialBody(name=name, mass=1.5, inertia=inertia, position=place, angular_velocity=(0.5, -1.0, 2.0))


def _planar(name: str, place: Place) -> PlanarBody:
    return PlanarBody(name=name, mass=1.5, inertia=0.05, position=place[:2], angular_velocity=2.0)


ENDS: tuple[dict[str, Any], ...] = (
    {"name": "one", "body_a": GROUND, "body_b": "a"}, {"name": "two", "body_a": "a", "body_b": "b"},
)  # fmt: skip
PLACES = (HUNG, LINKED)
SPACE_JOINTS: dict[str, Callable[[int, dict[str, Any]], Any]] = {
    "revolute": lambda k, ends: Revolute(**ends, point=PLACES[k], axis=AXES[k]),
    "prismatic": lambda k, ends: Prismatic(**ends, point=PLACES[k], axis=AXES[k]),
    "cylindrical": lambda k, ends: Cylindrical(**ends, point=PLACES[k], axis=AXES[k]),
    "spherical": lambda k, ends: Spherical(**ends, point=PLACES[k]),
    "universal": lambda k, ends: Universal(**ends, point=PLACES[k], axis_a=AXES[k], axis_b=AXES[1 - k]),
    "distance": lambda k, ends: Distance(
        **ends, point_a=(HELD, _mark(FIRST))[k], point_b=_mark((FIRST, SECOND)[k])
    ),
    "point_on_plane": lambda k, ends: PointOnPlane(**ends, point=PLACES[k], normal=AXES[k]),
}  # fmt: skip
PLANE_JOINTS: dict[str, Callable[[int, dict[str, Any]], Any]] = {
    "revolute": lambda k, ends: Revolute(**ends, point=PLACES[k][:2]),
    "prismatic": lambda k, ends: Prismatic(**ends, point=PLACES[k][:2], axis=AXES[k][:2]),
    "distance": lambda k, ends: Distance(
        **ends, point_a=(HELD, _mark(FIRST))[k][:2], point_b=_mark((FIRST, SECOND)[k])[:2]
    ),
}  # fmt: skip
SPACE_LOADS: dict[str, Any] = {
    "force": Force(name="load", body="b", point=_mark(SECOND), vector=(3.0, 2.0, -4.0), frame="body"),
    "torque_vector": TorqueVector(name="load", body="b", vector=(0.3, -0.2, 0.4), frame="body"),
    "spring_damper": SpringDamper(
        name="load", body_a=GROUND, body_b="b", point_a=HELD, point_b=_mark(SECOND), stiffness=40.0, damping=1.0,
        rest_length=0.5,
    ),
    "torsion_spring": TorsionSpring(
        name="load", body_a="a", body_b="b", stiffness=3.0, damping=0.1, rest_angle=0.2, axis=AXES[1]
    ),
}  # fmt: skip
PLANE_LOADS: dict[str, Any] = {
    "force": Force(name="load", body="b", point=_mark(SECOND)[:2], vector=(3.0, 2.0), frame="body"),
    "torque": Torque(name="load", body="b", torque=0.4),
    "spring_damper": SpringDamper(
        name="load", body_a=GROUND, body_b="b", point_a=HELD[:2], point_b=_mark(SECOND)[:2], stiffness=40.0,
        damping=1.0, rest_length=0.5,
    ),
    "torsion_spring": TorsionSpring(
        name="load", body_a="a", body_b="b", stiffness=3.0, damping=0.1, rest_angle=0.2
    ),
}  # fmt: skip
POINT_BUSHING = PointBushing(
    name="load", body_a="a", body_b="b", point=LINKED[:2], stiffness=60.0, damping=1.0
)  # fmt: skip
BUSHING = Bushing(
    name="load", body_a=GROUND, body_b="a", point=HUNG, stiffness=(40.0, 50.0, 60.0, 2.0, 3.0, 4.0),
    damping=(1.0, 0.8, 0.6, 0.1, 0.05, 0.08),
)  # fmt: skip
SWAY = Harmonic(amplitude=0.05, omega=6.0, phase=0.5)  # m, rad
SPACE_DRIVES: dict[str, Any] = {
    "coordinate_drive": CoordinateDrive(name="drive", body="b", coordinate="z", motion=SWAY),
    "point_drive": PointDrive(name="drive", body="a", point=_mark(FIRST), direction=(1.0, 0.0, -1.0), motion=SWAY),
    "rotation_drive": RotationDrive(name="drive", body_a="a", body_b="b", axis=AXES[1], motion=SWAY),
}
PLANE_DRIVES: dict[str, Any] = {
    "coordinate_drive": CoordinateDrive(name="drive", body="b", coordinate="angle", motion=SWAY),
    "point_drive": PointDrive(name="drive", body="a", point=_mark(FIRST)[:2], direction=AXES[0][:2], motion=SWAY),
}


@cache
def probes() -> dict[tuple[str, int], Scene]:
    """Return the scenes, by the part's type and the dimension."""
    return {(kind, scene.dimension): scene for kind, scene in (*_in_plane(), *_in_space())}


def _in_plane() -> Iterator[tuple[str, Scene]]:
    bodies, hinge = (_planar("a", FIRST), _planar("b", SECOND)), PLANE_JOINTS["revolute"](0, ENDS[0])
    bob = PointMass(name="b", mass=0.5, position=SECOND[:2], velocity=(0.3, 0.2))
    rod = Distance(**ENDS[1], point_a=_mark(FIRST)[:2], point_b=SECOND[:2])
    yield "point_mass", _scene("point_mass", (bodies[0], bob), (hinge, rod))
    yield "weld", _scene("weld", bodies, (hinge, Weld(**ENDS[1], point=LINKED[:2])))
    yield "point_bushing", _scene("point_bushing", bodies, (hinge,), (POINT_BUSHING,))
    yield from _of_rigid(bodies, PLANE_JOINTS, PLANE_DRIVES, PLANE_LOADS)


def _in_space() -> Iterator[tuple[str, Scene]]:
    bodies, hinge = (_spatial("a", FIRST), _spatial("b", SECOND)), SPACE_JOINTS["revolute"](0, ENDS[0])
    bob = PointMass(name="b", mass=0.5, position=SECOND, velocity=(0.3, 0.2, 0.1))
    rod = Distance(**ENDS[1], point_a=_mark(FIRST), point_b=SECOND)
    yield "point_mass", _scene("point_mass", (bodies[0], bob), (hinge, rod))
    yield "weld", _scene("weld", bodies, (hinge, Weld(**ENDS[1], point=LINKED)))
    yield "bushing", _scene("bushing", bodies[:1], (), (BUSHING,))
    yield from _of_rigid(bodies, SPACE_JOINTS, SPACE_DRIVES, SPACE_LOADS)


def _of_rigid(
    bodies: tuple[Any, ...], joints: dict[str, Callable], drives: dict[str, Any], loads: dict[str, Any]
) -> Iterator[tuple[str, Scene]]:
    """Yield two of each joint, and each drive and load on bodies that two hinges hold."""
    pairs = {kind: tuple(joint(k, ENDS[k]) for k in (0, 1)) for kind, joint in joints.items()}
    hinges = pairs["revolute"]
    for kind, pair in pairs.items():
        yield kind, _scene(kind, bodies, pair)
    for kind, drive in drives.items():
        yield kind, _scene(kind, bodies, (*hinges, drive))
    for kind, load in loads.items():
        yield kind, _scene(kind, bodies, hinges, (load,))


def _scene(kind: str, bodies: tuple[Any, ...], joints: tuple[Any, ...], loads: tuple[Any, ...] = ()) -> Scene:
    dimension = len(bodies[0].position)
    where = "plane" if dimension == 2 else "space"
    rough = Scene(
        name=f"{kind}_in_{where}", gravity=GRAVITY[:dimension], bodies=bodies, joints=joints, loads=loads,
        duration=DURATION,
    )  # fmt: skip
    return consistent(rough)


# --- the truth ------------------------------------------------------------------------------------


def probe_truth(scene: Scene, times: np.ndarray) -> Truth:
    """Return the truth of a probe at the times (s)."""
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
    found = solve_ivp(slope, (0.0, times[-1]), y, "DOP853", times, rtol=rtol, atol=1e-2 * rtol)
    states = [parts(column) for column in found.y.T]
    position, orientation, rate = (np.array(part) for part in zip(*states, strict=True))
    return position, orientation, rate


def _turning(theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return theta' (n, 4) of Euler parameters at angular velocities (n, 3) about world axes."""
    return 0.5 * product(np.concatenate((np.zeros((len(omega), 1)), omega), axis=1), theta)
