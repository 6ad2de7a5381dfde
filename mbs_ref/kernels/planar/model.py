"""The arrays of a compiled planar scene, one homogeneous group per element type.

See `rigid.model` for the numbering.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import accessor
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.rigid import model as shared
from mbs_ref.kernels.rigid.closures import Closures, Loops
from mbs_ref.kernels.signals import SignalArrays

RATES = tuple(range(3))  # of a body: a loop over it has bounds that the compiler knows


class Bodies(NamedTuple):
    mass: Annotated[Floats, "n"]  # kg
    inertia: Annotated[Floats, "n"]  # kg m^2; 1 for a point mass, whose third slot stays at rest
    scene_index: Annotated[Ints, "n"]  # place in the scene's order
    q: Annotated[Ints, "n"]  # first place in the state of Rx, Ry, theta
    v: Annotated[Ints, "n"]  # first place in the state of their rates
    parent: Annotated[Ints, "n"]  # n for ground or none


class Slots(NamedTuple):
    body: Annotated[Ints, "n_slots", 2]  # sides 0 and 1
    padding: Annotated[Floats, "n_slots", 3]  # : 1 where a row is unused, else 0


class Angles(NamedTuple):
    """theta_b - theta_a = value: one row."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]  # which side of the slot is body_a
    value: Annotated[Floats, "k"]  # rad


class AngleDrives(NamedTuple):
    """theta - start = signal: one row, the other side is ground."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side: Annotated[Ints, "k"]  # which side of the slot is the body
    start: Annotated[Floats, "k"]  # rad
    signal: Annotated[Ints, "k"]


class Forces(NamedTuple):
    body: Annotated[Ints, "k"]
    point: Annotated[Floats, "k", 2]  # m, in the body
    vector: Annotated[Floats, "k", 2]  # N
    follows: Annotated[Ints, "k"]  # 1 along body axes
    torque: Annotated[Floats, "k"]  # N m
    signal: Annotated[Ints, "k"]


class TorsionSprings(NamedTuple):
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    stiffness: Annotated[Floats, "k"]  # N m/rad
    damping: Annotated[Floats, "k"]  # N m s/rad
    rest_angle: Annotated[Floats, "k"]  # rad


class PlanarGroups(NamedTuple):
    """Every array of a compiled planar scene."""

    bodies: Bodies
    slots: Slots
    loops: Loops
    points: shared.Points
    planes: shared.Planes
    angles: Angles
    distances: shared.Distances
    drives: shared.Drives
    angle_drives: AngleDrives
    forces: Forces
    springs: shared.Springs
    torsion_springs: TorsionSprings
    contact_pairs: shared.ContactPairs
    contact_laws: ContactLaws
    contact_modes: ContactModes
    near_pairs: NearPairs
    watches: shared.Watches
    signals: SignalArrays
    world: shared.World


angles_of = accessor("angles")
angle_drives_of = accessor("angle_drives")


class Kinematics(NamedTuple):
    """Last row: ground."""

    pose: Annotated[Floats, "n + 1", 4]  # x, y, cos, sin
    motion: Annotated[Floats, "n + 1", 4]  # vx, vy, omega, theta
    force: Annotated[Floats, "n + 1", 3]  # N, N, N m
    user: Annotated[Floats, 3, "n", 3]  # q, v and f in scene order, for a user's force law


class Tree(NamedTuple):
    articulated: Annotated[Floats, "n + 1", 3, 3]  # lower triangle used
    mass_factor: Annotated[Floats, "n", 6]  # L D L^T of the articulated block
    row_factor: Annotated[Floats, "n", 6]  # L D L^T of J M^-1 J^T
    lift: Annotated[Floats, "n", 3, 3]  # M^-1 J^T
    transfer: Annotated[Floats, "n", 3, 3]  # (J M^-1 J^T)^-1 K
    free: Annotated[Floats, "n", 3]  # M^-1 f of the pass under way
    load: Annotated[Floats, "n + 1", 3]  # f accumulated
    acceleration: Annotated[Floats, "n + 1", 3]  # the solution of the pass, ground row zero


class PlanarScratch(NamedTuple):
    """Scratch of one run."""

    kinematics: Kinematics
    rows: shared.Rows
    tree: Tree
    closures: Closures
    solved: shared.Solved
