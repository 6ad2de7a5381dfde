"""Random mechanisms from a seed: trees and loops, in the plane and in space, with every joint, drive and load.

They are reasonable on purpose: sizes near 1 m, masses 0.1 to 10 kg, speeds near 1 m/s, and no row of C_q within
LEAST_SINGULAR of the others' span unless it repeats them exactly. Extremes have scenes of their own. Loops close
because joints are world points at t = 0; velocities are random, and projected onto the constraints by the judge.
"""

import math
from typing import Any

import numpy as np

from cross_checks.truths.oracle import Moment, augmented, consistent
from mbs_ref import scene as parts
from mbs_ref.scene import GROUND, PointMass, Scene
from mbs_ref.scene.signals import Constant, HalfSine, Harmonic, Polynomial, Table

MOST_BODIES = 50
LEAST_SINGULAR = 1e-3  # of the largest singular value of the mass-scaled C_q, for a loop or drive to be taken
SMOOTH_UNTIL = 0.04  # s: no signal jumps before, so that t = 0 lies in a smooth stretch
DURATION = 0.1  # s


def random_scene(seed: int, most: int = MOST_BODIES) -> Scene:
    """Return the scene of a seed, always the same: 2 or 3 dimensions, 1 to `most` bodies."""
    rng = np.random.default_rng([seed, 7])
    kind = (_Plane, _Space)[int(rng.integers(2))]
    maker = kind(rng, round(math.exp(rng.uniform(0.0, math.log(most)))))
    maker.grow()
    maker.load()
    return consistent(maker.scene(f"random_{seed}"))


