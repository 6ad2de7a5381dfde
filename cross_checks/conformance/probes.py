"""A small scene for every kind of joint, drive and load, so that an engine is tested on whatever it declares.

Two bodies in generic places, about generic axes: the joint under test holds both; a load or a drive under test
acts on bodies that hinges hold. The truth shares no equation with any engine, ours among them: the dense
oracle, which reads forces and constraints from the shared judge alone, is integrated by SciPy's DOP853.

Every contact law and pair of shapes has a ball that falls, with one equation as its truth: m g' = -m g + F along the
line of centres, where the gap g closes and F follows from the law's formula. DOP853 integrates it between touch-down
and lift-off, which are events; flights are parabolas.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cross_checks.truths.oracle import Moment, augmented, consistent
from cross_checks.truths.truth import Truth, unturned
from mbs_ref.files import package_data
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import GROUND, PlanarBody, Scene, SpatialBody, contact
from mbs_ref.scene.euler_parameters import product
from mbs_ref.trajectory import pose_shapes

DURATION = 0.2  # s
TOLERANCES = (1e-10, 1e-11)  # of the runs whose difference is what the truth is known to

WORLDS = package_data(__name__, "probes.toml")
ENDS = ({"name": "one", "body_a": GROUND, "body_b": "a"}, {"name": "two", "body_a": "a", "body_b": "b"})
RADIUS, MASS, SPEED, GRAVITY = 0.05, 1.0, 1.0, 9.81  # m, kg, m/s towards the other, m/s^2
GAP, ONE_BOUNCE = 0.05, 0.15  # m at the start, s
NORMALS = {2: (0.6, 0.8), 3: (1 / 3, 2 / 3, 2 / 3)}  # of the floor
LAWS: tuple[contact.Law, ...] = (
    contact.SpringDamperLaw(stiffness=1e4, damping=40.0), contact.ProgressiveLaw(stiffness=1e4, damping=4e3),
    contact.HuntCrossleyLaw(stiffness=1e5, damping=4e4), contact.LankaraniNikraveshLaw(stiffness=1e5, restitution=0.6),
    contact.FloresLaw(stiffness=1e5, restitution=0.6), contact.RigidLaw(restitution=0.6), contact.ConstraintLaw(),
)  # fmt: skip
UNCERTAINTY = 1e-10  # m and m/s: a hundred times the tolerances of the integration


@cache
def probes() -> dict[tuple[str, int], Scene]:
    """Return the scenes, by the part's type and the dimension."""
    scenes = (*_in_dimension(2), *_in_dimension(3), *bounces())
    return {(kind, scene.dimension): scene for kind, scene in scenes}


def _in_dimension(d: int) -> Iterator[tuple[str, Scene]]:
    """Yield two of each joint, each drive and load on bodies that two hinges hold, and particles, welds, bushings."""
    world = _resolved(WORLDS["plane" if d == 2 else "space"], d)
    bodies = [*world["bodies"].values()]
    joints = {
        kind: [{"type": kind, **ENDS[k], **{name: pair[k] for name, pair in fields.items()}} for k in (0, 1)]
        for kind, fields in world["joints"].items()
    }
    hinges = joints["revolute"]
    drives = {kind: [*hinges, {"type": kind, "name": "drive"} | drive] for kind, drive in world["drives"].items()}
    loads = {kind: [{"type": kind, "name": "load"} | load] for kind, load in world["loads"].items()}
    built: dict[str, dict[str, Any]] = {kind: {"joints": own} for kind, own in (joints | drives).items()}
    built |= {kind: {"joints": hinges, "loads": own} for kind, own in loads.items()} | world["scenes"]
    shared = {"bodies": bodies, "gravity": WORLDS["vectors"]["gravity"][:d], "duration": DURATION}
    yield from ((kind, consistent(Scene.model_validate(shared | {"name": kind} | own))) for kind, own in built.items())


def _resolved(data: Any, d: int) -> Any:
    """Return data in which the names of vectors are replaced by their first d components."""
    if isinstance(data, dict):
        return {name: _resolved(value, d) for name, value in data.items()}
    if isinstance(data, list):
        return [_resolved(value, d) for value in data]
    return WORLDS["vectors"][data][:d] if data in WORLDS["vectors"] else data


def bounces() -> Iterator[tuple[str, Scene]]:
    """Yield a ball on a floor for each law, and on another ball, with the type of part that it is for."""
    for dimension in (2, 3):
        yield from ((law.type, _on_floor(law, dimension)) for law in LAWS if dimension == 2 or not law.HOLDS)
        for touch in (_on_floor(LAWS[0], dimension), _on_ball(dimension)):
            yield touch.contacts[0].type, touch


def _ball(name: str, place: np.ndarray, velocity: np.ndarray) -> PlanarBody | SpatialBody:
    start: dict[str, Any] = {"position": tuple(place.tolist()), "velocity": tuple(velocity.tolist())}
    inertia = 0.4 * MASS * RADIUS**2
    if len(place) == 2:
        return PlanarBody(name=name, mass=MASS, inertia=inertia, **start)
    return SpatialBody(name=name, mass=MASS, inertia=(inertia, inertia, inertia, 0.0, 0.0, 0.0), **start)


