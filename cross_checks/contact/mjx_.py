"""MJX with its own contacts: MuJoCo's, translated as for MuJoCo, under approximated effective masses.

MJX lacks noslip_iterations and mjENBL_DIAGEXACT (MuJoCo documentation, "MuJoCo XLA", feature parity); an
impedance of each pair makes up for the second.
"""

# the first, for its absence is what says that the extra is not installed
from cross_checks.engines.mjx_ import Copied, Mjx, copied

# isort: split
from dataclasses import replace
from typing import ClassVar

import numpy as np

from cross_checks.contact import mujoco_ as of_mujoco
from cross_checks.contact.mujoco_ import DEFAULT, OPTIONS, STOCK
from cross_checks.contact.request import ContactModel, Request, Translation
from cross_checks.engine import Method, Plan, Refusal
from mbs_ref import Scene

CALLS = "some loads need a call of Python within a step, which MJX does not have"
OWN = {name: option | STOCK for name, option in OPTIONS.items() if "noslip_iterations" not in option}


class OwnContact(Mjx):
    """MJX's Euler, with pairs whose parameters are translated from the laws of the scene."""

    method_table: ClassVar[tuple[Method, ...]] = tuple(
        replace(method, description=method.description.replace("MuJoCo", "MJX"))
        for method in of_mujoco.OwnContact.method_table
        if method.name in OWN
    )
    lacks: ClassVar[frozenset[str]] = frozenset({"bushing", "point_bushing", "user_force"})
    extra: ClassVar[frozenset[str]] = of_mujoco.OwnContact.extra

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        found = of_mujoco.OwnContact.topology_refusals(self, scene)  # type: ignore[arg-type]
        return found + ([Refusal(CALLS, permanent=True)] if of_mujoco.calls_python(scene) else [])

    def build(self, scene: Scene, plan: Plan) -> Copied:
        made = of_mujoco.built(scene, plan, OWN[plan.method.name])
        frictionless = made.model.pair_dim == 1
        if not frictionless.all():  # condim 1 beside others is not implemented: a friction of 1e-5 instead
            made.model.pair_dim[frictionless], made.model.pair_friction[frictionless] = 3, np.full(5, 1e-5)
        return copied(made.linkage, made.model)


def translate(request: Request) -> Translation:
    """Return MuJoCo's parameters; of a body that is free in space the approximated effective mass is exact."""
    found = of_mujoco.translate(request)
    return replace(found, snippet=found.snippet.replace('<flag diagexact="enable"/>', ""))


MODEL = ContactModel(OwnContact(), translate, (DEFAULT, "stock"))
