"""Beams of segments against closed forms and a floating frame with given modes, and this against published digits."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, PointBushing, Scene, SpatialBody, TorsionSpring
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.equilibrium import at_equilibrium

LENGTH, AXIAL, BENDING, DENSITY, RATE = 10.0, 2.8e7, 1.4e4, 1.2, 6.0  # m, N, N m^2, kg/m, rad/s: Simo and Vu-Quoc


@cache
def spin_up(segments: int, end: float) -> np.ndarray:
    """Return time (s), stretch and deflection (m) of the tip as the root sees them (3, n_t)."""
    times = np.linspace(0.0, end, round(10.0 * end) + 1)
    scene = scenes.make("spin_up_beam", segments=segments)
    path = simulate(scene, Settings(method="dop853", rtol=1e-6, estimate="off", reactions=False), times)
    assert path.ok
    root, last = path.orientation[:, 0], path.orientation[:, -1]
    tip = path.position[:, -1] + 0.5 * LENGTH / segments * np.stack([np.cos(last), np.sin(last)], axis=1)
    along = np.cos(root) * tip[:, 0] + np.sin(root) * tip[:, 1]
    return np.stack([times, along - LENGTH, np.cos(root) * tip[:, 1] - np.sin(root) * tip[:, 0]])


def modal_lag(times: np.ndarray) -> np.ndarray:
    """Return the tip's deflection (m) by a floating frame with five modes, stiffened as Kane, Ryan and Banerjee do.

    w'' with the stiffness of bending, and of the tension rho A W^2 (L^2 - x^2)/2; J. Guidance 10 (1987) 139-151.
    """
    x, weight = np.polynomial.legendre.leggauss(60)
    x, weight = 0.5 * (x + 1.0), 0.5 * weight
    roots = np.array([1.875104068711961, 4.694091132974175, 7.854757438237613, 10.99554073487547, 14.1371683910465])
    sigma = (np.cos(roots) + np.cosh(roots)) / (np.sin(roots) + np.sinh(roots))
    z, ends = roots[:, None] * x, roots

    def shape(z, s):
        return np.cosh(z) - np.cos(z) - s * (np.sinh(z) - np.sin(z))

    phi = shape(z, sigma[:, None])
    slope = roots[:, None] * (np.sinh(z) + np.sin(z) - sigma[:, None] * (np.cosh(z) - np.cos(z)))
    mass = DENSITY * LENGTH * (phi * weight) @ phi.T
    stiffness = BENDING / LENGTH**3 * np.diag(roots**4) @ (phi * weight) @ phi.T
    tension = 0.5 * DENSITY * LENGTH * (slope * weight * (1.0 - x**2)) @ slope.T
    push = DENSITY * LENGTH**2 * (phi * weight) @ x

    def derivative(t, y):
        rate = 0.4 * t - 3.0 / np.pi * np.sin(2.0 * np.pi * t / 15.0)
        rising = 0.4 - 0.4 * np.cos(2.0 * np.pi * t / 15.0)
        pull = stiffness + rate**2 * (tension - mass)
        return np.concatenate([y[5:], np.linalg.solve(mass, -rising * push - pull @ y[:5])])

    y = solve_ivp(derivative, (0.0, times[-1]), np.zeros(10), "DOP853", times, rtol=1e-8, atol=1e-10).y
    return shape(ends, sigma) @ y[:5]


def test_a_beam_that_spins_up_lags_as_a_floating_frame_with_given_modes_says():
    """By two numbers of segments and extrapolation in 1/n^2; the linear theory is off by (deflection/length)^2."""
    coarse, fine = spin_up(4, 8.0), spin_up(8, 8.0)
    lag = fine[2] + (fine[2] - coarse[2]) / 3.0
    modes = modal_lag(fine[0])
    assert np.abs(lag - modes).max() < (modes.min() / LENGTH) ** 2 * -modes.min()
    errors = [np.abs(one[2] - modes).max() for one in (coarse, fine)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)  # twice the segments, a quarter of the error


@pytest.mark.slow
def test_at_full_speed_the_beam_is_longer_by_its_centrifugal_tension():
    """u(L) = L (tan(k L)/(k L) - 1), k^2 = rho A W^2/(E A), in the mean of a second.

    The tip still swings by d, as a cantilever under a load at its tip bends, and is nearer by 0.6 d^2/L.
    """
    wave = LENGTH * np.sqrt(DENSITY * RATE**2 / AXIAL)
    published = LENGTH * (np.tan(wave) / wave - 1.0)
    assert published == pytest.approx(5.14e-4, abs=5e-7)  # to its three published digits
    ends = [spin_up(n, 15.0)[1:, -10:] for n in (4, 8)]
    stretch = [np.mean(u + 0.6 * d**2 / LENGTH) for u, d in ends]
    assert stretch[1] + (stretch[1] - stretch[0]) / 3.0 == pytest.approx(published, rel=0.002)


# IVP test set, slider crank: start, and phi2, x3, q1..q4 at t = 0.1 s (rad, m)
CRANK_START = (0.0, 0.450016933, 0.0, 0.0, 0.103339863e-4, 0.169327969e-4, -74.99576703969453, -2.689386719979040e-6,
               0.4448961125815990, 0.4634339319238670e-2, -1.785910760000550e-6, -2.689386719979040e-6)  # fmt: skip
CRANK_END = (-3.311734987910881e-01, 1.697373326718410e-01, 1.893192460247178e-04, 2.375751865617931e-05,
             -5.323907988763734e-06, -8.363283141616840e-06)  # fmt: skip
L1, L2, M2, M3, SPEED, AREA, HEIGHT, E = 0.15, 0.3, 0.151104, 0.075552, 150.0, 0.008**2, 0.008, 0.2e12
INERTIA = 0.0045339259  # kg m^2, of the rod about its pin


def flexible_crank(rtol: float) -> np.ndarray:
    """Return phi2, x3, q1..q4 at 0.1 s of a rod in a floating frame: two sines across it, a parabola along it.

    The parabola has the test set's mass, which lacks a factor 1/15, its integral over the rod.
    """
    pi, stretch = 3.1415927, E * AREA / L2  # as in the source
    mass = M2 * np.diag([0.5, 0.5, 0.0, 0.0])
    mass[2:, 2:] = M2 * np.array([[8.0, 1.0], [1.0, 2.0]])
    stiffness = stretch * (HEIGHT / L2) ** 2 * pi**4 * np.diag([1.0 / 24.0, 2.0 / 3.0, 0.0, 0.0])
    stiffness[2:, 2:] = stretch / 3.0 * np.array([[16.0, -8.0], [-8.0, 7.0]])
    along, across = M2 * np.array([0.0, 0.0, 2 / 3, 1 / 6]), M2 * np.array([2 / pi, 0.0, 0.0, 0.0])
    x_along, x_across = M2 * L2 * np.array([0, 0, 1 / 3, 1 / 6]), M2 * L2 * np.array([1 / pi, -0.5 / pi, 0, 0])
    both = np.zeros((4, 4))
    both[0, 2:], both[1, 3] = (-16 / pi**3, 8 / pi**3 - 1 / pi), 0.5 / pi
    both = M2 * (both - both.T)

    def derivative(t, y):
        q, qd, turn, w, ahead = y[2:6], y[8:], y[0], y[6], SPEED * t
        s, c = np.sin(ahead - turn), np.cos(ahead - turn)
        kkt, due, reach = np.zeros((8, 8)), np.zeros(8), L2 + q[3]
        kkt[0, 0], kkt[1, 1], kkt[2:6, 2:6] = INERTIA + q @ mass @ q + 2.0 * x_along @ q, M3, mass
        kkt[0, 2:6] = kkt[2:6, 0] = x_across + q @ both
        due[0] = SPEED**2 * L1 * (0.5 * L2 * M2 * s + along @ q * s - across @ q * c)
        due[0] -= 2.0 * w * (x_along @ qd + qd @ mass @ q) + qd @ both @ qd
        due[2:6] = w**2 * (mass @ q + x_along) + SPEED**2 * L1 * (c * along + s * across) + 2.0 * w * both @ qd
        due[2:6] -= stiffness @ q
        sine, cosine = np.sin(turn), np.cos(turn)
        rows = np.zeros((2, 6))
        rows[0, 0], rows[0, 5], rows[1, 0], rows[1, 1], rows[1, 5] = reach * cosine, sine, reach * sine, 1.0, -cosine
        kkt[6:, :6], kkt[:6, 6:] = rows, rows.T
        due[6] = L1 * np.sin(ahead) * SPEED**2 + reach * sine * w**2 - 2.0 * w * cosine * qd[3]
        due[7] = -L1 * np.cos(ahead) * SPEED**2 - reach * cosine * w**2 - 2.0 * w * sine * qd[3]
        return np.concatenate([y[6:], np.linalg.solve(kkt, due)[:6]])

    return solve_ivp(derivative, (0.0, 0.1), CRANK_START, "DOP853", rtol=rtol, atol=1e-3 * rtol).y[:6, -1]


@pytest.mark.slow
def test_a_floating_frame_with_given_modes_ends_at_the_published_digits():
    """The start has 0.45 m to 5e-10 m: 1e-9 of the pose is left, and 1e-10 m of deformations, a thousandth of it."""
    np.testing.assert_allclose(flexible_crank(1e-11), CRANK_END, rtol=1e-9, atol=1e-10)


def test_the_rod_of_segments_ends_bent_as_published_but_for_its_tension():
    """It vibrates along itself by as much as it is stretched at the start, and the slider and the angle with it.

    The published rod is not stiffened by its tension, ours is, by the largest tension over Euler's load.
    """
    count, times = 8, np.linspace(0.0, 0.1, 41)
    scene = scenes.make("flexible_slider_crank", segments=count)
    path = simulate(scene, Settings(method="dop853", rtol=1e-7, estimate="off", reactions=False), times)
    assert path.ok
    pin = 2.0 * path.position[:, 0]
    rod = path.position[:, -1] - pin
    length = 2.0 * CRANK_START[5]  # m: both rods vibrate
    assert path.position[-1, -1, 0] == pytest.approx(CRANK_END[1], abs=length)
    assert np.arctan2(rod[-1, 1], rod[-1, 0]) == pytest.approx(CRANK_END[0], abs=length / L2)
    across = np.stack([-rod[:, 1], rod[:, 0]], axis=1) / np.linalg.norm(rod, axis=1)[:, None]
    bow = np.einsum("tkj,tj->tk", path.position[:, 1:-1] - pin[:, None], across)
    angles = np.pi * (np.arange(count) + 0.5) / count
    sines = 2.0 / count * bow @ np.sin(np.outer(angles, (1.0, 2.0)))  # (n_t, 2) m
    tension = (M3 + 0.5 * M2) * SPEED**2 * L1 * (1.0 + L1 / L2)  # N, half-way, at the dead centre
    stiffened = tension * L2**2 / (np.pi**2 * E * AREA * HEIGHT**2 / 12.0)
    assert 0.05 < stiffened < 0.11
    assert (np.abs(sines[-1] - CRANK_END[2:4]) < stiffened * np.abs(sines).max(axis=0)).all()


# Obrezkov, Mikkola, Matikainen, Nonlinear Dynamics 109 (2022) 531-546: tip deflections (m) along height and width of
# ANSYS beams under 8.896 and 13.345 N, by angle (deg)
ANSYS = {
    (8.896, 0.0): (1.071417630e-2, 0.0), (8.896, 45.0): (8.837226265e-3, 0.108987937),
    (13.345, 45.0): (1.518618440e-2, 0.156467239), (13.345, 75.0): (6.248967384e-3, 0.196097131),
    (13.345, 90.0): (0.0, 0.200677707),
}  # fmt: skip
SIDES, YOUNG, POISSON = (12.3777e-3, 3.2024e-3), 71.7e9, 0.31  # m, Pa


def bent_rod(load: float, angle: float) -> np.ndarray:
    """Return the tip (3,), m, of a rod of Reissner and Simo by shooting: no segments, and an ODE along the rod."""
    span, (height, width), shear = 0.508, SIDES, YOUNG / 2.0 / (1.0 + POISSON)
    odd = np.arange(1, 40, 2)  # Saint-Venant's series
    series = 1.0 / 3.0 - 64.0 / np.pi**5 * width / height * np.sum(np.tanh(odd * np.pi * height / width / 2.0) / odd**5)
    stretch = height * width * np.array([YOUNG, shear, shear])
    bend = height * width * np.array([shear * series * width**2, YOUNG / 12.0 * width**2, YOUNG / 12.0 * height**2])
    force = load * np.array([0.0, -np.cos(np.radians(angle)), np.sin(np.radians(angle))])

    def slope(_, y, force):
        axes = rotation_matrices(y[3:7])
        along = axes @ ((1.0, 0.0, 0.0) + axes.T @ force / stretch)
        k1, k2, k3 = axes.T @ y[7:] / bend
        turning = np.array([[0, -k1, -k2, -k3], [k1, 0, k3, -k2], [k2, -k3, 0, k1], [k3, k2, -k1, 0]])
        return np.concatenate([along, 0.5 * turning @ y[3:7], -np.cross(along, force)])

    def shot(moment, share):
        start = np.concatenate([np.zeros(3), (1.0, 0.0, 0.0, 0.0), moment])
        return solve_ivp(slope, (0.0, span), start, "DOP853", rtol=1e-8, atol=1e-10, args=(share * force,)).y[:, -1]

    moment = np.zeros(3)
    for share in (0.5, 1.0):
        moment = root(lambda m, share=share: shot(m, share)[7:], moment, tol=1e-11).x
    return shot(moment, 1.0)[:3]


def rested(segments: int, load: float, angle: float) -> np.ndarray:
    """Return the tip (3,), m, of the beam of segments in equilibrium."""
    scene = scenes.make("princeton_beam", segments=segments, load=load, angle=angle, start="equilibrium")
    last = scene.bodies[-1]
    assert isinstance(last, SpatialBody)
    return np.array(last.position) + 0.5 * 0.508 / segments * rotation_matrices(last.orientation)[:, 0]


@pytest.mark.parametrize("case", ANSYS)
def test_a_rod_bends_as_published(case):
    """Bent one way as theirs, by elements, to 2e-4; obliquely it twists, with a torsion constant of theirs unknown."""
    one_way = case[1] in (0.0, 90.0)
    np.testing.assert_allclose(np.abs(bent_rod(*case)[1:]), ANSYS[case], rtol=3e-4 if one_way else 0.015, atol=1e-12)


def test_the_princeton_beam_of_segments_rests_where_a_rod_does():
    rod = bent_rod(13.345, 45.0)
    coarse, fine = (rested(n, 13.345, 45.0) for n in (3, 6))
    errors = [np.linalg.norm(tip - rod) for tip in (coarse, fine)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    np.testing.assert_allclose(fine + (fine - coarse) / 3.0, rod, atol=6e-5)  # m


def test_a_strained_bushing_rests_in_an_equilibrium():
    """A block of 2 kg hangs on a bushing by m g/k, and starts there."""
    block = PlanarBody(name="block", mass=2.0, inertia=0.1, position=(1.0, 0.0))
    ends = {"body_a": "ground", "body_b": "block"}
    springs = (PointBushing(name="rubber", point=(1.0, 0.0), stiffness=1e4, damping=50.0, **ends),
               TorsionSpring(name="turn", stiffness=10.0, **ends))  # fmt: skip
    rest = at_equilibrium(Scene(name="hung", duration=1.0, gravity=(0.0, -9.81), bodies=(block,), loads=springs))
    assert rest.bodies[0].position == pytest.approx((1.0, -2.0 * 9.81 / 1e4), abs=1e-14)  # to roundoff of 1 m
    tight = Settings(estimate="off", rtol=1e-10, atol=1e-10)
    path = simulate(rest, tight, np.array([0.0, 1.0]))
    assert np.abs(path.position[1] - path.position[0]).max() < 1e-10  # the tolerance of the run
