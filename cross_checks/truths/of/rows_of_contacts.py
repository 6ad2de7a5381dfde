"""Truths of bodies in a row that touch each other: cradles, walls and stacks."""

from typing import Any

import numpy as np
from scipy.linalg import expm

from cross_checks.truths.made_by.mechanisms.unilateral import Unilateral, line_motion, line_of, one_sided
from cross_checks.truths.truth import NoTruth, Truth, unturned
from mbs_ref.scene import Scene
from mbs_ref.scenes.stacks import BOX_HEIGHT as HEIGHT


def newtons_cradle(scene: Scene, times: np.ndarray) -> Truth:
    """One coordinate a ball."""
    n, contacts = len(scene.bodies), []
    for k, contact in enumerate(scene.contacts):
        row = tuple(float(j == k + 1) - float(j == k) for j in range(n))
        reach = contact.radius_a + contact.radius_b  # type: ignore[union-attr]
        contacts.append(one_sided(contact.law, row, reach))
    how = "one-sided contacts on a line, matrix exponentials between instants located to roundoff"
    return _on_line(scene, times, 0, contacts, how)


def _on_line(scene: Scene, times: np.ndarray, axis: int, contacts: list[Unilateral], how: str) -> Truth:
    """Return the truth of planar bodies that move along one axis and do not turn."""
    along, uncertainty = line_motion(line_of(scene, axis, contacts), times)
    position = np.zeros((*along.shape, 2))
    position[..., axis] = along
    return Truth(position, np.zeros_like(along), uncertainty, "exact", how)


def disc_between_walls(scene: Scene, times: np.ndarray) -> Truth:
    """One coordinate."""
    walls: Any = zip(scene.contacts, (1.0, -1.0), strict=True)
    contacts = [one_sided(wall.law, (sign,), sign * wall.point_1[0] + wall.radius) for wall, sign in walls]
    how = "free flight and half oscillations, matrix exponentials between instants located to roundoff"
    return _on_line(scene, times, 0, contacts, how)


def box_stack(scene: Scene, times: np.ndarray) -> Truth:
    """Heights of the boxes."""
    n = len(scene.bodies)
    rows = [tuple(float(j == k) - float(j == k - 1) for j in range(n)) for k in range(n)]
    law = scene.contacts[0].law
    contacts = [one_sided(law, row, HEIGHT if k else 0.5 * HEIGHT, parallel=2.0) for k, row in enumerate(rows)]
    how = "upright by symmetry: one-sided spring-dampers on a line, matrix exponentials between located instants"
    return _on_line(scene, times, 1, contacts, how)


UNCERTAINTY = 1e-12  # m, of the matrix exponential at these sinks
LOOKS = 400  # times at which the corners are asked whether they still push


def block_stack(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """y = (heights above the start, rates) obeys y' = A y + b."""
    law: Any = scene.contacts[0].law
    mass = np.array([body.mass for body in scene.bodies])
    n = len(mass)
    below = np.eye(n) - np.eye(n, k=-1)  # compression d = -below z
    stiff, damp = 4.0 * law.stiffness * below.T @ below, 4.0 * law.damping * below.T @ below
    matrix = np.zeros((2 * n + 1, 2 * n + 1))
    matrix[:n, n : 2 * n] = np.eye(n)
    matrix[n : 2 * n, :n] = -stiff / mass[:, None]
    matrix[n : 2 * n, n : 2 * n] = -damp / mass[:, None]
    matrix[n : 2 * n, -1] = scene.gravity[2]
    start = np.append(np.zeros(2 * n), 1.0)
    looks = np.concatenate((np.geomspace(1e-6, 1.0, LOOKS) * max(float(times[-1]), 1e-6), times[times > 0.0]))
    seen = np.array([expm(matrix * t) @ start for t in looks])
    push = -(law.stiffness * seen[:, :n] + law.damping * seen[:, n : 2 * n]) @ below.T
    if not np.all(push > 0.0):
        return NoTruth("a corner loses contact while the stack settles; the linear motion holds while all push")
    sunk = np.array([(expm(matrix * t) @ start)[:n] for t in times])
    position = np.array([body.position for body in scene.bodies])[None] + sunk[:, :, None] * np.array([0.0, 0.0, 1.0])
    how = "the linear motion of masses on springs, matrix exponential"
    return Truth(position, unturned(position), UNCERTAINTY, "exact", how)
