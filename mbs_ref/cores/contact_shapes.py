"""Contact parts and granules -> the arrays of the shapes that may touch, and what lists the near ones."""

import math
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.cores.events import RELEASES
from mbs_ref.kernels.border.groups import absent, empty, floats, ints
from mbs_ref.kernels.contact import laws as shared
from mbs_ref.kernels.contact import neighbours
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.rigid.model import ContactPairs
from mbs_ref.scene import Scene, contact
from mbs_ref.scene.base.part import cross, normals, unit
from mbs_ref.scene.base.rows import Axes
from mbs_ref.scene.traits import deflecting

GRAIN_SKIN = 0.4  # of the mean radius
ROOM = {2: 12, 3: 32}  # neighbours a sphere, by dimension: three times those of equal spheres at their densest
FROM_PAIRS = 100  # a scene with fewer looks at all of them: that is cheaper than keeping a list
SKIN = 0.5  # of the mean ball's radius
_ENDS = {
    "line": shared.ENDS_NONE, "segment": shared.ENDS_OPEN, "plane": shared.ENDS_NONE, "rectangle": shared.ENDS_OPEN,
    "capped": shared.ENDS_CAPPED,
}  # fmt: skip


class _Shape(NamedTuple):
    """One row of ContactPairs, with the marks in world axes at t = 0."""

    kind: int
    center: tuple[float, ...]
    radius: float
    origin: Any
    axes: Any  # unit vectors, as many as the scene has dimensions
    half: tuple[float, float]
    ends: int = shared.ENDS_NONE
    thickness: float = math.inf
    flank: tuple[float, float] = (1.0, 0.0)


def _line(part: contact.CircleOnLine) -> _Shape:
    first, second = np.array(part.point_1), np.array(part.point_2)
    length = float(np.linalg.norm(second - first))
    along = (second - first) / length
    axes = along, (-along[1], along[0])
    return _flat(part, 0.5 * (first + second), axes, (0.5 * length, 0.0))


def _plane(part: contact.SphereOnPlane) -> _Shape:
    normal = unit(part.normal)
    edge = normals(part.normal)[0] if part.edge is None else unit(part.edge)
    half = (math.inf, math.inf) if part.size is None else (0.5 * part.size[0], 0.5 * part.size[1])
    return _flat(part, part.point, (edge, cross(normal, edge), normal), half)


def _flat(part: Any, origin: Any, axes: Any, half: tuple[float, float]) -> _Shape:
    thickness = math.inf if part.thickness is None else part.thickness
    return _Shape(shared.PAIR_FLAT, part.center, part.radius, origin, axes, half, _ENDS[part.extent], thickness)


def _round(part: contact.CircleOnCircle | contact.SphereOnSphere) -> _Shape:
    axes, half = np.eye(len(part.center_a)), (part.radius_b, part.radius_b)
    return _Shape(shared.PAIR_ROUND, part.center_a, part.radius_a, part.center_b, axes, half)


def _sprocket(part: contact.PinOnSprocket) -> _Shape:
    c, s = math.cos(part.first_seat), math.sin(part.first_seat)
    rows = np.eye(2) if part.axis is None else np.array([unit(part.seat), np.cross(unit(part.axis), unit(part.seat))])
    axes = [c * rows[0] + s * rows[1], c * rows[1] - s * rows[0], *([] if part.axis is None else [unit(part.axis)])]
    return _Shape(
        shared.PAIR_SPROCKET, part.center, part.clearance, part.axle, axes, (part.pitch_radius, 0.0),
        part.teeth, part.addendum_radius - part.pitch_radius, (math.cos(part.flank_angle), math.sin(part.flank_angle)),
    )  # fmt: skip


_SHAPES: dict[type, Any] = {
    contact.CircleOnLine: _line, contact.CircleOnCircle: _round, contact.PinOnSprocket: _sprocket,
    contact.SphereOnPlane: _plane, contact.SphereOnSphere: _round,
}  # fmt: skip


def contact_pairs(scene: Scene, places: Axes) -> ContactPairs:
    """Return the shapes in body axes."""
    if not scene.contacts:
        return absent(ContactPairs)
    parts, d, sticking = scene.contacts, scene.dimension, deflecting(scene)
    shapes: list[_Shape] = [_SHAPES[type(part)](part) for part in parts]
    axes = [x for shape in shapes for x in shape.axes]
    order = {name: k for k, name in enumerate(sticking)}
    return ContactPairs(
        kind=ints([s.kind for s in shapes]), a=ints([places.body(p.body_a) for p in parts]),
        b=ints([places.body(p.body_b) for p in parts]),
        center=places.points([p.body_a for p in parts], [s.center for s in shapes]),
        radius=floats(s.radius for s in shapes),
        origin=places.points([p.body_b for p in parts], [s.origin for s in shapes]),
        axes=places.directions([p.body_b for p in parts for _ in range(d)], axes).reshape(-1, d, d),
        half=floats((s.half for s in shapes), 2), ends=ints([s.ends for s in shapes]),
        thickness=floats(s.thickness for s in shapes), flank=floats((s.flank for s in shapes), 2),
        deflection=ints([order.get(p.name, -1) for p in parts]), sticking=ints([len(sticking)]),
    )  # fmt: skip


