"""Static equilibrium: poses near a scene's start in which nothing accelerates, for any scene of joints.

The unknowns are displacements T z along the constraints, T a basis of the rates that the joints allow. With a(q) the
constrained acceleration at rest and T^T da/dq T = V L V^-1, each iteration takes

    z = V (|L| + s)^-1 V^-1 T^T a,    s = max |a| / d,

and projects the poses onto the joints. |L| makes the steps go downhill in the potential energy, so that they end in a
stable pose (saddle-free Newton, Dauphin et al. 2014). The shift s bounds them by about d and vanishes with the residual
(pseudo-transient continuation, Kelley and Keyes 1998). d is halved where a step passes the lowest point along it.
"""

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.simulate.linearised.stiffness import LARGEST
from mbs_ref.simulate.start.restated import restated
from mbs_ref.trajectory import Trajectory

DIFFERENCE = 1e-7  # m, rad: half a step of the central differences
LONGEST = 5e-3  # of the scene's length: d at most
SMALLEST = 1e-9  # of that
RESIDUAL = 1e-10  # of gravity, or of the largest acceleration at the start: what counts as rest
ROUNDED = 1e3  # times this residual remains after every part is restated at its new place
MOST = 1000  # iterations: five lengths of way
OVERSHOT = -0.5  # slope at a step's end over that at its start, below which d is halved


class NoEquilibrium(ValueError):
    """No pose at rest was reached; the message states what remains."""


def at_equilibrium(scene: Scene) -> Scene:
    """Return the scene at rest in a stable static equilibrium near its start, under the loads at t = 0.

    Every part moves with its bodies. NoEquilibrium if none is reached, or if a part is unstrained wherever it starts,
    as a bushing is; ValueError for a scene without joints, or with more than 250 bodies.
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
        """Return a state without accelerations above `allowed`; NoEquilibrium if none is reached."""
        longest = distance = LONGEST * self.system.scales.length
        for _ in range(MOST):
            a = self.acceleration(y)
            size = float(np.abs(a).max())
            if size <= allowed:
                return y
            basis = self._allowed(y)
            values, modes = np.linalg.eig(self._stiffness(y, basis))
            inverse = np.linalg.inv(modes) @ basis.T
            downhill = inverse @ a
            while True:
                step = downhill / (np.abs(values) + size / distance)
                trial = self._displaced(y, np.real(basis @ (modes @ step)))
                self.system.project(0.0, trial)
                slope = np.vdot(step, inverse @ self.acceleration(trial)).real / np.vdot(step, downhill).real
                if slope > OVERSHOT or distance < SMALLEST * longest:
                    break
                distance *= 0.5
            y, distance = trial, min(longest, 2.0 * distance)
        name = self.system.scene.name
        raise NoEquilibrium(f"{name}: no rest after {MOST} iterations; {size:.3g} m/s^2 or rad/s^2 remains")

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
