"""Deviations of one run from what every right motion keeps, each over the scene's own length, speed or energy."""

import numpy as np
from scipy.interpolate import make_interp_spline

from mbs_ref import Trajectory
from mbs_ref.observables import constraint_residual, energy_balance, kinetic_energy
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_axis_angle, rotation_matrices
from mbs_ref.scene.scales import scales_of

ORDERS = (5, 7)  # degrees of the splines through samples whose slopes are compared: errors of orders 6 and 8
EDGE = 4  # samples at either end whose slopes are one-sided
NORMAL = np.array([0.0, 0.0, 1.0])  # of the plane: what turns in it turns about this axis of space


def slope_misses(scene: Scene, path: Trajectory, roundoff: float) -> tuple[np.ndarray, float]:
    """Return by how much rates miss the slopes of poses (n, k) at inner samples, and how sure slopes are.

    Both are over the largest rate. Places count over the scene's length; angular velocities are compared with the
    slope of the rotation matrices, R' = omega x R. Poses are known to `roundoff`, relative.
    """
    n, length = len(path.times), scales_of(scene).length
    turns = np.array([isinstance(body, PlanarBody | SpatialBody) for body in scene.bodies])
    theta, omega = path.orientation[:, turns], path.angular_velocity[:, turns]
    if scene.dimension == 2:
        theta, omega = from_axis_angle(NORMAL, theta), omega[..., None] * NORMAL
    matrices = rotation_matrices(theta)
    spun = np.cross(omega[..., None, :], np.swapaxes(matrices, -1, -2)).swapaxes(-1, -2)
    pose, rate = (
        np.concatenate([places.reshape(n, -1) / length, turned.reshape(n, -1)], axis=1)
        for places, turned in ((path.position, matrices), (path.velocity, spun))
    )
    interval = path.times[1] - path.times[0]
    rougher, slope = (make_interp_spline(path.times, pose, k)(path.times, 1)[EDGE:-EDGE] for k in ORDERS)
    inner = rate[EDGE:-EDGE]
    fastest = max(float(np.abs(slope).max()), float(np.abs(inner).max())) or 1.0
    rounding = roundoff * float(np.abs(pose).max()) / interval
    return (slope - inner) / fastest, (typical(slope - rougher) + rounding) / fastest


def typical(misses: np.ndarray) -> float:
    """Return the median over samples of the largest miss: samples do not resolve a transient, or an impact's jump."""
    return float(np.median(np.abs(misses).max(axis=1)))


def energy_drift(scene: Scene, path: Trajectory) -> np.ndarray | None:
    """Return E(t) - E(0) - work over the largest kinetic energy (n_t,); None where no balance can be drawn."""
    balance = energy_balance(scene, path)
    if balance.drift is None or balance.resolution > 0.0:  # work is integrated over the samples: too rough here
        return None
    scale = float(kinetic_energy(scene, path).max())
    return balance.drift / scale if scale else None


def joint_gaps(scene: Scene, path: Trajectory) -> np.ndarray | None:
    """Return C (m over the scene's length, rad) at every sample; None where there is no joint."""
    return constraint_residual(scene, path) / scales_of(scene).length if scene.joints else None
