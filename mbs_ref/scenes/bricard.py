"""Bricard's mechanism, problem A04 of the IFToMM benchmark library: overconstrained, and yet it moves."""

import math
from itertools import pairwise

import numpy as np

from mbs_ref.scene import GROUND, Revolute, Scene, SpatialBody
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.euler_parameters import from_matrix

ROD_MASS, ROD_LENGTH = 1.0, 1.0  # kg, m
ACROSS = ROD_MASS * ROD_LENGTH**2 / 12.0  # kg m^2, uniform thin rod about its centre
SLENDER = 1e-4  # axial over transverse moment: the benchmark's rods are lines, whose axial moment would be 0
CORNERS = ((0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1))  # edges of a cube, in rod lengths
AXES = ((0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0))  # of the hinge at each corner


def bricard(*, gravity: Positive = 9.81) -> Scene:
    """Let five rods on six hinges fall round an edge of a cube (IFToMM A04): one freedom where Gruebler counts none.

    gravity (m/s^2, along -y).
    """
    rods = [f"rod{k + 1}" for k in range(5)]
    chain = [GROUND, *rods, GROUND]
    corners = [tuple(ROD_LENGTH * x for x in corner) for corner in CORNERS]
    return Scene(
        name="bricard",
        description="Five 1 m rods and the ground, an edge loop of a cube with six hinges; a redundant loop.",
        source="IFToMM Technical Committee for Multibody Dynamics, benchmark library, A04 Bricard's mechanism",
        duration=10.0,
        gravity=(0.0, -gravity, 0.0),
        bodies=tuple(_rod(name, *ends) for name, ends in zip(rods, pairwise(corners), strict=True)),
        joints=tuple(
            Revolute(name=f"hinge{k + 1}", body_a=a, body_b=b, point=corners[k], axis=AXES[k])
            for k, (a, b) in enumerate(pairwise(chain))
        ),
    )


def _rod(name: str, start: tuple[float, ...], end: tuple[float, ...]) -> SpatialBody:
    """A rod whose body x axis runs from start to end."""
    along = np.subtract(end, start) / math.dist(start, end)
    across = np.roll(along, 1)
    theta = from_matrix(np.column_stack((along, across, np.cross(along, across))))
    return SpatialBody(
        name=name, mass=ROD_MASS, inertia=(SLENDER * ACROSS, ACROSS, ACROSS, 0.0, 0.0, 0.0),
        position=tuple((0.5 * np.add(start, end)).tolist()), orientation=tuple(theta.tolist()),
    )  # fmt: skip
