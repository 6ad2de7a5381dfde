"""Families of hidden events: each draws a world of size and duration about 1, in the plane (2) or in space (3).

A family draws in a frame of its own, with hinges along the third axis; `draw` turns and moves the whole.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.mbs_ref.hidden_events.world import GROUND, NOTHING, THIRD, Body, Contact, Length, Level, Mark, World

Rng = np.random.Generator
Family = Callable[[Rng, int], World]
WEAK_LAWS = ("spring_damper_law", "progressive_law", "hunt_crossley_law")
WORLD_AXES = {"levels"}  # families that are neither turned nor moved: their events are along the world's axes


def log_uniform(rng: Rng, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _vector(rng: Rng, dimension: int, size: float = 1.0) -> np.ndarray:
    """Return a vector of that length in a random direction."""
    vector = np.append(rng.normal(size=dimension), [0.0] * (3 - dimension))
    return size * vector / np.linalg.norm(vector)


def _perpendicular(rng: Rng, dimension: int, direction: np.ndarray) -> np.ndarray:
    """Return a unit vector perpendicular to a unit vector, in the plane of both where the dimension is 2."""
    if dimension == 2:
        return rng.choice((-1.0, 1.0)) * np.cross(THIRD, direction)
    other = np.cross(direction, rng.normal(size=3))
    return other / np.linalg.norm(other)


def _polar(radius: float, angle: float, height: float = 0.0) -> np.ndarray:
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def _ground(point: np.ndarray) -> Mark:
    return Mark(GROUND, point)


def _law(rng: Rng, least: float = 0.5, weak: float = 0.4) -> dict:
    """Return a law: rigid, or too weak to be noticed."""
    if rng.random() < weak:
        return {"law": rng.choice(WEAK_LAWS).item()}
    return {"restitution": float(rng.choice([1.0, rng.uniform(least, 1.0)]))}


def _rotor(rng: Rng, spin: float) -> Body:
    """A heavy body on a hinge through or beside its centre of mass, which turns at a constant rate."""
    offset = _polar(rng.choice([0.0, 0.3]), rng.uniform(0.0, 6.0))
    return Body("rotor", 1.0, log_uniform(rng, 0.1, 10.0), NOTHING, spin=spin * THIRD, kind="hinged", offset=offset)


def _near(rng: Rng, most: float) -> float:
    """Return a small depth: of a crossing and its return where it is positive, of a near miss where not."""
    return log_uniform(rng, 1e-9, most) * (1.0 if rng.random() < 0.7 else -1.0)


def _sign(rng: Rng) -> float:
    return float(rng.choice((-1.0, 1.0)))


def studs(rng: Rng, dimension: int) -> World:
    """A stud on a rotor meets a stone, a free stone, or a plane once a turn."""
    spin = 2.0 * np.pi * log_uniform(rng, 3.0, 300.0 if dimension == 2 else 60.0) * _sign(rng)
    reach = rng.uniform(0.3, 1.0)
    stud, stone = (reach * log_uniform(rng, 3e-3, 0.1) for _ in range(2))
    rotor, arm = _rotor(rng, spin), Mark("rotor", _polar(reach, 0.0))
    angle, depth = rng.uniform(0.5, 5.8), rng.uniform(0.1, 0.9)
    match rng.choice(["stone", "free", "plane"]):
        case "plane":
            normal = -_polar(1.0, angle)
            contact = Contact(
                "hit", arm, _ground(-normal * (reach + stud * (1.0 - depth))), stud, normal=normal, **_law(rng)
            )
            return World(dimension, (rotor,), (contact,))
        case "stone":
            height = rng.uniform(-0.3, 0.3) * (stud + stone) * (dimension - 2)
            place = _polar(reach + _sign(rng) * (stud + stone) * (1.0 - depth), angle, height)
            return World(dimension, (rotor,), (Contact("hit", arm, _ground(place), stud, stone, **_law(rng)),))
    place = _polar(reach + (stud + stone) * (1.0 - depth), angle)
    free = Body("stone", log_uniform(rng, 1e-3, 1.0), 1e-3, place, kind=rng.choice(["point", "free"]).item())
    contact = Contact("hit", arm, Mark("stone", NOTHING), stud, stone, **_law(rng))
    return World(dimension, (rotor, free), (contact,))


def bullets(rng: Rng, dimension: int) -> World:
    """Fast small spheres and a target that they hit or pass: a sphere, a plane, or a plate; gravity at times."""
    gravity = _vector(rng, dimension, rng.choice([0.0, rng.uniform(0.1, 5.0)]))
    kind = rng.choice(["sphere", "ground", "plane", "plate", "behind"])
    mass = log_uniform(rng, 0.1, 10.0)
    size = log_uniform(rng, 1e-3, 0.1)
    moved = _vector(rng, dimension, rng.uniform(0.0, 1.0))
    bodies, watches = [], []
    if kind == "sphere":
        bodies.append(
            Body("target", mass, 0.4 * mass * size**2, NOTHING, moved, kind=rng.choice(["point", "free"]).item())
        )
    for k in range(int(rng.integers(1, 4))):
        time, radius = rng.uniform(0.1, 0.9), log_uniform(rng, 1e-3, 0.05)
        direction = _vector(rng, dimension)
        beside = _perpendicular(rng, dimension, direction)
        speed = log_uniform(rng, 1.0, 1e3)
        aim = beside * rng.choice([rng.uniform(0.0, 0.95), rng.uniform(1.05, 2.0)]) * (radius + size)
        name, target = f"bullet{k}", Mark("target" if kind == "sphere" else GROUND, NOTHING)
        if kind == "sphere":
            at, velocity = aim + moved * time, moved + speed * direction
            start = at - velocity * time
        else:
            at, velocity = aim, speed * direction - gravity * time
            start = at - velocity * time - 0.5 * gravity * time**2
        law = _law(rng)
        if kind in ("plane", "plate", "behind"):
            normal, half = -direction, 0.0
            tilt = beside * rng.uniform(-1.0, 1.0)
            normal = (normal + tilt) / np.linalg.norm(normal + tilt)
            along = _perpendicular(rng, dimension, normal)
            edges: tuple[np.ndarray, ...] = () if kind == "plane" else (along, np.cross(normal, along))[: dimension - 1]
            thick, place = None, NOTHING
            if kind != "plane":
                half, law = log_uniform(rng, 0.01, 0.3), {"restitution": rng.uniform(0.5, 1.0)}
                place = along * half * rng.choice([rng.uniform(-0.9, 0.9), rng.uniform(1.1, 3.0)])
            if kind == "behind":
                thick = 0.1 * radius
                place = place + normal * rng.uniform(-2.0, 2.0) * half
            contact = Contact(f"hit{k}", Mark(name, NOTHING), _ground(place), radius, normal=normal, edges=edges,
                              half=half, thickness=thick, **law)  # fmt: skip
        else:
            contact = Contact(f"hit{k}", Mark(name, NOTHING), target, radius, size, **law)
        body_kind = rng.choice(["point", "free"]).item()
        bodies.append(Body(name, log_uniform(rng, 0.1, 10.0), 1e-3, start, velocity, kind=body_kind))
        watches.append(contact)
    return World(dimension, tuple(bodies), tuple(watches), gravity)


def grazing(rng: Rng, dimension: int) -> World:
    """The closest approach is 1e-9 to 1e-3 below or above contact: a free sphere, a parabola, a turning arm."""
    depth = _near(rng, 1e-3)
    radius, stone = log_uniform(rng, 0.003, 0.1), log_uniform(rng, 0.003, 0.1)
    law, time = _law(rng, weak=0.6), rng.uniform(0.2, 0.8)
    bullet = Mark("bullet", NOTHING)
    match rng.choice(["pass", "parabola", "arm_stone", "arm_plane"]):
        case "pass":
            direction = _vector(rng, dimension)
            velocity, beside = direction * log_uniform(rng, 1.0, 100.0), _perpendicular(rng, dimension, direction)
            start = beside * (radius + stone - depth) - velocity * time
            body = Body("bullet", 1.0, 1e-3, start, velocity, kind="point")
            return World(dimension, (body,), (Contact("hit", bullet, _ground(NOTHING), radius, stone, **law),))
        case "parabola":
            normal = _vector(rng, dimension)
            gravity = normal * rng.uniform(1.0, 20.0)
            velocity = _perpendicular(rng, dimension, normal) * rng.uniform(0.0, 3.0) - gravity * time
            start = normal * (radius - depth) - velocity * time - 0.5 * gravity * time**2
            body = Body("bullet", 1.0, 1e-3, start, velocity)
            contact = Contact("hit", bullet, _ground(NOTHING), radius, normal=normal, **law)
            return World(dimension, (body,), (contact,), gravity)
        case other:
            turns = log_uniform(rng, 0.6, 100.0 if dimension == 2 else 30.0)
            rotor, arm = _rotor(rng, 2.0 * np.pi * turns * _sign(rng)), Mark("rotor", _polar(1.0, 0.0))
            outward = _polar(1.0, rng.uniform(0.5, 5.8))
            if other == "arm_plane":
                at = _ground(outward * (1.0 + radius - depth))
                return World(dimension, (rotor,), (Contact("hit", arm, at, radius, normal=-outward, **law),))
            at = _ground(outward * (1.0 + radius + stone - depth))
            return World(dimension, (rotor,), (Contact("hit", arm, at, radius, stone, **law),))


def doubles(rng: Rng, dimension: int) -> World:
    """Several contacts in a short time: a corner, two stones on a path, two close walls, two bullets at once."""
    short = log_uniform(rng, 1e-7, 1e-2)
    time, radius = rng.uniform(0.1, 0.8), log_uniform(rng, 1e-3, 0.05)
    direction = _vector(rng, dimension)
    beside = _perpendicular(rng, dimension, direction)
    speed = log_uniform(rng, 1.0, 100.0)
    bullet, velocity = Mark("bullet", NOTHING), speed * direction
    body = Body("bullet", 1.0, 1e-3, -velocity * time, velocity, kind=rng.choice(["point", "free"]).item())
    match rng.choice(["corner", "stones", "walls", "pair"]):
        case "corner":
            opening = rng.uniform(0.3, 1.2)
            normals = [-direction * np.cos(opening) + side * beside * np.sin(opening) for side in (1.0, -1.0)]
            places = [-normals[0] * radius, -normals[1] * radius + direction * speed * short]
            watches = [
                Contact(f"hit{k}", bullet, _ground(place), radius, normal=normal, **_law(rng))
                for k, (normal, place) in enumerate(zip(normals, places, strict=True))
            ]
        case "stones":
            stone = log_uniform(rng, 1e-3, 0.05)
            places = [
                direction * along + beside * side * rng.uniform(0.5, 0.95) * (radius + stone)
                for along, side in ((0.0, 1.0), (speed * short, rng.choice([1.0, -1.0])))
            ]
            watches = [
                Contact(f"hit{k}", bullet, _ground(place), radius, stone, **_law(rng)) for k, place in enumerate(places)
            ]
        case "walls":
            room = speed * max(short, 5e-3)
            body = replace(body, place=direction * rng.uniform(0.1, 0.9) * room, velocity=velocity + 0.3 * beside)
            watches = [
                Contact(f"hit{k}", bullet, _ground(place), radius, normal=normal, **_law(rng, 0.97, 0.0))
                for k, (normal, place) in enumerate(
                    [(direction, -radius * direction), (-direction, (room + radius) * direction)]
                )
            ]
        case _:
            other = Body("other", 1.0, 1e-3, -velocity * (time + short) + beside, velocity, kind="point")
            law = _law(rng)
            watches = [
                Contact(
                    f"hit_{name}", Mark(name, NOTHING), _ground(direction * radius), radius, normal=-direction, **law
                )
                for name in ("bullet", "other")
            ]
            return World(dimension, (body, other), tuple(watches))
    return World(dimension, (body,), tuple(watches))


def turning(rng: Rng, dimension: int) -> World:
    """A free body that turns while it flies, or a pair: discs on its arms reach a plane, a stone, each other."""
    gravity = _vector(rng, dimension, rng.choice([0.0, rng.uniform(0.1, 5.0)]))
    arm, radius = rng.uniform(0.2, 0.6), log_uniform(rng, 3e-3, 0.05)
    axis = THIRD if dimension == 2 else _vector(rng, 3)

    def flyer(name: str, place: np.ndarray) -> Body:
        spin = axis * _sign(rng) * 2.0 * np.pi * log_uniform(rng, 1.0, 100.0 if dimension == 2 else 30.0)
        mass, velocity = log_uniform(rng, 0.3, 3.0), _vector(rng, dimension, rng.uniform(0.0, 1.0))
        return Body(name, mass, mass * rng.uniform(0.05, 0.5), place, velocity, spin)

    kind = rng.choice(["plane", "stone", "pair"])
    tips = [_vector(rng, dimension, arm) for _ in range(int(rng.integers(1, 3)))]
    bodies = [flyer("rod", NOTHING)]
    law, watches = _law(rng), []
    normal = -_vector(rng, dimension)
    for k, tip in enumerate(tips):
        name, own = f"hit{k}", Mark("rod", tip)
        if kind == "plane":
            place = -normal * (arm + radius) * rng.uniform(0.9, 1.2)
            watches.append(Contact(name, own, _ground(place), radius, normal=normal, **law))
        elif kind == "stone":
            stone = radius * rng.uniform(0.3, 3.0)
            place = _vector(rng, dimension, arm + rng.uniform(-0.9, 0.9) * (radius + stone))
            watches.append(Contact(name, own, _ground(place), radius, stone, **law))
        else:
            if k == 0:
                bodies.append(flyer("other", _vector(rng, dimension, rng.uniform(0.5, 1.2))))
            watches.append(Contact(name, own, Mark("other", _vector(rng, dimension, arm)), radius, radius, **law))
    return World(dimension, tuple(bodies), tuple(watches), gravity)


def strings(rng: Rng, dimension: int) -> World:
    """A string of a turning or flying body is taut for a short time; its force is too small to be noticed."""
    if rng.random() < 0.6:
        reach = rng.uniform(0.3, 1.0)
        body = _rotor(rng, 2.0 * np.pi * log_uniform(rng, 1.0, 200.0 if dimension == 2 else 30.0) * _sign(rng))
        mark, anchor = Mark("rotor", _polar(reach, 0.0)), _polar(reach * rng.uniform(0.2, 2.0), rng.uniform(0.5, 5.8))
        farthest = reach + float(np.linalg.norm(anchor))
        value = farthest * (1.0 - _near(rng, 0.1))
        return World(dimension, (body,), (Length("string", mark, _ground(anchor), value),))
    gravity = _vector(rng, dimension, rng.uniform(1.0, 20.0))
    time, reach = rng.uniform(0.2, 0.8), rng.uniform(0.3, 1.0)
    apex = -gravity / np.linalg.norm(gravity) * reach
    sideways = _perpendicular(rng, dimension, apex / reach) * rng.uniform(0.0, 0.3)
    velocity = sideways - gravity * time
    body = Body("ball", 1.0, 1e-3, apex - velocity * time - 0.5 * gravity * time**2, velocity, kind="point")
    value = reach * (1.0 - _near(rng, 0.1))
    return World(dimension, (body,), (Length("string", Mark("ball", NOTHING), _ground(NOTHING), value),), gravity)


def levels(rng: Rng, dimension: int) -> World:
    """A declared event that crosses its value and returns within a short time, or remains just below it."""
    crossing = rng.choice(["either", "either", "rising", "falling"]).item()
    near = 1.0 - _near(rng, 0.03)
    side = _sign(rng)
    spin = 2.0 * np.pi * log_uniform(rng, 0.6, 200.0 if dimension == 2 else 30.0) * _sign(rng)
    reach, start = rng.uniform(0.2, 1.0), rng.uniform(0.0, 6.0)
    match rng.choice(["sine", "drive", "parabola", "distance", "angle" if dimension == 2 else "sine"]):
        case "sine":
            rate = bool(rng.random() < 0.4)
            body = Body("rotor", 1.0, 1.0, NOTHING, spin=spin * THIRD, kind="hinged", offset=_polar(reach, start))
            value = side * near * reach * (abs(spin) if rate else 1.0)
            return World(dimension, (body,), (Level("level", "rotor", int(rng.integers(2)), rate, value, crossing),))
        case "drive":
            body = Body("slider", 1.0, 1.0, NOTHING, spin=abs(spin) * THIRD, kind="driven", offset=_polar(reach, start))
            return World(dimension, (body,), (Level("level", "slider", 0, False, side * near * reach, crossing),))
        case "angle":
            body = Body("rotor", 1.0, 1.0, NOTHING, spin=spin * THIRD)
            return World(
                dimension, (body,), (Level("level", "rotor", 3, False, spin * rng.uniform(-0.5, 1.2), crossing),)
            )
        case "distance":
            spins = [spin, spin * rng.uniform(-1.0, 1.0)]
            apart = _polar(3.0 * reach, rng.uniform(0.0, 6.0))
            bodies = [
                Body(name, 1.0, 1.0, place, spin=each * THIRD, kind="hinged")
                for name, place, each in zip(("rotor", "other"), (NOTHING, apart), spins, strict=True)
            ]
            marks = [Mark(body.name, _polar(reach, rng.uniform(0.0, 6.0))) for body in bodies]
            value = reach * (3.0 + 2.0 * side * (1.0 - log_uniform(rng, 1e-4, 0.1)))
            return World(dimension, tuple(bodies), (Length("level", *marks, value, True, crossing),))
    gravity, axis = np.zeros(3), int(rng.integers(dimension))
    gravity[axis] = -side * rng.uniform(1.0, 20.0)
    time = rng.uniform(0.2, 0.8)
    velocity = np.append(rng.normal(size=dimension), [0.0] * (3 - dimension))
    velocity[axis] = -gravity[axis] * time
    top = 0.5 * abs(gravity[axis]) * time**2
    body = Body("ball", 1.0, 1e-3, NOTHING, velocity, kind="point")
    level = Level("level", "ball", axis, False, side * near * top, crossing)
    return World(dimension, (body,), (level,), gravity)


def valves(rng: Rng, dimension: int) -> World:
    """A flap on a hinge strikes two close stops in turn, many times in a short time."""
    reach, tip = rng.uniform(0.3, 1.0), log_uniform(rng, 3e-3, 0.05)
    clearance = log_uniform(rng, 1e-4, 0.3)
    strokes = log_uniform(rng, 2.0, 150.0)
    rotor, arm = _rotor(rng, clearance * strokes * _sign(rng)), Mark("rotor", _polar(reach, 0.0))
    stop, rests = tip * rng.uniform(0.3, 3.0), rng.uniform(0.1, 0.9) * clearance
    watches = []
    for name, angle, side in (("low", rests - clearance, -1.0), ("high", rests, 1.0)):
        touch, outward = _polar(reach, angle), side * _polar(1.0, angle + 0.5 * np.pi)
        law = _law(rng, 0.95, 0.0)
        if rng.random() < 0.5:
            watches.append(Contact(name, arm, _ground(touch + tip * outward), tip, normal=-outward, **law))
        else:
            watches.append(Contact(name, arm, _ground(touch + (tip + stop) * outward), tip, stop, **law))
    return World(dimension, (rotor,), tuple(watches))


def springs(rng: Rng, dimension: int) -> World:
    """A mass flies between two stiff strings or two stiff planes: each contact lasts half a period."""
    speed = log_uniform(rng, 1.0, 30.0)
    along = _vector(rng, dimension)
    velocity = speed * along
    holds = [log_uniform(rng, 3e-4, 1e-2) for _ in range(2)]
    mark = Mark("ball", NOTHING)
    start = rng.uniform(0.2, 0.8)
    if rng.random() < 0.5:
        body = Body("ball", log_uniform(rng, 0.1, 10.0), 1e-3, start * along, velocity, kind="point")
        # Each string is taut at its own end: the anchor is one length behind it.
        strings = [
            Length(f"hit{k}", mark, _ground(side * along), value, hold=holds[k])
            for k, (side, value) in enumerate([(-0.5, 1.5), (1.5, 1.5)])
        ]
        return World(dimension, (body,), tuple(strings))
    radius = log_uniform(rng, 1e-3, 0.05)
    velocity = velocity + _perpendicular(rng, dimension, along) * rng.uniform(0.0, 1.0)
    body = Body("ball", log_uniform(rng, 0.1, 10.0), 1e-3, start * along, velocity, kind="free")
    planes = [
        Contact(f"hit{k}", mark, _ground(place * along), radius, normal=side * along, hold=holds[k])
        for k, (side, place) in enumerate([(-1.0, 1.0 + radius), (1.0, -radius)])
    ]
    return World(dimension, (body,), tuple(planes))


FAMILIES: dict[str, Family] = {
    each.__name__: each for each in (studs, bullets, grazing, doubles, turning, strings, levels, valves, springs)
}


def draw(family: str, rng: Rng, dimension: int) -> World:
    """Return a random world of a family, turned and moved at random."""
    world = FAMILIES[family](rng, dimension)
    if family in WORLD_AXES:
        return world
    turn = Rotation.random(random_state=rng).as_matrix() if dimension == 3 else Rotation.from_rotvec(
        rng.uniform(0.0, 6.0) * THIRD).as_matrix()  # fmt: skip
    return world.placed(turn, np.append(rng.uniform(-1.0, 1.0, dimension), [0.0] * (3 - dimension)))
