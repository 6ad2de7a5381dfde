"""Andrews' squeezer: seven bodies in the plane, three loops, one freedom."""

import math

from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene, SpringDamper, Torque

A, B, C = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)  # m, fixed points; the crank turns about the origin
RR, D, SS, E, ZT, U, ZF = 0.007, 0.028, 0.035, 0.02, 0.04, 0.04, 0.02  # m, joint to joint, K1 to K5, K7, K6
CENTRES = {  # m, along a body from its first joint, and to the left
    "K1": (0.00092, 0.0), "K2": (0.0115, 0.0), "K3": (0.01874, 0.01043), "K4": (E - 0.01421, 0.0),
    "K5": (0.02308, 0.00916), "K6": (ZF - 0.01421, 0.0), "K7": (0.01228, -0.00449),
}  # fmt: skip
HOOK = (0.018, 0.02)  # m, of the spring on K3, measured alike
MASS = {"K1": 0.04325, "K2": 0.00365, "K3": 0.02373, "K4": 0.00706, "K5": 0.07050, "K6": 0.00706, "K7": 0.05498}  # kg
INERTIA = {
    "K1": 2.194e-6, "K2": 4.410e-7, "K3": 5.255e-6, "K4": 5.667e-7, "K5": 1.169e-5, "K6": 5.667e-7, "K7": 1.912e-5,
}  # kg m^2, about the centre of mass  # fmt: skip
STIFFNESS, REST, DRIVE = 4530.0, 0.07785, 0.033  # N/m, m, N m
START = {  # rad: beta, Theta, gamma, Phi, delta, Omega, epsilon of the source
    "beta": -0.0617138900142764496358948458001, "Theta": 0.0, "gamma": 0.455279819163070380255912382449,
    "Phi": 0.222668390165885884674473185609, "delta": 0.487364979543842550225598953530,
    "Omega": -0.222668390165885884674473185609, "epsilon": 1.23054744454982119249735015568,
}  # fmt: skip
# How far a body's direction from its first to its second joint is turned from the angle that the source gives it.
AHEAD = {"K1": 0.0, "K2": math.pi, "K3": -math.pi / 2, "K4": -math.pi / 2, "K5": 0.0, "K6": 0.0, "K7": -math.pi / 2}


def andrews() -> Scene:
    """Squeeze: a constant torque drives the crank from rest against a stiff spring (IFToMM A03, Andrews' mechanism).

    Angles of K1 to K7 are beta, beta + Theta, gamma, Phi + delta, delta, Omega + epsilon and epsilon of the source.
    """
    q = START
    angles = {
        "K1": q["beta"], "K2": q["beta"] + q["Theta"], "K3": q["gamma"], "K4": q["Phi"] + q["delta"], "K5": q["delta"],
        "K6": q["Omega"] + q["epsilon"], "K7": q["epsilon"],
    }  # fmt: skip
    crank = _along((0.0, 0.0), angles["K1"], RR)
    upper, lower = _along(A, angles["K5"], ZT), _along(A, angles["K7"] - math.pi / 2, U)
    apex = _along(B, angles["K3"] - math.pi / 2, SS)
    roots = {"K1": (0.0, 0.0), "K2": crank, "K3": B, "K4": upper, "K5": A, "K6": lower, "K7": A}
    bodies = tuple(
        PlanarBody(name=name, mass=MASS[name], inertia=INERTIA[name], angle=angles[name],
                   position=_along(roots[name], angles[name] + AHEAD[name], *CENTRES[name]))
        for name in roots
    )  # fmt: skip
    pins = (
        ("O", GROUND, "K1", (0.0, 0.0)), ("K1_K2", "K1", "K2", crank), ("B", GROUND, "K3", B),
        ("A5", GROUND, "K5", A), ("K4_K5", "K5", "K4", upper), ("A7", GROUND, "K7", A), ("K6_K7", "K7", "K6", lower),
        ("P3", "K2", "K3", apex), ("P4", "K2", "K4", apex), ("P6", "K2", "K6", apex),
    )  # fmt: skip
    hook = _along(B, angles["K3"] + AHEAD["K3"], *HOOK)
    return Scene(
        name="andrews",
        description="Andrews' squeezing mechanism: a motor drives seven bodies against a stiff spring, for 0.03 s.",
        source="IFToMM benchmark library, A03; Hairer and Wanner, Solving Ordinary Differential Equations II (1996), "
        "sec. VII.7; Mazzia and Magherini, Test Set for Initial Value Problem Solvers, release 2.4 (2008), andrews",
        duration=0.03,
        bodies=bodies,
        joints=tuple(Revolute(name=n, body_a=a, body_b=b, point=point) for n, a, b, point in pins),
        loads=(
            Torque(name="motor", body="K1", torque=DRIVE),
            SpringDamper(name="spring", body_a=GROUND, body_b="K3", point_a=C, point_b=hook, stiffness=STIFFNESS,
                         rest_length=REST),
        ),
    )  # fmt: skip


def _along(start: tuple[float, float], angle: float, ahead: float, left: float = 0.0) -> tuple[float, float]:
    """Return the point that lies so far ahead and to the left of a start, in a direction."""
    c, s = math.cos(angle), math.sin(angle)
    return start[0] + ahead * c - left * s, start[1] + ahead * s + left * c
