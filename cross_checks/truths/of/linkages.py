"""Truths of linkages: pins by complex numbers and Peaucellier's inversion, Cardan's joint by its equation."""

from typing import Any

import numpy as np

from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import EPS, Truth
from mbs_ref.scene import Scene
from mbs_ref.scenes.linkages import LINKAGES, SWING

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