class _Maker:
    """Grows a scene part by part; what the plane and space share."""

    dimension: int
    coordinates: tuple[str, ...]  # that a drive may prescribe; of a particle the first ones
    inner: tuple[Any, ...]  # loads between bodies
    outer: tuple[Any, ...]  # loads from nowhere

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        self.rng = rng
        self.count = count
        self.bodies: list[Any] = []
        self.joints: list[Any] = []
        self.loads: list[Any] = []
        self.floats = count > 1 and self.chance(0.15)  # nothing is tied to ground: momentum is conserved
        self.gravity = self.vector(9.81) if self.chance(0.85) else (0.0,) * self.dimension

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def pick(self, *choices: Any) -> Any:
        return choices[int(self.rng.integers(len(choices)))]

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def vector(self, size: float) -> Any:
        """Return a vector of that length in a random direction."""
        direction = self.rng.standard_normal(self.dimension)
        return tuple((size * direction / np.linalg.norm(direction)).tolist())

    def beside(self, point: Any, near: float, far: float) -> Any:
        return tuple(np.add(point, self.vector(self.between(near, far))).tolist())

    def mark(self, name: str) -> Any:
        """Return a place to attach something to a body, or to ground near the scene."""
        body = self.named(name)
        if body is None:
            return self.beside(self.pick(*self.bodies).position, 0.5, 1.0)
        return body.position if isinstance(body, PointMass) else self.beside(body.position, 0.05, 0.3)

    def named(self, name: str) -> Any:
        return next((body for body in self.bodies if body.name == name), None)

    def signal(self, *, jumps: bool) -> Any:
        """Return a signal for a load; those that jump do so within (SMOOTH_UNTIL, 0.06)."""
        smooth = (Constant(value=self.between(-1, 1)), self.wave(1.0), self.polynomial())
        start = self.between(SMOOTH_UNTIL, 0.05)
        table = Table(times=(start, start, start + 0.01), values=(0.0, 1.0, 0.5))
        return self.pick(*smooth, *((HalfSine(peak=1.0, duration=0.01, start=start), table) if jumps else ()))

    def wave(self, size: float) -> Harmonic:
        return Harmonic(amplitude=size * self.between(0.2, 1), omega=self.between(1, 8), phase=self.between(-3, 3))

    def polynomial(self) -> Polynomial:
        return Polynomial(coefficients=tuple(self.rng.uniform(-1, 1, int(self.rng.integers(1, 6))).tolist()))

    def motion(self) -> dict[str, Any]:
        """Return motion and level of a drive; only an acceleration may jump."""
        start = self.between(SMOOTH_UNTIL, 0.05)
        push = HalfSine(peak=self.between(-20, 20), duration=0.01, start=start)
        level = self.pick("position", "velocity", "acceleration")
        smooth = self.pick(self.wave(0.3), self.polynomial())
        return {"motion": push if level == "acceleration" and self.chance(0.3) else smooth, "level": level}

    def grow(self) -> None:
        for k in range(self.count):
            parent = self._parent(k)
            here = self.beside((0.0,) * self.dimension if parent == GROUND else self.named(parent).position, 0.4, 1.0)
            name = f"b{k}"
            self.bodies.append(self.particle(name, here) if k and self.chance(0.08) else self.rigid(name, here))
            if not self.chance(0.08) and not (self.floats and parent == GROUND):
                self.joints += self.tree_joints(parent, name)
        for _ in range(0 if self.floats else int(self.rng.poisson(1.0))):
            self._try(self.drive(self.pick(*self.bodies)))
        for _ in range(int(self.rng.poisson(1.2)) if self.count > 1 else 0):
            self._try(self.closure(*self._pair()))
        if self.chance(0.1):
            self._repeat()

    def _parent(self, k: int) -> str:
        rigid = [body.name for body in self.bodies if not isinstance(body, PointMass)]
        if not rigid or (self.chance(0.1) and not self.floats):
            return GROUND
        return rigid[-1] if self.chance(0.6) else self.pick(*rigid)

    def _pair(self) -> tuple[str, str]:
        first, second = self.rng.choice(self.count, 2, replace=False)
        return (GROUND if self.chance(0.3) and not self.floats else self.bodies[first].name), self.bodies[second].name

    def ends(self, first: str, second: str) -> dict[str, str]:
        first, second = (second, first) if self.chance(0.4) else (first, second)
        return {"body_a": first, "body_b": second}

    def _try(self, joint: Any) -> None:
        """Keep a joint that leaves C_q well away from losing rank."""
        if joint is None:
            return
        kept = self.joints
        self.joints = [*kept, joint]
        system = augmented(Moment.start(self.scene("trial")))
        regular = system.redundant == 0 and system.condition < 1.0 / LEAST_SINGULAR
        self.joints = self.joints if regular else kept

    def _repeat(self) -> None:
        """Add a joint that says what another says already: redundant rows that stay redundant."""
        able = [j for j in self.joints if isinstance(j, parts.Revolute | parts.Weld | parts.Spherical)]
        if able:
            twin = self.pick(*able)
            self.joints.append(self.repeated(twin).model_copy(update={"name": f"j{len(self.joints)}"}))

    def next_name(self) -> str:
        return f"j{len(self.joints)}"

    def load(self) -> None:
        jumps, kinds = self.chance(0.3), self.inner if self.floats else (*self.inner, *self.outer)
        for k in range(int(self.rng.poisson(1.0 + 0.2 * self.count))):
            part = self.pick(*kinds)(f"l{k}", jumps)
            if part is not None:
                self.loads.append(part)

    def spring(self, name: str, jumps: bool) -> Any:
        if self.count < 2:
            return None
        ends = self.ends(*self._pair())
        first, second = self.mark(ends["body_a"]), self.mark(ends["body_b"])
        rest = math.dist(first, second) * self.pick(0.7, 0.9, 1.2)  # never at the kink of tension_only
        return parts.SpringDamper(
            name=name, **ends, point_a=first, point_b=second, rest_length=rest,
            stiffness=self.between(1, 300), damping=self.pick(0.0, self.between(0, 5)), tension_only=self.chance(0.3),
        ) if math.dist(first, second) > 0.2 else None  # fmt: skip

    def force(self, name: str, jumps: bool) -> Any:
        body = self.pick(*self.bodies).name
        vector, frame = self.vector(self.between(1, 20)), self.pick("world", "body")
        at, factor = self.mark(body), self.signal(jumps=jumps)
        return parts.Force(name=name, body=body, point=at, vector=vector, frame=frame, factor=factor)

    def turning(self) -> Any:
        """Return a body that has an orientation."""
        return self.pick(*(body for body in self.bodies if not isinstance(body, PointMass)))

    def scene(self, name: str) -> Scene:
        return Scene(name=name, duration=DURATION, gravity=self.gravity, bodies=tuple(self.bodies),
                     joints=tuple(self.joints), loads=tuple(self.loads))  # fmt: skip

    def particle(self, name: str, here: Any) -> Any:
        return PointMass(name=name, mass=self.mass(), position=here, velocity=self.vector(self.between(0, 2)))

    def mass(self) -> float:
        return math.exp(self.between(math.log(0.1), math.log(10.0)))

    def _rod(self, name: str, ends: dict[str, str]) -> parts.Distance:
        return parts.Distance(name=name, **ends, point_a=self.mark(ends["body_a"]), point_b=self.mark(ends["body_b"]))

    def drive(self, body: Any) -> Any:
        name, at = self.next_name(), self.mark(body.name)
        along = parts.PointDrive(name=name, body=body.name, point=at, direction=self.vector(1.0), **self.motion())
        coordinate = self.pick(*self.coordinates[: self.dimension if isinstance(body, PointMass) else 3])
        return self.pick(
            along, parts.CoordinateDrive(name=name, body=body.name, coordinate=coordinate, **self.motion())
        )


