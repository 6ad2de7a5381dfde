"""Truths of linkages: pins by complex numbers and Peaucellier's inversion, Cardan's joint by its equation."""

import numpy as np

from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scenes.linkages import LINKAGES, SWING

FOUR_BARS = {"watt": (2 - 1j, 1, 1, 1), "chebyshev": (2 + 0j, 2.5, 1, 2.5)}  # D, AB, BC, CD, m
LONG, SHORT = 2.5, 1  # m, rods of Peaucellier's cell


def straight_line_linkage(scene: Scene, times: np.ndarray) -> Truth:
    """Place every rod at the crank's angle."""
    kind, speed = str(scene.parameters["kind"]), np.longdouble(scene.parameters["speed"])
    turned = np.exp(1j * (LINKAGES[kind]["crank"][3] - SWING + speed * times.astype(np.longdouble)))
    rods = _cell(1 + turned) if kind == "peaucellier" else _four_bar(turned, *FOUR_BARS[kind])
    ways = np.array([other - one for one, other in rods]).T
    middles = np.array([(one + other) / 2 for one, other in rods]).T
    angles = np.unwrap(np.angle(ways), axis=0).astype(float)
    place = np.stack([middles.real, middles.imag], axis=-1).astype(float)
    return Truth(place, angles, 1e-15, "exact", "rods placed in closed form in extended precision")


def _four_bar(turned: np.ndarray, d: complex, crank: float, coupler: float, rocker: float):
    """Return the ends of crank, coupler and rocker; the law of cosines at B."""
    b = crank * turned
    reach = np.abs(d - b)
    c = b + coupler * (d - b) / reach * np.exp(
        -1j * np.arccos((coupler**2 + reach**2 - rocker**2) / (2 * coupler * reach))
    )
    return (0 * b, b), (b, c), (c, d + 0 * b)


def _cell(p: np.ndarray):
    """Return the ends of Peaucellier's rods: Q is P's inverse, and A and B lie across the middle of P and Q."""
    q = p * (LONG**2 - SHORT**2) / np.abs(p) ** 2
    across = 1j * p / np.abs(p) * np.sqrt(SHORT**2 - np.abs(q - p) ** 2 / 4)
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
