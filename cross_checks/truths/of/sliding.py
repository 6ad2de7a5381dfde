"""Truths of bodies that slide, rest or roll under Coulomb's friction."""

from typing import Any

import numpy as np

from cross_checks.truths.made_by.numerics.solvers import extrapolate
from cross_checks.truths.truth import NoTruth, OutsideDomainError, Truth, of_one_body
from mbs_ref import Scene
from mbs_ref.scene.euler_parameters import from_axis_angle, parameter_matrix, product

BLOCK_ROUNDOFF = 1e-13  # m, of the equilibrium of the sunk corners


def require_both_corners(scene: Scene) -> None:
    """Raise OutsideDomainError where a corner does not push at the start: the block topples about the other one.

    On hard ground that is where friction over normal force, min(tan(angle), mu), exceeds length over height.
    """
    corners: Any = scene.contacts[:2]  # the lower ones
    if not all(corner.center[1] < 0.0 for corner in corners):
        raise OutsideDomainError("the block topples: the closed form holds while both of its corners push")


def incline(scene: Scene, times: np.ndarray) -> Truth:
    """x = (g sin - mu g cos) t^2 / 2, or rest."""
    require_both_corners(scene)
    block: Any = scene.bodies[0]
    friction: Any = scene.contacts[0].friction
    pull = scene.gravity[0] + friction.coefficient * scene.gravity[1]
    x = block.position[0] + 0.5 * max(pull, 0.0) * times**2
    how = "closed form: rest within the angle of friction, uniform sliding beyond it"
    return of_one_body(x, np.full_like(times, block.position[1]), block.angle, BLOCK_ROUNDOFF, how)


def sliding_block(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """x = v t - mu g t^2 / 2 until t = v / (mu g)."""
    require_both_corners(scene)
    block: Any = scene.bodies[0]
    friction: Any = scene.contacts[0].friction
    slowing = friction.coefficient * -scene.gravity[1]
    stops = block.velocity[0] / slowing if slowing > 0.0 else np.inf
    if scene.parameters["height"] and times[-1] > stops:
        return NoTruth("as it stops, a block of some height tips back on corners whose friction is not unique")
    under_way = np.minimum(times, stops)
    x = block.position[0] + block.velocity[0] * under_way - 0.5 * slowing * under_way**2
    how = "closed form: uniform slowing by Coulomb's friction, then rest"
    return of_one_body(x, np.full_like(times, block.position[1]), block.angle, BLOCK_ROUNDOFF, how)


DISC_ROUNDOFF = 1e-14  # m


def rolling_disc(scene: Scene, times: np.ndarray) -> Truth:
    """u = u0 - mu g t and r w = -(m r^2/I) mu g t until u + r w = 0; then both stay."""
    disc: Any = scene.bodies[0]
    ground: Any = scene.contacts[0]
    slowing = ground.friction.coefficient * -scene.gravity[1]
    ratio = disc.mass * ground.radius**2 / disc.inertia
    rolls = disc.velocity[0] / (slowing * (1.0 + ratio))
    sliding = np.minimum(times, rolls)
    lost = slowing * sliding  # m/s
    way = 0.5 * slowing * sliding**2 + lost * (times - sliding)
    x = disc.position[0] + disc.velocity[0] * times - way
    angle = disc.angle - ratio / ground.radius * way
    how = "closed form: uniform slowing by friction on the sunk disc, then rolling"
    return of_one_body(x, np.full_like(times, disc.position[1]), angle, DISC_ROUNDOFF, how)


UP = np.array([0.0, 0.0, 1.0])
UNCERTAINTY = 1e-13  # m, of elementary functions and of the extrapolated orientation


def stop_of_slip(scene: Scene) -> tuple[float, np.ndarray, np.ndarray]:
    """Return when sliding ends (s), how far the centre has come (m) and its velocity from then on (m/s).

    u' = -7/2 mu g u/|u|, so it ends at 2 |u0| / (7 mu g) with v = v0 - 2/7 u0; without spin 12 v0^2 / (49 mu g) on.
    """
    ball: Any = scene.bodies[0]
    speed, direction, pull = _slip(scene)
    end = 2.0 * speed / (7.0 * pull)
    start = np.array(ball.velocity)
    return end, start * end - 0.5 * pull * direction * end**2, start - 2.0 / 7.0 * speed * direction


def rolling_sphere(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Positions by closed form; the orientation turns about a fixed axis, or with spin by extrapolation."""
    ball: Any = scene.bodies[0]
    _, direction, pull = _slip(scene)
    end, path, final = stop_of_slip(scene)
    since = np.minimum(times, end)[:, None]
    sliding = np.array(ball.velocity) * since - 0.5 * pull * direction * since**2
    rolling = final * np.maximum(times - end, 0.0)[:, None]
    position = np.array(ball.position) + np.where(times[:, None] <= end, sliding, path + rolling)
    return Truth(position[:, None], _orientation(scene, times, end)[:, None], UNCERTAINTY, "exact",
                 "uniform acceleration against the slip velocity, then uniform motion")  # fmt: skip


def _slip(scene: Scene) -> tuple[float, np.ndarray, float]:
    """Return the first slip speed (m/s), its direction (3,), and mu g (m/s^2)."""
    ball: Any = scene.bodies[0]
    contact: Any = scene.contacts[0]
    slip = np.array(ball.velocity) - contact.radius * np.cross(ball.angular_velocity, UP)
    speed = float(np.linalg.norm(slip))
    return speed, slip / speed, contact.friction.coefficient * -scene.gravity[2]


def _orientation(scene: Scene, times: np.ndarray, end: float) -> np.ndarray:
    """Return theta (n_t, 4): omega' = 5 mu g / (2 r) n x u/|u| while it slides."""
    ball: Any = scene.bodies[0]
    contact: Any = scene.contacts[0]
    _, direction, pull = _slip(scene)
    spin, gain = np.array(ball.angular_velocity), 2.5 * pull / contact.radius * np.cross(UP, direction)
    grid = np.unique(np.concatenate(([0.0, end], times[times < end])))

    def rate(t: float, theta: np.ndarray) -> np.ndarray:
        return 0.5 * parameter_matrix(theta).T @ (spin + gain * t)

    slid = extrapolate(rate, np.array([1.0, 0.0, 0.0, 0.0]), grid, 1e-15)
    final = spin + gain * end
    rolled = product(from_axis_angle(final, np.linalg.norm(final) * np.maximum(times - end, 0.0)), slid[-1])
    return np.where(times[:, None] < end, slid[np.searchsorted(grid, np.minimum(times, end))], rolled)