class _Plane(_Maker):
    dimension, coordinates = 2, ("x", "y", "angle")

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        super().__init__(rng, count)
        self.inner = (self.spring, self.torsion_spring, self.point_bushing)
        self.outer = (self.force, self.torque)

    def rigid(self, name: str, here: Any) -> parts.PlanarBody:
        mass = self.mass()
        return parts.PlanarBody(
            name=name, mass=mass, inertia=mass * self.between(0.02, 0.3), position=here, angle=self.between(-7, 7),
            velocity=self.vector(self.between(0, 2)), angular_velocity=self.between(-3, 3),
        )  # fmt: skip

    def tree_joints(self, parent: str, child: str) -> list[Any]:
        ends, name = self.ends(parent, child), self.next_name()
        body = self.named(child)
        if isinstance(body, PointMass):
            return [self.pick(self._pin(name, ends, body.position), self._rod(name, ends))]
        point = self.mark(child)
        kind = self.pick("pin", "pin", "pin", "slide", "weld", "rod")
        if kind == "slide":
            return [parts.Prismatic(name=name, **ends, point=point, axis=self.vector(1.0))]
        if kind == "weld":
            return [parts.Weld(name=name, **ends, point=point)]
        return [self._rod(name, ends) if kind == "rod" else self._pin(name, ends, point)]

    def _pin(self, name: str, ends: dict[str, str], point: Any) -> parts.Revolute:
        return parts.Revolute(name=name, **ends, point=point)

    def closure(self, first: str, second: str) -> Any:
        ends, name = self.ends(first, second), self.next_name()
        if any(isinstance(self.named(end), PointMass) for end in (first, second)):
            return self._rod(name, ends)
        point = self.mark(second)
        slide = parts.Prismatic(name=name, **ends, point=point, axis=self.vector(1.0))
        return self.pick(self._pin(name, ends, point), slide, self._rod(name, ends))

    def repeated(self, joint: Any) -> Any:
        revolute = isinstance(joint, parts.Revolute)
        return joint if revolute else joint.model_copy(update={"point": self.mark(joint.body_b)})

    def torque(self, name: str, jumps: bool) -> parts.Torque:
        body, torque = self.turning().name, self.between(-3, 3)
        return parts.Torque(name=name, body=body, torque=torque, factor=self.signal(jumps=jumps))

    def torsion_spring(self, name: str, jumps: bool) -> Any:
        ends = [] if self.floats else [GROUND]
        ends += [body.name for body in self.bodies if not isinstance(body, PointMass)]
        if len(ends) < 2:
            return None
        a, b = self.rng.choice(len(ends), 2, replace=False)
        return parts.TorsionSpring(name=name, body_a=ends[a], body_b=ends[b], stiffness=self.between(1, 50),
                                   damping=self.pick(0.0, 0.3), rest_angle=self.pick(None, 0.2))  # fmt: skip

    def point_bushing(self, name: str, jumps: bool) -> Any:
        if self.count < 2:
            return None
        a, b = self._pair()
        at = next((x.position for x in (self.named(a), self.named(b)) if isinstance(x, PointMass)), self.mark(b))
        if all(isinstance(self.named(x), PointMass) for x in (a, b)):
            return None
        ends = self.ends(a, b)
        if isinstance(self.named(ends["body_a"]), PointMass):  # which cannot bear the couple
            ends = {"body_a": ends["body_b"], "body_b": ends["body_a"]}
        return parts.PointBushing(name=name, **ends, point=at, stiffness=self.between(1, 300),
                                  damping=self.pick(0.0, self.between(0, 5)))  # fmt: skip


