"""The wheelset of the IVP test set, of index 2: creep forces that depend on the multipliers of the rails' constraints.

A rigid body of revolution rolls at 30 m/s on two rails; cone on circle. Places and angles p = (x, y, z, theta, phi) and
the spin's excess beta are those of the source: Simeon, Fuehrer, Rentrop, Surv. Math. Ind. 1 (1991) 1-37; Test Set for
Initial Value Problem Solvers, wheelset.f. Everything there is repeated in its letters; the contact points, which are
unknowns there, have closed forms here, and the multipliers are solved for at every evaluation.
"""

from __future__ import annotations

import cmath
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbs_ref.scene import Scene, SpatialBody, UserConstraint, UserForce
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

MASS, GRAVITY, SPEED, RADIUS, SPIN = 16.08, 9.81, 30.0, 0.1, 300.0  # kg, m/s^2, m/s, m, rad/s
I1, I2 = 0.0605, 0.366  # kg m^2, about the axle and across it
MU, ARM, CX, CZ = 0.12, 0.19, 6400.0, 6400.0  # friction; m; N/m
CONE, HALF, RAIL = 0.0262, 0.1506, 0.06  # rad; m, of the track's width; m, radius of a rail's head
TAPER, MIDDLE = math.tan(CONE), HALF + math.sin(CONE) * RAIL
ELLIPSE, SHEAR_ROOT, POISSON, SHEAR = 1.3537956, math.sqrt(0.7115218), 0.28, 7.92e10  # of Kalker's linear theory; Pa
C11, C22, C23, PI = 4.72772197, 4.27526987, 1.97203505, 3.1415926
SIDES = (-1.0, 1.0)  # the sign of a contact's place along the axle; the source's right and left

START = (0.14941e-2, 0.40089e-6, 0.11241e-5, -0.28573e-3, 0.26459e-3)
CONTACTS = (-7.4122380357667139e-6, -0.1521364296121248, 7.5634406395172940e-6, 0.1490635714733819)  # psi, xi at t = 0
RATES = (-1.975258894011285, -1.0898297102811276e-3, 7.8855083626142589e-2, -5.533362821731549, -0.3487021489546511,
         -2.132968724380927)  # at t = 0  # fmt: skip
# at t = 10 s, by DASSL at a tolerance of 1e-9: p, their rates and beta; psi and xi
END = (0.86355386965811e-2, 0.13038281022727e-4, -0.93635784016818e-4, -0.13642299804033e-1, 0.15292895005422e-2,
       -0.76985374142666e-1, -0.25151106429207e-3, 0.20541188079539e-2, -0.23904837703692, -0.13633468454173e-1,
       -0.24421377661131)  # fmt: skip
END_CONTACTS = (-0.33666751972196e-3, -0.15949425684022, 0.37839614386969e-3, 0.14173214964613)
START_MULTIPLIERS, MULTIPLIERS = (-74.144, -83.593), (-56.285630573753, -101.24044903201)  # N, at t = 0 and 10 s


def contact(p: Any, side: float, m: Any = math) -> tuple[Any, ...]:
    """Return psi (rad), xi (m), the wheel's radius (m), the rail's slope and the Jacobian (5,) of the gap at a side.

    Equations (15), (14) and the profiles are solved for psi, the slope and xi. Complex p carry a derivative with
    m = cmath.
    """
    x, _, _, theta, phi = p[:5]
    st, ct, sp, cp = m.sin(theta), m.cos(theta), m.sin(phi), m.cos(phi)
    taper = -side * TAPER
    psi = m.asin(taper * st * cp / m.sqrt(ct * ct + (st * sp) ** 2)) - m.atan(st * sp / ct)
    s, c = m.sin(psi), m.cos(psi)
    ahead = ct * sp * c - st * s
    slope = (ahead - taper * ct * cp) / (taper * sp + cp * c)
    place = side * (MIDDLE - side * slope * RAIL / m.sqrt(1.0 + slope * slope))
    xi = (place - x - (RADIUS + TAPER * HALF) * ahead) / (ct * cp + taper * ahead)
    r = RADIUS + TAPER * HALF + taper * xi
    rows = (
        slope, -1.0, 0.0, slope * (r * (-ct * s - c * sp * st) - cp * st * xi),
        -c * r * sp - cp * xi + slope * (cp * c * ct * r - ct * sp * xi),
    )  # fmt: skip
    return psi, xi, r, slope, rows


