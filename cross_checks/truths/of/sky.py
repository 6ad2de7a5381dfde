"""Truths of particles and satellites under celestial forces."""

from dataclasses import replace
from typing import Any

import numpy as np

from cross_checks.truths import seek_truth
from cross_checks.truths.made_by.numerics.solvers import extrapolate
from cross_checks.truths.made_by.sky import PI
from cross_checks.truths.made_by.sky.particles import converge
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.celestial import GravityGradient
from mbs_ref.scene.euler_parameters import from_axis_angle


def kepler(scene: Scene, times: np.ndarray) -> Truth:
    """M = E - e sin E with Newton's method; x = cos E - e, y = sqrt(1 - e^2) sin E (a = gm = 1)."""
    planet = scene.bodies[1]
    x, v = np.longdouble(planet.position[0]), np.longdouble(planet.velocity[1])
    a = 1 / (2 / x - v * v)  # of the orbit that the rounded start is on
    e = 1 - x / a
    mean = np.sqrt(1 / a**3) * times.astype(np.longdouble)
    anomaly = _eccentric_anomaly(mean, e)
    position = np.zeros((len(times), 2, 3))
    position[:, 1, 0] = a * (np.cos(anomaly) - e)
    position[:, 1, 1] = a * np.sqrt(1 - e * e) * np.sin(anomaly)
    speed = float(np.sqrt((1 + e) / (1 - e)))
    uncertainty = 2e-16 + speed * float(times[-1]) * 1e-17  # m: double output; extended precision carries the phase
    return Truth(
        position, np.zeros((len(times), 2)), uncertainty, "exact", "Kepler's equation solved in extended precision"
    )


def _eccentric_anomaly(mean: np.ndarray, e) -> np.ndarray:
    """Solve E - e sin E = M by Newton's method from beyond the root, to which it falls: convex up to pi."""
    whole = np.rint(mean / (2 * np.pi)) * (2 * PI)
    rest = mean - whole
    anomaly = np.sign(rest) * np.minimum(np.abs(rest) + e, PI)
    for _ in range(200):
        change = (anomaly - e * np.sin(anomaly) - rest) / (1 - e * np.cos(anomaly))
        anomaly = anomaly - change
        if np.all(np.abs(change) <= 1e-19 * (1 + np.abs(anomaly))):
            break
    return anomaly + whole


# Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, sec. II.10; the test set's 16 digits
X = (0.3706139143970502, 3.237284092057233, -3.222559032418324, 0.6597091455775310, 0.3425581707156584,
     1.562172101400631, -0.7003092922212495)  # m  # fmt: skip
Y = (-3.943437585517392, -3.271380973972550, 5.225081843456543, -2.590612434977470, 1.198213693392275,
     -0.2429682344935824, 1.091449240428980)  # m  # fmt: skip
END = 3.0  # s
PUBLISHED_TO = 1e-13  # m: all but the last digit or two are confirmed by two methods of unlike kind


