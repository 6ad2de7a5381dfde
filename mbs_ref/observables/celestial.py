"""Energy and momentum of particles under gravity, summed in extended precision: the drifts are that small."""

import itertools

import numpy as np

from mbs_ref.scene import Scene
from mbs_ref.scene.scales import attraction
from mbs_ref.trajectory import Trajectory


def is_newtonian(scene: Scene) -> bool:
    """Return whether Newton's attraction is all that acts."""
    return all(load.type in ("newton", "epoch") for load in scene.loads)


def energy(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return kinetic plus potential energy (n_t,), J; a test particle counts with its own mass, in a fixed field.

    With gm in place of masses the sum is G times the energy; a scene's masses fix G (its heaviest body's gm / m).
    """
    gm = np.array(attraction(scene), dtype=np.longdouble)
    x, v = (part.astype(np.longdouble) for part in (trajectory.position, trajectory.velocity))
    constant = _constant(scene, gm)
    weight = np.where(gm > 0.0, gm, constant * np.array([body.mass for body in scene.bodies], dtype=np.longdouble))
    total = 0.5 * np.sum(v**2, axis=2) @ weight
    for i, j in itertools.combinations(range(len(gm)), 2):
        product = max(weight[i] * gm[j], weight[j] * gm[i])
        if product > 0.0:
            total = total - product / np.sqrt(np.sum((x[:, i] - x[:, j]) ** 2, axis=1))
    total = total - constant * (x @ np.asarray(scene.gravity)) @ (weight / constant)
    return total / constant


def drift(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return E(t) - E(0) (n_t,), J."""
    every = energy(scene, trajectory)
    return (every - every[0]).astype(float)


def momentum_drift(scene: Scene, trajectory: Trajectory) -> np.ndarray | None:
    """Return the largest drift of momentum, kg m/s and kg m^2/s, (n_t,); None where it is not conserved."""
    gm = np.array(attraction(scene), dtype=np.longdouble)
    if not is_newtonian(scene) or np.any(gm == 0.0) or any(scene.gravity):
        return None
    mass = gm / _constant(scene, gm)
    x, v = (part.astype(np.longdouble) for part in (trajectory.position, trajectory.velocity))
    linear, angular = np.einsum("k,tkd->td", mass, v), np.einsum("k,tkd->td", mass, np.cross(x, v))
    moved = [np.max(np.abs(part - part[0]), axis=1) for part in (linear, angular)]
    return np.maximum(*moved).astype(float)


def _constant(scene: Scene, gm: np.ndarray) -> np.longdouble:
    k = int(np.argmax(gm))
    return gm[k] / np.longdouble(scene.bodies[k].mass) if gm[k] > 0.0 else np.longdouble(1.0)
