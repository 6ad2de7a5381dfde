"""Loads and contacts for tree mechanisms of other engines, by our own force code: then dynamics is what is compared.

Contact forces are clipped by the state instead of switched at located events, so a one-step method is of
order 2 where a force starts with a kink, and of order 1 where it jumps.
"""

from __future__ import annotations

import numpy as np

from cross_checks.workshop.method import Refusal
from cross_checks.workshop.planar_motion import arrays_of, motion_of, project
from cross_checks.workshop.planar_tree import JointTree
from mbs_ref.cores.planar.system import PlanarSystem
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import FloresLaw, LankaraniNikraveshLaw, RigidLaw, StickSlip

SHARED = "loads and contacts come from the shared force code, called through Python"
# what gives a force that follows from the state alone
CLIPPED_CONTACTS = frozenset(
    {"circle_on_line", "circle_on_circle", "pin_on_sprocket"}
    | {"spring_damper_law", "progressive_law", "hunt_crossley_law", "regularised_coulomb"}
)


def contact_refusals(scene: Scene) -> list[Refusal]:
    """Return why the scene's contacts need located events, contact by contact."""
    return [
        Refusal(f"contact {c.name!r}: {c.law.type} or its friction needs located events", False)
        for c in scene.contacts
        if isinstance(c.law, RigidLaw | LankaraniNikraveshLaw | FloresLaw) or isinstance(c.friction, StickSlip)
    ]


class AppliedForces:
    """Generalized applied forces of a scene, gravity included, in the coordinates of its joint tree."""

    def __init__(self, tree: JointTree) -> None:
        self.arrays = arrays_of(tree)
        self.system = PlanarSystem(tree.scene)
        self.system.start_contacts(0.0, self.system.initial_state(), located=False)

    def on_bodies(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the forces (n_bodies, 3) at the centres of mass of tree coordinates q, v (n_q,): N, N, N m."""
        return self.of_poses(t, *motion_of(self.arrays, q, v))

    def generalized(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the generalized forces (n_q,)."""
        pose, rate = motion_of(self.arrays, q, v)
        return project(self.arrays, q, pose, self.of_poses(t, pose, rate))

    def of_poses(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the forces (n_bodies, 3) of world poses and velocities (n_bodies, 3)."""
        self.system.set_mode_time(t)
        return self.system.applied_forces(t, q, v)