class Ball(NamedTuple):
    """What a shape lies in."""

    body: int
    center: tuple[float, ...]  # m, in the body
    reach: float  # m


def contact_balls(pairs: ContactPairs, dimension: int) -> NearPairs:
    """Return what every pair's shapes lie in, and the list of near pairs."""
    sides = [(_ball(pairs, k), _other_ball(pairs, k)) for k in range(len(pairs.kind))]
    bounded = [k for k, (_, other) in enumerate(sides) if other is not None]
    every = empty(NearPairs, dimension=dimension)._replace(
        pair=np.arange(len(sides)), count=np.array([len(sides)]), flag=np.zeros(len(sides), dtype=np.int64)
    )
    if len(sides) < FROM_PAIRS or not bounded:
        return every
    reach: dict[tuple[int, tuple[float, ...]], float] = {}
    for k in bounded:
        for ball in sides[k]:
            assert ball is not None
            reach[ball[:2]] = max(ball.reach, reach.get(ball[:2], 0.0))
    number = {mark: s for s, mark in enumerate(reach)}
    ends = np.array([[number[ball[:2]] for ball in sides[k] if ball is not None] for k in bounded])
    keys = ends.min(axis=1) * len(number) + ends.max(axis=1)
    by_key = np.argsort(keys, kind="stable")
    places = np.full((len(number), dimension), np.nan)
    return every._replace(
        stale=np.ones(1, dtype=np.int64), skin=np.array([SKIN * float(np.mean(list(reach.values())))]),
        body=ints([body for body, _ in number]), center=np.array([center for _, center in number]),
        reach=np.array(list(reach.values())), travel=np.zeros(len(reach)), place=places, built=places.copy(),
        last=places.copy(), order=np.arange(len(number)), low=np.zeros(len(number)), key=keys[by_key],
        keyed=np.array(bounded)[by_key],
        always=np.array(sorted(set(range(len(sides))) - set(bounded)), dtype=np.int64),
    )  # fmt: skip


def _ball(pairs: ContactPairs, k: int) -> Ball:
    radius = 0.0 if pairs.kind[k] == shared.PAIR_SPROCKET else float(pairs.radius[k])  # a pin's is in its clearance
    return Ball(int(pairs.a[k]), tuple(pairs.center[k]), radius)


def _other_ball(pairs: ContactPairs, k: int) -> Ball | None:
    """Return None for a surface without ends or without a back, which reaches far below itself."""
    endless = pairs.ends[k] == shared.ENDS_NONE or math.isinf(pairs.thickness[k])
    if pairs.kind[k] == shared.PAIR_FLAT and endless:
        return None
    reach = math.hypot(*pairs.half[k]) if pairs.kind[k] == shared.PAIR_FLAT else float(pairs.half[k, 0])
    if pairs.kind[k] == shared.PAIR_SPROCKET:
        reach = (reach + float(pairs.thickness[k])) / math.cos(math.pi / pairs.ends[k])
    return Ball(int(pairs.b[k]), tuple(pairs.origin[k]), reach)


def granules(scene: Scene, places: Axes) -> neighbours.Granules:
    """Return the arrays of the granules: their shapes, walls and law, and room for the list of near pairs."""
    parts = [load for load in scene.loads if isinstance(load, contact.Granules)]
    if not parts:
        return absent(neighbours.Granules)
    (part,) = parts
    chosen = np.flatnonzero(np.broadcast_to(part.radius, len(scene.bodies)))
    radius, half = part.shapes(len(scene.bodies), scene.dimension)
    radius, half = radius[chosen], half[chosen]
    reach = radius + np.linalg.norm(half, axis=1)
    slender = np.mean(reach**scene.dimension) / np.mean(np.prod(radius[:, None] + half, axis=1))  # 1 of spheres
    law, friction = part.law.numbers(), part.friction.numbers() if part.friction else contact.FrictionNumbers()
    d, n, outward = scene.dimension, len(chosen), [unit(wall.normal) for wall in part.walls]
    numbers: dict[str, Any] = {
        "stiffness": law.stiffness, "dashpot": law.damping, "exponent": law.exponent,
        "damping_exponent": law.damping_exponent, "coefficient": friction.coefficient, "creep": friction.creep,
        "skin": GRAIN_SKIN * float(np.mean(reach)),
    }  # fmt: skip
    most = ROOM[d] * math.ceil(slender) * n
    lengths = {"n": n, "n + 1": n + 1, "dimension": d, "most": most, "buckets": 1 << (2 * n - 1).bit_length()}
    return empty(neighbours.Granules, **lengths)._replace(
        body=ints([places.body(scene.bodies[k].name) for k in chosen]),
        **{"radius": radius, "half": half, "reach": reach, "unit": np.eye(d)},
        normal=floats(outward, d),
        offset=floats(axis @ np.array(wall.point) for axis, wall in zip(outward, part.walls, strict=True)),
        release=ints([RELEASES[law.release]]),
        built=np.full((n, d), np.nan),
        **{name: np.array([value]) for name, value in numbers.items()},
    )
