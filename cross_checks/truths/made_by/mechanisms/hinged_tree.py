"""A tree of hinged planar bodies on a free root, in absolute angles: Lagrange's and Hamilton's equations.

The bodies that are welded to ground are ground. y holds the root's place x, y (m), then every body's
angle (rad), then as many rates or momenta. Vectors of the plane are complex numbers, x + i y.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cross_checks.truths.made_by import Formulation
from cross_checks.truths.made_by.mechanisms import hinged_tree_loads
from cross_checks.truths.made_by.mechanisms.hinged_tree_loads import Loads, Motion, loads_of, mark, planar
from cross_checks.truths.made_by.mechanisms.rod_chain import factor_and_solve
from cross_checks.truths.truth import OutsideDomainError
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.scene import GROUND, Revolute, Scene, Weld


class Tree(NamedTuple):
    """r_i = r_root + sum_k exp(i theta_k) arm[i, k]; compiled code takes it as it is."""

    arm: np.ndarray  # (n, n) m, in body k's axes; zero where k is not between the root and i
    mass: np.ndarray  # (n,) kg
    coupling: np.ndarray  # (n, n) kg m^2: M_jk is the real part of coupling_jk exp(i theta_k - i theta_j)


def formulations(scene: Scene) -> tuple[Formulation, Formulation]:
    """Return Lagrange's and Hamilton's equations; OutsideDomainError where the mechanism is of another kind."""
    fixed = {GROUND, *(j.body_b for j in scene.joints if isinstance(j, Weld) and j.body_a == GROUND)}
    free = [body.name for body in scene.bodies if body.name not in fixed]
    tree, loads = _tree(scene, free, _hinges(scene, free)), loads_of(scene, free)
    rates = _start(scene, free)
    momenta, n = rates.copy(), len(rates) // 2
    momenta[n:] = _mass_matrix(tree, rates) @ rates[n:]
    known = scene, free, tree, loads
    lagrange = _formulation(*known, _lagrange_slope, lambda y: y, rates)
    return lagrange, _formulation(*known, _hamilton_slope, lambda y: _with_rates(tree, y), momenta)


def _hinges(scene: Scene, free: list[str]) -> dict[str, Revolute]:
    """Return the hinge that carries each body, the root's excepted, every carrier before what it carries."""
    hinges = [j for j in scene.joints if isinstance(j, Revolute)]
    welds = [j for j in scene.joints if isinstance(j, Weld)]
    carrying: dict[str, Revolute] = {}
    reached = [free[0]]
    for body in reached:
        for joint in hinges:
            other = {joint.body_a: joint.body_b, joint.body_b: joint.body_a}.get(body)
            if other is not None and other not in reached:
                carrying[other] = joint
                reached.append(other)
    if len(reached) < len(free) or len(hinges) != len(free) - 1 or len(hinges) + len(welds) < len(scene.joints):
        raise OutsideDomainError(f"{scene.name!r} is no free tree of hinged bodies")
    return carrying


def _tree(scene: Scene, free: list[str], hinge: dict[str, Revolute]) -> Tree:
    arm = np.zeros((len(free), len(free)), dtype=complex)
    for child, joint in hinge.items():
        parent = joint.body_a if joint.body_b == child else joint.body_b
        (i, outwards), (p, along) = (mark(scene, free, name, joint.point) for name in (child, parent))
        arm[i] = arm[p]
        arm[i, p] += along
        arm[i, i] -= outwards
    bodies = [planar(scene, name) for name in free]
    mass = np.array([b.mass for b in bodies])
    return Tree(arm, mass, arm.conj().T @ (mass[:, None] * arm) + np.diag([b.inertia for b in bodies]))


def _formulation(
    scene: Scene, free: list[str], tree: Tree, loads: Loads, slope: Callable, rates_of: Callable, start: np.ndarray
) -> Formulation:
    """Return the equations y' = slope(...) of a state whose rates are those of rates_of(y)."""

    def frozen(t, y, on):
        return slope(tree, loads.arrays, loads.factors(t), y, on)

    def switches(t, y):
        return hinged_tree_loads.measure_switches(loads.arrays, _motion(tree, rates_of(y))[0])

    def poses(t, y):
        return _all_poses(scene, free, _motion(tree, y)[0])

    def derivative(t, y):
        values = switches(t, y)  # NaN in a trial step that goes too far; error control then rejects the step
        return frozen(t, y, values > 0.0) if not np.isnan(values).any() else np.full(len(y), np.nan)

    def known(t, y):
        values = switches(t, y)
        if np.isnan(values).any():
            raise OutsideDomainError("a circle is deeper than its surface is thick")
        return values

    return Formulation(derivative, start, poses, frozen, known, scene.breakpoints())


