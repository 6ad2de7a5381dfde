"""Truths of linkages of one degree of freedom."""

from itertools import pairwise
from typing import Any

import numpy as np

from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import EPS, Truth, in_space
from mbs_ref.scene import Scene, SpatialBody, Universal
from mbs_ref.scene.euler_parameters import from_matrix, rotation_matrices
from mbs_ref.scenes.linkages import LINKAGES, SWING
from mbs_ref.scenes.robot_arms import ARMS, frames_at, pose_at
from mbs_ref.scenes.slider_cranks import PIVOT

SIZES = {  # m: D, AB, BC, CD of four-bars; the rods of Peaucellier's cell
    "watt": (2 - 1j, 1, 1, 1), "chebyshev": (2 + 0j, 2.5, 1, 2.5), "peaucellier": (2.5, 1),
}  # fmt: skip


def straight_line_linkage(scene: Scene, times: np.ndarray) -> Truth:
    """Place every rod at the crank's angle; the truth is as uncertain as the scene's rounded numbers leave it."""
    kind, speed = str(scene.parameters["kind"]), np.longdouble(scene.parameters["speed"])
    start, turn = LINKAGES[kind]["crank"][3] - SWING, speed * times.astype(np.longdouble)

    def placed(start: Any, *sizes: Any) -> np.ndarray:
        """Return middle (m) and angle of every rod, (3, n_t, n_rods)."""
        turned = np.exp(1j * (start + turn))
        rods = _cell(1 + turned, *sizes) if kind == "peaucellier" else _four_bar(turned, *sizes)
        middles = np.array([(one + other) / 2 for one, other in rods]).T
        angles = np.unwrap(np.angle(np.array([other - one for one, other in rods]).T), axis=0)
        return np.stack((middles.real, middles.imag, angles))

    numbers = (np.longdouble(start), *SIZES[kind])
    result = placed(*numbers)
    off = 2 * EPS * np.longdouble(np.max(np.abs(numbers[1:])))  # a length is the difference of two rounded coordinates
    rounded = [(*numbers[:k], numbers[k] + off, *numbers[k + 1 :]) for k in range(len(numbers))]
    doubt = EPS + sum(float(np.max(np.abs(placed(*others) - result))) for others in rounded)
    place, angles = np.moveaxis(result[:2], 0, -1).astype(float), result[2].astype(float)
    return Truth(place, angles, doubt, "exact", "rods placed in closed form in extended precision")


def _four_bar(turned: np.ndarray, d: Any, crank: Any, coupler: Any, rocker: Any):
    """Return the ends of crank, coupler and rocker; the law of cosines at B."""
    b = crank * turned
    reach = np.abs(d - b)
    c = b + coupler * (d - b) / reach * np.exp(
        -1j * np.arccos((coupler**2 + reach**2 - rocker**2) / (2 * coupler * reach))
    )
    return (0 * b, b), (b, c), (c, d + 0 * b)


def _cell(p: np.ndarray, long: Any, short: Any):
    """Return the ends of Peaucellier's rods: Q is P's inverse, and A and B lie across the middle of P and Q."""
    q = p * (long**2 - short**2) / np.abs(p) ** 2
    across = 1j * p / np.abs(p) * np.sqrt(short**2 - np.abs(q - p) ** 2 / 4)
    a, b, o = (p + q) / 2 + across, (p + q) / 2 - across, 0 * p
    return (1 + o, p), (o, a), (o, b), (p, a), (p, b), (a, q), (b, q)


def cardan_joint(scene: Scene, times: np.ndarray) -> Truth:
    """tan(psi) = cos(bend) tan(phi), written without its poles; one freedom."""
    first, second = scene.bodies
    bend = np.radians(np.longdouble(scene.parameters["angle"]))
    axis = np.array([np.cos(bend), np.sin(bend), 0 * bend])
    frame = np.array([[axis[0], -axis[1], 0], [axis[1], axis[0], 0], [0, 0, 1]])

    def poses(phi: Jet) -> tuple[Jet, Jet]:
        sine, cosine = jet.sin(phi), jet.cos(phi)
        slow = cosine * cosine + sine * sine * axis[0]
        ahead = jet.arctan(sine * cosine * (axis[0] - 1) * jet.reciprocal(slow))
        turns = [jet.turn((1.0, 0.0, 0.0), phi), jet.turn(axis, phi + ahead) @ frame]
        return jet.stack([jet.lift(np.array(body.position)) for body in (first, second)]), jet.stack(turns)

    ways = "Lagrange's by DOP853", "Hamilton's equations in one angle by extrapolation"
    return agree_on(scene, poses, 0.0, float(scene.parameters["speed"]), times, ways)


