"""A scene as links in space, planar or not, for engines of minimal coordinates that know space alone.

Every joint's frame stands along the world's axes at t = 0, where all coordinates are zero. A planar body gets the
same moment of inertia about all axes, so that nothing turns it out of the plane.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cross_checks.workshop.method import Refusal
from cross_checks.workshop.planar_forces import CLIPPED_CONTACTS, AppliedForces
from cross_checks.workshop.planar_tree import JointTree, joint_tree
from cross_checks.workshop.spatial_forces import SpatialApplied
from cross_checks.workshop.spatial_tree import SpatialEdge, SpatialTree, depth_first, spatial_tree
from mbs_ref.scene import Distance, PlanarBody, Revolute, Scene, SpatialBody, symmetric
from mbs_ref.scene.euler_parameters import from_matrix, product

PARTS = frozenset(  # what links and the shared forces make up together
    {"planar", "point_mass", "revolute", "prismatic", "weld", "distance"}
    | {"spatial", "spherical", "universal"}
    | {"force", "torque", "spring_damper", "torsion_spring", "point_bushing"}
    | {"torque_vector", "bushing"}
    | CLIPPED_CONTACTS
)
NORMAL = np.array([0.0, 0.0, 1.0])  # of the plane
NO_TURN = np.zeros((3, 3))


@dataclass(frozen=True)
class Link:
    """One body with the joint that hangs it on its parent, which comes before it."""

    name: str
    body: int
    parent: int  # FIXED for ground
    kind: str  # revolute, prismatic, cylindrical, universal, ball, planar, weld, free
    origin: np.ndarray  # (3,) m, the joint in the world at t = 0
    axes: np.ndarray  # (0, 1 or 2; 3) unit, world at t = 0: the joint's, or where it slides and then turns
    mass: float  # kg
    centre: np.ndarray  # (3,) m, the centre of mass from the origin
    inertia: np.ndarray  # (3, 3) kg m^2 about the centre of mass, world axes at t = 0
    rates: np.ndarray  # of the coordinates at t = 0; free: velocity, then angular velocity; planar: x, y, turn
    of_tree: int = 0  # how many of them a planar tree has: a particle that slides has no turn


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


@dataclass(frozen=True)
class Linkage:
    """A scene's links, each after its parent, and what closes its loops."""

    scene: Scene
    tree: JointTree | SpatialTree
    links: tuple[Link, ...]
    closures: tuple[Closure, ...]

    @property
    def gravity(self) -> np.ndarray:  # (3,) m/s^2
        return _lifted(self.scene.gravity)

    def origin(self, body: int) -> np.ndarray:
        """Return where the frame of a body's link is at t = 0, (3,) m; ground's is the world's."""
        return next((link.origin for link in self.links if link.body == body), np.zeros(3))


def _lifted(vector) -> np.ndarray:
    return np.resize((*vector, 0.0), 3).astype(float)


def linkage_of(scene: Scene) -> Linkage:
    """Return the scene as links."""
    tree = joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)
    links = _planar_links(tree) if isinstance(tree, JointTree) else map(_Spatial(tree).link, depth_first(tree))
    return Linkage(scene, tree, tuple(links), tuple(_closure(scene, joint) for joint in tree.closures))


def closure_refusals(engine: str, scene: Scene, known: set[str]) -> list[Refusal]:
    """Return which joints close a loop in a way that the engine is not taught."""
    tree = joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)
    closed = (_closure(scene, joint) for joint in tree.closures)
    sentence = "closes a loop as {}, which {} is not yet taught"
    return [
        Refusal(f"joint {c.name!r} " + sentence.format(c.kind, engine), False) for c in closed if c.kind not in known
    ]


PLANAR_KINDS = {"free": "planar", "free_point": "planar"}


def _planar_links(tree: JointTree) -> Iterator[Link]:
    rates = tree.rates()
    for edge in tree.edges:
        body = tree.scene.bodies[edge.body]
        kind = PLANAR_KINDS.get(edge.kind, edge.kind)
        slides = edge.kind == "free_point"  # it never turns, so any inertia will do
        moment = body.inertia if isinstance(body, PlanarBody) else float(slides) * body.mass
        axes = {"prismatic": [_lifted(edge.axis)], "revolute": [NORMAL]}.get(kind, [])
        yield Link(
            body.name, edge.body, edge.parent, kind, _lifted(edge.point), np.array(axes).reshape(-1, 3), body.mass,
            _lifted(tree.position[edge.body] - edge.point), moment * np.eye(3),
            np.array([*rates[edge.start : edge.start + edge.size], *([0.0] if slides else [])]), edge.size,
        )  # fmt: skip


