"""Truths of pendulums of one body."""

import numpy as np

from cross_checks.truths.made_by import Formulation, agree
from cross_checks.truths.made_by.numerics import closed_forms
from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period, running_integral
from cross_checks.truths.truth import Truth, unturned
from mbs_ref import Scene


def pendulum(scene: Scene, times: np.ndarray) -> Truth:
    """Released from the horizontal: sin(theta/2) = k sn(K + omega t | k^2), k^2 = 1/2 (Whittaker 1904, section 44)."""
    length, gravity = np.longdouble(scene.parameters["length"]), np.longdouble(scene.parameters["gravity"])
    half = np.longdouble(0.5)
    omega = np.sqrt(gravity / length)  # rad/s
    phase = amplitude(quarter_period(half) + omega * times.astype(np.longdouble), half)
    theta = -2 * np.arcsin(np.sqrt(half) * np.sin(phase))  # from straight down; the bob starts at x = -length
    position = length * np.stack([np.sin(theta), -np.cos(theta)], axis=1)
    turns = 1.0 + float(omega) * float(times[-1])
    uncertainty = float(length) * (2.3e-16 + 1e2 * turns * float(np.finfo(np.longdouble).eps))
    return Truth(
        position[:, None].astype(float), np.zeros((len(times), 1)), uncertainty, "exact",
        "Jacobi elliptic functions by the arithmetic-geometric mean in extended precision",
    )  # fmt: skip


def spherical_pendulum(scene: Scene, times: np.ndarray) -> Truth:
    """Return the bob's motion; every angle and speed is in its domain but the separatrix, where it is not known."""
    names = ("length", "gravity", "angle", "speed")
    data, grid = np.array([scene.parameters[name] for name in names], dtype=np.longdouble), times.astype(np.longdouble)
    position, error = _spherical_motion(data, grid)
    uncertainty = error + closed_forms.rounding_error(lambda near, few: _spherical_motion(near, few)[0], data, grid)
    how = "elliptic functions by the arithmetic-geometric mean, azimuth by quadrature, extended precision"
    place = position[:, None].astype(float)
    return Truth(place, unturned(place), uncertainty, "exact", how)


def _spherical_motion(data: np.ndarray, grid: np.ndarray) -> tuple[np.ndarray, float]:
    """u = z / l: u'^2 = (2 g / l) (u - u1)(u - u2)(u - u3), u1 <= u <= u2 < 1 < u3 (Whittaker 1904, section 55).

    u = u1 + (u2 - u1) sn^2(p t + offset), p = sqrt((2 g / l)(u3 - u1)) / 2; the azimuth is the integral of
    h / (1 - u^2), h = v / l sin(angle0) the angular momentum per m l^2. Return positions (n_t, 3) and their error, m.
    """
    length, gravity, angle, speed = data
    u0 = -np.cos(angle)
    level = speed**2 / (2 * gravity * length) + u0  # energy over m g l
    half, constant = (level - u0) / 2, u0**2 - level * u0 - 1  # the other two roots: u^2 - 2 half u + constant = 0
    root = np.sqrt(half**2 - constant)
    u3 = half + root
    other = constant / u3
    u1, u2 = min(u0, other), max(u0, other)
    m, p = (u2 - u1) / (u3 - u1), np.sqrt(2 * gravity / length * (u3 - u1)) / 2
    quarter = quarter_period(m)
    offset = quarter if u0 > other else 0 * quarter
    h = speed / length * np.sin(angle)

    def height(t):
        return u1 + (u2 - u1) * np.sin(amplitude(offset + p * t, m)) ** 2

    steep = float(1 / min(1 - u1**2, 1 - u2**2))  # how the azimuth magnifies the rounding of u
    noise = steep * float(np.finfo(np.longdouble).eps)
    piece = float(quarter / p) / 16
    phi, error = running_integral(
        lambda t: h / (1 - height(t) ** 2), grid, piece, max(closed_forms.TOLERANCE, 16 * noise)
    )
    u = height(grid)
    radius = np.sqrt(1 - u**2)
    position = length * np.stack([radius * np.cos(phi), radius * np.sin(phi), u], axis=1)
    return position, float(length) * (error + 4.0 * noise * (1.0 + float(p * grid[-1])))