def _on_floor(law: Any, dimension: int) -> Scene:
    normal = np.array(NORMALS[dimension])
    ball = _ball("ball", (RADIUS + GAP) * normal, -SPEED * normal)
    common: dict[str, Any] = {"name": "floor", "body_a": "ball", "center": ball.position, "radius": RADIUS, "law": law}
    if dimension == 2:  # the free side is on the left, walking from 1 to 2
        along = (RADIUS * float(normal[1]), -RADIUS * float(normal[0]))  # a longer line would be the scene's length
        floor = contact.CircleOnLine(**common, point_1=(0.0, 0.0), point_2=along)
    else:
        floor = contact.SphereOnPlane(**common, point=(0.0, 0.0, 0.0), normal=NORMALS[3])
    gravity = tuple((-GRAVITY * normal).tolist())
    return Scene(name=law.type, gravity=gravity, bodies=(ball,), contacts=(floor,), duration=ONE_BOUNCE)


def _on_ball(dimension: int) -> Scene:
    normal = np.array(NORMALS[dimension])
    balls = (_ball("a", (2.0 * RADIUS + GAP) * normal, -SPEED * normal), _ball("b", 0.0 * normal, 0.0 * normal))
    kind: Any = contact.CircleOnCircle if dimension == 2 else contact.SphereOnSphere
    touch = kind(
        name="touch", body_a="a", center_a=balls[0].position, radius_a=RADIUS,
        body_b="b", center_b=balls[1].position, radius_b=RADIUS, law=LAWS[0],
    )  # fmt: skip
    gravity = (0.0,) * dimension
    return Scene(name="two_balls", gravity=gravity, bodies=balls, contacts=(touch,), duration=ONE_BOUNCE)


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


def bounce_truth(scene: Scene, times: np.ndarray) -> Truth:
    """Return the truth of one of these scenes at the times (s)."""
    normal, n = np.array(NORMALS[scene.dimension]), len(scene.bodies)
    gap, rate = _fall(scene.contacts[0].law, MASS / n, float(np.linalg.norm(scene.gravity)), times)
    share = np.array([1.0, 0.0] if n == 1 else [0.5, -0.5])[:n]  # of the distance of centres, about their middle
    middle, moving = (0.0, 0.0) if n == 1 else (0.5 * (2.0 * RADIUS + GAP), -0.5 * SPEED)
    along = middle + moving * times[:, None] + share * (n * RADIUS + gap[:, None])
    speed = moving + share * rate[:, None]
    place, doubt = along[..., None] * normal, np.full(len(times), UNCERTAINTY)
    still = np.zeros((len(times), *pose_shapes(n, scene.dimension)[-1]))
    how = "the equation of the gap, integrated between touch-down and lift-off"
    return Truth(place, unturned(place), UNCERTAINTY, "converged", how, velocity=speed[..., None] * normal,
                 angular_velocity=still, rate_uncertainty=doubt)  # fmt: skip


def _fall(law: Any, mass: float, gravity: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the gap (m) and its rate (m/s) at the times: a flight, a contact and a flight, or rest."""
    touch = 2.0 * GAP / (SPEED + np.sqrt(SPEED**2 + 2.0 * gravity * GAP))
    impact = SPEED + gravity * touch
    numbers = law.numbers()
    factor = numbers.damping + numbers.impact_damping * numbers.stiffness / impact

    def force(depth: float, inward: float) -> float:
        depth = max(depth, 0.0)
        return numbers.stiffness * depth**numbers.exponent + factor * depth**numbers.damping_exponent * inward

    def lifts(t: float, y: np.ndarray) -> float:
        return y[0] if numbers.release == "gap" or t <= touch else force(y[0], y[1])

    lifts.terminal, lifts.direction = True, -1  # type: ignore[attr-defined]
    leave, away, inside = touch, numbers.restitution * impact, None
    if not law.IMPULSIVE:
        inside = solve_ivp(
            lambda t, y: (y[1], gravity - force(y[0], y[1]) / mass), (touch, touch + times[-1] + ONE_BOUNCE),
            (0.0, impact), "DOP853", dense_output=True, events=lifts, rtol=1e-12, atol=1e-13,
        )  # fmt: skip
        leave, away = inside.t[-1], -inside.y[1, -1]
    since = np.maximum(times - leave, 0.0)
    gap, rate = away * since - 0.5 * gravity * since**2, away - gravity * since
    if law.HOLDS:
        gap, rate = 0.0 * since, 0.0 * since
    if inside is not None:
        within = (times > touch) & (times < leave)
        gap, rate = np.where(within, -inside.sol(np.clip(times, touch, leave)), (gap, rate))
    before = times <= touch
    gap[before] = (GAP - SPEED * times - 0.5 * gravity * times**2)[before]
    rate[before] = (-SPEED - gravity * times)[before]
    return gap, rate
