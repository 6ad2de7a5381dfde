"""Modes about a steady motion: whether perturbations grow, decay or oscillate.

A motion is steady if every body's velocity (world axes) and angular velocity (body axes) is constant, and if moving
along it does not change the equations: a wheel that rolls straight on, an upright spinning top of revolution, or rest.
Such a motion y(t) = exp(t X) y(0) is at rest in a frame that moves with it, where perturbations z obey z' = (f_y - X) z
with constant matrices, although f_y itself depends on the wheels' angles along y(t). (Marsden and Ratiu, Introduction
to Mechanics and Symmetry, 2nd ed., 1999, relative equilibria.)

The matrix is restricted to perturbations that satisfy the constraints.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.scene import Scene
from mbs_ref.scene.signals import Constant
from mbs_ref.scene.traits import traits
from mbs_ref.simulate.linearised.stiffness import LARGEST

STEP = 0.01  # of a unit direction of the state: truncation ~ h^8 / 630 and roundoff ~ eps / h are both below 1e-13
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)  # central differences of order 8 (Fornberg 1988)
STEADY = 1e-9  # of the largest rate: a smaller acceleration is roundoff
SAME = 1e-6  # of the largest entry: vector fields that differ by less are equal to the accuracy of the differences
INDEPENDENT = 1e-8  # of the largest singular value: rows with smaller ones are dependent
ZERO = 1e-10  # of the largest singular value: smaller ones belong to the kernel
NEARBY = 0.01  # size of the displacement, in state units, at which the symmetry is tested


@dataclass(frozen=True)
class SteadyMotion:
    """Modes about the motion in which a scene starts; none if it is not steady."""

    eigenvalues: np.ndarray  # (n,) complex, 1/s: one per position and velocity freedom, by falling real part
    reason: str  # why there are none, otherwise empty


def steady_motion_at_start(scene: Scene) -> SteadyMotion:
    """Linearise a scene about its motion at t = 0; if that is not steady, the result holds the reason."""
    reason = _unsupported(scene)
    if reason:
        return _none(reason)
    system = compile_scene(scene)
    assert isinstance(system, JointedSystem)
    y = system.initial_state()
    system.set_mode_time(0.0)
    f, (course, generator) = system.derivative(0.0, y), system.steady_course(y)
    rates = f[system.n_positions :] - course[system.n_positions :]
    if np.abs(rates).max() > STEADY * max(1.0, np.abs(f).max()):
        return _none("the motion at t = 0 is accelerated")
    if not _is_symmetric(system, y, course, generator):
        return _none("the equations change along the motion at t = 0")
    tangent = _tangent(system, y)
    matrix = differences(lambda x: system.derivative(0.0, x), y, tangent) - generator @ tangent
    found = _eigenvalues(tangent.T @ matrix)
    return SteadyMotion(found[np.lexsort((np.imag(found), -np.real(found)))], "")


def _none(reason: str) -> SteadyMotion:
    return SteadyMotion(np.zeros(0, complex), reason)


def _unsupported(scene: Scene) -> str:
    """Return why a scene is not analysed, or nothing."""
    signals = [signal for part in (*scene.joints, *scene.loads) for signal in part.signals]
    if scene.contacts or traits(scene) & {"rheonomic", "user-force", "user-constraint"}:
        return "contacts, drives and user-defined laws are not analysed"
    if not all(isinstance(signal, Constant) for signal in signals):
        return "a load changes in time"
    if not scene.joints:
        return "no joint holds a body"
    return f"more than {LARGEST} bodies" if len(scene.bodies) > LARGEST else ""


def _is_symmetric(system: JointedSystem, y: np.ndarray, course: np.ndarray, generator: np.ndarray) -> bool:
    """Return whether the affine field X commutes with f, f_y X = X f, at a generic state near y."""
    near = y + NEARBY * np.cos(1.0 + np.arange(len(y)))
    along = course + generator @ (near - y)
    size = np.linalg.norm(along)
    if size == 0.0:
        return True
    moved = size * differences(lambda x: system.derivative(0.0, x), near, along[:, None] / size)[:, 0]
    turned = generator @ system.derivative(0.0, near)
    return bool(np.abs(moved - turned).max() < SAME * max(1.0, np.abs(turned).max()))


def _tangent(system: JointedSystem, y: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis (n_state, n) of the perturbations that preserve C, C_dot and the norms."""

    def conserved(x: np.ndarray) -> np.ndarray:
        rows = [np.concatenate(pair) for pair in system.residuals(0.0, x).values()]
        return np.concatenate((*rows, system.norms(x)))

    return _kernel(differences(conserved, y, np.eye(len(y))), INDEPENDENT)[0]


def _kernel(matrix: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return orthonormal bases of a matrix's kernel and of the kernel's complement."""
    _, values, basis = np.linalg.svd(matrix)
    rank = int(np.sum(values > tolerance * values.max(initial=0.0)))
    return basis[rank:].T, basis[:rank].T


def _eigenvalues(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvalues, those of Jordan blocks at 0 exactly.

    A bicycle's place and heading have no effect, and such Jordan chains would perturb the small eigenvalues. The kernel
    is removed until it is empty (the staircase algorithm of Kublanovskaya 1966).
    """
    every = len(matrix)
    while len(matrix):
        kernel, rest = _kernel(matrix, ZERO)
        if not kernel.shape[1]:
            break
        matrix = rest.T @ matrix @ rest
    return np.concatenate((np.linalg.eigvals(matrix), np.zeros(every - len(matrix))))


def differences(f: Callable[[np.ndarray], np.ndarray], y: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return f_y directions (n_f, n) by central differences of order 8; directions (n_y, n) of length one."""
    columns = []
    for along in directions.T:
        pairs = [f(y + j * STEP * along) - f(y - j * STEP * along) for j in range(1, len(WEIGHTS) + 1)]
        columns.append(np.tensordot(WEIGHTS, pairs, axes=1) / STEP)
    return np.array(columns).T