def spring_pendulum(scene: Scene, times: np.ndarray) -> Truth:
    """Newton's equations by DOP853 against Hamilton's polar ones by extrapolation in extended precision."""
    given = {key: float(value) for key, value in scene.parameters.items()}
    ways = "Newton's in x, y by DOP853", "polar Hamilton's equations by extrapolation in extended precision"
    return agree(_cartesian(**given), _polar(**given), times, ways, extended=True)


def _cartesian(rest_length, mass, stiffness, damping, gravity) -> Formulation:
    def derivative(t, y):
        x, v = y[:2], y[2:]
        r = np.hypot(*x)
        pull = stiffness * (r - rest_length) + damping * (x @ v) / r  # N
        return np.concatenate([v, -pull * x / (r * mass) - np.array([0.0, gravity])])

    return Formulation(derivative, np.array([rest_length, 0.0, 0.0, 0.0]), lambda t, y: (y[None, :2], np.zeros(1)))


def _polar(rest_length, mass, stiffness, damping, gravity) -> Formulation:
    def derivative(t, y):
        r, phi, p, spin = y  # m, rad, kg m/s, kg m^2/s
        turn = spin / (mass * r**2)
        pull = stiffness * (r - rest_length) + damping * p / mass
        push = mass * r * turn**2 - pull - mass * gravity * np.sin(phi)
        return np.array([p / mass, turn, push, -mass * gravity * r * np.cos(phi)], dtype=y.dtype)

    def poses(t, y):
        return y[0] * np.array([[np.cos(y[1]), np.sin(y[1])]]), np.zeros(1)

    return Formulation(derivative, np.array([rest_length, 0.0, 0.0, 0.0]), poses)


def driven_pendulum(scene: Scene, times: np.ndarray) -> Truth:
    """Lagrange's equation by DOP853 against Hamilton's by extrapolation in extended precision."""
    given = {key: float(value) for key, value in scene.parameters.items()}
    ways = "Lagrange's by DOP853", "Hamilton's equations in the rod's angle by extrapolation in extended precision"
    return agree(_lagrange(**given), _hamilton(**given), times, ways, extended=True)


def _lagrange(length, mass, amplitude, omega, angle, gravity) -> Formulation:
    """(l/3) theta'' = (1/2) sin(theta) X'' - (1/2) g cos(theta), X'' = -amplitude omega^2 cos(omega t)."""

    def derivative(t, y):
        push = -amplitude * omega**2 * np.cos(omega * t)
        return np.array([y[1], 1.5 / length * (np.sin(y[0]) * push - gravity * np.cos(y[0]))])

    return Formulation(derivative, np.array([angle, 0.0]), _driven_poses(length, amplitude, omega))


def _hamilton(length, mass, amplitude, omega, angle, gravity) -> Formulation:
    """p = (m l^2/3) theta' - (m l/2) sin(theta) X', p' = -(m l/2) cos(theta) (theta' X' + g)."""
    inertia, moment = mass * length**2 / np.longdouble(3), mass * length / np.longdouble(2)

    def derivative(t, y):
        speed = -amplitude * omega * np.sin(omega * t)
        rate = (y[1] + moment * np.sin(y[0]) * speed) / inertia
        return np.array([rate, -moment * np.cos(y[0]) * (rate * speed + gravity)])

    return Formulation(derivative, np.array([angle, 0.0]), _driven_poses(length, amplitude, omega))


def _driven_poses(length, amplitude, omega):
    def poses(t, y):
        carriage = np.array([amplitude * (np.cos(omega * t) - 1.0), 0.0])
        along = length / 2 * np.array([np.cos(y[0]), np.sin(y[0])])
        return np.stack([carriage, carriage + along]), np.array([0.0, y[0]])

    return poses