def gap(p: Any, side: float, m: Any = math) -> Any:
    """Return the height (m) of the rail over the wheel where they touch."""
    psi, xi, r, slope, _ = contact(p, side, m)
    rail = RAIL / m.sqrt(1.0 + slope * slope) - RADIUS - math.cos(CONE) * RAIL
    return rail - p[1] - xi * m.sin(p[4]) + r * m.cos(p[4]) * m.cos(psi)


class Side:
    """What a contact's creep force is made of, but for the normal force."""

    def __init__(self, p: Any, v: Any, side: float) -> None:
        self.side = side
        self.psi, xi, r, slope, self.rows = contact(p, side)
        theta, phi = p[3], p[4]
        xd, yd, zd, thetad, phid, betad = v
        st, ct, sp, cp = math.sin(theta), math.cos(theta), math.sin(phi), math.cos(phi)
        s, c = math.sin(self.psi), math.cos(self.psi)
        delta = -side * math.atan(slope)
        self.sd, self.cd = math.sin(delta), math.cos(delta)
        self.sv, self.cv = math.sin(theta / self.cd), math.cos(theta / self.cd)
        sv, cv, turning, down = self.sv, self.cv, SPIN + betad, xi * sp - r * cp * c
        along, across = r * (sv * sp * c + cv * s) + xi * sv * cp, xi * cv * cp + r * (cv * sp * c - sv * s)
        w1 = -turning * r * (sv * c + cv * sp * s) + xd - thetad * along - phid * cv * down
        w2 = turning * r * cp * s + yd + phid * (xi * cp + r * sp * c)
        w3 = -turning * r * (cv * c - sv * sp * s) + SPEED + zd - thetad * across + phid * sv * down
        rolling = 0.5 * math.sqrt((w1 - 2 * xd) ** 2 + (w2 - 2 * yd) ** 2 + (w3 - 2 * zd - 2 * SPEED) ** 2)
        self.creep = (
            (sv * w1 + cv * w3) / rolling,
            (cv * self.cd * w1 - side * self.sd * w2 - sv * self.cd * w3) / rolling,
            (side * self.sd * turning + self.cd * thetad) / rolling,
        )
        curved = 0.5 / (r * math.sqrt(1.0 + TAPER * TAPER)) + 0.5 / RAIL
        self.ellipse = 3.0 * (1.0 - POISSON) * ELLIPSE / (2.0 * PI * curved * SHEAR * SHEAR_ROOT)
        self.lever = (
            (-(xi * st + r * s * ct * cp), -r * s * sp, -xi * ct + r * s * st * cp),
            (-(xi * ct * sp - r * c * ct * cp), xi * cp + r * c * sp, xi * st * sp - r * c * st * cp),
            (-r * (c * st + s * ct * sp), r * s * cp, -r * (c * ct - s * st * sp)),
        )

    def forces(self, multiplier: float) -> list[float]:
        """Return constraint and creep on the six equations of motion, N and N m, for a multiplier (N)."""
        normal = -multiplier / self.cd
        limit, half = MU * normal, (self.ellipse * abs(normal)) ** (1.0 / 3.0)  # m
        nu_x, nu_y, phi = self.creep
        tx = -limit * math.tanh(SHEAR * half**2 * C11 * nu_x / limit)
        ty = -limit * math.tanh(SHEAR * (half**2 * C22 * nu_y + half**3 * C23 * phi) / limit)
        size = math.hypot(tx, ty)
        if size > abs(limit):
            tx, ty = tx * abs(limit) / size, ty * abs(limit) / size
        sv, cv, sd, cd = self.sv, self.cv, self.sd, self.cd
        creep = (sv * tx + cv * cd * ty, -self.side * sd * ty, cv * tx - sv * cd * ty)
        moments = (a * creep[0] + b * creep[1] + c * creep[2] for a, b, c in self.lever)
        return [one + multiplier * q for one, q in zip((*creep, *moments), (*self.rows, 0.0), strict=True)]


