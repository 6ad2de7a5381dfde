"""Static equilibrium: poses near a scene's start in which nothing accelerates, for any scene of joints.

The unknowns are displacements T z along the constraints, T a basis of the rates that the joints allow. With a(q) the
constrained acceleration at rest and T^T da/dq T = V L V^-1, each iteration takes

    z = V (|L| + s)^-1 V^-1 T^T a,    s = max |a| / d,

and projects the poses onto the joints. |L| makes the steps go downhill in the potential energy, so that they end in a
stable pose (saddle-free Newton, Dauphin et al. 2014). The shift s bounds them by about d and vanishes with the residual
(pseudo-transient continuation, Kelley and Keyes 1998). d is halved where a step passes the lowest point along it.

A scene is restated at the end of a motion: bodies, and the points and directions of every part on them.
"""

import math
from typing import Any

import numpy as np

from mbs_ref import scene as parts
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import System
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.base.attached import Attached
from mbs_ref.scene.base.part import Role, fields_of
from mbs_ref.scene.contact import ContactPart, PinOnSprocket
from mbs_ref.simulate.linearised import LARGEST
from mbs_ref.trajectory import Trajectory

DIFFERENCE = 1e-7  # m, rad: half a step of the central differences
LONGEST = 5e-3  # of the scene's length: d at most
SMALLEST = 1e-9  # of that
RESIDUAL = 1e-10  # of gravity, or of the largest acceleration at the start: what counts as rest
HALVED = 0.5  # of the least residual: where an iteration leaves more, rounding is reached
ROUNDED = 1e3  # times this residual remains after every part is restated at its new place
MOST = 1000  # iterations: five lengths of way
OVERSHOT = -0.5  # slope at a step's end over that at its start, below which d is halved


class NoEquilibrium(ValueError):
    """No pose at rest was reached; the message states what remains."""


def at_equilibrium(scene: Scene) -> Scene:
    """Return the scene at rest in a stable static equilibrium near its start, under the loads at t = 0.

    Every part moves with its bodies. NoEquilibrium if none is reached, or if a part is unstrained wherever it starts;
    ValueError for a scene of free particles, or with more than 250 bodies.
    """
    system = compile_scene(scene)
    if not isinstance(system, JointedSystem) or len(scene.bodies) > LARGEST:
        raise ValueError(f"{scene.name}: equilibria are solved for bodies with joints, at most {LARGEST} of them")
    at_rest = _AtRest(system)
    y = system.initial_state()
    y[at_rest.half :] = 0.0
    allowed = RESIDUAL * max(float(np.linalg.norm(scene.gravity)), at_rest.residual(y))
    settled = restated(scene, Trajectory(np.zeros(1), *system.poses(at_rest.solved(y, allowed)[None])))
    again = compile_scene(settled)
    remaining = _AtRest(again).residual(again.initial_state())
    if not remaining <= ROUNDED * allowed:
        raise NoEquilibrium(f"{scene.name}: a part cannot start strained; {remaining:.3g} m/s^2 or rad/s^2 remains")
    return settled


class _AtRest:
    """A scene compiled, at rest and under the loads at t = 0, its contacts closed where they are deep."""

    def __init__(self, system: System) -> None:
        self.system, self.half = system, system.n_positions
        system.set_mode_time(0.0)
        system.start_contacts(0.0, system.initial_state(), False)

    def acceleration(self, y: np.ndarray) -> np.ndarray:
        """Return the derivative of the rates (n_rates,)."""
        return self.system.derivative(0.0, y)[self.half :]

    def residual(self, y: np.ndarray) -> float:
        """Return the largest acceleration, m/s^2 or rad/s^2."""
        return float(np.abs(self.acceleration(y)).max())

    def solved(self, y: np.ndarray, allowed: float) -> np.ndarray:
        """Return a state with accelerations below `allowed` and near rounding; NoEquilibrium if none is reached."""
        longest, best, least = LONGEST * self.system.scales.length, y, np.inf
        distance = longest
        for _ in range(MOST):
            a = self.acceleration(y)
            size = float(np.abs(a).max())
            halved = size <= HALVED * least
            if size < least:
                best, least = y, size
            if least == 0.0 or (least <= allowed and not halved):
                return best
            basis = self._allowed(y)
            values, modes = np.linalg.eig(self._stiffness(y, basis))
            inverse = np.linalg.inv(modes) @ basis.T
            downhill = inverse @ a
            while True:
                step = downhill / (np.abs(values) + size / distance)
                trial = self._displaced(y, np.real(basis @ (modes @ step)))
                self.system.project(0.0, trial)
                slope = np.vdot(step, inverse @ self.acceleration(trial)).real
                if slope >= OVERSHOT * np.vdot(step, downhill).real or distance < SMALLEST * longest:
                    break
                distance *= 0.5
            y, distance = trial, min(longest, 2.0 * distance)
        name = self.system.scene.name
        raise NoEquilibrium(f"{name}: no rest after {MOST} iterations; {least:.3g} m/s^2 or rad/s^2 remains")

    def _allowed(self, y: np.ndarray) -> np.ndarray:
        """Return an orthonormal basis (n_rates, n_free) of the rates along the constraints."""
        rates = len(y) - self.half
        unit = np.eye(rates, len(y), self.half)
        self.system.derivative(0.0, y)
        along = np.array([self.system.along_constraints(x)[self.half :] for x in unit]).T  # a projection
        mixed = np.random.default_rng(0).standard_normal((rates, round(np.trace(along))))
        return np.linalg.qr(along @ mixed)[0]

    def _stiffness(self, y: np.ndarray, basis: np.ndarray) -> np.ndarray:
        """Return T^T da/dq T (n_free, n_free), 1/s^2."""
        shifts = DIFFERENCE * basis.T
        pairs = [[self.acceleration(self._displaced(y, by)) for by in (x, -x)] for x in shifts]
        return basis.T @ np.array([ahead - behind for ahead, behind in pairs]).T / (2.0 * DIFFERENCE)

    def _displaced(self, y: np.ndarray, by: np.ndarray) -> np.ndarray:
        """Return the state at rest, displaced by rates times 1 s."""
        near = y.copy()
        near[self.half :] = by
        near[: self.half] += self.system.derivative(0.0, near)[: self.half]
        near[self.half :] = 0.0
        return near


