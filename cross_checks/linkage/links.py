"""A scene as links in space, planar or not: what engines of minimal coordinates build their models from.

Every joint's frame stands along the world's axes at t = 0, where all coordinates are zero. In a planar scene joints
turn about z and slide in x and y; a body gets the same moment of inertia about all axes.
"""

import heapq
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cross_checks.engine import Refusal
from mbs_ref.scene import GROUND, PlanarBody, PointMass, Scene, SpatialBody, SpringDamper, TorsionSpring, symmetric
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.joints import (
    CoordinateDrive,
    Cylindrical,
    Distance,
    PointOnPlane,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
    Weld,
)
from mbs_ref.scene.signals import Constant

FIXED = -1  # the index of ground
Holding = Revolute | Prismatic | Weld | Spherical | Universal | Cylindrical | Distance | PointOnPlane
CLOSES_EASILY = Revolute | Spherical | Distance  # engines close loops by shared points and by rods
ALONE = np.array([1.0, 0.0, 0.0, 0.0])  # Euler parameters of no turn
Z = np.array([0.0, 0.0, 1.0])
SIX = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])  # of a matrix: xx, yy, zz, xy, xz, yz
FREE_KIND = {2: "planar", 3: "free"}  # of a body without a joint, by dimension


@dataclass(frozen=True)
class Edge:
    """One body on its parent; a body without a joint is free."""

    body: int
    parent: int  # FIXED for ground
    joint: Holding | None


def spanning_tree(scene: Scene) -> tuple[tuple[Edge, ...], tuple[Holding, ...]]:
    """Return the edges, each subtree in one piece, and the joints outside of the tree, which close loops.

    The tree contains as many slides, welds and universal joints as possible (Prim 1957), and is as shallow as ties
    allow. MuJoCo numbers bodies depth first; Pinocchio gives a wrong mass matrix for any other order.
    """
    index = {GROUND: FIXED, **{name: k for k, name in enumerate(scene.body_names)}}
    holding = [joint for joint in scene.joints if isinstance(joint, Holding)]
    neighbours: dict[int, list[tuple[int, Holding]]] = {k: [] for k in range(FIXED, len(scene.bodies))}
    for joint in holding:
        a, b = (index[end] for end in joint.ends)
        for here, there in ((a, b), (b, a)):
            if _can_hang(scene, joint, there):
                neighbours[here].append((there, joint))
    children: dict[int, list[Edge]] = {k: [] for k in neighbours}
    for edge in _prim(neighbours):
        children[edge.parent].append(edge)
    edges = tuple(_depth_first(children, FIXED))
    used = {edge.joint.name for edge in edges if edge.joint is not None}
    return edges, tuple(joint for joint in holding if joint.name not in used)


def _can_hang(scene: Scene, joint: Holding, body: int) -> bool:
    """Return whether the joint alone holds the body; a rod in the plane turns a particle about its other end."""
    if isinstance(joint, Distance):
        particle = body != FIXED and isinstance(scene.bodies[body], PointMass)
        return scene.dimension == 2 and particle and joint.point_a != joint.point_b
    return not isinstance(joint, PointOnPlane)


def _prim(neighbours: dict[int, list[tuple[int, Holding]]]) -> Iterator[Edge]:
    """Yield the edges; a component without ground starts from its first body, which is free."""
    seen: set[int] = set()
    count = 0
    for root in neighbours:
        heap: list = [(False, 0, 0, Edge(root, FIXED, None))]
        while heap:
            _, depth, _, edge = heapq.heappop(heap)
            if edge.body in seen:
                continue
            seen.add(edge.body)
            if edge.body != FIXED:
                yield edge
            for other, joint in neighbours[edge.body]:
                count += 1
                heapq.heappush(
                    heap, (isinstance(joint, CLOSES_EASILY), depth + 1, count, Edge(other, edge.body, joint))
                )


def _depth_first(children: dict[int, list[Edge]], body: int) -> Iterator[Edge]:
    stack = children[body][::-1]
    while stack:
        edge = stack.pop()
        yield edge
        stack += children[edge.body][::-1]


