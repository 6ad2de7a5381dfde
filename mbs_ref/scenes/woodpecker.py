"""The woodpecker toy: a bird on a spring on a sleeve, which jams on a pole, lets go, and falls a little each time."""

import math

from mbs_ref.scene import CoordinateDrive, PlanarBody, Revolute, Scene, TorsionSpring
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.contact import CircleOnLine, SpringDamperLaw, StickSlip
from mbs_ref.scene.signals import Constant

SLEEVE, BIRD = (3e-4, 5e-9), (4.5e-3, 7e-7)  # kg, kg m^2
SPRING = 5.6e-3  # N m/rad, between sleeve and bird
POLE, BORE, HALF_HEIGHT = 2.5e-3, 3.1e-3, 5.8e-3  # m: radii of pole and sleeve, half of the sleeve's height
HINGE, CENTRE, BEAK = 0.010, 0.015, (0.015 - 0.0201, 0.020)  # m: from sleeve to hinge, from hinge to the bird's parts
FRICTION, REBOUND = 0.3, 0.5  # -: mu; restitution of the beak, that of the sleeve is 0
FALLING, LEANING, SWINGING = -0.3411, -0.2788, -7.4583  # m/s, rad, rad/s: on the published periodic motion
JAMMED = math.acos(POLE / math.hypot(BORE, HALF_HEIGHT)) - math.atan2(HALF_HEIGHT, BORE)  # rad, of the sleeve


def woodpecker(*, stiffness: Positive = 1e5, gravity: Positive = 9.81) -> Scene:
    """Let a toy woodpecker peck its way down a pole: jamming, release and impacts with friction, once a period.

    stiffness (N/m) of the contacts, whose dampers give the published restitutions to a free sleeve and a free bird;
    gravity (m/s^2). Published for rigid impacts by Newton's law and for geometry linear in the angles, which reach
    0.5 rad: a period of 0.1452 s. The first peck hardly depends on either, later ones do.
    """
    hinge = (HINGE * math.cos(JAMMED), -HINGE * math.sin(JAMMED))
    along, across = (math.cos(LEANING), math.sin(LEANING)), (-math.sin(LEANING), math.cos(LEANING))
    beak = tuple(hinge[k] + BEAK[0] * along[k] + BEAK[1] * across[k] for k in range(2))
    sleeve = PlanarBody(name="sleeve", mass=SLEEVE[0], inertia=SLEEVE[1], angle=-JAMMED, velocity=(0.0, FALLING))
    bird = PlanarBody(
        name="bird", mass=BIRD[0], inertia=BIRD[1], angle=LEANING, angular_velocity=SWINGING,
        position=(hinge[0] + CENTRE * along[0], hinge[1] + CENTRE * along[1]),
        velocity=(SWINGING * CENTRE * across[0], FALLING + SWINGING * CENTRE * across[1]),
    )  # fmt: skip
    corner, up = math.hypot(BORE, HALF_HEIGHT), math.atan2(HALF_HEIGHT, BORE)
    lower, upper = ((corner * math.cos(a), corner * math.sin(a)) for a in (-up - JAMMED, up - JAMMED))
    log = math.log(REBOUND)
    # of the turning body at its mark: its mass (kg), and the share of critical damping
    of = {
        "sleeve": (SLEEVE[1] / HALF_HEIGHT**2, 1.0),
        "bird": (BIRD[1] / BEAK[1] ** 2, -log / math.hypot(math.pi, log)),
    }
    law = {
        name: {"stiffness": stiffness, "damping": 2.0 * share * math.sqrt(stiffness * mass)}
        for name, (mass, share) in of.items()
    }
    return Scene(
        name="woodpecker", description="A bird on a torsion spring on a sleeve that jams on a pole.",
        source="Glocker, Dynamik von Starrkoerpersystemen mit Reibung und Stoessen (1995) 162; "
        "Leine, Glocker, van Campen, Nonlinear Dynamics of the Woodpecker Toy, ASME DETC2001/VIB-21608",
        duration=0.5, gravity=(0.0, -gravity), bodies=(sleeve, bird),
        joints=(
            CoordinateDrive(name="pole", body="sleeve", coordinate="x", motion=Constant(value=0.0)),
            Revolute(name="hinge", body_a="sleeve", body_b="bird", point=hinge),
        ),
        loads=(TorsionSpring(name="spring", body_a="sleeve", body_b="bird", stiffness=SPRING, rest_angle=0.0),),
        contacts=tuple(
            CircleOnLine(
                name=name, body_a=body, center=mark, radius=0.0, point_1=(POLE, 1.0), point_2=(POLE, 0.0),
                law=SpringDamperLaw(release="force", **law[body]),
                friction=StickSlip(coefficient=FRICTION, **law[body]),
            )
            for name, body, mark in (("lower", "sleeve", lower), ("upper", "sleeve", upper), ("beak", "bird", beak))
        ),
    )  # fmt: skip