def restated(scene: Scene, path: Trajectory, sign: float = 1.0) -> Scene:
    """Return the scene that starts at the last sample of a motion, its velocities times `sign`.

    Springs and bushings keep their strains; contacts have no history, and signals begin new.
    """
    motion = Motion(scene, path)
    bodies = tuple(_body(body, path, k, sign) for k, body in enumerate(scene.bodies))
    kinds = ("joints", "loads", "contacts", "events")
    moved = {kind: tuple(_part(part, motion) for part in getattr(scene, kind)) for kind in kinds}
    return scene.model_copy(update={"bodies": bodies, **moved})


def _body(body: Any, path: Trajectory, k: int, sign: float) -> Any:
    velocity, turning = sign * path.velocity[-1, k], sign * path.angular_velocity[-1, k]
    orientation = path.orientation[-1, k]
    update: dict[str, Any] = {"position": tuple(path.position[-1, k].tolist()), "velocity": tuple(velocity.tolist())}
    if isinstance(body, parts.PlanarBody):
        update |= {"angle": float(orientation), "angular_velocity": float(turning)}
    elif not isinstance(body, parts.PointMass):
        unit = orientation / np.linalg.norm(orientation)
        update |= {"orientation": tuple(unit.tolist()), "angular_velocity": tuple(turning.tolist())}
    return body.model_copy(update=update)


def _part(part: Attached, motion: Motion) -> Attached:
    """Return a joint, load, contact or event with its points and directions on the moved bodies."""
    update: dict[str, Any] = {}
    for name in {*fields_of(type(part), Role.POINT), *fields_of(type(part), Role.DIRECTION)}:
        value = getattr(part, name)
        if value is None or (owner := _owner(part, name)) == GROUND:
            continue
        at = motion.point if name in fields_of(type(part), Role.POINT) else motion.direction
        update[name] = tuple(at(owner, value)[0][-1].tolist())
    return part.model_copy(update=update | _as_strained(part, motion))


def _owner(part: Any, name: str) -> str:
    """Return the body that a point or direction is fixed in; ground where it is the world's."""
    fields = vars(part)
    if "body" in fields:
        turns = name == "axis" and isinstance(part, parts.RollingWheel)
        return part.body if turns or name in ("point", "center") else GROUND
    if name.endswith(("_a", "_b")):
        return fields[f"body{name[-2:]}"]
    bushing = isinstance(part, parts.PointBushing | parts.Bushing)
    first = name == "center" if isinstance(part, ContactPart) else name != "point" or bushing
    return fields["body_a" if first else "body_b"]


def _as_strained(part: Any, motion: Motion) -> dict[str, Any]:
    """Return the fields that count from t = 0, counted from the present start instead."""
    if isinstance(part, parts.SpringDamper | parts.Distance):
        name = "length" if isinstance(part, parts.Distance) else "rest_length"
        return {name: math.dist(part.point_a, part.point_b)} if getattr(part, name) is None else {}
    if isinstance(part, parts.PointBushing | parts.Bushing):
        mark = {"point_b": tuple(motion.point(part.body_b, part.marks[1])[0][-1].tolist())}
        axes = zip(("x_axis_b", "y_axis_b"), part.frames[1].T, strict=False) if isinstance(part, parts.Bushing) else ()
        return mark | {name: tuple(motion.direction(part.body_b, axis)[0][-1].tolist()) for name, axis in axes}
    if isinstance(part, PinOnSprocket) and part.axis is None:
        return {"first_seat": part.first_seat + float(motion.angle(part.body_b)[-1])}
    if not isinstance(part, parts.TorsionSpring):
        return {}
    if part.axis is not None:
        turned = motion.angle_about(part.body_a, part.body_b, part.axis)[0]
        return {"rest_angle": (part.rest_angle or 0.0) - float(turned[-1])}
    if part.rest_angle is not None:
        return {}
    drawn = {body.name: getattr(body, "angle", 0.0) for body in motion.scene.bodies}
    return {"rest_angle": drawn.get(part.body_b, 0.0) - drawn.get(part.body_a, 0.0)}
