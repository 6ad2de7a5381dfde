"""Positions of another point of the bodies than their centres of mass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files.mistakes.case import NONE, Case, vector


def other_points(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield points fixed in the bodies, other than the centres of mass, whose positions the file tells."""
    words, position, velocity = [], case.path.position.copy(), case.path.velocity.copy()
    if not case.told_turns:
        return
    for k, body in enumerate(case.scene.bodies):
        turn = _matrices(case.truth.orientation[:, k])
        gap = position[:, k] - case.truth.position[:, k]
        if np.isnan(gap).any() or not np.isfinite(turn).all():
            continue
        arm = np.mean(np.einsum("nji,nj->ni", turn, gap), axis=0)  # in body axes
        if np.linalg.norm(arm) <= NONE * case.length:
            continue
        away = turn @ arm
        position[:, k] -= away
        if case.truth.angular_velocity is not None:
            velocity[:, k] -= _crossed(case.truth.angular_velocity[:, k], away)
        words.append(f"{body.name} at {vector(arm)} m in body axes")
    if words:
        both = (replace(case.path, position=position), replace(case.path, position=position, velocity=velocity))
        for path in both:  # velocities may be of the centre of mass all the same
            yield f"positions are not of the centre of mass, but of {', '.join(words)}", replace(case, path=path)


def _crossed(spin: np.ndarray, arm: np.ndarray) -> np.ndarray:
    return spin[:, None] * np.column_stack([-arm[:, 1], arm[:, 0]]) if spin.ndim == 1 else np.cross(spin, arm)


def _matrices(orientation: np.ndarray) -> np.ndarray:
    if orientation.ndim == 2:
        return Rotation.from_quat(orientation, scalar_first=True).as_matrix()
    c, s = np.cos(orientation), np.sin(orientation)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