@dataclass(frozen=True)
class Link:
    """One body with the joint that hangs it on its parent, which comes before it."""

    name: str
    body: int
    parent: int  # FIXED for ground
    joint: str | None  # None where the body is free
    kind: str  # revolute, prismatic, cylindrical, universal, ball, planar, weld, free
    origin: np.ndarray  # (3,) m, the joint in the world at t = 0
    axes: np.ndarray  # (0, 1 or 2; 3) unit, world at t = 0: the joint's, or where it slides and then turns
    mass: float  # kg
    centre: np.ndarray  # (3,) m, the centre of mass from the origin
    inertia: np.ndarray  # (3, 3) kg m^2 about the centre of mass, world axes at t = 0
    rates: np.ndarray  # of the coordinates at t = 0; free: velocity, then angular velocity; planar: x, y, turn
    rigid: bool  # has an orientation; a particle that is free only slides
    held: frozenset[str] = frozenset()  # coordinates of a planar body that drives keep constant, and that are left out

    @property
    def freedoms(self) -> list[tuple[str, np.ndarray]]:
        """The joint as a chain of slides and turns, each with its axis (3,); ball and free joints have none."""
        none = np.zeros(3)
        if self.kind == "free":
            return [("free", none)] if self.rigid else [("slide", axis) for axis in np.eye(3)]
        if self.kind == "planar":
            kinds = [("x", "slide"), ("y", "slide"), *([("angle", "turn")] if self.rigid else [])]
            chain = zip(kinds, np.eye(3), strict=False)
            return [(kind, axis) for (name, kind), axis in chain if name not in self.held]
        kinds = {"prismatic": ["slide"], "cylindrical": ["slide", "turn"], "ball": ["ball"]}
        axes = [none] if self.kind == "ball" else list(self.axes)
        return list(zip(kinds.get(self.kind, ["turn"] * len(axes)), axes, strict=True))

    @property
    def turning_first(self) -> np.ndarray:
        """The rates at t = 0, a free body's angular velocity before its velocity."""
        return np.roll(self.rates, 3) if self.kind == "free" else self.rates

    @property
    def size(self) -> int:
        """The number of rates of its freedoms."""
        return sum({"free": 6, "ball": 3}.get(kind, 1) for kind, _ in self.freedoms)


@dataclass(frozen=True)
class Closure:
    """A joint that closes a loop."""

    name: str
    kind: str  # point, hinge, weld, rod; else the scene's type
    a: int  # body, FIXED for ground
    b: int
    point_a: np.ndarray  # (3,) m, world at t = 0
    point_b: np.ndarray
    axis: np.ndarray  # (3,) unit, world at t = 0; a hinge's alone
    length: float  # m, a rod's alone

    @property
    def shared_points(self) -> list[np.ndarray]:
        """World points at t = 0 that the two bodies share: a hinge's are two on its axis, 1 m apart."""
        offsets = (-0.5, 0.5) if self.kind == "hinge" else (0.0,)
        return [self.point_a + offset * self.axis for offset in offsets]


