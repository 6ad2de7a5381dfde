"""The dense oracle in extended precision: it tells who errs where the one in double precision cannot.

The shared judge keeps the precision of what it is given, so matrices, forces and gamma come out in it. They are
solved by iterative refinement: residuals in extended precision, corrections by the singular values of the matrix in
double (Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., ch. 12), until a correction is roundoff.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cross_checks.truths.oracle import AUGMENTED_CUTOFF, Augmented, Moment, Solution, augmented
from mbs_ref.scene import Scene

EXTENDED = np.longdouble
MOST_REFINEMENTS = 30
SETTLED = 1e-16  # of the accelerations: a last correction beyond has not converged
STILL = 1e-3  # m/s^2, rad/s^2: where all accelerations are smaller, corrections are measured against it


def has_extended_precision() -> bool:
    """Return whether this machine's long double is longer than a double."""
    return bool(np.finfo(EXTENDED).eps < 1e-18)


def extended(moment: Moment) -> Moment:
    """Return the same moment, its scene's numbers included, in extended precision."""
    arrays = (moment.position, moment.orientation, moment.rate)
    position, orientation, rate = (array.astype(EXTENDED) for array in arrays)
    return Moment(_extended_scene(moment.scene), EXTENDED(moment.time), position, orientation, rate)


def _extended_scene(scene: Scene) -> Scene:
    kinds = ("bodies", "joints", "loads")
    parts = {kind: tuple(_extended_part(part) for part in getattr(scene, kind)) for kind in kinds}
    return scene.model_copy(update={**parts, "gravity": _lengthened(scene.gravity)})


def _extended_part(part: Any) -> Any:
    return part.model_copy(update={name: _lengthened(value) for name, value in dict(part).items()})


def _lengthened(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_lengthened(one) for one in value)
    return EXTENDED(value) if type(value) is float else value


def solve(moment: Moment) -> tuple[Solution, Augmented]:
    """Return accelerations and joint forces of a moment in extended precision, and its system rounded to double."""
    exact = augmented(extended(moment))
    rough = _rounded(exact)
    size = len(exact.force)
    correct = _corrector(rough)
    a, lam, step = np.zeros(size, EXTENDED), np.zeros(len(exact.gamma), EXTENDED), np.inf
    for _ in range(MOST_REFINEMENTS):
        force = exact.force - exact.mass @ a - lam @ exact.jacobian
        da, dlam = correct(force.astype(float), (exact.gamma - exact.jacobian @ a).astype(float))
        a, lam = a + da, lam + dlam
        step = float(np.abs(da).max() / max(float(np.abs(a).max()), STILL))
        if step <= SETTLED:
            break
    else:
        raise ArithmeticError(f"refinement stops at {step:.2g} of the accelerations")
    acceleration = np.zeros_like(exact.moment.rate)
    acceleration[moment.used] = a
    return Solution(acceleration, exact.wrenches(lam), rough.condition, rough.redundant), rough


def _rounded(system: Augmented) -> Augmented:
    names = ("mass", "jacobian", "force", "gamma", "drift")
    return replace(system, **{name: getattr(system, name).astype(float) for name in names})


def _corrector(system: Augmented):
    """Return a function from residuals of both rows to corrections of accelerations and multipliers."""
    size, rows = len(system.force), len(system.gamma)
    scaled = system.scaled if rows else np.zeros((0, size))
    scale = system.row_scale if rows else np.ones(0)
    matrix = np.block([[np.eye(size), scaled.T], [scaled, np.zeros((rows, rows))]])
    inverse = np.linalg.pinv(matrix, rcond=AUGMENTED_CUTOFF)

    def correct(force: np.ndarray, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = inverse @ np.concatenate((np.linalg.solve(system.root, force), gap / scale))
        return np.linalg.solve(system.root.T, found[:size]), found[size:] / scale

    return correct
