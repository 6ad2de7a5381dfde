"""A robot file as Pinocchio's own parser reads it."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from cross_checks.robots.parity import Dynamics, Unreadable, Values


def by_pinocchio(path: Path, q: Values, v: Values) -> Dynamics:
    """Return what Pinocchio says; the other joints stay neutral."""
    read = pin.buildModelFromUrdf if path.suffix == ".urdf" else pin.buildModelFromMJCF
    try:
        model = read(str(path))
    except (ValueError, RuntimeError) as error:
        raise Unreadable(str(error).strip().splitlines()[0]) from error
    model = model[0] if isinstance(model, tuple) else model
    unknown = [name for name in q if not model.existJointName(name)]
    if unknown:
        raise Unreadable(f"it has no joint {', '.join(unknown)}")
    data = model.createData()
    index = [model.joints[model.getJointId(name)].idx_v for name in q]
    turned, rates = np.zeros((2, model.nv))
    turned[index], rates[index] = list(q.values()), list(v.values())
    places = pin.integrate(model, pin.neutral(model), turned)
    upper = np.triu(pin.crba(model, data, places))
    mass = upper + np.triu(upper, 1).T
    gravity = pin.computeGeneralizedGravity(model, data, places).copy()
    bias = pin.nonLinearEffects(model, data, places, rates).copy()
    return Dynamics(mass[np.ix_(index, index)], gravity[index], bias[index])


READER = by_pinocchio