@dataclass(frozen=True)
class _Spatial:
    tree: SpatialTree

    def link(self, edge: SpatialEdge) -> Link:
        tree, joint = self.tree, edge.joint
        body = tree.scene.bodies[edge.body]
        origin = np.array(body.position if joint is None else joint.point, dtype=float)
        kind, axes = self._kind(body, joint)
        turns = tree.axes(edge.body)
        inertia = turns @ symmetric(body.inertia) @ turns.T if isinstance(body, SpatialBody) else NO_TURN
        if kind == "free" and not isinstance(body, SpatialBody):
            inertia = body.mass * np.eye(3)  # it never turns, so any inertia will do
        sliding = tree.velocity(edge.body, origin) - tree.velocity(edge.parent, origin)
        turning = tree.relative_spin(edge)
        rates = {
            "free": lambda: [*sliding, *turning], "ball": lambda: turning, "weld": lambda: [],
            "prismatic": lambda: axes @ sliding, "cylindrical": lambda: [axes[0] @ sliding, axes[1] @ turning],
        }.get(kind, lambda: axes @ turning)()  # fmt: skip
        return Link(body.name, edge.body, edge.parent, kind, origin, axes, body.mass,
                    np.array(body.position) - origin, inertia, np.array(rates, dtype=float))  # fmt: skip

    def _kind(self, body, joint) -> tuple[str, np.ndarray]:
        """Return the kind and the axes; a particle on a ball joint stays where it is."""
        if joint is None:
            return "free", np.zeros((0, 3))
        if joint.type == "universal":
            axes = [joint.axis_a, joint.axis_b] if body.name == joint.body_b else [joint.axis_b, joint.axis_a]
        else:
            axes = {"cylindrical": 2, "revolute": 1, "prismatic": 1}.get(joint.type, 0) * [getattr(joint, "axis", None)]
        particle = not isinstance(body, SpatialBody)
        kind = {"spherical": "weld" if particle else "ball"}.get(joint.type, joint.type)
        return kind, np.array([_unit(axis) for axis in axes]).reshape(-1, 3)


def _closure(scene: Scene, joint: Any) -> Closure:
    a, b = (scene.body_index(name) for name in (joint.body_a, joint.body_b))
    if isinstance(joint, Distance):
        length = joint.length or float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
        return Closure(joint.name, "rod", a, b, _lifted(joint.point_a), _lifted(joint.point_b), np.zeros(3), length)
    axis = _unit(getattr(joint, "axis", None))
    point = _lifted(joint.point)
    shared = "hinge" if isinstance(joint, Revolute) and scene.dimension == 3 else "point"
    kind = {"revolute": shared, "spherical": "point"}.get(joint.type, joint.type)
    return Closure(joint.name, kind, a, b, point, point, axis, 0.0)


def _unit(axis) -> np.ndarray:
    """Return the direction of unit length; none where there is none."""
    return np.zeros(3) if axis is None else np.resize((*axis, 0.0), 3) / np.linalg.norm(axis)


class Reader(Protocol):
    """What an engine's state says of the links, in the scene's order of bodies."""

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return coordinates and rates of a planar tree, each (n_q,)."""
        ...

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return turns since t = 0 (n, 3, 3), centres of mass (n, 3), their velocities, and angular velocities."""
        ...


def poses_of(
    linkage: Linkage, reader: Reader, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return world poses and velocities; angles in the plane add up along the tree, beyond one turn."""
    turn, position, velocity, omega = (
        np.array(part) for part in zip(*(_copied(reader.frames(state)) for state in states), strict=True)
    )
    if isinstance(linkage.tree, JointTree):
        q, v = (np.array(part) for part in zip(*(reader.coordinates(state) for state in states), strict=True))
        _, angle, _, rate = linkage.tree.poses(q, v)
        return position[..., :2], angle, velocity[..., :2], rate
    theta = np.array([_orientations(linkage, of_sample) for of_sample in turn])
    rigid = np.array([isinstance(body, SpatialBody) for body in linkage.scene.bodies], dtype=float)
    return position, theta, velocity, omega * rigid[:, None]


def _copied(parts):
    return tuple(np.array(part) for part in parts)


def _orientations(linkage: Linkage, turn: np.ndarray) -> np.ndarray:
    """Return Euler parameters (n, 4) of the turns since t = 0 (n, 3, 3); particles have none."""
    theta = np.tile([1.0, 0.0, 0.0, 0.0], (len(turn), 1))
    for k, body in enumerate(linkage.scene.bodies):
        if isinstance(body, SpatialBody):
            theta[k] = (
                product(from_matrix(turn[k]), np.array(body.orientation)) if np.isfinite(turn[k]).all() else np.nan
            )
    return theta


class Applied:
    """Force and torque of all loads, contacts and gravity on the bodies, by the shared force code."""

    def __init__(self, linkage: Linkage) -> None:
        tree = linkage.tree
        self.linkage = linkage
        self.forces = AppliedForces(tree) if isinstance(tree, JointTree) else SpatialApplied(linkage.scene)

    def wrenches(self, t: float, reader: Reader, state: np.ndarray) -> np.ndarray:
        """Return force (N) and torque about the centre of mass (N m), (n_bodies, 6), world axes."""
        if isinstance(self.forces, SpatialApplied):
            turn, position, velocity, omega = reader.frames(state)
            return self.forces.on_bodies(t, position, _orientations(self.linkage, turn), velocity, omega)
        planar = self.forces.on_bodies(t, *reader.coordinates(state))
        wrench = np.zeros((len(planar), 6))
        wrench[:, [0, 1, 5]] = planar
        return wrench


def applied(linkage: Linkage) -> Applied | None:
    """Return what acts besides gravity, gravity included; None where gravity is all."""
    return Applied(linkage) if linkage.scene.loads or linkage.scene.contacts else None