@dataclass(frozen=True)
class Linkage:
    """A scene's links, each after its parent, and what closes its loops."""

    scene: Scene
    links: tuple[Link, ...]
    closures: tuple[Closure, ...]

    @property
    def gravity(self) -> np.ndarray:  # (3,) m/s^2
        return lifted(self.scene.gravity)

    @property
    def loaded(self) -> bool:
        """Whether anything but gravity acts."""
        return bool(self.scene.loads or self.scene.contacts)

    def origin(self, body: int) -> np.ndarray:
        """Return where the frame of a body's link is at t = 0, (3,) m; ground's is the world's."""
        return np.zeros(3) if body == FIXED else self.of_body[body].origin

    def local(self, body: str, point) -> np.ndarray:
        """Return a world point at t = 0 in the frame of a body's link, (3,) m."""
        return lifted(point) - self.origin(self.scene.body_index(body))

    def path(self, body: str) -> Iterator[Link]:
        """Yield the links from a body down to ground."""
        k = self.scene.body_index(body)
        while k != FIXED:
            yield self.of_body[k]
            k = self.of_body[k].parent

    @cached_property
    def of_body(self) -> tuple[Link, ...]:
        """The links in the scene's order of bodies."""
        return tuple(sorted(self.links, key=lambda link: link.body))

    @cached_property
    def rigid(self) -> np.ndarray:  # (n_bodies,) 1.0 where a body has an orientation, 0.0 for particles
        return np.array([float(link.rigid) for link in self.of_body])

    @cached_property
    def angle(self) -> np.ndarray:  # (n_bodies,) rad at t = 0, of planar bodies
        return np.array([getattr(body, "angle", 0.0) for body in self.scene.bodies])

    @cached_property
    def theta(self) -> np.ndarray:  # (n_bodies, 4) Euler parameters at t = 0, of spatial bodies
        return np.array([getattr(body, "orientation", ALONE) for body in self.scene.bodies])

    @cached_property
    def rates(self) -> np.ndarray:
        """The rates of all freedoms at t = 0, link after link: (n_v,)."""
        return np.concatenate([np.zeros(0), *(link.rates[: link.size] for link in self.links)])

    @cached_property
    def turns(self) -> np.ndarray:
        """Which coordinates turn each body of a planar scene, (n_bodies, n_q) of 0.0 and 1.0."""
        turns, first = np.zeros((len(self.links) + 1, len(self.rates))), 0  # the last row is ground's
        for link in self.links:
            turns[link.body] = turns[link.parent]
            for k, (kind, _) in enumerate(link.freedoms):
                turns[link.body, first + k] = float(kind == "turn")
            first += link.size
        return turns[:-1]

    def turned(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the angles (n_bodies,) since t = 0 in the plane, which count whole turns; zeros in space."""
        return self.turns @ coordinates if self.scene.dimension == 2 else np.zeros(len(self.links))


def lifted(vector) -> np.ndarray:
    """Return a vector of the scene in space, (3,)."""
    return np.resize((*vector, 0.0), 3).astype(float)


def rest_length(load: SpringDamper) -> float:
    """Return the length (m) at which a spring is relaxed."""
    initial = float(np.linalg.norm(np.subtract(load.point_b, load.point_a)))
    return initial if load.rest_length is None else load.rest_length


def rest_turn(scene: Scene, load: TorsionSpring) -> float:
    """Return by how much (rad) body b has turned in body a since t = 0 where the spring is relaxed."""
    if load.rest_angle is None:
        return 0.0
    angles = [*(getattr(body, "angle", 0.0) for body in scene.bodies), 0.0]
    return load.rest_angle - (angles[scene.body_index(load.body_b)] - angles[scene.body_index(load.body_a)])


def linkage_of(scene: Scene) -> Linkage:
    """Return the scene as links."""
    edges, rest = spanning_tree(scene)
    spins = {FIXED: np.zeros(3)}
    links = tuple(_link(scene, edge, spins) for edge in edges)
    return Linkage(scene, links, tuple(_closure(scene, joint) for joint in rest))


def closure_refusals(engine: str, scene: Scene, known: Collection[str]) -> list[Refusal]:
    """Return which joints close a loop in a way that the engine does not represent."""
    sentence = "joint {!r} closes a loop as {}, which {} does not yet support"
    closed = (_closure(scene, joint) for joint in spanning_tree(scene)[1])
    return [Refusal(sentence.format(c.name, c.kind, engine), False) for c in closed if c.kind not in known]


def _link(scene: Scene, edge: Edge, spins: dict[int, np.ndarray]) -> Link:
    """Return the link of an edge, and store the angular velocity (3,) of its frame at t = 0."""
    body, joint = scene.bodies[edge.body], edge.joint
    kind, axes = _kind(scene, edge)
    origin, centre = _origin(scene, edge), lifted(body.position)
    spins[edge.body] = _spin(scene, edge, origin, spins)

    inertia = _inertia(body)
    if not inertia.any() and kind in ("free", "planar"):
        inertia = body.mass * np.eye(3)  # it never turns, so any inertia will do
    held = frozenset(drive.coordinate for drive in held_coordinates(scene) if drive.body == body.name)
    link = Link(body.name, edge.body, edge.parent, joint and joint.name, kind, origin, axes, body.mass,
                centre - origin, inertia, np.zeros(0), True, held)  # fmt: skip
    moving, carried = (_velocity(scene, k, origin, spins) for k in (edge.body, edge.parent))
    sliding, turning = moving - carried, spins[edge.body] - spins[edge.parent]
    of_kind = {"slide": lambda a: [a @ sliding], "turn": lambda a: [a @ turning], "ball": lambda _: turning,
               "free": lambda _: [*sliding, *turning]}  # fmt: skip
    rates = [rate for name, axis in link.freedoms for rate in of_kind[name](axis)]
    return Link(**{**vars(link), "rates": np.array(rates, dtype=float), "rigid": not isinstance(body, PointMass)})


def held_coordinates(scene: Scene) -> list[CoordinateDrive]:
    """Return the drives that keep a coordinate of a planar body constant, as a joint that lacks this freedom does."""
    every = [joint for joint in scene.joints if isinstance(joint, CoordinateDrive) and scene.dimension == 2]
    return [one for one in every if one.level == "position" and isinstance(one.motion, Constant)]


def _kind(scene: Scene, edge: Edge) -> tuple[str, np.ndarray]:
    """Return the kind and the axes; a particle on a pin or a ball joint stays where it is."""
    joint, body = edge.joint, scene.bodies[edge.body]
    particle = isinstance(body, PointMass)
    if joint is None:
        return FREE_KIND[scene.dimension], np.zeros((0, 3))
    if isinstance(joint, Universal):
        on_b = body.name == joint.body_b
        axes = [joint.axis_a, joint.axis_b] if on_b else [joint.axis_b, joint.axis_a]
        return "universal", np.array([_unit(axis) for axis in axes])
    if joint.type == "spherical":
        return ("weld" if particle else "ball"), np.zeros((0, 3))
    if isinstance(joint, Revolute | Distance) and getattr(joint, "axis", None) is None:  # in the plane
        pinned = particle and isinstance(joint, Revolute)
        return ("weld", np.zeros((0, 3))) if pinned else ("revolute", Z[None])
    count = {"cylindrical": 2, "revolute": 1, "prismatic": 1}.get(joint.type, 0)
    return joint.type, np.tile(_unit(getattr(joint, "axis", None)), (count, 1))


def _origin(scene: Scene, edge: Edge) -> np.ndarray:
    joint, body = edge.joint, scene.bodies[edge.body]
    if joint is None:
        return lifted(body.position)
    if isinstance(joint, Distance):
        return lifted(joint.point_a if body.name == joint.body_b else joint.point_b)
    return lifted(joint.point)


def _spin(scene: Scene, edge: Edge, origin: np.ndarray, spins: dict[int, np.ndarray]) -> np.ndarray:
    """Return the angular velocity of a body's frame at t = 0: a particle's turns with its rod or its parent."""
    body = scene.bodies[edge.body]
    if isinstance(body, PlanarBody):
        return body.angular_velocity * Z
    if isinstance(body, SpatialBody):
        return np.array(body.angular_velocity)
    if isinstance(edge.joint, Distance):
        rod = lifted(body.position) - origin
        return np.cross(rod, lifted(body.velocity) - _velocity(scene, edge.parent, origin, spins)) / (rod @ rod)
    return spins[edge.parent]


def _velocity(scene: Scene, k: int, point: np.ndarray, spins: dict[int, np.ndarray]) -> np.ndarray:
    """Return the velocity (3,) of the point of a body that is at a world point at t = 0."""
    if k == FIXED:
        return np.zeros(3)
    return lifted(scene.bodies[k].velocity) + np.cross(spins[k], point - lifted(scene.bodies[k].position))


def _inertia(body) -> np.ndarray:
    """Return the inertia (3, 3) about the centre of mass in world axes at t = 0; a particle's is zero."""
    if isinstance(body, SpatialBody):
        turns = rotation_matrices(body.orientation)
        return turns @ symmetric(body.inertia) @ turns.T
    return getattr(body, "inertia", 0.0) * np.eye(3)


def _closure(scene: Scene, joint: Holding) -> Closure:
    a, b = (scene.body_index(name) for name in (joint.body_a, joint.body_b))
    if isinstance(joint, Distance):
        length = joint.length or float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
        return Closure(joint.name, "rod", a, b, lifted(joint.point_a), lifted(joint.point_b), np.zeros(3), length)
    point = lifted(joint.point)
    shared = "point" if getattr(joint, "axis", None) is None else "hinge"  # planar hinges share a point
    kind = {"revolute": shared, "spherical": "point"}.get(joint.type, joint.type)
    return Closure(joint.name, kind, a, b, point, point, _unit(getattr(joint, "axis", None)), 0.0)


def _unit(axis) -> np.ndarray:
    """Return the direction of unit length in space; zeros where there is none."""
    return np.zeros(3) if axis is None else lifted(axis) / np.linalg.norm(axis)
