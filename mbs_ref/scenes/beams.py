"""Flexible bodies: beams as rigid segments, between which springs have the beam's stiffness.

A segment of length h carries the mass of its part of the beam. Where two meet, a bushing of E A/h and a torsion spring
of E I/h join them, and twice that where a beam is clamped: the element of Simo and Reissner with one point of
integration, its shear in the plane as stiff as its axis. In space one bushing has all six. With n segments the error is
in proportion to 1/n^2 (Huston, Computers and Structures 13 (1981) 45-49).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from mbs_ref.scene import (
    GROUND,
    Bushing,
    CoordinateDrive,
    Force,
    PlanarBody,
    PointBushing,
    Prismatic,
    Revolute,
    Scene,
    SpatialBody,
    TorsionSpring,
)
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.signals import Constant, Harmonic

Segments = Annotated[int, Field(ge=2, le=200)]


@dataclass(frozen=True)
class Beam:
    """A uniform beam along x at t = 0, in segments."""

    segments: int
    length: float  # m
    axial: float  # N, E A
    bending: float  # N m^2, E I
    density: float  # kg/m
    rotary: float  # kg m, moment of inertia of a section's matter per length

    @property
    def pitch(self) -> float:
        """The length h of a segment, m."""
        return self.length / self.segments

    def bodies(self, motion: Callable[[int], dict]) -> list[PlanarBody]:
        """Return the segments; `motion` gives the place and the rates of each."""
        mass = self.density * self.pitch
        inertia = mass * self.pitch**2 / 12.0 + self.rotary * self.pitch
        return [PlanarBody(name=f"segment{k}", mass=mass, inertia=inertia, **motion(k)) for k in range(self.segments)]

    def springs(self, start: float, clamp: str = "") -> list[PointBushing | TorsionSpring]:
        """Return what joins the segments from x = start (m) on, unstrained, and clamps the first to a body if named."""
        springs: list[PointBushing | TorsionSpring] = []
        for k in range(0 if clamp else 1, self.segments):
            ends: dict[str, Any] = {"body_a": f"segment{k - 1}" if k else clamp, "body_b": f"segment{k}"}
            share, at = (1.0 if k else 2.0) / self.pitch, (start + k * self.pitch, 0.0)
            springs += [
                PointBushing(name=f"stretch{k}", point=at, stiffness=share * self.axial, **ends),
                TorsionSpring(name=f"bend{k}", stiffness=share * self.bending, rest_angle=0.0, **ends),
            ]
        return springs


def spin_up_beam(*, segments: Segments = 16, speed: Positive = 6.0, rise: Positive = 15.0) -> Scene:
    """Spin up a flexible beam about its root, which lags behind and stretches by rho A w^2 L^3/(3 E A) at full speed.

    segments, speed (rad/s) after `rise` (s), when the run ends: w = speed (t/rise - sin(2 pi t/rise)/(2 pi)).
    """
    beam = Beam(segments, 10.0, 2.8e7, 1.4e4, 1.2, 6e-4)
    start = speed / rise
    spin = Harmonic(amplitude=-start, omega=2.0 * math.pi / rise, phase=0.5 * math.pi, offset=start)
    return Scene(
        name="spin_up_beam", description=f"A flexible beam of {segments} segments spins up about its root.",
        source="Simo, Vu-Quoc, J. Appl. Mech. 53 (1986) 849-863; Wu, Haug, IJNME 26 (1988) 2211-2226", duration=rise,
        bodies=(
            PlanarBody(name="hub", mass=1.0, inertia=1.0),
            *beam.bodies(lambda k: {"position": ((k + 0.5) * beam.pitch, 0.0)}),
        ),
        joints=(
            Revolute(name="axle", body_a=GROUND, body_b="hub", point=(0.0, 0.0)),
            CoordinateDrive(name="drive", body="hub", coordinate="angle", motion=spin, level="acceleration"),
        ),
        loads=tuple(beam.springs(0.0, "hub")),
    )  # fmt: skip


CRANK, SLIDER, SPEED = 0.15, 0.075552, 150.0  # m, kg, rad/s
ROD = (0.3, 1.28e7, 0.2e12 * 0.008**4 / 12.0, 7870.0 * 0.008**2, 7870.0 * 0.008**4 / 12.0)  # see Beam, without segments
BOW = (0.4448961125815990, 0.4634339319238670e-2)  # m/s, rates of the sines q1, q2: start of the IVP test set, as below
STRETCH = (0.1033398630e-4, 0.1693279690e-4)  # m, q3 and q4: along the rod at its middle and at its end
SWING = -74.99576703969453  # rad/s, of the rod


def flexible_slider_crank(*, segments: Segments = 16) -> Scene:
    """Turn a crank at 150 rad/s that drives a slider through a flexible rod (IVP test set, slider crank).

    segments (of the rod). The start is the test set's, on its smooth motion. Its published end is that of two bending
    modes on a straight rod whose tension does not stiffen it, as here it does.
    """
    rod = Beam(segments, *ROD)
    reach = CRANK + rod.length + STRETCH[1]

    def motion(k: int) -> dict:
        """Return a segment on the curve of two sines and a parabola; the first and the last end at their pins."""
        s = (k + 0.5) / segments
        u = 4.0 * s * (1.0 - s) * STRETCH[0] + s * (2.0 * s - 1.0) * STRETCH[1]
        waves = [(math.pi * (j + 1), rate) for j, rate in enumerate(BOW)]
        turning = SWING + sum(w / rod.length * math.cos(w * s) * rate for w, rate in waves)
        x = CRANK + s * rod.length + u
        rise = CRANK * SPEED + SWING * s * rod.length + sum(math.sin(w * s) * rate for w, rate in waves)
        if k == 0:
            x, rise = CRANK + 0.5 * rod.pitch, CRANK * SPEED + 0.5 * rod.pitch * turning
        elif k == segments - 1:
            x, rise = reach - 0.5 * rod.pitch, -0.5 * rod.pitch * turning
        return {"position": (x, 0.0), "velocity": (0.0, rise), "angular_velocity": turning}

    crank = PlanarBody(
        name="crank", mass=0.36, inertia=0.002727 - 0.36 * (0.5 * CRANK) ** 2, position=(0.5 * CRANK, 0.0),
        velocity=(0.0, 0.5 * CRANK * SPEED), angular_velocity=SPEED,
    )  # fmt: skip
    last = f"segment{segments - 1}"
    return Scene(
        name="flexible_slider_crank", description=f"A driven crank, a rod of {segments} segments and a slider.",
        source="Simeon, Math. Modelling of Systems 2 (1996) 1-18; Test Set for IVP Solvers 2.4, slider crank",
        duration=0.1,
        bodies=(
            crank, *rod.bodies(motion),
            PlanarBody(name="slider", mass=SLIDER, inertia=0.01 * SLIDER, position=(reach, 0.0)),
        ),
        joints=(
            Revolute(name="bearing", body_a=GROUND, body_b="crank", point=(0.0, 0.0)),
            CoordinateDrive(
                name="drive", body="crank", coordinate="angle", motion=Constant(value=SPEED), level="velocity"
            ),
            Revolute(name="crank_pin", body_a="crank", body_b="segment0", point=(CRANK, 0.0)),
            Revolute(name="wrist_pin", body_a=last, body_b="slider", point=(reach, 0.0)),
            Prismatic(name="guide", body_a=GROUND, body_b="slider", point=(reach, 0.0), axis=(1.0, 0.0)),
        ),
        loads=tuple(rod.springs(CRANK)),
    )  # fmt: skip


SPAN, HEIGHT, WIDTH = 0.508, 12.3777e-3, 3.2024e-3  # m, of the Princeton beam: along x, y, z
YOUNG, POISSON, DENSITY = 71.7e9, 0.31, 2810.0  # Pa, 1, kg/m^3: aluminium 7075
TWIST = 1.0 / 3.0 * (1.0 - 0.63025 * WIDTH / HEIGHT)  # of HEIGHT WIDTH^3: Saint-Venant's J, Timoshenko and Goodier 1970


def princeton_beam(
    *,
    segments: Annotated[int, Field(ge=2, le=100)] = 16,
    load: NonNegative = 13.345,
    angle: Annotated[float, Field(ge=0.0, le=90.0)] = 45.0,
) -> Scene:
    """Load a flat cantilever at its tip, obliquely: it bends both ways and twists, by up to 0.4 of its length.

    segments; load (N) and its angle (deg) from the section's height. With start = "equilibrium" it rests, as in the
    source; without, it is released straight.
    """
    pitch, area, shear = SPAN / segments, HEIGHT * WIDTH, YOUNG / (2.0 + 2.0 * POISSON)
    second = [HEIGHT * WIDTH**3 / 12.0, WIDTH * HEIGHT**3 / 12.0]  # m^4, about y and z
    rigid = (YOUNG * area, shear * area, shear * area, shear * TWIST * HEIGHT * WIDTH**3, *(YOUNG * i for i in second))
    mass, lean = DENSITY * area * pitch, math.radians(angle)
    across = [mass * pitch**2 / 12.0 + DENSITY * pitch * i for i in second]
    inertia: Any = (DENSITY * pitch * sum(second), *across, 0.0, 0.0, 0.0)
    joined: list[Any] = [tuple(share / pitch * x for x in rigid) for share in (2.0, 1.0)]  # at the clamp, elsewhere
    names = [f"segment{k}" for k in range(segments)]
    return Scene(
        name="princeton_beam", description=f"A flat cantilever of {segments} segments, loaded at its tip.",
        source="Dowell, Traybar, Princeton AMS reports 1194 and 1257 (1975); Bauchau et al., Multibody System Dynamics "
        "34 (2015) 373-389; Obrezkov et al., Nonlinear Dynamics 109 (2022) 531-546", duration=0.05,
        gravity=(0.0, 0.0, 0.0),
        bodies=tuple(
            SpatialBody(name=name, mass=mass, inertia=inertia, position=((k + 0.5) * pitch, 0.0, 0.0))
            for k, name in enumerate(names)
        ),
        loads=(
            Force(name="weight", body=names[-1], point=(SPAN, 0.0, 0.0),
                  vector=(0.0, -load * math.cos(lean), load * math.sin(lean))),
            *(
                Bushing(name=f"joint{k}", body_a=names[k - 1] if k else GROUND, body_b=name,
                        point=(k * pitch, 0.0, 0.0), stiffness=joined[min(k, 1)])
                for k, name in enumerate(names)
            ),
        ),
    )  # fmt: skip