class _Space(_Maker):
    dimension, coordinates = 3, ("x", "y", "z")

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        super().__init__(rng, count)
        self.inner = (self.spring, self.torsion_spring, self.bushing)
        self.outer = (self.force, self.torque_vector)

    def rigid(self, name: str, here: Any) -> parts.SpatialBody:
        mass, theta = self.mass(), self.rng.standard_normal(4)
        cloud = self.rng.standard_normal((5, 3)) * self.rng.uniform(0.05, 0.4, 3)  # m, where equal parts of it are
        second = cloud.T @ cloud / len(cloud)
        inertia = mass * (np.trace(second) * np.eye(3) - second)
        return parts.SpatialBody(
            name=name, mass=mass, position=here, velocity=self.vector(self.between(0, 2)),
            inertia=tuple(float(inertia[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))),
            orientation=tuple((theta / np.linalg.norm(theta)).tolist()),
            angular_velocity=self.vector(self.between(0, 3)),
        )  # fmt: skip

    def across(self, axis: Any) -> Any:
        """Return a vector perpendicular to the axis."""
        return tuple(np.cross(axis, self.vector(1.0)).tolist())

    def tree_joints(self, parent: str, child: str) -> list[Any]:
        ends, name = self.ends(parent, child), self.next_name()
        body = self.named(child)
        if isinstance(body, PointMass):
            return [self.pick(parts.Spherical(name=name, **ends, point=body.position), self._rod(name, ends))]
        point, axis = self.mark(child), self.vector(1.0)
        placed = {"name": name, **ends, "point": point}
        kind = self.pick("ball", "pin", "pin", "cardan", "sleeve", "slide", "weld", "rod", "plane")
        if kind in ("pin", "sleeve"):
            hinge = (parts.Revolute if kind == "pin" else parts.Cylindrical)(**placed, axis=axis)
            if not self.chance(0.12) or self.floats:
                return [hinge]
            driven = parts.RotationDrive(name=f"{name}_turn", **ends, axis=axis, **self.motion())
            return [hinge, driven]
        return [{
            "ball": lambda: parts.Spherical(**placed),
            "cardan": lambda: parts.Universal(**placed, axis_a=axis, axis_b=self.across(axis)),
            "slide": lambda: parts.Prismatic(**placed, axis=axis),
            "weld": lambda: parts.Weld(**placed),
            "rod": lambda: self._rod(name, ends),
            "plane": lambda: parts.PointOnPlane(**placed, normal=axis),
        }[kind]()]  # fmt: skip

    def closure(self, first: str, second: str) -> Any:
        ends, name = self.ends(first, second), self.next_name()
        if any(isinstance(self.named(end), PointMass) for end in (first, second)):
            return self._rod(name, ends)
        placed, axis = {"name": name, **ends, "point": self.mark(second)}, self.vector(1.0)
        return self.pick(
            lambda: parts.Spherical(**placed),
            lambda: self._rod(name, ends),
            lambda: parts.PointOnPlane(**placed, normal=axis),
            lambda: parts.Universal(**placed, axis_a=axis, axis_b=self.across(axis)),
            lambda: parts.Revolute(**placed, axis=axis),
        )()

    def repeated(self, joint: Any) -> Any:
        if not isinstance(joint, parts.Revolute):
            return joint
        return joint.model_copy(update={"point": tuple(np.add(joint.point, np.multiply(0.3, joint.axis)).tolist())})

    def torque_vector(self, name: str, jumps: bool) -> parts.TorqueVector:
        return parts.TorqueVector(name=name, body=self.turning().name, vector=self.vector(self.between(0.1, 3)),
                                  frame=self.pick("world", "body"), factor=self.signal(jumps=jumps))  # fmt: skip

    def torsion_spring(self, name: str, jumps: bool) -> Any:
        hinges = [joint for joint in self.joints if isinstance(joint, parts.Revolute)]
        if not hinges:
            return None
        hinge = self.pick(*hinges)
        return parts.TorsionSpring(name=name, body_a=hinge.body_a, body_b=hinge.body_b, axis=hinge.axis,
                                   stiffness=self.between(1, 50), damping=self.pick(0.0, 0.3),
                                   rest_angle=self.pick(None, 0.2))  # fmt: skip

    def bushing(self, name: str, jumps: bool) -> Any:
        rigid = [body.name for body in self.bodies if not isinstance(body, PointMass)]
        if len(rigid) < 2:
            return None
        a, b = self.rng.choice(len(rigid), 2, replace=False)
        x, other = self.vector(1.0), GROUND if self.chance(0.2) and not self.floats else rigid[a]
        return parts.Bushing(
            name=name, **self.ends(other, rigid[b]), point=self.mark(rigid[b]),
            stiffness=tuple(self.rng.uniform(0, 100, 6).tolist()), x_axis=x, y_axis=self.across(x),
            damping=tuple((self.rng.uniform(0, 2, 6) * self.chance(0.5)).tolist()),
        )  # fmt: skip