class Instant:
    """The equations of motion at p and its rates, with the excess of the spin (6,) beside them."""

    def __init__(self, p: Any, v: Any) -> None:
        self.both = [Side(p, v, side) for side in SIDES]
        thetad, phid, turning, yaw = v[3], v[4], SPIN + v[5], -2.0 * ARM**2 * CZ * p[3]
        self.sp, self.cp = math.sin(p[4]), math.cos(p[4])
        self.free = (
            -2.0 * CX * p[0], -MASS * GRAVITY, -2.0 * CZ * p[2],
            I2 * thetad * phid * self.sp - I1 * turning * phid - (I1 - I2) * thetad * self.sp * phid + self.cp * yaw,
            I1 * turning * thetad * self.cp + (I1 - I2) * thetad * self.sp * thetad * self.cp,
            -I1 * thetad * phid * self.cp + self.sp * yaw,
        )  # fmt: skip
        step = 1e-30  # a complex step along the motion: rows turn by it, without a difference
        nudged = [complex(a, step * b) for a, b in zip(p, v[:5], strict=True)]
        turned = [contact(nudged, side, cmath)[4] for side in SIDES]
        self.due = [-sum(complex(q).imag * b for q, b in zip(row, v[:5], strict=True)) / step for row in turned]

    def accelerations(self, multipliers: Any) -> list[float]:
        """Return the derivatives of the rates (6,), and of the excess, for both multipliers (N)."""
        left, right = (part.forces(one) for part, one in zip(self.both, multipliers, strict=True))
        return self._moved([a + b + c for a, b, c in zip(self.free, left, right, strict=True)])

    def _moved(self, force: Any) -> list[float]:
        turned = force[3] / (I2 * self.cp)
        return [*(one / MASS for one in force[:3]), turned, force[4] / I2, force[5] / I1 - self.sp * turned]

    def multipliers(self) -> list[float]:
        """Return both multipliers (N), for which the constraints keep their rates."""
        rows = [part.rows for part in self.both]
        held = [self._moved((*row, 0.0)) for row in rows]
        (a, b), (c, d) = (([_along(row, one) for one in held]) for row in rows)
        one = two = -0.5 * MASS * GRAVITY
        for _ in range(50):
            rates = self.accelerations((one, two))
            e, f = (due - _along(row, rates) for due, row in zip(self.due, rows, strict=True))
            change = (d * e - b * f) / (a * d - b * c), (a * f - c * e) / (a * d - b * c)
            one, two = one + change[0], two + change[1]
            if max(map(abs, change)) < 1e-13 * MASS * GRAVITY:
                return [one, two]
        raise AssertionError(f"multipliers change by {change} N still")


def _along(row: Any, rates: Any) -> float:
    return sum(q * rate for q, rate in zip(row, rates[:5], strict=True))


def derivative(_t: float, y: np.ndarray) -> list[float]:
    now = Instant(y[:5].tolist(), y[5:].tolist())
    return [*y[5:10].tolist(), *now.accelerations(now.multipliers())]


@pytest.mark.parametrize("side", SIDES)
def test_the_rows_are_the_gaps_derivatives(side):
    """With the contact point held, as where both surfaces touch along one plane it moves along it alone."""
    p, step = (2e-3, 1e-5, 3e-5, -8e-3, 1e-3), 1e-30
    for k, row in enumerate(contact(p, side)[4]):
        nudged = [complex(x, step * (j == k)) for j, x in enumerate(p)]
        assert gap(nudged, side, cmath).imag / step == pytest.approx(row, rel=1e-12, abs=1e-15)


def test_contact_points_and_accelerations_at_the_start_are_the_published_ones():
    """The published accelerations belong to the published multipliers, which have five digits."""
    found = [value for side in SIDES for value in contact(START, side)[:2]]
    assert found == pytest.approx(CONTACTS, rel=1e-13)
    start = Instant(START, (0.0,) * 6)
    assert start.accelerations(START_MULTIPLIERS) == pytest.approx(RATES, rel=1e-8)
    assert start.multipliers() == pytest.approx(START_MULTIPLIERS, rel=3e-5)


def test_multipliers_at_the_published_end_are_the_published_ones():
    assert Instant(END[:5], END[5:]).multipliers() == pytest.approx(MULTIPLIERS, rel=1e-8)


@pytest.mark.slow
def test_the_wheelset_ends_at_the_published_digits():
    """With a hundredth of the tolerance it is off by 4.6e-6 at most: the published run has a tolerance of 1e-9."""
    y = solve_ivp(derivative, (0.0, 10.0), (*START, *(0.0,) * 6), "DOP853", rtol=1e-8, atol=1e-11).y[:, -1].tolist()
    assert y == pytest.approx(END, rel=1e-5)
    assert [value for side in SIDES for value in contact(y, side)[:2]] == pytest.approx(END_CONTACTS, rel=1e-5)
    assert Instant(y[:5], y[5:]).multipliers() == pytest.approx(MULTIPLIERS, rel=1e-5)