def pleiades(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the published end and, before it, a converged solution that ends there."""
    if times[-1] != END:
        return NoTruth(
            f"the Pleiades are published at t = {END:g} s alone, and the last requested time is {times[-1]:g} s"
        )
    truth = converge(scene, times)
    if isinstance(truth, NoTruth):
        return truth
    published = np.column_stack((X, Y, np.zeros(7)))
    gap = float(np.linalg.norm(truth.position[-1] - published, axis=1).max())
    position = np.concatenate((truth.position[:-1], published[None]))
    how = f"Hairer, Norsett, Wanner (1993); before the end {truth.how}"
    uncertainty = max(PUBLISHED_TO, gap, truth.uncertainty)
    return replace(truth, position=position, uncertainty=uncertainty, kind="published", how=how, difference=gap)


def solar_system(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the motion of the scene's own equations; a sphere's steady spin is exact."""
    if scene.parameters["formulation"] == "point":
        return converge(scene, times)
    points = {**scene.parameters, "formulation": "point", "spin": False}
    truth = seek_truth(scenes.make(scene.name, **points), times)  # which may be known already
    if isinstance(truth, NoTruth):
        return truth
    spins = [body.angular_velocity for body in scene.bodies if isinstance(body, SpatialBody)]
    spinning = np.broadcast_to(spins, truth.position.shape)
    return replace(truth, orientation=_turned(scene, times), angular_velocity=spinning)


def _turned(scene: Scene, times: np.ndarray) -> np.ndarray:
    """Return the Euler parameters (n_t, n_bodies, 4) of spheres that turn steadily from the identity."""
    result = np.zeros((len(times), len(scene.bodies), 4))
    result[..., 0] = 1.0
    for k, body in enumerate(scene.bodies):
        assert isinstance(body, SpatialBody)
        rate = np.linalg.norm(body.angular_velocity)
        if rate > 0.0:
            result[:, k] = from_axis_angle(body.angular_velocity, rate * times)
    return result


FINE, COARSE = 1e-17, 1e-15  # tolerances, whose results tell the uncertainty


def librating_satellite(scene: Scene, times: np.ndarray) -> Truth:
    """With L = m (r'^2 + r^2 nu'^2) / 2 + C theta'^2 / 2 + gm m / r + gm (tr J - 3 I) / (2 r^3),
    I = A cos^2(theta - nu) + B sin^2(theta - nu); lengths in the first radius, times in 1 / n there.
    """
    body: Any = scene.bodies[1]
    load = next(x for x in scene.loads if isinstance(x, GravityGradient))
    a, b, c = (np.longdouble(x) for x in body.inertia[:3])
    radius, gm, mass = (np.longdouble(x) for x in (body.position[0], load.gm, body.mass))
    rate = np.sqrt(gm / radius**3)  # 1/s
    a, b, c = (x / (mass * radius**2) for x in (a, b, c))

    def slope(_t, y: np.ndarray) -> np.ndarray:
        r, climb, nu, sweep, theta, spin = y
        cosine, sine = np.cos(theta - nu), np.sin(theta - nu)
        along = a * cosine**2 + b * sine**2
        turning = 3 * (b - a) * sine * cosine / r**3  # torque on the orbit, its negative on the attitude
        pull = r * sweep**2 - 1 / r**2 - 3 * (a + b + c - 3 * along) / (2 * r**4)
        return np.array([climb, pull, sweep, (turning - 2 * r * climb * sweep) / r**2, spin, -turning / c])

    angle = 2 * np.arctan2(np.longdouble(body.orientation[3]), np.longdouble(body.orientation[0]))
    first = np.longdouble(body.velocity[1]) / (radius * rate)
    start = np.array([1, 0, 0, first, angle, np.longdouble(body.angular_velocity[2]) / rate], dtype=np.longdouble)
    grid = times.astype(np.longdouble) * rate
    fine, coarse = (_satellite_poses(extrapolate(slope, start, grid, x), radius, rate) for x in (FINE, COARSE))
    size = float(radius)
    apart = max(float(np.linalg.norm(x - y, axis=-1).max()) for x, y in zip(fine[:2], coarse[:2], strict=True))
    position, theta, velocity, omega = fine
    return Truth(
        position, theta, apart + 2.3e-16 * size, "converged",
        "Lagrange's equations in the orbit's plane by extrapolation in extended precision, at two tolerances",
        velocity=velocity, angular_velocity=omega,
        rate_uncertainty=np.full(len(times), (apart + 2.3e-16 * size) * float(rate)),
    )  # fmt: skip


def _satellite_poses(states: np.ndarray, radius, rate) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return places, Euler parameters, velocities and angular velocities of Earth and satellite."""
    r, climb, nu, sweep, theta, spin = states.T
    count = len(states)
    position, velocity, omega = (np.zeros((count, 2, 3)) for _ in range(3))
    turned = np.zeros((count, 2, 4))
    turned[:, 0, 0] = 1.0
    turned[:, 1] = from_axis_angle((0.0, 0.0, 1.0), theta.astype(float))
    place = radius * np.exp(1j * nu) * np.array((r, rate * (climb + 1j * r * sweep)))  # m and m/s, x + i y
    (position[:, 1, 0], velocity[:, 1, 0]), (position[:, 1, 1], velocity[:, 1, 1]) = place.real, place.imag
    omega[:, 1, 2] = spin * rate
    return position, turned, velocity, omega


TRUTHS = dict.fromkeys(
    ("figure_eight", "outer_solar_system", "satellite", "nesc_dropped_sphere", "nesc_sphere_in_air"), converge
)