def _start(scene: Scene, free: list[str]) -> np.ndarray:
    bodies = [planar(scene, name) for name in free]
    place, speed = [*bodies[0].position, *(b.angle for b in bodies)], [*bodies[0].velocity]
    return np.array([*place, *speed, *(b.angular_velocity for b in bodies)])


def _all_poses(scene: Scene, free: list[str], motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    bodies, moving = [planar(scene, name) for name in scene.body_names], [scene.body_index(name) for name in free]
    place, angle = np.array([b.position for b in bodies]), np.array([b.angle for b in bodies])
    place[moving] = np.column_stack((np.real(motion.place), np.imag(motion.place)))[:-1]
    angle[moving] = motion.angle[:-1]
    return place, angle


@strict_jit
def _motion(tree, y):
    """Return the bodies' motion, and their arms (n, n) in the world."""
    n = len(tree.mass)
    place, velocity = np.zeros(n + 1, dtype=np.complex128), np.zeros(n + 1, dtype=np.complex128)
    angle, spin = np.zeros(n + 1), np.zeros(n + 1)
    angle[:n], spin[:n] = y[2 : n + 2], y[n + 4 :]
    turned = tree.arm * np.exp(1j * angle[:n])
    place[:n] = y[0] + 1j * y[1] + turned.sum(axis=1)
    velocity[:n] = y[n + 2] + 1j * y[n + 3] + 1j * (turned * spin[:n]).sum(axis=1)
    return Motion(place, angle, velocity, spin), turned


@strict_jit
def _mass_matrix(tree, y):
    n = len(tree.mass)
    turn = np.exp(1j * y[2 : n + 2])
    swing = 1j * turn * (tree.mass.reshape(n, 1) * tree.arm).sum(axis=0)
    m = np.zeros((n + 2, n + 2))
    m[0, 0] = m[1, 1] = tree.mass.sum()
    m[0, 2:], m[1, 2:] = swing.real, swing.imag
    m[2:, 0], m[2:, 1] = swing.real, swing.imag
    m[2:, 2:] = (np.conj(turn).reshape(n, 1) * tree.coupling * turn).real
    return m


@strict_jit
def _generalized(turned, force, moment):
    """Return J^T of forces (n,) and moments (n,) at the centres of mass."""
    total = force.sum()
    about = (np.conj(turned) * force.reshape(len(force), 1)).sum(axis=0).imag
    return np.concatenate((np.array([total.real, total.imag]), moment + about))


@strict_jit
def _lagrange_slope(tree, arrays, factors, y, on):
    """M q'' = J^T (F + m h) with r'' = J q'' - h."""
    n = len(tree.mass)
    motion, turned = _motion(tree, y)
    force, moment = hinged_tree_loads.apply_loads(arrays, tree.mass, factors, motion, on)
    bend = (turned * motion.spin[:n] ** 2).sum(axis=1)
    push = _generalized(turned, force[:n] + tree.mass * bend, moment[:n])
    return np.concatenate((y[n + 2 :], factor_and_solve(_mass_matrix(tree, y), push)))


@strict_jit
def _with_rates(tree, y):
    """Momenta to rates."""
    n = len(tree.mass) + 2
    return np.concatenate((y[:n], factor_and_solve(_mass_matrix(tree, y), y[n:])))


@strict_jit
def _hamilton_slope(tree, arrays, factors, y, on):
    """p = M q', p' = J^T F + J'^T m v."""
    n = len(tree.mass)
    moving = _with_rates(tree, y)
    motion, turned = _motion(tree, moving)
    force, moment = hinged_tree_loads.apply_loads(arrays, tree.mass, factors, motion, on)
    swing = (np.conj(turned) * (tree.mass * motion.velocity[:n]).reshape(n, 1)).sum(axis=0).real
    push = _generalized(turned, force[:n], moment[:n] - motion.spin[:n] * swing)
    return np.concatenate((moving[n + 2 :], push))