# functions of numbers that carry their derivatives
ARRAYS = SimpleNamespace(sin=np.sin, cos=np.cos, asin=np.arcsin, atan=np.arctan, sqrt=np.sqrt)


def placed(x: Any, y: Any, z: Any, e: Any, m: Any = math) -> tuple[Any, ...]:
    """Return p of a centre and Euler parameters; the axle is the body's x axis."""
    ahead, up, aside = 0.5 - e[2] * e[2] - e[3] * e[3], e[1] * e[2] + e[0] * e[3], e[1] * e[3] - e[0] * e[2]
    return x, y, z, -m.atan(aside / ahead), m.asin(2.0 * up)


def frame(p: Any) -> np.ndarray:
    """Return the axle, what phi moves it to, and the axis of phi (3, 3), as rows."""
    st, ct, sp, cp = math.sin(p[3]), math.cos(p[3]), math.sin(p[4]), math.cos(p[4])
    return np.array([[ct * cp, sp, -st * cp], [-ct * sp, cp, st * sp], [st, 0.0, ct]])


def creep_and_springs(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return what acts beside weight and rails (1, 6), N and N m, in world axes; z counts along with the track."""
    p = placed(*q[0, :2].tolist(), q[0, 2] - SPEED * t, q[0, 3:].tolist())
    axes = frame(p)
    spin, yaw, roll = axes @ v[0, 3:]
    rates = (*v[0, :2].tolist(), v[0, 2] - SPEED, yaw / math.cos(p[4]), roll)
    now = Instant(p, (*rates, spin - rates[3] * math.sin(p[4]) - SPIN))
    total = np.array([-2.0 * CX * p[0], 0.0, -2.0 * CZ * p[2], 0.0, -2.0 * ARM**2 * CZ * p[3], 0.0])
    for part, multiplier in zip(now.both, now.multipliers(), strict=True):
        force = part.forces(multiplier)
        creep = np.array([one - multiplier * q for one, q in zip(force[:3], part.rows[:3], strict=True)])
        _, xi, r, _, _ = contact(p, part.side)
        arm = xi * axes[0] - r * (math.cos(part.psi) * axes[1] + math.sin(part.psi) * axes[2])
        total += np.concatenate([creep, np.cross(arm, creep)])
    return total[None]


def wheelset() -> Scene:
    """Return the wheelset as a body, with both rails as constraints of the user's own."""

    def touching(side: float):
        return lambda t, a, b: gap(placed(b.x, b.y, b.z, (b.e0, b.e1, b.e2, b.e3), ARRAYS), side, ARRAYS)

    axes = frame(START)
    body = SpatialBody(
        name="wheelset", mass=MASS, inertia=(I1, I2, I2, 0.0, 0.0, 0.0), position=START[:3], velocity=(0.0, 0.0, SPEED),
        orientation=tuple(from_matrix(axes.T).tolist()), angular_velocity=tuple((SPIN * axes[0]).tolist()),
    )  # fmt: skip
    rails = [UserConstraint(name=name, body_a="ground", body_b="wheelset", function=touching(side))
             for name, side in zip(("right", "left"), SIDES, strict=True)]  # fmt: skip
    force = UserForce(name="creep", function=creep_and_springs)
    return Scene(name="wheelset", gravity=(0.0, -GRAVITY, 0.0), bodies=(body,), joints=tuple(rails), loads=(force,))


@pytest.mark.slow
def test_a_body_on_two_constraints_of_the_users_own_goes_as_the_wheelset():
    """Its rows' multipliers are those that the creep forces were computed for.

    Its constraints close the gap of 5e-10 m that the published start leaves: 3e-9 rad of phi.
    """
    end = 0.25  # s: 12 turns
    path = simulate(wheelset(), Settings(method="dop853", rtol=1e-10, estimate="off"), np.array([0.0, end]))
    assert path.ok, path.message
    p = placed(*path.position[-1, 0, :2], path.position[-1, 0, 2] - SPEED * end, path.orientation[-1, 0])
    y = solve_ivp(derivative, (0.0, end), (*START, *(0.0,) * 6), "DOP853", rtol=1e-11, atol=1e-14).y[:, -1].tolist()
    assert p == pytest.approx(y[:5], rel=1e-5, abs=5e-9)
    held = Instant(y[:5], y[5:])
    for name, part, multiplier in zip(("right", "left"), held.both, held.multipliers(), strict=True):
        force = path.reactions[name][-1, :3]
        assert force == pytest.approx(np.array(part.rows[:3]) * multiplier, rel=1e-5, abs=1e-5)  # N