def n_four_bar(scene: Scene, times: np.ndarray) -> Truth:
    """All cranks turn alike: [(N+1)/3 + N] theta'' = [(N+1)/2 + N] g sin(theta), theta(0) = 0, theta'(0) = 1.

    Energy gives (theta/2)'^2 = 1/4 + kappa sin^2(theta/2), so theta/2 + pi/2 = am(K + t sqrt(1/4 + kappa) | m)
    with m = 4 kappa / (1 + 4 kappa).
    """
    loops = int(scene.parameters["loops"])
    theta = _crank_angle(loops, np.longdouble(scene.parameters["gravity"]), times.astype(np.longdouble))
    tip = np.stack([np.sin(theta), np.cos(theta)], axis=1)  # B_k - A_k, m
    feet = np.arange(loops + 1)[:, None] * np.array([1.0, 0.0])
    cranks = feet + tip[:, None] / 2
    couplers = feet[:-1] + np.array([0.5, 0.0]) + tip[:, None]
    upright = np.arctan2(np.longdouble(1), np.longdouble(0))
    angle = np.concatenate([np.repeat((upright - theta)[:, None], loops + 1, 1), np.zeros((len(times), loops))], 1)
    rounding = 1e3 * float(np.finfo(np.longdouble).eps) * (1.0 + 10.0 * float(times[-1]))
    return Truth(
        np.concatenate([cranks, couplers], axis=1).astype(float), angle.astype(float),
        2.3e-16 * (loops + 1) + rounding, "exact",
        "one degree of freedom; Jacobi's amplitude by the arithmetic-geometric mean in extended precision",
    )  # fmt: skip


def _crank_angle(loops: int, gravity, times: np.ndarray) -> np.ndarray:
    """Crank angle (n_t,) from the vertical, rad."""
    one = np.longdouble(1)
    kappa = gravity * ((loops + 1) * one / 2 + loops) / ((loops + 1) * one / 3 + loops)  # 1/s^2
    m = 4 * kappa / (1 + 4 * kappa)
    phase = amplitude(quarter_period(m) + times * np.sqrt(one / 4 + kappa), m)
    return 2 * phase - 2 * np.arctan2(one, one * 0)


def spatial_n_four_bar(scene: Scene, times: np.ndarray) -> Truth:
    """Lift the exact planar motion into the plane z = 0."""
    return in_space(n_four_bar(scene, times))


ROOT3 = np.sqrt(np.longdouble(3))
BRICARD_START = np.arctan2(np.sqrt(np.longdouble(2)), np.longdouble(1))  # both angles are right ones there


def bricard(scene: Scene, times: np.ndarray) -> Truth:
    """Three hinges turn by theta, the three between them by phi, with cos(theta/2) cos(phi/2) = 1/2.

    The threefold-symmetric linkage with right-angled twists (Chen, You, Tarnai, Int. J. Solids Struct. 42
    (2005) 2287: cos(theta) + cos(phi) + cos(theta) cos(phi) = 0). The half-angles are the legs of a right
    spherical triangle of hypotenuse 60 degrees; its angle s is a coordinate without turning points.
    """
    hinges: Any = scene.joints
    rods = [np.subtract(b.point, a.point) for a, b in pairwise(hinges)]
    bodies = (body for body in scene.bodies if isinstance(body, SpatialBody))
    start = [rotation_matrices(body.orientation).astype(np.longdouble) for body in bodies]
    right = 2 * np.arctan(np.longdouble(1))

    def poses(s: Jet) -> tuple[Jet, Jet]:
        theta, phi = jet.arctan(jet.cos(s) * ROOT3) * 2, jet.arcsin(jet.sin(s) * (ROOT3 / 2)) * 2
        turns = (jet.lift(right) - theta, jet.lift(right) - phi)  # from the start, about the scene's axes
        turned, corner = jet.lift(np.eye(3)), jet.lift(np.zeros(3))
        places, axes = [], []
        for k, (rod, frame) in enumerate(zip(rods, start, strict=True)):
            turned = turned @ jet.turn(hinges[k].axis, turns[k % 2])
            along = turned @ rod
            places.append(corner + along * 0.5)
            axes.append(turned @ frame)
            corner = corner + along
        return jet.stack(places), jet.stack(axes)

    how = "Hamilton's equations in the one coordinate of the closed loop by extrapolation in extended precision"
    return agree_on(scene, poses, BRICARD_START, np.longdouble(0), times, ("Lagrange's by DOP853", how))


