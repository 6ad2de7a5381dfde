"""Another frame: a world that is turned or shifted, body axes that are turned."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files.mistakes.case import NONE, Case, vector
from mbs_ref.scene.euler_parameters import conjugate, product, rotation_vector
from mbs_ref.trajectory import Trajectory

FITS = 6  # corrections by Gauss and Newton


def turned_world(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the rotation and the shift of the whole world that fit best."""
    turn = _fitted_turn(case)
    if turn is None:
        return
    path = _turned(case, turn)
    gaps = case.truth.position - path.position
    told = ~np.isnan(gaps).any(axis=2)
    away = gaps[told].mean(axis=0) if told.any() else np.zeros(case.scene.dimension)
    words = []
    if turn.magnitude() > NONE:
        words.append(f"turned by {np.degrees(turn.magnitude()):.4g} deg about {_axis(turn)}")
    if np.linalg.norm(away) > NONE * case.length:
        words.append(f"shifted by {vector(-away)} m")
    if words:
        told = f"the file's world is {' and '.join(words)}"
        yield told, replace(case, path=replace(path, position=path.position + away))


def _fitted_turn(case: Case) -> Rotation | None:
    """Return the rotation from the file's world to the scene's, by poses; None where the file tells too little."""
    path, truth = case.path, case.truth
    if not case.planar:
        rows = ~np.isnan(path.orientation).any(axis=2)
        if rows.any() and truth.orientation.ndim == 3:
            between = product(truth.orientation[rows], conjugate(path.orientation[rows]))
            return Rotation.from_quat(between, scalar_first=True).mean()
    told = ~np.isnan(path.position).any(axis=2)
    if np.count_nonzero(told) < 2:
        return None
    ours, theirs = (_in_space(values[told] - values[told].mean(axis=0)) for values in (path.position, truth.position))
    if case.planar:
        cross = float(np.sum(ours[:, 0] * theirs[:, 1] - ours[:, 1] * theirs[:, 0]))
        return Rotation.from_rotvec([0.0, 0.0, np.arctan2(cross, float(np.sum(ours * theirs)))])
    return Rotation.align_vectors(theirs, ours)[0]


def _turned(case: Case, turn: Rotation) -> Trajectory:
    path, d = case.path, case.scene.dimension
    matrix = turn.as_matrix()[:d, :d]
    if d == 2:
        orientation, spin = path.orientation + turn.as_rotvec()[2], path.angular_velocity
    else:
        orientation = product(turn.as_quat(scalar_first=True), path.orientation)
        spin = path.angular_velocity @ matrix.T
    return replace(path, position=path.position @ matrix.T, orientation=orientation, velocity=path.velocity @ matrix.T,
                   angular_velocity=spin)  # fmt: skip


def turning_world(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the steady rotation about the scene's origin that the file's world takes part in, as Earth-fixed axes do.

    Fitted by Gauss and Newton on orientations, else on positions.
    """
    if case.planar:
        return
    spin, path = np.zeros(3), case.path
    for _ in range(FITS):
        change = _spin_left(replace(case, path=path))
        if change is None:
            return
        spin = spin + change
        path = _turned_along(case.path, spin)
    speed = float(np.linalg.norm(spin))
    if speed * case.scene.duration > NONE:
        words = f"{np.degrees(speed):.4g} deg/s about {vector(spin / speed)}"
        yield f"the file's world turns by {words}", replace(case, path=path)


def _spin_left(case: Case) -> np.ndarray | None:
    """Return the spin (3,), rad/s, that brings the file's motion nearer to the truth; None where nothing is told."""
    path, truth, t = case.path, case.truth, case.path.times
    if case.comparable_turns and not np.isnan(path.orientation).all():
        turns = rotation_vector(product(truth.orientation, conjugate(path.orientation)))
        known = ~np.isnan(turns).any(axis=2)
        weight = np.broadcast_to(t[:, None], known.shape)[known]
        return weight @ turns[known] / (weight @ weight)
    known = ~np.isnan(path.position).any(axis=2)
    if not known.any():
        return None
    place, gap = path.position[known], (truth.position - path.position)[known]
    weight = np.broadcast_to(t[:, None], known.shape)[known]
    rows = -weight[:, None, None] * np.cross(place[:, None, :], np.eye(3)).transpose(0, 2, 1)  # spin x place
    return np.linalg.lstsq(rows.reshape(-1, 3), gap.ravel(), rcond=None)[0]


def _turned_along(path: Trajectory, spin: np.ndarray) -> Trajectory:
    """Return a motion that was seen in axes with this spin (rad/s) as it is seen in axes that do not turn."""
    turn = Rotation.from_rotvec(path.times[:, None] * spin)
    matrices = turn.as_matrix()[:, None]
    position, velocity, omega = (
        (matrices @ values[..., None])[..., 0] for values in (path.position, path.velocity, path.angular_velocity)
    )
    orientation = product(turn.as_quat(scalar_first=True)[:, None, :], path.orientation)
    return replace(path, position=position, orientation=orientation, velocity=velocity + np.cross(spin, position),
                   angular_velocity=omega)  # fmt: skip


def turned_bodies(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield a constant rotation between the file's body axes and the scene's."""
    if not case.comparable_turns:
        return
    words, orientation = [], case.path.orientation.copy()
    for k, body in enumerate(case.scene.bodies):
        told = ~np.isnan(orientation[:, k].reshape(len(orientation), -1)).any(axis=1)
        if not told.any():
            continue
        if case.planar:
            gap = case.truth.orientation[told, k] - orientation[told, k]
            turn = float(np.arctan2(np.sin(gap).mean(), np.cos(gap).mean()))
            orientation[:, k] += turn
            words += [f"{body.name} by {np.degrees(-turn):.4g} deg"] if abs(turn) > NONE else []
        else:
            between = product(conjugate(orientation[told, k]), case.truth.orientation[told, k])
            mean = Rotation.from_quat(between, scalar_first=True).mean()
            orientation[:, k] = product(orientation[:, k], mean.as_quat(scalar_first=True))
            if mean.magnitude() > NONE:
                words.append(f"{body.name} by {np.degrees(mean.magnitude()):.4g} deg about {_axis(mean.inv())}")
    if words:
        path = replace(case.path, orientation=orientation)
        yield f"body axes are turned: {', '.join(words)}", replace(case, path=path)


def _in_space(vectors: np.ndarray) -> np.ndarray:
    return vectors if vectors.shape[1] == 3 else np.column_stack([vectors, np.zeros(len(vectors))])


def _axis(turn: Rotation) -> str:
    return vector(turn.as_rotvec() / turn.magnitude())


def other_points(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield points fixed in the bodies, other than the centres of mass, whose positions the file tells."""
    words, position, velocity = [], case.path.position.copy(), case.path.velocity.copy()
    if not case.comparable_turns:
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
