"""Accelerations: ABA in trees, proximal constraint dynamics in loops."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from cross_checks.engines.pinocchio_.build import Mechanism

PROXIMAL = {"absolute_accuracy": 1e-14, "mu": 1e-8, "max_iter": 20}  # mu = 0 gives NaN on redundant rows
RightHandSide = Callable[[float, np.ndarray], np.ndarray]


def right_hand_side(mechanism: Mechanism, contact_data: Any) -> RightHandSide:
    """Return f(t, y) with y = (q, v), one Pinocchio call each."""
    model, data, n = mechanism.model, mechanism.data, mechanism.n_q
    derivative = np.empty(n + model.nv)
    if not len(mechanism.contacts):

        def tree_rhs(t: float, y: np.ndarray) -> np.ndarray:
            q, v = mechanism.configured(y[:n]), y[n:]
            derivative[:n] = mechanism.rate(q, v)
            derivative[n:] = pin.aba(model, data, q, v, mechanism.torques(t, q, v))
            return derivative

        return tree_rhs
    contacts = mechanism.contacts
    for contact in contacts:
        contact_data.append(contact.createData())
    pin.initConstraintDynamics(model, data, contacts, contact_data)
    proximal = pin.ProximalSettings(PROXIMAL["absolute_accuracy"], PROXIMAL["mu"], PROXIMAL["max_iter"])

    def loop_rhs(t: float, y: np.ndarray) -> np.ndarray:
        q, v = mechanism.configured(y[:n]), y[n:]
        derivative[:n] = mechanism.rate(q, v)
        torques = mechanism.torques(t, q, v)
        derivative[n:] = pin.constraintDynamics(model, data, q, v, torques, contacts, contact_data, proximal)
        return derivative

    return loop_rhs