WAYS = "Lagrange's by DOP853", "Hamilton's equations in the crank angle by extrapolation in extended precision"


def slider_crank(scene: Scene, times: np.ndarray) -> Truth:
    """Crank at phi, rod at psi: r sin(phi) + l sin(psi) = 0."""
    given = scene.parameters
    crank, rod = float(given["crank_length"]), float(given["rod_length"])

    def poses(phi: Jet) -> tuple[Jet, Jet]:
        psi = -jet.arcsin(jet.sin(phi) * (crank / rod))
        pin, reach = (jet.stack([jet.cos(a), jet.sin(a)]) * size for a, size in ((phi, crank), (psi, rod)))
        slider = jet.stack([(pin + reach)[0], phi * 0])
        return jet.stack([pin * 0.5, pin + reach * 0.5, slider]), jet.stack([phi, psi, phi * 0])

    return agree_on(scene, poses, float(given["crank_angle"]), float(given["crank_speed"]), times, WAYS)


def four_bar_with_spring(scene: Scene, times: np.ndarray) -> Truth:
    """Both cranks turn alike, and the coupler goes along; the diagonal is 2 sin(theta/2)."""
    stiffness, rest = float(scene.parameters["stiffness"]), float(scene.parameters["rest"])

    def poses(theta: Jet) -> tuple[Jet, Jet]:
        tip = jet.stack([jet.cos(theta), jet.sin(theta)])
        places = [tip * 0.5, tip + jet.lift(np.array([0.5, 0.0])), tip * 0.5 + jet.lift(np.array([1.0, 0.0]))]
        return jet.stack(places), jet.stack([theta, theta * 0, theta])

    def stored(theta: Jet) -> Jet:
        stretch = jet.sin(theta * 0.5) * 2 - rest
        return stretch * stretch * (0.5 * stiffness)

    start = np.radians(np.longdouble(scene.parameters["angle"]))
    return agree_on(scene, poses, start, np.longdouble(0), times, WAYS, stored=stored)


def spatial_slider_crank(scene: Scene, times: np.ndarray) -> Truth:
    """Crank about x from upright; the rod from its pin to the slider, turned as the universal joint lets it."""
    crank, rod = float(scene.parameters["crank_length"]), float(scene.parameters["rod_length"])
    wrist = next(joint for joint in scene.joints if isinstance(joint, Universal))
    second, first = (np.array(axis) / np.linalg.norm(axis) for axis in (wrist.axis_a, wrist.axis_b))

    def poses(angle: Jet) -> tuple[Jet, Jet]:
        turned = jet.turn((1.0, 0.0, 0.0), angle)
        arm = turned @ np.array([0.0, 0.0, crank])
        pin = arm + PIVOT
        across = pin * pin
        reach = jet.sqrt(jet.lift(rod**2) - across[1] - across[2])
        slide = reach * np.array([1.0, 0.0, 0.0])
        along = (slide - pin) * (1 / rod)
        normal = jet.unit(jet.cross(along, second)) * sign
        axes = jet.stack([along, normal, jet.cross(along, normal)], axis=1)
        places = jet.stack([arm * 0.5 + PIVOT, (pin + slide) * 0.5, slide])
        return places, jet.stack([turned, axes, jet.lift(np.eye(3))])

    sign = 1.0
    sign = float(np.sign(poses(jet.parameter(0.0))[1].value[1][:, 1] @ first))
    return agree_on(scene, poses, 0.0, float(scene.parameters["crank_speed"]), times, WAYS, is_costly=True)


def puma560(scene: Scene, times: np.ndarray) -> Truth:
    """Multiply the arm's Denavit-Hartenberg frames at the prescribed coordinates."""
    rate, acceleration = float(scene.parameters["rate"]), float(scene.parameters["acceleration"])
    poses = pose_at(scene.name, times, rate, acceleration)
    frames = np.array([frames_at(scene.name, pose)[1:] for pose in poses])
    centres = np.array([(*link["centre"], 1.0) for link in ARMS[scene.name]["links"]])
    error = 20.0 * EPS * (1.0 + float(np.abs(poses - poses[0]).max()))
    orientation = np.array([[from_matrix(frame[:3, :3]) for frame in row] for row in frames])
    return Truth(np.einsum("tbij,bj->tbi", frames, centres)[..., :3], orientation, error, "exact", "forward kinematics")


TRUTHS = {"stanford_arm": puma560}
