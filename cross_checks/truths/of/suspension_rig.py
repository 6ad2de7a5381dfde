"""Truth of a suspension unit on a shaker: M z'' + C z' + K z = k_tire y(t), z from static equilibrium."""

from typing import Any

import numpy as np
from scipy.linalg import expm

from cross_checks.truths.truth import Truth, unturned
from mbs_ref import Scene

ROUNDOFF = 1e-15  # of the largest rise, per radian of the fastest mode


def suspension_rig(scene: Scene, times: np.ndarray) -> Truth:
    """Exponentiate the linear system of z, z', 1, cos(w t) and sin(w t), whose motion that of the post is part of.

    The springs stay in tension or compression along y alone, so that the system is linear exactly.
    """
    loads: Any = {load.name: load for load in scene.loads}
    joints: Any = {joint.name: joint for joint in scene.joints}
    drive = joints["post.y"].motion
    wheel, hull = (scene.bodies[scene.body_index(name)].mass for name in ("wheel", "hull"))
    tire, k, c = loads["tire"].stiffness, loads["bar"].stiffness, loads["bar"].damping
    inverse = np.diag([1.0 / wheel, 1.0 / hull])
    system = np.zeros((7, 7))
    system[:2, 2:4] = np.eye(2)
    system[2:4, :2] = -inverse @ [[tire + k, -k], [-k, k]]
    system[2:4, 2:4] = -inverse @ [[c, -c], [-c, c]]
    system[2, 4:6] = tire / wheel * drive.amplitude * np.array([-1.0, 1.0])  # y = amplitude (cos(w t) - 1)
    system[5:, 5:] = drive.omega * np.array([[0.0, -1.0], [1.0, 0.0]])
    start = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    states = np.array([expm(system * t) @ start for t in times])
    rise = np.column_stack((drive.amplitude * (states[:, 5] - 1.0), states[:, :2]))
    rate = np.column_stack((-drive.amplitude * drive.omega * states[:, 6], states[:, 2:4]))
    position = np.array([body.position for body in scene.bodies]) + np.stack((0.0 * rise, rise), axis=2)
    velocity = np.stack((0.0 * rate, rate), axis=2)
    fastest = float(np.abs(np.linalg.eigvals(system)).max())
    size = ROUNDOFF * float(np.abs(rise).max()) * max(1.0, fastest * times[-1])
    how = "closed form: a linear oscillator of two masses under a harmonic motion of its base"
    still = unturned(position)
    return Truth(
        position, still, size, "exact", how, velocity=velocity, angular_velocity=still,
        rate_uncertainty=np.full(len(times), size * fastest),
    )  # fmt: skip
