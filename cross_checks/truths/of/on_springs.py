"""Truths of mechanisms on springs: a suspension unit on a shaker, and the stiff flyball governor.

The unit: M z'' + C z' + K z = k_tire y(t), z from static equilibrium.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy

from cross_checks.truths.made_by import Formulation, agree
from cross_checks.truths.truth import Truth, unturned
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_axis_angle, product

ROUNDOFF = 1e-15  # of the largest rise, per radian of the fastest mode


def suspension_rig(scene: Scene, times: np.ndarray) -> Truth:
    """M z'' + C z' + K z = k_tire y(t): exponentiate the linear system of z, z', 1, and the motion of the post.

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
    states = np.array([scipy.linalg.expm(system * t) @ start for t in times])
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


LENGTH, OFFSET = 1.0, 0.05  # m, of the governor's shaft and rods; from its axis to the rods' hinges
HALF = 0.5 * LENGTH  # m, from the hinge to the coupler
DROOP = np.radians(30.0)  # rad, of the rods below the horizontal at the start
REST, SLIDER_HEIGHT = 0.5, 0.5  # m, of the couplers and at the start


def flyball_governor(scene: Scene, times: np.ndarray) -> Truth:
    """Turned by half a turn the governor is itself: both arms droop alike. Two unlike sets of coordinates."""
    governor = _governor(scene)
    first = "Lagrange's in slider height and arm angle by LSODA"
    ways = first, "Hamilton's equations in coupler length and arm angle by Radau IIA"
    both = _heights(governor), _lengths(governor)
    return agree(*both, times, ways, extended=False, is_stiff=True, is_costly=True)


class Governor(NamedTuple):
    """Shaft, slider, arms with their balls, and couplers; a is the arms' droop below the horizontal."""

    arm: float  # kg
    reach: float  # m, from the hinge to the arm's centre
    axial: float  # kg m^2
    across: float  # kg m^2, about the centre
    still: float  # kg m^2, shaft and slider about the vertical
    slider: float  # kg
    stiffness: float  # N/m
    damping: float  # N s/m
    spin: float  # rad/s at t = 0
    gravity: float  # m/s^2

    def poses(self, z: float, a: float, psi: float) -> tuple[np.ndarray, np.ndarray]:
        """Return centres (4, 3) and Euler parameters (4, 4) of shaft, slider, left and right arm."""
        turned = from_axis_angle((0.0, 0.0, 1.0), psi)
        out, up = OFFSET + self.reach * np.cos(a), LENGTH - self.reach * np.sin(a)
        where = np.array([np.cos(psi), np.sin(psi), 0.0])
        top = np.array([0.0, 0.0, 1.0])
        arms = [product(turned, from_axis_angle((0.0, 1.0, 0.0), angle)) for angle in (np.pi - a, a)]
        places = [0.5 * LENGTH * top, z * top, -out * where + up * top, out * where + up * top]
        return np.array(places), np.array([turned, turned, *arms])


@strict_jit
def _vertical(g, a):
    """Return the whole's inertia about the vertical and its slope by a."""
    c, s, out = np.cos(a), np.sin(a), OFFSET + g.reach * np.cos(a)
    size = g.still + 2.0 * (g.arm * out**2 + g.axial * s**2 + g.across * c**2)
    return size, 4.0 * (-g.arm * out * g.reach * s + (g.axial - g.across) * s * c)


@strict_jit
def _arms(g, a):
    """Return the turn (rad/s), what it and gravity do on the arms (N m), and the arms' inertia about their hinges."""
    size, slope = _vertical(g, a)
    turning = g.spin * _vertical(g, DROOP)[0] / size
    fling = 0.5 * turning**2 * slope + 2.0 * g.arm * g.gravity * g.reach * np.cos(a)
    return turning, fling, 2.0 * (g.arm * g.reach**2 + g.across)


def _governor(scene: Scene) -> Governor:
    shaft, slider, arm = (body for body in scene.bodies[:3] if isinstance(body, SpatialBody))
    given = {key: float(scene.parameters[key]) for key in ("stiffness", "damping", "spin", "gravity")}
    reach = float(np.hypot(abs(arm.position[0]) - OFFSET, LENGTH - arm.position[2]))
    still = shaft.inertia[2] + slider.inertia[2]
    return Governor(arm.mass, reach, arm.inertia[0], arm.inertia[1], still, slider.mass, **given)


def _heights(g: Governor) -> Formulation:
    """Return the equations of y = (z, a, z', a', psi): forces on the slider and moments on the arms."""
    start = np.array([SLIDER_HEIGHT, DROOP, 0.0, 0.0, 0.0])
    return Formulation(lambda t, y: _height_slope(g, y), start, lambda t, y: g.poses(y[0], y[1], y[4]))


@strict_jit
def _height_slope(g, y):
    z, a, dz, da, _ = y
    run, rise = HALF * np.cos(a), LENGTH - HALF * np.sin(a) - z  # of a coupler, from slider to arm
    length = np.hypot(run, rise)
    by_a, by_z = (-run * HALF * np.sin(a) - rise * HALF * np.cos(a)) / length, -rise / length
    pull = 2.0 * (g.stiffness * (length - REST) + g.damping * (by_a * da + by_z * dz))
    turning, fling, swing = _arms(g, a)
    return np.array([dz, da, -g.gravity - pull * by_z / g.slider, (fling - pull * by_a) / swing, turning])


def _lengths(g: Governor) -> Formulation:
    """y = (l, a, p_l, p_a, psi): z = LENGTH - HALF sin(a) - sqrt(l^2 - HALF^2 cos(a)^2)."""
    start = np.array([REST, DROOP, 0.0, 0.0, 0.0])
    return Formulation(
        lambda t, y: _length_slope(g, y), start,
        lambda t, y: g.poses(LENGTH - HALF * np.sin(y[1]) - _rise(y[0], y[1]), y[1], y[4]),
    )  # fmt: skip


@strict_jit
def _rise(length, a):
    return np.sqrt(length**2 - (HALF * np.cos(a)) ** 2)


@strict_jit
def _length_slope(g, y):
    length, a, p, q, _ = y
    rise, cs = _rise(length, a), HALF**2 * np.cos(a) * np.sin(a)
    u, w = -length / rise, -HALF * np.cos(a) - cs / rise  # z' = u l' + w a'
    turning, fling, swing = _arms(g, a)
    speed = p / (g.slider * u)  # of the slider
    da = (q - w * p / u) / swing
    dl = (speed - w * da) / u
    du = -dl / rise + length * (length * dl + cs * da) / rise**3
    slope = HALF * np.sin(a) - HALF**2 * np.cos(2.0 * a) / rise
    dw = slope * da + cs * (length * dl + cs * da) / rise**3
    # d/dt(m z' u) = m z' u' - dV/dl - coupler; d/dt(m z' w + I a') = m z' w' - dV/da + the arms'
    push = g.slider * speed
    dp = push * du - g.slider * g.gravity * u - 2.0 * (g.stiffness * (length - REST) + g.damping * dl)
    dq = push * dw - g.slider * g.gravity * w + fling
    return np.array([dl, da, dp, dq, turning])
